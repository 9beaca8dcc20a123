//! The best direction for a patch over air, measured with lines through it.

use super::Grid;
use super::lines::{Cells, Line};
use crate::span::{Rows, Span};
use std::f64::consts::PI;

/// Directions tried on every patch, beside those of its edges \[degrees\].
const STEP: f64 = 5.0;
/// Lines laid through a patch to measure a direction: about a row apart, but neither fewer nor more.
const LINES: [f64; 2] = [12.0, 64.0];
/// Shares of supported length that differ by less are alike: rows tell no more.
const ALIKE: f64 = 0.05;
/// Spans that are longer by less than this are alike, and by less than a row.
const ALIKE_SPAN: f64 = 1.02;
/// This share of the supported length lies on spans no longer than the one that counts.
const LONG: f64 = 0.9;
/// An edge is straight where the steps from row to row differ by no more than this \[nm\], on at least
/// that many rows.
const STRAIGHT: (f64, usize) = (12_000.0, 4);
/// Edges of directions less apart than this are added up \[degrees\].
const SAME_EDGE: f64 = 1.0;
/// Only the longest edges give directions.
const EDGES: usize = 4;

/// How a direction suits a patch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Score {
    /// The direction \[degrees\].
    pub degrees: f64,
    /// Share of the lines' length that is held at both ends, and at one at least.
    pub held: [f64; 2],
    /// The long spans among these \[units\].
    pub span: [f64; 2],
    /// Length of the edges that run so or at right angles to it \[units\].
    pub edge: f64,
}

/// A patch, ready to be measured.
#[derive(Debug)]
pub struct Measure<'a> {
    patch: &'a Rows,
    below: Cells<'a>,
    cells: Cells<'a>,
    grid: Grid<'a>,
    /// Extent along the rows \[units\].
    width: f64,
}

impl<'a> Measure<'a> {
    /// A connected patch, and what lies below the layer.
    pub fn new(patch: &'a Rows, below: &'a Rows, grid: Grid<'a>) -> Self {
        let low = patch.spans().iter().map(|s| s.start).min().unwrap_or(0);
        let high = patch.spans().iter().map(|s| s.end).max().unwrap_or(0);
        let corner = (low, patch.first());
        let pitch = grid.frame.pitch();
        Self {
            patch,
            below: Cells::new(below, pitch, corner),
            cells: Cells::new(patch, pitch, corner),
            grid,
            width: (i64::from(high) - i64::from(low)) as f64,
        }
    }

    /// The direction \[degrees\], 0 to below 180, in which most of the lines' length is held at both
    /// ends, else at one; of like ones that with the shortest spans, then along the longest edges, then
    /// the smallest. `None` where no direction is held.
    pub fn best(&self) -> Option<f64> {
        let edges = self.edges();
        let longest = edges.first().map_or(0.0, |e| e.1);
        let grid = (0..(180.0 / STEP) as u32).map(|i| (f64::from(i) * STEP, 0.0));
        let sides = edges.iter().flat_map(|&(d, l)| [(d, l), (d + 90.0, l)]);
        let relevant = sides.filter(|e| e.1 >= longest / 4.0);
        let scores: Vec<Score> = grid
            .chain(relevant)
            .map(|(degrees, edge)| Score { edge, ..self.score(degrees.rem_euclid(180.0)) })
            .collect();
        choose(scores, self.grid.frame.pitch() as f64)
    }

    /// Measures a direction.
    pub fn score(&self, degrees: f64) -> Score {
        let pitch = self.grid.frame.pitch() as f64;
        let (sin, cos) = libm::sincos((degrees - self.grid.degrees).rem_euclid(180.0) * PI / 180.0);
        let rows = f64::from(self.patch.end() - self.patch.first());
        // The corners of the patch's bounds, across the lines.
        let (t0, t1) = (-0.5 * pitch, (rows - 0.5) * pitch);
        let across =
            [(0.0, t0), (self.width, t0), (0.0, t1), (self.width, t1)].map(|(s, t)| t * cos - s * sin);
        let low = across.into_iter().fold(f64::INFINITY, f64::min);
        let extent = across.into_iter().fold(f64::NEG_INFINITY, f64::max) - low;
        let lines = (extent / pitch).round().clamp(LINES[0], LINES[1]);
        let mut found: [Vec<f64>; 2] = Default::default();
        let mut all = 0.0;
        for i in 0..lines as u32 {
            let q = low + extent * (f64::from(i) + 0.5) / lines;
            let line = Line { from: (-q * sin, q * cos), along: (cos, sin) };
            self.cells.pieces(line, |from, to| {
                all += to - from;
                let ends = [self.rests(line, from, -1.0), self.rests(line, to, 1.0)];
                if ends[0] || ends[1] {
                    found[1].push(to - from);
                }
                if ends[0] && ends[1] {
                    found[0].push(to - from);
                }
            });
        }
        let held = [0, 1].map(|i: usize| if all > 0.0 { found[i].iter().sum::<f64>() / all } else { 0.0 });
        Score { degrees, held, span: found.map(long), edge: 0.0 }
    }

    /// True when a line goes on over something that lies below within two rows of its end.
    fn rests(&self, line: Line, end: f64, way: f64) -> bool {
        let step = self.grid.frame.pitch() as f64 / 2.0;
        (1..=4).any(|i| self.below.holds(line.at(end + way * step * f64::from(i))))
    }

    /// The directions \[degrees\] of the patch's straight edges and their lengths \[units\], longest first.
    fn edges(&self) -> Vec<(f64, f64)> {
        let mut runs = Vec::new();
        let pitch = self.grid.frame.pitch() as f64;
        for side in [0, 1] {
            self.straight_runs(side, |run| {
                let (rows, s) = (run.rows as f64 * pitch, run.length);
                let degrees = libm::atan2(rows, s) * 180.0 / PI + self.grid.degrees;
                runs.push((degrees.rem_euclid(180.0), (rows * rows + s * s).sqrt()));
            });
        }
        // Edges along the rows are the ends of the stack, seen where a span has nothing beside it.
        let along =
            self.patch.iter().flat_map(|(k, row)| [k - 1, k + 1].map(|j| bare(row, self.patch.row(j))));
        let along = along.fold(0, |a: i64, b| a.max(b)) as f64;
        runs.push((self.grid.degrees.rem_euclid(180.0), along));
        runs.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.total_cmp(&b.0)));
        let mut edges: Vec<(f64, f64)> = Vec::new();
        for (degrees, length) in runs {
            let apart = |e: f64| ((degrees - e + 90.0).rem_euclid(180.0) - 90.0).abs();
            match edges.iter_mut().find(|e| apart(e.0) < SAME_EDGE) {
                Some(same) => same.1 += length,
                None => edges.push((degrees, length)),
            }
        }
        edges.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.total_cmp(&b.0)));
        edges.truncate(EDGES);
        edges
    }

    /// The stretches on which the spans' starts (side 0) or ends (1) go on by the same step.
    fn straight_runs(&self, side: usize, mut found: impl FnMut(Run)) {
        let slack = self.grid.frame.units(STRAIGHT.0) as f64;
        let end = |s: Span| f64::from(if side == 0 { s.start } else { s.end });
        let mut now: Vec<Option<Run>> = Vec::new();
        let mut done = |run: Option<Run>| {
            if let Some(run) = run.filter(|r| r.rows + 1 >= STRAIGHT.1) {
                found(run);
            }
        };
        for (k, row) in self.patch.iter() {
            let above = self.patch.row(k + 1);
            now.resize(row.len(), None);
            let mut next = vec![None; above.len()];
            for (i, span) in row.iter().enumerate() {
                let run = now[i].take();
                let Some(j) = neighbour(row, i, above, side) else {
                    done(run);
                    continue;
                };
                let step = end(above[j]) - end(*span);
                next[j] = match run {
                    Some(r) if (r.length / r.rows as f64 - step).abs() <= slack => {
                        Some(Run { rows: r.rows + 1, length: r.length + step })
                    }
                    _ => {
                        done(run);
                        Some(Run { rows: 1, length: step })
                    }
                };
            }
            now = next;
        }
        now.into_iter().for_each(done);
    }
}

/// A straight stretch of border: rows, and the way along them \[units\].
#[derive(Clone, Copy, Debug)]
struct Run {
    rows: usize,
    length: f64,
}

/// The span of the row above that goes on at the same side as span `i`, if both are the first (side 0)
/// or last (1) to overlap each other.
fn neighbour(row: &[Span], i: usize, above: &[Span], side: usize) -> Option<usize> {
    let overlap = |a: Span, b: Span| a.start < b.end && b.start < a.end;
    let pick = |spans: &[Span], with: Span| match side {
        0 => spans.iter().position(|&s| overlap(s, with)),
        _ => spans.iter().rposition(|&s| overlap(s, with)),
    };
    let j = pick(above, row[i])?;
    (pick(row, above[j]) == Some(i)).then_some(j)
}

/// The longest stretch of a row with nothing beside it \[units\].
fn bare(row: &[Span], beside: &[Span]) -> i64 {
    let mut longest = 0;
    for s in row {
        let mut at = i64::from(s.start);
        for b in beside.iter().filter(|b| b.end > s.start && b.start < s.end) {
            longest = longest.max(i64::from(b.start) - at);
            at = i64::from(b.end);
        }
        longest = longest.max(i64::from(s.end) - at);
    }
    longest
}

/// The span length below which most of the length lies.
fn long(mut spans: Vec<f64>) -> f64 {
    spans.sort_by(f64::total_cmp);
    let all: f64 = spans.iter().sum();
    let mut sum = 0.0;
    for &s in &spans {
        sum += s;
        if sum >= LONG * all {
            return s;
        }
    }
    0.0
}

/// The direction of the best of some scores; rows are so far apart \[units\].
fn choose(mut scores: Vec<Score>, row: f64) -> Option<f64> {
    let best = |scores: &[Score], of: &dyn Fn(&Score) -> f64| scores.iter().map(of).fold(0.0, f64::max);
    let ends = [0, 1].into_iter().find(|&i: &usize| best(&scores, &|s| s.held[i]) >= ALIKE)?;
    let most = best(&scores, &|s| s.held[ends]);
    scores.retain(|s| s.held[ends] >= most - ALIKE && s.held[ends] > 0.0);
    let shortest = scores.iter().map(|s| s.span[ends]).fold(f64::INFINITY, f64::min);
    scores.retain(|s| s.span[ends] <= shortest * ALIKE_SPAN + row);
    let edge = best(&scores, &|s| s.edge);
    scores.retain(|s| s.edge >= 0.9 * edge);
    let most = best(&scores, &|s| s.held[ends]);
    scores.retain(|s| s.held[ends] >= most - ALIKE / 10.0);
    scores.iter().map(|s| s.degrees).min_by(f64::total_cmp)
}
