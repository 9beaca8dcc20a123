//! Insets against a second polygon library and, where the two differ, against their definition.

use super::definition::{inset_area, length};
#[cfg(test)]
use super::nasty;
use clipper2_rust::{EndType, JoinType, Paths64, Point64};
use microtome::contour::ExPolygon;
#[cfg(test)]
use microtome::region::offset::inset;
use microtome::region::offset::{ARC_TOLERANCE, MITER_LIMIT, SIMPLIFY};

/// Area of the inset by the other library \[mm²\].
pub fn library_area(areas: &[ExPolygon], distance: i64) -> f64 {
    area_of(&library_inset(areas, distance))
}

pub fn area_of(paths: &Paths64) -> f64 {
    paths.iter().map(clipper2_rust::area).sum::<f64>() * 1e-12
}

/// The inset by the other library, each area by itself.
pub fn library_inset(areas: &[ExPolygon], distance: i64) -> Paths64 {
    let point = |p: &microtome::lattice::Point2| Point64::new(i64::from(p.x), i64::from(p.y));
    let one = |area: &ExPolygon| {
        let rings: Paths64 = area.rings().map(|r| r.iter().map(point).collect()).collect();
        let delta = -(distance as f64);
        clipper2_rust::inflate_paths_64(
            &rings,
            delta,
            JoinType::Miter,
            EndType::Polygon,
            MITER_LIMIT,
            ARC_TOLERANCE,
        )
    };
    areas.iter().flat_map(one).collect()
}

pub fn area(areas: &[ExPolygon]) -> f64 {
    areas.iter().map(ExPolygon::area_mm2).sum()
}

/// How a difference between the library and us is explained.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// We are within 0.1 mm² of the definition, the library is not.
    Library,
    /// Both are within 0.1 mm² of the definition, on either side.
    Neither,
    /// We differ by no more than simplification may: its tolerance times the length of the borders.
    Simplified,
    /// We are wrong.
    Ours,
}

/// Who is nearer to the definition \[mm²\], and what the definition gives.
pub fn judge(areas: &[ExPolygon], distance: i64, result: &[ExPolygon], library: f64) -> (Verdict, f64) {
    let exact = inset_area(areas, distance as f64, 20_000);
    let off = (area(result) - exact).abs();
    let verdict = if off <= 0.1 {
        if (library - exact).abs() > 0.1 { Verdict::Library } else { Verdict::Neither }
    } else if off <= 0.01 + SIMPLIFY * 1e-6 * length(result) {
        Verdict::Simplified
    } else {
        Verdict::Ours
    };
    (verdict, exact)
}

#[test]
fn insets_are_those_of_the_library_or_of_the_definition() {
    for seed in 0..600 {
        let case = nasty::case(seed);
        let ours = inset(&case.areas, case.distance);
        let library = library_area(&case.areas, case.distance);
        if (area(&ours) - library).abs() > 0.1 {
            let (verdict, exact) = judge(&case.areas, case.distance, &ours, library);
            let kind = case.kind;
            assert_ne!(verdict, Verdict::Ours, "seed {seed}, {kind}: {} for {exact} mm2", area(&ours));
        }
    }
}

#[test]
fn the_definition_gives_the_areas_of_geometry() {
    use microtome::lattice::Point2;
    let ring = |points: &[(i32, i32)]| points.iter().map(|&(x, y)| Point2::new(x, y)).collect::<Vec<_>>();
    let mm = 1_000_000;
    let outer = ring(&[(0, 0), (10 * mm, 0), (10 * mm, 10 * mm), (0, 10 * mm)]);
    let hole = ring(&[(4 * mm, 4 * mm), (4 * mm, 6 * mm), (6 * mm, 6 * mm), (6 * mm, 4 * mm)]);
    let plate = [ExPolygon { contour: outer, holes: vec![hole] }];
    for (d, expected) in [(0.5, 81.0 - 9.0), (1.9, 6.2 * 6.2 - 5.8 * 5.8), (2.0, 0.0)] {
        let found = inset_area(&plate, d * 1e6, 20_000);
        assert!((found - expected).abs() < 0.02, "{d}: {found}");
    }
    // A cut of 30 degrees into a block is blunted by a cap one distance away from its end.
    let (s, c) = 15f64.to_radians().sin_cos();
    let (x, y) = ((1e7 * s / c) as i32, 10 * mm);
    let block = ring(&[
        (-30 * mm, -20 * mm),
        (30 * mm, -20 * mm),
        (30 * mm, y),
        (x, y),
        (0, 0),
        (-x, y),
        (-30 * mm, y),
    ]);
    let block = [ExPolygon { contour: block, holes: vec![] }];
    let found = inset_area(&block, 1e6, 20_000);
    // Both faces of the cut move by 1 mm; they and the cap at y = -1 make a trapezium.
    let at = |y: f64| (y * s + 1.0) / c;
    let cut = 0.5 * (at(9.0) + at(-1.0)) * 2.0 * 10.0;
    assert!((found - (58.0 * 28.0 - cut)).abs() < 0.1, "{found} for {}", 58.0 * 28.0 - cut);
}

#[test]
fn a_wrong_inset_is_judged_wrong() {
    let case = (0..)
        .map(nasty::case)
        .find(|c| c.kind == "plate with holes" && area(&inset(&c.areas, c.distance)) > 20.0);
    let case = case.unwrap();
    let library = library_area(&case.areas, case.distance);
    let right = inset(&case.areas, case.distance);
    assert_ne!(judge(&case.areas, case.distance, &right, library).0, Verdict::Ours);
    let wrong = inset(&case.areas, case.distance + 10_000);
    assert_eq!(judge(&case.areas, case.distance, &wrong, library).0, Verdict::Ours);
    let (verdict, _) = judge(&case.areas, case.distance, &right, library + 0.3);
    assert_eq!(verdict, Verdict::Library);
}
