//! Directed edges → sorted spans per row: no rings, no links, no order.
//!
//! The rules are those of [`super::scan()`], and so are the bits. Crossings are counted per row before
//! they are computed, so each goes straight to its row; rows are then sorted, which are short.

use super::scan::crossing;
use super::{RowFrame, Rows, RowsBuilder};
use crate::lattice::Point2;
use crate::slice::crossing::moved;
use std::ops::Range;

/// Scans the edges of one section after another; its memory is used again.
#[derive(Clone, Debug)]
pub struct EdgeScan {
    frame: RowFrame,
    search: RowSearch,
    /// The edges that cross rows.
    lines: Vec<Line>,
    /// The first row.
    first: i32,
    /// Per row the end of its keys.
    end: Vec<usize>,
    /// Per row its position \[units\].
    at: Vec<f64>,
    /// Crossings row by row: the position, doubled, plus one where the edge runs upwards.
    keys: Vec<i64>,
}

/// An edge that crosses rows, from its lower end.
#[derive(Clone, Copy, Debug)]
struct Line {
    s: [i32; 2],
    t: [i32; 2],
    /// The rows that it crosses, counted from the first.
    from: u32,
    to: u32,
    up: bool,
}

impl EdgeScan {
    /// For the rows of a frame.
    pub fn new(frame: &RowFrame) -> Self {
        Self {
            frame: *frame,
            search: RowSearch::new(frame),
            lines: Vec::new(),
            first: 0,
            end: Vec::new(),
            at: Vec::new(),
            keys: Vec::new(),
        }
    }

    /// The non-zero winding interior of directed edges \[nm\], as [`super::scan()`] gives it for the rings
    /// that they were cut from.
    pub fn scan(&mut self, edges: &[[Point2; 2]]) -> Rows {
        let rows = self.load(edges, i32::MIN + 1..i32::MAX);
        let mut out = RowsBuilder::with_capacity(rows.start, rows.len(), self.keys.len() / 2);
        for k in rows.clone() {
            self.row(k, |start, end| out.push(start, end));
            out.end_row();
        }
        if rows.is_empty() { Rows::default() } else { out.finish() }
    }

    /// Takes the edges \[nm\] of a section and returns the rows from the first to the last that they
    /// cross within some.
    pub fn load(&mut self, edges: &[[Point2; 2]], within: Range<i32>) -> Range<i32> {
        let frame = self.frame;
        match frame.direction() {
            Some([1, 0]) => self.count(edges, within, |p| (p.x, p.y)),
            Some([0, 1]) => self.count(edges, within, |p| (p.y, -p.x)),
            _ => self.count(edges, within, |p| frame.st(p)),
        }
        self.cut();
        let is_hit = |i: &usize| self.end[*i] > self.begin(*i);
        let (Some(first), Some(last)) =
            ((0..self.end.len()).find(is_hit), (0..self.end.len()).rev().find(is_hit))
        else {
            return 0..0;
        };
        self.first + first as i32..self.first + last as i32 + 1
    }

    /// Hands over the ends of the spans of a row in ascending order. Spans may touch or be empty.
    #[inline]
    pub fn row(&mut self, k: i32, mut span: impl FnMut(i32, i32)) {
        let i = k.wrapping_sub(self.first) as usize;
        let Some(&end) = self.end.get(i) else { return };
        let begin = self.begin(i);
        let Some(keys) = self.keys.get_mut(begin..end) else { return };
        sort(keys);
        let (mut winding, mut open) = (0, 0);
        for &key in &*keys {
            let s = (key >> 1) as i32;
            if winding == 0 {
                open = s;
            }
            winding += ((key & 1) << 1) - 1;
            if winding == 0 {
                span(open, s);
            }
        }
    }

    fn begin(&self, i: usize) -> usize {
        if i == 0 { 0 } else { self.end[i - 1] }
    }

    /// Finds the edges that cross rows, and how many cross each.
    fn count(&mut self, edges: &[[Point2; 2]], within: Range<i32>, st: impl Fn(Point2) -> (i32, i32)) {
        self.lines.clear();
        self.end.clear();
        self.at.clear();
        let (mut low, mut high) = (i32::MAX, i32::MIN);
        for edge in edges {
            let (a, b) = (st(edge[0]).1, st(edge[1]).1);
            (low, high) = (low.min(a).min(b), high.max(a).max(b));
        }
        if low >= high {
            return;
        }
        // Rows up to `below` lie below all, those above `last` above all.
        let below = self.search.row_below(low).max(within.start.saturating_sub(1));
        let last = self.search.row_below(high).min(within.end.saturating_sub(1));
        if below >= last {
            return;
        }
        self.first = below + 1;
        let rows = (last - below) as usize;
        self.end.resize(rows + 1, 0);
        self.lines.reserve(edges.len());
        for &[a, b] in edges {
            let ((s0, t0), (s1, t1)) = (st(a), st(b));
            let a = (self.search.row_below(t0).clamp(below, last) - below) as u32;
            let b = (self.search.row_below(t1).clamp(below, last) - below) as u32;
            let line = if a < b {
                Line { s: [s0, s1], t: [t0, t1], from: a, to: b, up: true }
            } else if a > b {
                Line { s: [s1, s0], t: [t1, t0], from: b, to: a, up: false }
            } else {
                continue;
            };
            // Steps up and down, summed below; wrapping, as a sum may pass below zero on its way.
            self.end[line.from as usize] = self.end[line.from as usize].wrapping_add(1);
            self.end[line.to as usize] = self.end[line.to as usize].wrapping_sub(1);
            self.lines.push(line);
        }
        let (mut count, mut total) = (0usize, 0usize);
        self.at.reserve(rows);
        self.end.truncate(rows);
        for (k, end) in (self.first..).zip(&mut self.end) {
            count = count.wrapping_add(*end);
            *end = total;
            total += count;
            self.at.push(self.frame.t(k) as f64);
        }
        self.keys.resize(total, 0);
    }

    /// Computes the crossings.
    fn cut(&mut self) {
        for line in &self.lines {
            let (from, to) = (line.from as usize, line.to as usize);
            let low = f64::from(line.t[0]);
            // Differences are below 2^32 and exact; quotient and product then err by less than `moved`
            // allows for.
            let slope = (f64::from(line.s[1]) - f64::from(line.s[0])) / (f64::from(line.t[1]) - low);
            for (end, &t) in self.end[from..to].iter_mut().zip(&self.at[from..to]) {
                let (s, certain) = moved(line.s[0], slope * (t - low));
                let s = if certain { s } else { line.exact(t) };
                if let Some(key) = self.keys.get_mut(*end) {
                    *key = i64::from(s) << 1 | i64::from(line.up);
                }
                *end += 1;
            }
        }
    }
}

impl Line {
    #[cold]
    fn exact(&self, t: f64) -> i32 {
        crossing(self.s[0], self.t[0], self.s[1], self.t[1], t as i64)
    }
}

/// Rows have few crossings, mostly.
#[inline]
fn sort(keys: &mut [i64]) {
    match keys {
        [] | [_] => {}
        [a, b] => (*a, *b) = ((*a).min(*b), (*a).max(*b)),
        _ if keys.len() > 20 => keys.sort_unstable(),
        _ => {
            for i in 1..keys.len() {
                let key = keys[i];
                let mut j = i;
                while j > 0 && keys[j - 1] > key {
                    keys[j] = keys[j - 1];
                    j -= 1;
                }
                keys[j] = key;
            }
        }
    }
}

/// [`RowFrame::row_below`] by multiplication.
#[derive(Clone, Copy, Debug)]
struct RowSearch {
    frame: RowFrame,
    /// Position and undivided number of a row below all others.
    low: i64,
    row: i32,
    pitch: u64,
    /// 2^64 over the pitch, rounded up; 0 where the pitch is too large for the product to be exact.
    inverse: u64,
    sub_rows: u64,
    /// The first one where rows are not divided is in `low`.
    offset: [i64; super::frame::MAX_SUB_ROWS],
}

impl RowSearch {
    fn new(frame: &RowFrame) -> Self {
        let (pitch, n) = (frame.pitch(), frame.sub_rows());
        let shift = if n == 1 { frame.t(0) } else { frame.base() };
        let row = (i64::from(i32::MIN) - shift).div_euclid(pitch);
        let mut offset = [i64::MAX; super::frame::MAX_SUB_ROWS];
        for (to, from) in offset.iter_mut().zip(frame.offsets()) {
            *to = *from;
        }
        Self {
            frame: *frame,
            low: shift + row * pitch,
            row: row as i32,
            pitch: pitch as u64,
            // Lemire et al., "Faster remainder by direct computation" (2019): the quotient is exact while
            // numerator times pitch is below 2^64. Numerators are below 2^33.
            inverse: if pitch < 1 << 28 { u64::MAX / pitch as u64 + 1 } else { 0 },
            sub_rows: n.into(),
            offset,
        }
    }

    fn over_pitch(&self, numerator: u64) -> u64 {
        ((u128::from(numerator) * u128::from(self.inverse)) >> 64) as u64
    }

    #[inline(always)]
    fn row_below(&self, t: i32) -> i32 {
        if self.inverse == 0 {
            return self.frame.row_below(t.into());
        }
        let from_low = (i64::from(t) - self.low) as u64;
        let row = self.over_pitch(from_low);
        if self.sub_rows == 1 {
            return self.row + row as i32;
        }
        let rest = (from_low - row * self.pitch) as i64;
        // Off by at most one, as offsets are rounded.
        let guess = self.over_pitch(rest as u64 * self.sub_rows + self.pitch / 2) as usize;
        let is_above = |j: usize| self.offset.get(j).is_none_or(|&offset| offset > rest);
        let below = if !is_above(guess) {
            guess + 1
        } else if guess > 0 && is_above(guess - 1) {
            guess - 1
        } else {
            guess
        };
        (self.row + row as i32) * self.sub_rows as i32 + below as i32 - 1
    }
}
