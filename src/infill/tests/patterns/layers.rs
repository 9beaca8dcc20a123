//! How patterns go on from layer to layer.

use super::*;

fn block(s: &Settings) -> Vec<Vec<Vec<FillPath>>> {
    let layers = vec![vec![island(circle(1.0, 0.4, 30.0, 80), vec![])]; 16];
    fill(&stack(&layers), &FillPlan::new(s))
}

#[test]
fn patterns_repeat_as_stated() {
    for pattern in ALL {
        let fills = block(&with(pattern, 15.0));
        let period = match pattern {
            FillPattern::AlignedRectilinear
            | FillPattern::Grid
            | FillPattern::Triangles
            | FillPattern::Stars => 1,
            FillPattern::Honeycomb => 3,
            FillPattern::Cubic => continue,
            _ => 2,
        };
        for i in 4..8 {
            assert_eq!(fills[i], fills[i + period], "{pattern:?}");
            for less in 1..period {
                assert_ne!(fills[i], fills[i + less], "{pattern:?}");
            }
        }
    }
}

/// How far lines at `degrees` are from the nearest multiple of a pitch plus a phase, at most, and how many
/// there are \[nm\].
fn off(paths: &[FillPath], degrees: f64, pitch: f64, phase: f64) -> (f64, usize) {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let (mut worst, mut count) = (0.0f64, 0);
    for w in paths.iter().filter(|p| p.kind == FillKind::Sparse).flat_map(|p| p.points.windows(2)) {
        let (dx, dy) = w[1].minus(w[0]);
        let (dx, dy) = (dx as f64, dy as f64);
        if (cos * dy - sin * dx).abs() > 10.0 || dx * dx + dy * dy < 1e12 {
            continue;
        }
        let left = (cos * f64::from(w[0].y) - sin * f64::from(w[0].x) - phase).rem_euclid(pitch);
        worst = worst.max(left.min(pitch - left));
        count += 1;
    }
    (worst, count)
}

#[test]
fn the_planes_of_cubes_are_at_right_angles() {
    let s = lines_of(FillPattern::Cubic, 15.0);
    let plan = FillPlan::new(&s);
    let pitch = 3.0 * plan.pitch(FillKind::Sparse, 4);
    let fills = block(&s);
    for (i, fills) in fills.iter().enumerate().take(13).skip(3) {
        let z = (i + 1) as f64 * HEIGHT as f64;
        for turn in [0.0, 120.0, 240.0] {
            // The normal of a plane is (sqrt(2/3) to the left, -1/sqrt(3) upwards): three such are
            // orthogonal, and left - z / sqrt(2) is a multiple of the pitch.
            let (worst, count) = off(&fills[0], 45.0 + turn, pitch, z / 2f64.sqrt());
            assert!(worst < 3.0 && count > 5, "layer {i}, {turn} degrees: {worst} nm, {count} lines");
            assert!(off(&fills[0], 45.0 + turn, pitch, z).0 > 1e4);
        }
    }
}

#[test]
fn triangles_meet_in_threes_and_stars_in_twos() {
    for (pattern, third) in [(FillPattern::Triangles, 0.0), (FillPattern::Stars, 0.5)] {
        let s = lines_of(pattern, 15.0);
        let pitch = 3.0 * FillPlan::new(&s).pitch(FillKind::Sparse, 4);
        let fills = block(&s);
        for (turn, phase) in [(0.0, 0.0), (120.0, 0.0), (240.0, third * pitch)] {
            let (worst, count) = off(&fills[4][0], 45.0 + turn, pitch, phase);
            assert!(worst < 3.0 && count > 5, "{pattern:?}: {worst} nm, {count} lines");
        }
    }
}

#[test]
fn honeycombs_lie_upon_each_other() {
    let s = lines_of(FillPattern::Honeycomb, 15.0);
    let w = FillPlan::new(&s).sparse_spacing(4, 1);
    let side = w * (4.0 + (16.0f64 - 12.0 * 0.15).sqrt()) / (27f64.sqrt() * 0.15);
    let fills = block(&s);
    let reach = 0.6 * w;
    // Corners of the cells: the points of a triangular lattice of this side less the cells' middles.
    let (sin, cos) = libm::sincos(45f64.to_radians());
    let is_corner = |p: &Point2| {
        let (u, v) = (
            (cos * f64::from(p.x) + sin * f64::from(p.y)) / side,
            (cos * f64::from(p.y) - sin * f64::from(p.x)) / side,
        );
        let b = (v / 0.75f64.sqrt()).round();
        let a = (u - 0.5 * b).round();
        let (du, dv) = (u - a - 0.5 * b, v - b * 0.75f64.sqrt());
        (du * du + dv * dv).sqrt() * side < reach && (a - b).rem_euclid(3.0) != 0.0
    };
    for (i, fills) in fills.iter().enumerate().take(12).skip(3) {
        let corners: Vec<Point2> = fills
            .iter()
            .flatten()
            .filter(|p| p.kind == FillKind::Sparse)
            .flat_map(|p| p.points[1..p.points.len() - 1].to_vec())
            .collect();
        assert!(corners.len() > 100);
        assert!(corners.iter().all(is_corner), "layer {i}");
        let moved = |p: &Point2| Point2::new(p.x + (side * 0.5) as i32, p.y);
        assert!(!corners.iter().map(moved).any(|p| is_corner(&p)));
    }
}

#[test]
fn a_shift_by_whole_cells_shifts_the_paths() {
    for pattern in [FillPattern::ZigZag, FillPattern::Line, FillPattern::Grid] {
        let mut s = with(pattern, 15.0);
        s.infill.fill_angle = 0.0;
        let families = if pattern == FillPattern::Grid { 2.0 } else { 1.0 };
        let pitch = (families * FillPlan::new(&s).pitch(FillKind::Sparse, 4)).round() as i32;
        let (dx, dy) = (-2 * pitch, 3 * pitch);
        let paths = |dx: i32, dy: i32| {
            let moved =
                |ring: Vec<Point2>| ring.iter().map(|p| Point2::new(p.x + dx, p.y + dy)).collect::<Vec<_>>();
            let layer = vec![island(moved(circle(0.0, 0.0, 17.0, 77)), vec![moved(square(1.0, 2.0, 5.0))])];
            fill(&stack(&vec![layer; 9]), &FillPlan::new(&s)).swap_remove(4)
        };
        let mut here = paths(0, 0);
        for p in here.iter_mut().flatten().flat_map(|p| &mut p.points) {
            *p = Point2::new(p.x + dx, p.y + dy);
        }
        assert_eq!(here, paths(dx, dy), "{pattern:?}");
        assert_ne!(here, paths(dx + 1, dy + 1), "{pattern:?}");
    }
}
