//! Spans of loose edges against spans of the rings that they were cut from.

use super::{Random, frames, rings, slices};
use crate::lattice::{LIMIT, Point2};
use crate::span::{Axis, EdgeScan, RowFrame, Rows, RowsBuilder, scan};

const AXES: [Axis; 4] = [Axis::X, Axis::Diagonal, Axis::Y, Axis::AntiDiagonal];

/// The edges of rings in random order, some cut in two at a point of theirs that all rows see alike.
fn shuffled(rings: &[Vec<Point2>], frame: &RowFrame, random: &mut Random) -> Vec<[Point2; 2]> {
    let mut edges: Vec<_> =
        rings.iter().flat_map(|r| (0..r.len()).map(|i| [r[i], r[(i + 1) % r.len()]])).collect();
    for i in 0..edges.len() {
        let [a, b] = edges[i];
        let upright = a.x == b.x || a.y == b.y;
        let at = Point2::new((a.x + b.x) / 2, (a.y + b.y) / 2);
        if upright && frame.direction().is_some() && random.below(2) == 0 {
            edges[i] = [a, at];
            edges.push([at, b]);
        }
    }
    for i in (1..edges.len()).rev() {
        edges.swap(i, random.below(i as u64 + 1) as usize);
    }
    edges
}

fn divided() -> Vec<RowFrame> {
    let mut frames = frames();
    for axis in AXES {
        for sub_rows in [1, 2, 4, 8, 16] {
            for (base, pitch) in [(250, 1000), (-7, 1001), (123_456_789, 24_013)] {
                frames.push(RowFrame::strips(axis, base, pitch, sub_rows));
            }
        }
    }
    frames
}

#[test]
fn spans_of_edges_are_those_of_rings() {
    let mut spans = 0;
    for frame in divided() {
        let mut edge_scan = EdgeScan::new(&frame);
        for seed in 1..60 {
            let mut random = Random(seed);
            let mut rings = rings(&mut random, &frame);
            if seed % 3 == 0 {
                // Small among large ones, so that rows between stay empty.
                let far = random.within(-9000, 9000) as i32;
                rings.push(
                    [(far, 3), (far + 400, 7), (far, 450)].map(|(x, y)| Point2::new(x, y + far)).to_vec(),
                );
            }
            let edges = shuffled(&rings, &frame, &mut random);
            let expected = scan(slices(&rings), &frame);
            spans += expected.spans().len();
            assert_eq!(edge_scan.scan(&edges), expected, "seed {seed}, {frame:?}: {rings:?}");
        }
    }
    assert!(spans > 50_000, "{spans}");
}

#[test]
fn large_edges_have_the_bits_of_small_ones() {
    let m = i64::from(LIMIT - 1);
    let mut random = Random(9);
    for axis in AXES {
        for (sub_rows, pitch) in [(1, 9_999_999), (4, 9_999_999), (1, 300_000_000), (2, 1 << 30)] {
            let frame = RowFrame::strips(axis, random.within(-m, m), pitch, sub_rows);
            let mut edge_scan = EdgeScan::new(&frame);
            for round in 0..40 {
                let mut point = || {
                    let mut c = || [random.within(-m, m), m, -m][random.below(3) as usize] as i32;
                    Point2::new(c(), c())
                };
                let rings: Vec<_> = (0..2).map(|_| (0..4).map(|_| point()).collect::<Vec<_>>()).collect();
                let edges = shuffled(&rings, &frame, &mut Random(round + 1));
                assert_eq!(edge_scan.scan(&edges), scan(slices(&rings), &frame), "{frame:?}: {rings:?}");
            }
        }
    }
}

#[test]
fn a_lost_or_turned_edge_is_noticed() {
    let frame = frames()[0];
    let mut edge_scan = EdgeScan::new(&frame);
    let ring = [(0, 0), (9000, 300), (8000, 9000), (-300, 7000)].map(|(x, y)| Point2::new(x, y)).to_vec();
    let edges = shuffled(std::slice::from_ref(&ring), &frame, &mut Random(1));
    let expected = scan([&ring[..]], &frame);
    assert_eq!(edge_scan.scan(&edges), expected);
    for i in 0..edges.len() {
        let mut broken = edges.clone();
        broken[i].reverse();
        let crosses = frame.row_below(edges[i][0].y.into()) != frame.row_below(edges[i][1].y.into());
        assert_eq!(edge_scan.scan(&broken) != expected, crosses);
        broken.remove(i);
        assert_eq!(edge_scan.scan(&broken) != expected, crosses);
    }
}

#[test]
fn rows_within_bounds_are_those_without() {
    let frame = RowFrame::strips(Axis::X, 0, 1000, 2);
    let mut edge_scan = EdgeScan::new(&frame);
    for seed in 1..60 {
        let mut random = Random(seed);
        let rings = rings(&mut random, &frame);
        let edges = shuffled(&rings, &frame, &mut random);
        let all = scan(slices(&rings), &frame);
        let low = random.within(-20, 20) as i32;
        let within = low..low + random.within(0, 20) as i32;
        let rows = edge_scan.load(&edges, within.clone());
        assert!(rows.is_empty() || rows.start >= within.start && rows.end <= within.end);
        for k in -30..30 {
            let mut out = RowsBuilder::new(k);
            edge_scan.row(k, |start, end| out.push(start, end));
            out.end_row();
            let expected: Option<&Rows> = within.contains(&k).then_some(&all);
            assert_eq!(
                out.finish().row(k),
                expected.map_or(&[][..], |rows| rows.row(k)),
                "seed {seed}, row {k}"
            );
        }
    }
}

#[test]
fn nothing_gives_nothing() {
    let mut edge_scan = EdgeScan::new(&frames()[0]);
    let p = Point2::new(5, 250);
    assert_eq!(edge_scan.scan(&[]), Rows::default());
    assert_eq!(edge_scan.scan(&[[p, p]]), Rows::default());
    assert_eq!(edge_scan.load(&[[p, p]], 0..5), 0..0);
    edge_scan.row(0, |_, _| unreachable!("there is no span"));
}

#[test]
fn sub_rows_are_in_the_middles_of_equal_strips() {
    let frame = RowFrame::strips(Axis::X, -500, 1001, 4);
    assert_eq!(frame.offsets(), [125, 375, 626, 876], "125.125, 375.375, 625.625, 875.875");
    assert_eq!((frame.t(0), frame.t(3), frame.t(4), frame.t(-1)), (-375, 376, 626, -625));
    assert_eq!(RowFrame::strips(Axis::X, 0, 1001, 1).t(0), 501, "a half is rounded up");
    for n in [1, 2, 4, 8, 16] {
        let frame = RowFrame::strips(Axis::Y, -12_345, 24_013, n);
        for k in -100..100 {
            let t = frame.t(k);
            assert!(t < frame.t(k + 1));
            assert_eq!((frame.row_below(t), frame.row_below(t - 1)), (k, k - 1));
            let middle = (t + frame.t(k + 1) + 1) / 2;
            assert_eq!((frame.nearest_row(t), frame.nearest_row(middle + 2)), (k, k + 1), "{n} {k}");
        }
    }
    let square =
        [(0, 0), (3_000_000, 0), (3_000_000, 3_000_000), (0, 3_000_000)].map(|(x, y)| Point2::new(x, y));
    let frame = RowFrame::strips(Axis::Diagonal, 0, 24_000, 16);
    let area = scan([&square[..]], &frame).length() as f64 * frame.mm2_per_unit();
    assert!((area - 9.0).abs() < 0.01, "{area}");
}
