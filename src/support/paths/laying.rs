//! The strands of a layer in the making.

use super::fill::{Fill, fill};
use super::shrink::{shrink, shrink_all};
use super::thin;
use crate::contour::{ExPolygon, Ring};
use crate::support::{Strand, StrandKind};

/// Walls and the lines inside overlap by this share of their width.
const OVERLAP: f64 = 0.1;

/// The sides of a loop are at least this share of the lines' distance apart somewhere; else a single line is laid.
const APART: f64 = 0.5;

/// Strands of one kind.
#[derive(Debug)]
pub struct Laying {
    /// What they are.
    pub kind: StrandKind,
    /// Width of a line \[nm\].
    pub width: f64,
    /// Distance of lines that touch \[nm\].
    pub spacing: f64,
    /// The strands so far.
    pub strands: Vec<Strand>,
}

impl Laying {
    /// Strands of lines of that width and distance \[nm\].
    pub fn new(kind: StrandKind, width: f64, spacing: f64) -> Self {
        Self { kind, width, spacing, strands: Vec::new() }
    }

    /// Fills areas; with `walled`, inside a line around each of them. No area remains without any line.
    pub fn fill(&mut self, areas: &[ExPolygon], how: Fill, walled: bool) {
        let mut within: Vec<ExPolygon> = Vec::with_capacity(areas.len());
        // Per area its walls, or what its lines are laid in.
        let mut rest = Vec::with_capacity(areas.len());
        for area in areas {
            let walls = shrink(area, self.half());
            let begin = within.len();
            if walled {
                within.extend(shrink_all(&walls, self.beside()));
            } else {
                within.extend(walls.iter().cloned());
            }
            rest.push((begin..within.len(), walls));
        }
        let mut area = 0;
        let mut filled = vec![false; within.len()];
        let mut lines: Vec<Vec<Strand>> = vec![Vec::new(); areas.len()];
        fill(&within, how, self.spacing, |region, points| {
            while rest[area].0.end <= region {
                area += 1;
            }
            filled[region] = true;
            lines[area].push(Strand { points, closed: false, kind: self.kind });
        });
        for ((own, (range, walls)), area) in lines.into_iter().zip(rest).zip(areas) {
            let is_bare = !walled && filled[range].iter().any(|f| !f);
            self.strands.extend(own);
            if walls.is_empty() || self.is_thin(area, &walls) {
                self.thin(area, &walls);
            } else if walled || is_bare {
                self.loops(&walls);
            }
        }
    }

    /// Loops around an area, `count` of them, each inside the one before.
    pub fn walls(&mut self, area: &ExPolygon, pitch: f64, count: usize) {
        let mut inner = shrink(area, self.half());
        if inner.is_empty() || self.is_thin(area, &inner) {
            return self.thin(area, &inner);
        }
        for _ in 0..count {
            self.loops(&inner);
            inner = shrink_all(&inner, pitch.round().max(1.0) as i64);
            if inner.is_empty() {
                return;
            }
        }
    }

    /// Loops beside the outermost ones, where there is room.
    pub fn inner_walls(&mut self, areas: &[ExPolygon]) {
        let inner = shrink_all(areas, self.half() + self.spacing.round() as i64);
        self.loops(&inner);
    }

    /// Whether the two sides of the loops `walls` around an area lie upon each other everywhere.
    fn is_thin(&self, area: &ExPolygon, walls: &[ExPolygon]) -> bool {
        let apart = APART * self.spacing;
        // Somewhere an area is at least as wide as on average.
        let length: f64 = area.rings().map(|r| length(r)).sum();
        let mean = 2e12 * area.area_mm2() / length.max(1.0);
        mean < self.width + apart && walls.iter().all(|w| shrink(w, (0.5 * apart) as i64).is_empty())
    }

    /// Lines where a loop has no room: single ones, where that works.
    fn thin(&mut self, area: &ExPolygon, walls: &[ExPolygon]) {
        let own = thin::strands(area, self.width, self.kind);
        if own.is_empty() {
            self.loops(walls);
        }
        self.strands.extend(own);
    }

    /// The borders of areas.
    pub fn loops(&mut self, areas: &[ExPolygon]) {
        let (kind, strands) = (self.kind, &mut self.strands);
        let strand = |ring: &Ring| Strand { points: ring.clone(), closed: true, kind };
        strands.extend(areas.iter().flat_map(ExPolygon::rings).map(strand));
    }

    /// From a border to the middle of a line along it \[nm\].
    pub fn half(&self) -> i64 {
        (0.5 * self.width).round() as i64
    }

    /// From the middle of a line to the ends of those beside it \[nm\].
    pub fn beside(&self) -> i64 {
        (self.spacing - OVERLAP * self.width).round().max(1.0) as i64
    }
}

/// Length of a closed ring \[nm\].
fn length(ring: &Ring) -> f64 {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum()
}
