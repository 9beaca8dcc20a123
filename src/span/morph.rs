//! Dilation and erosion of areas by a disc, exact on the rows of a frame.
//!
//! The rows need not be evenly spaced: their positions are a function of their number. Across the rows
//! the disc sees what the rows show and no more, so a radius below their distance works along them only.

use super::{Rows, RowsBuilder, Span};
use std::ops::Range;

/// Radii above this are cut off \[units\]; a square of one fits an `i64`.
pub const MOST_RADIUS: i64 = 1 << 30;

/// Grows an area by `radius` \[units\], or shrinks it by a negative one; see [`dilate_disc`] and
/// [`erode_disc`].
pub fn offset_disc(area: &Rows, radius: i64, t: impl Fn(i32) -> i64) -> Rows {
    if radius < 0 { erode_disc(area, radius.saturating_neg(), t) } else { dilate_disc(area, radius, t) }
}

/// Dilation by a disc: every point at most `radius` \[units\] from the area.
///
/// `t` is the position of a row across the rows \[units\], strictly ascending. An output row is the
/// union, over the rows at a distance `d <= radius`, of their spans made longer at both ends by the
/// integer part of `sqrt(radius² - d²)`. Costs about spans times rows in reach; spans that lie inside one
/// of the row next to them reach no further than that one and are left out.
pub fn dilate_disc(area: &Rows, radius: i64, t: impl Fn(i32) -> i64) -> Rows {
    if radius <= 0 || area.is_empty() {
        return area.clone();
    }
    let radius = radius.min(MOST_RADIUS);
    spread(area, radius, in_reach(area.first()..area.end(), radius, &t), &t)
}

/// Erosion by a disc: the complement of the dilated complement, so that
/// [`dilate_disc`] tells all. Rows without a span are outside.
pub fn erode_disc(area: &Rows, radius: i64, t: impl Fn(i32) -> i64) -> Rows {
    if radius <= 0 || area.is_empty() {
        return area.clone();
    }
    let radius = radius.min(MOST_RADIUS);
    let rows = area.first()..area.end();
    // Of the rows beyond, which are all outside, the nearest reaches furthest in.
    let outside = complement(area, rows.start.saturating_sub(1)..rows.end.saturating_add(1));
    complement(&spread(&outside, radius, rows.clone(), &t), rows)
}

/// The rows at most `radius` from some of `rows`.
fn in_reach(rows: Range<i32>, radius: i64, t: &impl Fn(i32) -> i64) -> Range<i32> {
    let (mut first, mut last) = (rows.start, rows.end - 1);
    let (low, high) = (t(first) - radius, t(last) + radius);
    while first > i32::MIN / 2 && t(first - 1) >= low && t(first - 1) < t(first) {
        first -= 1;
    }
    while last < i32::MAX / 2 && t(last + 1) <= high && t(last + 1) > t(last) {
        last += 1;
    }
    first..last + 1
}

/// What lies between the spans, from one end of the coordinates to the other.
fn complement(area: &Rows, rows: Range<i32>) -> Rows {
    let count = rows.len();
    let mut out = RowsBuilder::with_capacity(rows.start, count, area.spans().len() + count);
    for k in rows {
        let mut at = i32::MIN;
        for s in area.row(k) {
            out.push(at, s.start);
            at = s.end;
        }
        out.push(at, i32::MAX);
        out.end_row();
    }
    out.finish()
}

/// The given rows of the dilated area.
fn spread(area: &Rows, radius: i64, rows: Range<i32>, t: &impl Fn(i32) -> i64) -> Rows {
    // Seen from below a row counts only where the row under it does not hide it, and vice versa.
    let (from_below, from_above) = (not_within(area, -1), not_within(area, 1));
    let mut out = RowsBuilder::with_capacity(rows.start, rows.len(), area.spans().len());
    let mut widths = Widths { radius, known: Vec::new() };
    let mut found: Vec<Span> = Vec::new();
    let (mut low, mut high) = (area.first(), area.first());
    for k in rows {
        let here = t(k);
        while low < area.end() && t(low) < here - radius {
            low += 1;
        }
        while high < area.end() && t(high) <= here + radius {
            high += 1;
        }
        found.clear();
        // Nearest first: what is further away is then mostly covered already.
        let mut add = |j: i32, row: &[Span]| {
            if !row.is_empty() {
                unite(&mut found, row, widths.at(j.abs_diff(k), t(j) - here));
            }
        };
        add(k, area.row(k));
        let (mut under, mut over) = (k.min(high), (k + 1).max(low));
        while under > low || over < high {
            if under > low {
                under -= 1;
                add(under, from_above.row(under));
            }
            if over < high {
                add(over, from_below.row(over));
                over += 1;
            }
        }
        for s in &found {
            out.push(s.start, s.end);
        }
        out.end_row();
    }
    out.finish()
}

/// Adds the spans of a row, longer by `by` at both ends, to disjoint ascending spans.
fn unite(all: &mut Vec<Span>, row: &[Span], by: i32) {
    let mut i = 0;
    for s in row {
        let (start, end) = (s.start.saturating_sub(by), s.end.saturating_add(by));
        while i < all.len() && all[i].end < start {
            i += 1;
        }
        match all.get_mut(i) {
            Some(old) if old.start <= end => {
                old.start = old.start.min(start);
                if end <= old.end {
                    continue;
                }
                old.end = end;
                // It may have grown into those behind it.
                let mut behind = i + 1;
                while behind < all.len() && all[behind].start <= end {
                    all[i].end = all[i].end.max(all[behind].end);
                    behind += 1;
                }
                if behind > i + 1 {
                    all.drain(i + 1..behind);
                }
            }
            _ => all.insert(i, Span { start, end }),
        }
    }
}

/// The spans that lie in no span of the row `step` further.
fn not_within(area: &Rows, step: i32) -> Rows {
    let count = area.end() - area.first();
    let mut out = RowsBuilder::with_capacity(area.first(), count as usize, area.spans().len());
    for (k, row) in area.iter() {
        let over = area.row(k + step);
        let mut i = 0;
        for s in row {
            while i < over.len() && over[i].end < s.end {
                i += 1;
            }
            if i == over.len() || over[i].start > s.start {
                out.push(s.start, s.end);
            }
        }
        out.end_row();
    }
    out.finish()
}

/// Half the length of the disc's chords. Distances repeat from row to row, so the last one of each
/// number of rows is kept.
struct Widths {
    radius: i64,
    known: Vec<(i64, i32)>,
}

impl Widths {
    fn at(&mut self, rows: u32, distance: i64) -> i32 {
        let i = rows as usize;
        if i >= self.known.len() {
            self.known.resize(i + 1, (i64::MAX, 0));
        }
        let distance = distance.abs();
        if self.known[i].0 != distance {
            // Not above 2^60, and never negative: rows further away are not asked for.
            let square = self.radius * self.radius - distance * distance;
            self.known[i] = (distance, square.max(0).isqrt() as i32);
        }
        self.known[i].1
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::span::algebra;
    use crate::span::tests::Random;

    /// Rows `pitch / 3` apart, rounded as sub-rows are.
    fn uneven(pitch: i64) -> impl Fn(i32) -> i64 {
        move |k| i64::from(k.div_euclid(3)) * pitch + (2 * i64::from(k.rem_euclid(3)) + 1) * pitch / 6
    }

    fn random_area(random: &mut Random) -> Rows {
        let mut out = RowsBuilder::new(random.within(-5, 5) as i32);
        for _ in 0..random.within(1, 14) {
            let mut at = random.within(-30, 0) as i32;
            for _ in 0..random.within(0, 4) {
                let end = at + random.within(1, 25) as i32;
                out.push(at, end);
                at = end + random.within(1, 25) as i32;
            }
            out.end_row();
        }
        out.finish()
    }

    /// Is a cell of the area at most `radius` from cell `s` of row `k`?
    fn dilated_cell(area: &Rows, radius: i64, t: &impl Fn(i32) -> i64, k: i32, s: i32) -> bool {
        area.iter().any(|(j, row)| {
            let d = t(j) - t(k);
            row.iter().any(|x| {
                let ds = i64::from((x.start - s).max(s - (x.end - 1)).max(0));
                d * d + ds * ds <= radius * radius
            })
        })
    }

    #[test]
    fn both_equal_a_search_cell_by_cell() {
        for seed in 0..60 {
            let mut random = Random(seed * 7919 + 1);
            let area = random_area(&mut random);
            let t = uneven(random.within(3, 40));
            let radius = random.within(0, 30);
            let (grown, shrunk) = (dilate_disc(&area, radius, &t), erode_disc(&area, radius, &t));
            let holds =
                |rows: &Rows, k: i32, s: i32| rows.row(k).iter().any(|x| (x.start..x.end).contains(&s));
            let outside = complement(&area, area.first() - 40..area.end() + 40);
            let mut clipped = RowsBuilder::new(outside.first());
            for (_, row) in outside.iter() {
                row.iter().for_each(|s| clipped.push(s.start.max(-200), s.end.min(400)));
                clipped.end_row();
            }
            let outside = clipped.finish();
            for k in (area.first() - 35..area.end() + 35).step_by(1 + seed as usize % 3) {
                for s in (-70..170).step_by(1 + seed as usize % 5) {
                    let expected = dilated_cell(&area, radius, &t, k, s);
                    assert_eq!(holds(&grown, k, s), expected, "dilation, seed {seed}, row {k}, s {s}");
                    if (area.first()..area.end()).contains(&k) {
                        let expected = !dilated_cell(&outside, radius, &t, k, s);
                        assert_eq!(holds(&shrunk, k, s), expected, "erosion, seed {seed}, row {k}, s {s}");
                    }
                }
            }
            assert!(algebra::sub(&area, &grown).is_empty() && algebra::sub(&shrunk, &area).is_empty());
        }
    }

    #[test]
    fn a_square_grows_round_corners() {
        let mut square = RowsBuilder::new(0);
        for _ in 0..1000 {
            square.push(0, 1_000_000);
            square.end_row();
        }
        let (square, t) = (square.finish(), |k: i32| i64::from(k) * 1000);
        let area = |rows: &Rows| rows.length() as f64 * 1000.0 * 1e-12;
        let grown = area(&offset_disc(&square, 100_000, t));
        let expected = 1.0 + 4.0 * 0.1 + std::f64::consts::PI * 0.01;
        assert!((grown - expected).abs() < 0.001, "{grown} for {expected}");
        let shrunk = area(&offset_disc(&square, -100_000, t));
        assert!((shrunk - 0.64).abs() < 0.002, "{shrunk}");
        assert_eq!(offset_disc(&square, 0, t), square);
        assert!(offset_disc(&square, -600_000, t).is_empty());
        // A radius cut off at the limit, and a function that does not ascend, end all the same.
        assert!(erode_disc(&square, i64::MAX, t).is_empty());
        assert_eq!(dilate_disc(&square, 5, |_| 0).end(), 1000);
    }
}
