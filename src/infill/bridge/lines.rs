//! Straight lines through an area that is known on the rows of another direction.

use crate::span::{Rows, Span};

/// An area as cells: a span stands for the strip half a row to either side of it.
///
/// Positions are relative to `corner`, so that an area that is moved by whole rows is seen alike.
#[derive(Clone, Copy, Debug)]
pub struct Cells<'a> {
    rows: &'a Rows,
    pitch: f64,
    /// Position along the rows, and row, that become (0, 0).
    corner: (i32, i32),
}

/// A line: where it begins, and its direction, upwards or along +s \[units of the frame\].
#[derive(Clone, Copy, Debug)]
pub struct Line {
    /// A point on it.
    pub from: (f64, f64),
    /// Cosine and sine of its direction; the sine is not negative.
    pub along: (f64, f64),
}

impl Line {
    /// The point at a distance from the first.
    pub fn at(&self, x: f64) -> (f64, f64) {
        (self.from.0 + x * self.along.0, self.from.1 + x * self.along.1)
    }
}

/// Flatter lines stay in their row \[sine\].
const FLAT: f64 = 1e-6;
/// Pieces that are less apart than this are one \[units\].
const JOIN: f64 = 2.0;

impl<'a> Cells<'a> {
    /// The area, seen from `corner`: a position along the rows, and a row.
    pub fn new(rows: &'a Rows, pitch: i64, corner: (i32, i32)) -> Self {
        Self { rows, pitch: pitch as f64, corner }
    }

    /// True where the area is.
    pub fn holds(&self, (s, t): (f64, f64)) -> bool {
        let row = self.row((t / self.pitch + 0.5).floor() as i32);
        let i = row.partition_point(|span| self.s(span.end) <= s);
        row.get(i).is_some_and(|span| self.s(span.start) <= s)
    }

    /// The pieces of a line inside, in its direction, as distances from its first point.
    pub fn pieces(&self, line: Line, mut piece: impl FnMut(f64, f64)) {
        let mut open: Option<(f64, f64)> = None;
        let mut add = |from: f64, to: f64| match &mut open {
            Some(last) if from <= last.1 + JOIN => last.1 = last.1.max(to),
            _ => {
                if let Some(done) = open.replace((from, to)) {
                    piece(done.0, done.1);
                }
            }
        };
        let (cos, sin) = line.along;
        if sin < FLAT {
            let row = self.row((line.from.1 / self.pitch + 0.5).floor() as i32);
            let ends = |span: &Span| (self.s(span.start) - line.from.0, self.s(span.end) - line.from.0);
            if cos > 0.0 {
                row.iter().map(ends).for_each(|(a, b)| add(a, b));
            } else {
                row.iter().rev().map(ends).for_each(|(a, b)| add(-b, -a));
            }
        } else {
            let first = self.rows.first() - self.corner.1;
            let last = self.rows.end() - self.corner.1;
            let step = self.pitch / sin;
            let mut enter = (f64::from(first) * self.pitch - self.pitch / 2.0 - line.from.1) / sin;
            for k in first..last {
                self.cross(self.row(k), line, (enter, enter + step), &mut add);
                enter += step;
            }
        }
        if let Some(done) = open {
            piece(done.0, done.1);
        }
    }

    /// The pieces within one row, where the line is between two distances.
    fn cross(&self, row: &[Span], line: Line, x: (f64, f64), add: &mut impl FnMut(f64, f64)) {
        let (s0, s1) = (line.at(x.0).0, line.at(x.1).0);
        let (low, high) = (s0.min(s1), s0.max(s1));
        let first = row.partition_point(|span| self.s(span.end) <= low);
        let behind = first + row[first..].partition_point(|span| self.s(span.start) <= high);
        let mut one = |span: &Span| {
            let (a, b) = (self.s(span.start), self.s(span.end));
            if a <= low && b >= high {
                return add(x.0, x.1);
            }
            let at = |s: f64| (s - line.from.0) / line.along.0;
            let (a, b) = (at(a), at(b));
            let (from, to) = (a.min(b).max(x.0), a.max(b).min(x.1));
            if from < to {
                add(from, to);
            }
        };
        if line.along.0 > 0.0 {
            row[first..behind].iter().for_each(&mut one);
        } else {
            row[first..behind].iter().rev().for_each(&mut one);
        }
    }

    fn row(&self, k: i32) -> &[Span] {
        self.rows.row(k.saturating_add(self.corner.1))
    }

    fn s(&self, s: i32) -> f64 {
        (i64::from(s) - i64::from(self.corner.0)) as f64
    }
}
