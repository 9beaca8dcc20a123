//! From the points of a walk to the contours of a layer: the one finish that all backends share.

use super::chains::{self, OpenReport};
use super::trace::{LayerContours, TraceOptions, Walked};
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
    walked: Walked,
}

impl<'a> Finish<'a> {
    pub(super) fn new(options: &'a TraceOptions) -> Self {
        Self {
            options,
            points: vec![],
            scratch: vec![],
            rings: vec![],
            chains: vec![],
            walked: Walked::default(),
        }
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
        self.walked.closed += 1;
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
        self.walked.open += 1;
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
        let walked = self.walked;
        if !self.chains.is_empty() {
            let chains = std::mem::take(&mut self.chains);
            let (closed, report) = chains::close(chains, self.options.match_tolerance);
            for ring in closed {
                self.points = ring;
                self.close();
            }
            open = report;
        }
        self.walked = Walked::default();
        // Whole rings are compared only where first points are equal.
        self.rings.sort_unstable();
        LayerContours { rings: self.rings.drain(..).map(|(_, ring)| ring).collect(), open, walked }
    }
}

#[cfg(test)]
mod tests {
    use crate::contour::{TraceOptions, contours_of, trace};
    use crate::mesh::{Adjacency, OPEN, shapes};
    use crate::slice::{Segments, cpu};

    /// Closed cycles and open chains, by following the links from slot to slot.
    fn walked(segments: &Segments) -> (u32, u32) {
        let next = &segments.next;
        let mut headed = vec![false; next.len()];
        next.iter().filter(|&&n| n != OPEN).for_each(|&n| headed[n as usize] = true);
        let mut taken = vec![false; next.len()];
        let mut follow = |from: usize| {
            let (mut at, mut new) = (from, false);
            while !taken[at] {
                (taken[at], new) = (true, true);
                at = if next[at] == OPEN { at } else { next[at] as usize };
            }
            u32::from(new)
        };
        let open = (0..next.len()).filter(|&i| !headed[i]).map(&mut follow).sum();
        ((0..next.len()).map(follow).sum(), open)
    }

    #[test]
    fn every_cycle_and_every_chain_counts_once() {
        let whole = shapes::knot(2.0, 1.0, 2000);
        let mut torn = whole.clone();
        let mut at = 0;
        torn.triangles.retain(|_| {
            at += 1;
            at % 7 != 0
        });
        // Horizontal planes through its vertices: contours of no length.
        let pyramids = shapes::merge(&[shapes::tetrahedron(5.0), shapes::cone(3.0, 4.0, 12)]);
        for mesh in [whole, torn, pyramids] {
            let adjacency = Adjacency::build(&mesh);
            let mut planes: Vec<i32> = mesh.vertices.iter().step_by(5).map(|v| v.z).collect();
            planes.extend(mesh.bounds().into_iter().flatten().map(|v| v.z));
            planes.sort_unstable();
            planes.dedup();
            let options =
                TraceOptions { simplify_tolerance: None, match_tolerance: 0, memory_budget: 1 << 20 };
            let segments = cpu::slice(&mesh, &adjacency, &planes);
            let expected = walked(&segments);
            let sum = |layers: &[crate::contour::LayerContours]| {
                layers.iter().fold((0, 0), |(c, o), l| (c + l.walked.closed, o + l.walked.open))
            };
            assert_eq!(sum(&contours_of(&mesh, &planes, &segments, &options)), expected);
            assert_eq!(trace(&mesh, &adjacency, &planes, &options).map(|l| sum(&l)), Ok(expected));
        }
    }
}
