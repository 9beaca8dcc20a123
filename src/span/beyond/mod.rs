//! What of an area lies out of reach of another one.

#[cfg(feature = "gpu")]
pub mod gpu;
pub mod pairs;
pub mod twin;

use super::{Rows, RowsBuilder, Span};
use std::mem::swap;

/// Half the length of a disc's chords \[units\] by their distance from its middle in rows: what
/// [`super::morph::dilate_disc`] makes spans longer by at both ends. Rows lie `pitch` \[units\] apart.
pub fn half_widths(radius: i64, pitch: i64) -> Vec<i32> {
    thick_half_widths(radius, pitch, 0)
}

/// As [`half_widths`] for a disc that has been made `thick` rows longer across the rows, to either side.
pub fn thick_half_widths(radius: i64, pitch: i64, thick: u32) -> Vec<i32> {
    let (radius, pitch) = (radius.clamp(0, super::morph::MOST_RADIUS), pitch.max(1));
    let width = |row: i64| {
        let distance = (row - i64::from(thick)).max(0) * pitch;
        (radius * radius - distance * distance).max(0).isqrt() as i32
    };
    (0..=radius / pitch + i64::from(thick)).map(width).collect()
}

/// The part of `a` that no span of `b` covers when the spans of the rows `m` further are made longer by
/// `widths[m]` \[units\] at both ends.
///
/// With [`half_widths`] it is `sub(a, &dilate_disc(b, radius, t))`, span for span, for evenly spaced rows. Costs
/// about the rows of `a`, and where something is left of it, the rows in reach.
pub fn beyond(a: &Rows, b: &Rows, widths: &[i32]) -> Rows {
    let rows = (a.end() - a.first()).max(0) as usize;
    let mut out = RowsBuilder::with_capacity(a.first(), rows, 0);
    let (mut left, mut next): (Vec<Span>, Vec<Span>) = (Vec::new(), Vec::new());
    for (k, row) in a.iter() {
        left.clear();
        cut(row, b.row(k), widths.first().copied().unwrap_or(0), &mut left);
        for (m, &by) in (1..).zip(widths.iter().skip(1)) {
            for near in [k.saturating_sub(m), k.saturating_add(m)] {
                let cover = b.row(near);
                if !left.is_empty() && !cover.is_empty() {
                    next.clear();
                    cut(&left, cover, by, &mut next);
                    swap(&mut left, &mut next);
                }
            }
            if left.is_empty() {
                break;
            }
        }
        for s in &left {
            out.push(s.start, s.end);
        }
        out.end_row();
    }
    out.finish()
}

/// Appends what of `row` lies outside `cover`, whose spans are `by` longer at both ends.
fn cut(row: &[Span], cover: &[Span], by: i32, out: &mut Vec<Span>) {
    let mut j = 0;
    for span in row {
        let mut start = span.start;
        if cover.len() - j > 8 {
            j += cover[j..].partition_point(|c| c.end.saturating_add(by) <= start);
        }
        while j < cover.len() && cover[j].end.saturating_add(by) <= start {
            j += 1;
        }
        let mut i = j;
        while start < span.end
            && let Some(c) = cover.get(i)
        {
            let from = c.start.saturating_sub(by);
            if from >= span.end {
                break;
            }
            if start < from {
                out.push(Span { start, end: from });
            }
            start = start.max(c.end.saturating_add(by));
            i += 1;
        }
        if start < span.end {
            out.push(Span { start, end: span.end });
        }
    }
}

#[cfg(test)]
#[allow(clippy::expect_used)]
mod tests {
    use super::pairs::{Pairs, REACH};
    use super::*;
    use crate::slice::cpu;
    use crate::span::algebra::{dilate, sub};
    use crate::span::morph::dilate_disc;
    use crate::span::tests::Random;

    /// What the kernels would leave.
    fn by_twins(pairs: &Pairs) -> Option<Vec<Rows>> {
        let offset = cpu::scan(&twin::count(pairs));
        pairs.unpack(&offset, &twin::fill(pairs, &offset))
    }

    /// Up to six spans in each of some rows.
    fn area(random: &mut Random) -> Rows {
        let mut out = RowsBuilder::new(random.within(-9, 9) as i32);
        for _ in 0..random.below(20) {
            let mut at = random.within(-300, 0) as i32;
            for _ in 0..random.below(7) {
                let end = at + random.within(1, 90) as i32;
                out.push(at, end);
                at = end + random.within(1, 120) as i32;
            }
            out.end_row();
        }
        out.finish()
    }

    #[test]
    fn it_is_the_rest_of_a_dilation() {
        let (mut rest, mut whole, mut faults) = (0, 0, 0);
        for seed in 1..600 {
            let mut random = Random(seed * 104_729);
            let (a, b) = (area(&mut random), area(&mut random));
            let (radius, pitch) = (random.within(0, 60), random.within(1, 30));
            let found = beyond(&a, &b, &half_widths(radius, pitch));
            let expected = sub(&a, &dilate_disc(&b, radius, |k| i64::from(k) * pitch));
            assert_eq!(found, expected, "seed {seed}, radius {radius}, pitch {pitch}");
            let wrong = beyond(&a, &b, &half_widths(radius + 1, pitch));
            faults += u32::from(wrong != expected);
            (rest, whole) = (rest + found.length(), whole + a.length());
        }
        assert!(rest * 10 > whole && rest * 10 < whole * 9, "{rest} of {whole}");
        assert!(faults > 100, "{faults}");
    }

    #[test]
    fn a_thick_disc_is_a_dilation_by_rows_first() {
        for seed in 1..200 {
            let mut random = Random(seed * 7_919);
            let (a, b) = (area(&mut random), area(&mut random));
            let (radius, pitch) = (random.within(0, 60), random.within(1, 30));
            let found = beyond(&a, &b, &thick_half_widths(radius, pitch, 1));
            let thick = dilate(&b, 1, 0);
            let expected = sub(&a, &dilate_disc(&thick, radius, |k| i64::from(k) * pitch));
            assert_eq!(found, expected, "seed {seed}");
        }
    }

    #[test]
    fn the_twins_leave_the_same() {
        let (mut spans, mut faults) = (0, 0);
        for seed in 1..40 {
            let mut random = Random(seed * 15_485_863);
            let (mut pairs, mut expected) = (Pairs::default(), Vec::new());
            for _ in 0..random.below(9) {
                let (a, b) = (area(&mut random), area(&mut random));
                let widths = thick_half_widths(random.within(0, 60), random.within(1, 30), seed as u32 % 2);
                assert!(pairs.push(&a, &b, &widths), "seed {seed}");
                expected.push(beyond(&a, &b, &widths));
            }
            let found = by_twins(&pairs).expect("rows");
            assert_eq!(found.len(), expected.len());
            for (found, expected) in found.iter().zip(&expected) {
                assert_eq!(found.spans(), expected.spans(), "seed {seed}");
                let rows = expected.first()..expected.end();
                assert!(rows.clone().all(|k| found.row(k) == expected.row(k)), "seed {seed}");
                spans += found.spans().len();
            }
            pairs.widths.iter_mut().for_each(|width| *width += 1);
            let wrong = by_twins(&pairs).expect("rows");
            faults += u32::from(wrong.iter().zip(&expected).any(|(w, e)| w.spans() != e.spans()));
        }
        assert!(spans > 1000 && faults > 10, "{spans}, {faults}");
    }

    #[test]
    fn what_32_bits_do_not_hold_is_refused() {
        let span = |start, end| {
            let mut out = RowsBuilder::new(0);
            out.push(start, end);
            out.end_row();
            out.finish()
        };
        let (small, large) = (span(0, 9), span(0, REACH));
        let mut pairs = Pairs::default();
        assert!(pairs.push(&small, &small, &[]) && pairs.push(&small, &Rows::default(), &[REACH - 1]));
        assert!(!pairs.push(&large, &small, &[0]) && !pairs.push(&small, &large, &[0]));
        assert!(!pairs.push(&small, &small, &[REACH]) && !pairs.push(&small, &small, &[-1]));
        let left = by_twins(&pairs).expect("rows");
        assert_eq!((left.len(), left[0].is_empty(), &left[1]), (2, true, &small));
    }
}
