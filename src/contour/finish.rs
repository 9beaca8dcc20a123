//! From the points of a walk to the contours of a layer: the one finish that all backends share.

use super::chains::{self, OpenReport};
use super::trace::{LayerContours, TraceOptions};
use super::{Ring, ring, simplify};
use crate::lattice::Point2;

/// Takes the contours of one layer after the other; its memory is reused between layers.
pub(super) struct Finish<'a> {
    options: &'a TraceOptions,
    /// The contour being walked.
    points: Vec<Point2>,
    scratch: Vec<Point2>,
    /// Finished rings, each with the key of its first point, which decides most comparisons.
    rings: Vec<(u64, Ring)>,
    chains: Vec<Vec<Point2>>,
}

impl<'a> Finish<'a> {
    pub(super) fn new(options: &'a TraceOptions) -> Self {
        Self { options, points: vec![], scratch: vec![], rings: vec![], chains: vec![] }
    }

    /// Appends a point to the contour being walked.
    #[inline]
    pub(super) fn point(&mut self, p: Point2) {
        // Zero-length segments vanish here.
        if self.points.last() != Some(&p) {
            self.points.push(p);
        }
    }

    /// Appends points to the contour being walked; a closed one must follow.
    #[inline]
    pub(super) fn points(&mut self, points: impl Iterator<Item = Point2>) {
        self.points.extend(points);
    }

    /// The contour being walked is a closed loop. Returns its ring's first point, if there is a ring.
    pub(super) fn close(&mut self) -> Option<Point2> {
        ring::merge_repeats(&mut self.points);
        let mut first = None;
        if self.points.len() >= 3 {
            let ring = match self.options.simplify_tolerance {
                Some(tolerance) => {
                    simplify::simplify(&mut self.points, &mut self.scratch, tolerance);
                    self.points.as_slice().to_vec()
                }
                None => {
                    let (behind, before) = self.points.split_at(ring::start(&self.points));
                    [before, behind].concat()
                }
            };
            first = ring.first().copied();
            if let Some(first) = first {
                self.rings.push((ring::key(first), ring));
            }
        }
        self.points.clear();
        first
    }

    /// The contour being walked is an open chain; `before` are the points in front of its first one,
    /// from the first backwards.
    pub(super) fn leave_open(&mut self, before: &[Point2]) {
        let mut chain: Vec<Point2> = before.iter().rev().chain(&self.points).copied().collect();
        chain.dedup();
        if chain.len() >= 2 {
            self.chains.push(chain);
        }
        self.points.clear();
    }

    /// Everything since the last call is one layer.
    pub(super) fn layer(&mut self) -> LayerContours {
        let mut open = OpenReport::default();
        if !self.chains.is_empty() {
            let chains = std::mem::take(&mut self.chains);
            let (closed, report) = chains::close(chains, self.options.match_tolerance);
            for ring in closed {
                self.points = ring;
                self.close();
            }
            open = report;
        }
        // Whole rings are compared only where first points are equal.
        self.rings.sort_unstable();
        LayerContours { rings: self.rings.drain(..).map(|(_, ring)| ring).collect(), open }
    }
}
