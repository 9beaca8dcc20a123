//! Scans against an exact point-in-polygon oracle, algebra against bitmaps.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod edges;
mod sets;

use super::*;
use crate::lattice::{LIMIT, Point2};

/// Xorshift (Marsaglia 2003): the same numbers on every machine.
pub(crate) struct Random(pub u64);

impl Random {
    /// A number in `0..n`.
    pub(crate) fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 16) % n
    }

    /// A number in `low..high`.
    pub(crate) fn within(&mut self, low: i64, high: i64) -> i64 {
        low + self.below((high - low) as u64) as i64
    }
}

const PITCH: i64 = 1000;

fn frames() -> Vec<RowFrame> {
    [0.0, 45.0, 90.0, 135.0, 30.0, 71.5, 180.0, -45.0]
        .into_iter()
        .map(|angle| {
            let probe = RowFrame::new(angle, 0.0, 1e6);
            RowFrame::new(angle, 250.0 / probe.scale(), PITCH as f64 / probe.scale())
        })
        .collect()
}

/// Polygons whose vertices often lie on rows; most intersect themselves.
fn rings(random: &mut Random, frame: &RowFrame) -> Vec<Vec<Point2>> {
    let count = 1 + random.below(3);
    (0..count)
        .map(|_| {
            let corners = 1 + random.below(9);
            (0..corners)
                .map(|_| {
                    let s = 2 * random.within(-300, 300) as i32;
                    let t = 250 + 500 * random.within(-10, 10);
                    frame.xy(s, t)
                })
                .collect()
        })
        .collect()
}

/// True when the middle of cell `s..s+1` of a row is inside: the winding number of the edges that
/// pass strictly left of it, a vertex on the row counting as above.
fn is_inside(rings: &[Vec<Point2>], frame: &RowFrame, row: i32, s: i64) -> bool {
    let t = i128::from(frame.t(row));
    let mut winding = 0;
    for ring in rings {
        for i in 0..ring.len() {
            let [a, b] = [ring[i], ring[(i + 1) % ring.len()]].map(|p| frame.st(p));
            let (low, high, sign) = if a.1 < b.1 { (a, b, -1) } else { (b, a, 1) };
            let [s0, t0, s1, t1] = [low.0, low.1, high.0, high.1].map(i128::from);
            // 2 s_crossing < 2 s + 1, multiplied by the edge's height.
            if t0 < t
                && t <= t1
                && 2 * (s0 * (t1 - t0) + (s1 - s0) * (t - t0)) < (2 * i128::from(s) + 1) * (t1 - t0)
            {
                winding += sign;
            }
        }
    }
    winding != 0
}

/// The first cell in which spans and oracle differ.
fn difference(
    rows: &Rows,
    rings: &[Vec<Point2>],
    frame: &RowFrame,
    random: &mut Random,
) -> Option<(i32, i64)> {
    for row in -14..14 {
        let mut cells: Vec<i64> = (0..20).map(|_| random.within(-700, 700)).collect();
        cells.extend(
            rows.row(row)
                .iter()
                .flat_map(|s| (-2..2).flat_map(|d| [i64::from(s.start) + d, i64::from(s.end) + d])),
        );
        for s in cells {
            let spanned = rows.row(row).iter().any(|x| i64::from(x.start) <= s && s < i64::from(x.end));
            if spanned != is_inside(rings, frame, row, s) {
                return Some((row, s));
            }
        }
    }
    None
}

fn slices(rings: &[Vec<Point2>]) -> impl Iterator<Item = &[Point2]> {
    rings.iter().map(|r| &r[..])
}

#[test]
fn spans_are_the_exact_interior() {
    for frame in frames() {
        for seed in 1..80 {
            let mut random = Random(seed);
            let rings = rings(&mut random, &frame);
            let rows = scan(slices(&rings), &frame);
            assert_eq!(
                difference(&rows, &rings, &frame, &mut random),
                None,
                "seed {seed}, {frame:?}: {rings:?}"
            );
            for (_, row) in rows.iter() {
                assert!(row.windows(2).all(|w| w[0].end < w[1].start), "seed {seed}: {row:?}");
            }
        }
    }
}

#[test]
fn a_displaced_span_is_noticed() {
    let frame = frames()[0];
    let mut seen = 0;
    for seed in 1..100 {
        let mut random = Random(seed);
        let rings = rings(&mut random, &frame);
        let rows = scan(slices(&rings), &frame);
        let mut out = RowsBuilder::new(rows.first());
        for (_, row) in rows.iter() {
            row.iter().for_each(|s| out.push(s.start + 1, s.end));
            out.end_row();
        }
        seen +=
            u32::from(!rows.is_empty() && difference(&out.finish(), &rings, &frame, &mut random).is_some());
    }
    assert!(seen > 80, "{seen}");
}

#[test]
fn a_trace_bounds_every_span_by_its_crossings() {
    for frame in frames() {
        for seed in 1..100 {
            let rings = rings(&mut Random(seed), &frame);
            let t = trace(slices(&rings), &frame);
            assert_eq!(t.rows, scan(slices(&rings), &frame), "seed {seed}");
            assert_eq!(t.ring_hits.len(), rings.len() + 1);
            for (k, row) in t.rows.iter() {
                for (span, i) in row.iter().zip(t.rows.range(k)) {
                    let [a, b] = t.ends[i].map(|h| t.hits[h as usize]);
                    assert_eq!((a.row, a.s, b.row, b.s), (k, span.start, k, span.end), "seed {seed}");
                }
            }
            // Along a ring neighbouring crossings lie on the same row or on neighbouring ones.
            for r in 0..rings.len() {
                let hits = &t.hits[t.ring_hits[r] as usize..t.ring_hits[r + 1] as usize];
                for (i, h) in hits.iter().enumerate() {
                    let next = hits[(i + 1) % hits.len()];
                    let step = if h.up == next.up { if h.up { 1 } else { -1 } } else { 0 };
                    assert_eq!(next.row - h.row, step, "seed {seed}");
                    assert_eq!(h.ring as usize, r);
                }
            }
        }
    }
}

#[test]
fn the_corners_of_the_lattice_do_not_overflow() {
    let m = LIMIT - 1;
    let square = [(-m, -m), (m, -m), (m, m), (-m, m)].map(|(x, y)| Point2::new(x, y));
    for angle in [0.0, 45.0, 90.0, 135.0, 30.0] {
        let frame = RowFrame::new(angle, 0.0, 1e7);
        let rows = scan([&square[..]], &frame);
        let area = rows.length() as f64 * frame.mm2_per_unit();
        let exact = 4.0 * (f64::from(m) * 1e-6).powi(2);
        assert!((area / exact - 1.0).abs() < 0.01, "{angle}: {area} of {exact}");
        for p in square {
            let (s, t) = frame.st(p);
            assert!(frame.xy(s, t.into()).distance(p) < 1.5);
        }
    }
    assert_eq!(scan::crossing(-m - m, -m - m, m + m, m + m, i64::from(m)), m);
    assert_eq!(scan::crossing(m + m, -m - m, -m - m, m + m, i64::from(m)), -m);
}

#[test]
fn rows_are_where_the_frame_says() {
    let frame = RowFrame::new(45.0, 0.0, 1e6);
    assert_eq!(frame.pitch(), 1_414_214);
    assert_eq!(frame.st(Point2::new(3, 5)), (8, 2));
    assert_eq!(frame.xy(8, 2), Point2::new(3, 5));
    assert_eq!(RowFrame::new(225.0, 0.0, 1e6), frame);
    let frame = RowFrame::new(0.0, 3e5, 1e6);
    assert_eq!((frame.row_below(299_999), frame.row_below(300_000)), (-1, 0));
    assert_eq!((frame.nearest_row(799_999), frame.nearest_row(800_000)), (0, 1));
    assert_eq!(frame.t(2), 2_300_000);
}
