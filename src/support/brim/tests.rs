#![allow(clippy::unwrap_used)]

use super::*;
use crate::lattice::{Point2, area2};
use crate::region::inside::Edges;
use crate::settings::flow::Section;
use crate::span::tests::Random;

const FLOW: Flow = Flow { width: 0.45, height: 0.2, section: Section::Rounded };

fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Ring {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(nm(x) as i32, nm(y) as i32)).to_vec()
}

fn clockwise(mut ring: Ring) -> Ring {
    ring.reverse();
    ring
}

fn solid(ring: Ring) -> ExPolygon {
    ExPolygon { contour: ring, holes: Vec::new() }
}

/// A plate of 40 mm x 20 mm with a hole 20 mm x 10 mm, in which stands a block of 4 mm x 4 mm.
fn frame() -> Vec<ExPolygon> {
    let holes = vec![clockwise(rectangle(10.0, 5.0, 30.0, 15.0))];
    vec![
        ExPolygon { contour: rectangle(0.0, 0.0, 40.0, 20.0), holes },
        solid(rectangle(18.0, 8.0, 22.0, 12.0)),
    ]
}

fn settings(brim_type: BrimType) -> AdhesionSettings {
    AdhesionSettings { brim_width: 3.0, brim_type, ..AdhesionSettings::default() }
}

fn edges(strand: &Strand) -> impl Iterator<Item = (Point2, Point2)> + '_ {
    let n = strand.points.len();
    let count = if strand.closed { n } else { n - 1 };
    (0..count).map(move |i| (strand.points[i], strand.points[(i + 1) % n]))
}

fn length(strands: &[Strand]) -> f64 {
    strands.iter().flat_map(edges).map(|(a, b)| a.distance(b) * 1e-6).sum()
}

/// Points about 0.1 mm apart on a line.
fn points(strand: &Strand) -> impl Iterator<Item = Point2> + '_ {
    edges(strand).flat_map(|(a, b)| {
        let n = (a.distance(b) / 1e5).ceil().max(1.0);
        (0..n as usize).map(move |i| a.toward(b, i as f64 / n))
    })
}

/// Distance of a point from the nearest edge of areas \[mm\].
fn to_border(p: Point2, areas: &[ExPolygon]) -> f64 {
    let to_edge = |a: Point2, b: Point2| {
        let ((ux, uy), (vx, vy)) = (b.minus(a), p.minus(a));
        let (ux, uy, vx, vy) = (ux as f64, uy as f64, vx as f64, vy as f64);
        let t = ((ux * vx + uy * vy) / (ux * ux + uy * uy).max(1.0)).clamp(0.0, 1.0);
        (vx - t * ux).hypot(vy - t * uy) * 1e-6
    };
    let rings = areas.iter().flat_map(ExPolygon::rings);
    rings
        .flat_map(|r| {
            r.iter().zip(r.iter().cycle().skip(1)).map(|(a, b)| to_edge(*a, *b)).collect::<Vec<_>>()
        })
        .fold(f64::INFINITY, f64::min)
}

fn is_inside(p: Point2, areas: &[ExPolygon]) -> bool {
    Edges::new(areas).contains(p)
}

#[test]
fn lines_lie_at_whole_spacings_around_a_block() {
    let block = vec![solid(rectangle(0.0, 0.0, 20.0, 10.0))];
    let wanted = AdhesionSettings { brim_separation: 0.3, ..settings(BrimType::OuterOnly) };
    let strands = brim(&block, &[], FLOW, &wanted);
    // 3 / 0.407 = 7.4.
    assert_eq!(strands.len(), 7);
    for (i, strand) in strands.iter().rev().enumerate() {
        let distance = 0.3 + (i as f64 + 0.5) * FLOW.spacing();
        assert!(strand.closed && strand.kind == StrandKind::Brim);
        assert!(points(strand).all(|p| (to_border(p, &block) - distance).abs() < 0.012));
        let around = 60.0 + 2.0 * std::f64::consts::PI * distance;
        assert!((length(std::slice::from_ref(strand)) - around).abs() < 0.1);
    }
}

#[test]
fn a_width_of_so_many_lines_gives_so_many() {
    let block = vec![solid(rectangle(0.0, 0.0, 20.0, 10.0))];
    for count in 1..30 {
        let brim_width = f64::from(count) * FLOW.spacing();
        let wanted = AdhesionSettings { brim_width, ..AdhesionSettings::default() };
        assert_eq!(brim(&block, &[], FLOW, &wanted).len(), count as usize);
    }
    assert!(brim(&block, &[], FLOW, &AdhesionSettings::default()).is_empty());
    assert!(brim(&[], &[], FLOW, &settings(BrimType::OuterAndInner)).is_empty());
}

#[test]
fn the_type_says_on_which_side_lines_lie() {
    let [none, outer, inner, both] =
        [BrimType::NoBrim, BrimType::OuterOnly, BrimType::InnerOnly, BrimType::OuterAndInner]
            .map(|t| brim(&frame(), &[], FLOW, &settings(t)));
    assert!(none.is_empty() && cover(&frame(), FLOW, &settings(BrimType::NoBrim)).is_empty());
    let plate = [solid(rectangle(0.0, 0.0, 40.0, 20.0))];
    assert!(outer.iter().flat_map(points).all(|p| !is_inside(p, &plate)));
    assert!(inner.iter().flat_map(points).all(|p| is_inside(p, &plate)));
    assert_eq!(both.len(), outer.len() + inner.len());
    // The block in the hole has a brim too: the room between it and the hole is filled.
    let filled = length(&inner) * FLOW.spacing();
    let room = 20.0 * 10.0 - 4.0 * 4.0;
    assert!(filled > 0.75 * room && filled < room, "{filled} of {room}");
    assert!(inner.iter().any(|s| s.points.iter().all(|p| p.x > 16_000_000 && p.x < 24_000_000)));
}

#[test]
fn no_line_is_laid_twice_in_a_narrow_gap() {
    for gap in [0.2, 0.5, 0.7, 0.9, 1.3, 1.7, 2.2, 4.0, 5.0] {
        let two =
            vec![solid(rectangle(0.0, 0.0, 10.0, 20.0)), solid(rectangle(10.0 + gap, 0.0, 20.0 + gap, 20.0))];
        let strands = brim(&two, &[], FLOW, &settings(BrimType::OuterOnly));
        // Lines that run upwards in the middle of the gap.
        let mut at: Vec<f64> = strands
            .iter()
            .flat_map(edges)
            .filter(|(a, b)| (a.y < 10_000_000) != (b.y < 10_000_000))
            .map(|(a, _)| f64::from(a.x) * 1e-6)
            .filter(|x| *x > 10.0 && *x < 10.0 + gap)
            .collect();
        at.sort_unstable_by(f64::total_cmp);
        let least = LEAST_ROOM * FLOW.spacing() - 0.01;
        assert!(at.windows(2).all(|w| w[1] - w[0] > least), "gap {gap}: {at:?}");
        // No room for another one is left.
        let ends = [10.0 - 0.5 * FLOW.spacing(), 10.0 + gap + 0.5 * FLOW.spacing()];
        let all = [&ends[..1], &at, &ends[1..]].concat();
        let widest = (1.0 + LEAST_ROOM) * FLOW.spacing() + FLOW.spacing() + 0.01;
        assert!(all.windows(2).all(|w| w[1] - w[0] < widest), "gap {gap}: {all:?}");
        assert!(at.len() <= 14);
    }
}

#[test]
fn lines_are_cut_where_something_else_lies() {
    let block = vec![solid(rectangle(0.0, 0.0, 20.0, 10.0))];
    let foot = vec![solid(rectangle(22.0, 3.0, 30.0, 7.0))];
    let whole = brim(&block, &[], FLOW, &settings(BrimType::OuterOnly));
    let cut = brim(&block, &foot, FLOW, &settings(BrimType::OuterOnly));
    let near = |strands: &[Strand]| {
        strands
            .iter()
            .flat_map(points)
            .filter(|p| to_border(*p, &foot) < 0.22 || is_inside(*p, &foot))
            .count()
    };
    assert!(near(&whole) > 0);
    assert_eq!(near(&cut), 0);
    let open = cut.iter().filter(|s| !s.closed).count();
    // Those 1.8 mm and further out run into it, one piece each.
    assert_eq!((cut.len(), open), (7, 3));
    assert!(length(&cut) > length(&whole) - 3.0 * 6.0);
    // A ring that starts within a piece is one piece.
    assert!(cut.iter().filter(|s| !s.closed).all(|s| length(std::slice::from_ref(s)) > 40.0));
    // All round it leaves nothing.
    let around = vec![ExPolygon {
        contour: rectangle(-9.0, -9.0, 29.0, 19.0),
        holes: vec![clockwise(rectangle(-0.1, -0.1, 20.1, 10.1))],
    }];
    assert!(brim(&block, &around, FLOW, &settings(BrimType::OuterOnly)).is_empty());
}

#[test]
fn ears_lie_at_sharp_corners_only() {
    let mut wanted = AdhesionSettings { brim_ears: true, ..settings(BrimType::OuterOnly) };
    let block = vec![solid(rectangle(0.0, 0.0, 40.0, 20.0))];
    let strands = brim(&block, &[], FLOW, &wanted);
    let corners = rectangle(0.0, 0.0, 40.0, 20.0);
    let reach = 3.0 - 0.5 * FLOW.spacing() + 0.02;
    assert!(strands.iter().flat_map(points).all(|p| corners.iter().any(|c| c.distance(p) * 1e-6 < reach)));
    // Three quarters of a disc each.
    let filled = length(&strands) * FLOW.spacing();
    let discs = 4.0 * 0.75 * 9.0 * std::f64::consts::PI;
    assert!(filled > 0.85 * discs && filled < discs, "{filled} of {discs}");
    wanted.brim_ears_max_angle = 80.0;
    assert!(brim(&block, &[], FLOW, &wanted).is_empty());
    // A circle has no corner, a hole's corners are not the part's, but a tooth in the hole is.
    wanted.brim_ears_max_angle = 125.0;
    let circle: Ring = (0..200)
        .map(|i| libm::sincos(f64::from(i) * std::f64::consts::TAU / 200.0))
        .map(|(y, x)| Point2::new((8e6 * x) as i32, (8e6 * y) as i32))
        .collect();
    assert!(brim(&[solid(circle)], &[], FLOW, &wanted).is_empty());
    let inner = AdhesionSettings { brim_type: BrimType::InnerOnly, ..wanted.clone() };
    let first = frame();
    assert!(brim(&first[..1], &[], FLOW, &inner).is_empty());
    let on_block = brim(&first, &[], FLOW, &inner);
    assert!(!on_block.is_empty());
    assert!(on_block.iter().flat_map(points).all(|p| to_border(p, &first[1..]) < 3.0));
}

#[test]
fn a_rounded_corner_has_one_ear() {
    // Corners rounded with a radius of 0.4 mm by many short edges.
    let mut ring = Ring::new();
    for (k, (x, y)) in [(19.6, 9.6), (0.4, 9.6), (0.4, 0.4), (19.6, 0.4)].into_iter().enumerate() {
        for i in 0..=20 {
            let (sin, cos) = libm::sincos((k as f64 + f64::from(i) / 20.0) * std::f64::consts::FRAC_PI_2);
            ring.push(Point2::new(nm(x + 0.4 * cos) as i32, nm(y + 0.4 * sin) as i32));
        }
    }
    assert!(area2(&ring) > 0);
    let wanted = AdhesionSettings { brim_ears: true, brim_width: 1.0, ..settings(BrimType::OuterOnly) };
    let area: f64 = cover(&[solid(ring)], FLOW, &AdhesionSettings { brim_width: 1.0, ..wanted })
        .iter()
        .map(ExPolygon::area_mm2)
        .sum();
    // Between one disc less a quarter and a little more for its place on the rounding.
    assert!(area > 4.0 * 0.6 * std::f64::consts::PI && area < 4.0 * 0.85 * std::f64::consts::PI, "{area}");
}

#[test]
fn every_loop_comes_before_those_inside_it_and_parts_stay_together() {
    let mut blocks = Vec::new();
    for i in 0..4 {
        let x = f64::from(i) * 30.0;
        blocks.push(solid(rectangle(x, 0.0, x + 10.0, 10.0)));
    }
    let strands = brim(&blocks, &[], FLOW, &settings(BrimType::OuterOnly));
    assert_eq!(strands.len(), 4 * 7);
    let middle = |s: &Strand| s.points.iter().map(|p| i64::from(p.x)).sum::<i64>() / s.points.len() as i64;
    for of_one in strands.chunks(7) {
        assert!(of_one.iter().all(|s| (middle(s) - middle(&of_one[0])).abs() < 500_000));
        let sizes: Vec<i128> = of_one.iter().map(|s| area2(&s.points)).collect();
        assert!(sizes.is_sorted_by(|a, b| a > b));
    }
}

#[test]
fn nothing_covers_the_part_or_leaves_the_cover() {
    for seed in 0..16 {
        let mut random = Random(seed * 7919 + 3);
        let mut mm = |low: i64, high: i64| random.within(low * 1000, high * 1000) as f64 * 1e-3;
        let rings: Vec<Ring> = (0..6)
            .map(|_| {
                let (x, y) = (mm(0, 30), mm(0, 30));
                rectangle(x, y, x + mm(1, 15), y + mm(1, 15))
            })
            .collect();
        let filled = boolean::union(&rings, Winding::NonZero);
        let bite = vec![solid(rectangle(10.0, 10.0, 10.0 + mm(1, 12), 10.0 + mm(1, 12)))];
        let first = boolean::difference(&filled, &bite);
        let wanted = AdhesionSettings {
            brim_separation: mm(0, 1),
            brim_ears: seed % 4 == 3,
            ..settings([BrimType::OuterOnly, BrimType::InnerOnly, BrimType::OuterAndInner][seed as usize % 3])
        };
        let strands = brim(&first, &[], FLOW, &wanted);
        let least = wanted.brim_separation + 0.5 * FLOW.spacing() - 0.012;
        let (area, part) = (Edges::new(&cover(&first, FLOW, &wanted)), Edges::new(&first));
        for p in strands.iter().flat_map(points) {
            assert!(!part.contains(p), "seed {seed}");
            assert!(to_border(p, &first) > least, "seed {seed}: {} < {least}", to_border(p, &first));
            assert!(area.contains(p), "seed {seed}: {p:?}");
        }
        // Moved, it is the same.
        let (dx, dy) = (123_456_789, -98_765_432);
        let shift = |r: &mut Ring| r.iter_mut().for_each(|p| *p = Point2::new(p.x + dx, p.y + dy));
        let mut moved = first.clone();
        moved.iter_mut().for_each(|p| {
            shift(&mut p.contour);
            p.holes.iter_mut().for_each(shift);
        });
        let mut expected = strands;
        expected.iter_mut().for_each(|s| shift(&mut s.points));
        assert_eq!(brim(&moved, &[], FLOW, &wanted), expected, "seed {seed}");
    }
}
