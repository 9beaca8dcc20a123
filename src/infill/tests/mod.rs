//! Tests of the whole stage on constructed layers.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod combine;
mod onto;
mod patterns;
mod shapes;
mod shells;
mod skins;
mod stays_inside;

use super::*;
use crate::lattice::mm;
use crate::region::Island;
use shapes::*;

/// The paths of all layers.
fn fill(layers: &[FillLayer], plan: &FillPlan) -> Vec<Vec<Vec<FillPath>>> {
    super::fill(layers, plan).paths
}

/// Length of all paths of a kind \[mm\].
fn length(paths: &[FillPath], kind: FillKind) -> f64 {
    let of = |p: &FillPath| p.points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() * 1e-6;
    paths.iter().filter(|p| p.kind == kind).map(of).sum()
}

#[test]
fn the_density_is_the_one_asked_for() {
    let side = 600.0;
    let layers = vec![vec![island(square(0.0, 0.0, side), vec![])]; 9];
    for (percent, kind) in [
        (10.0, FillKind::Sparse),
        (20.0, FillKind::Sparse),
        (50.0, FillKind::Sparse),
        (100.0, FillKind::Solid),
    ] {
        for angle in [0.0, 45.0, 30.0] {
            let mut settings = settings();
            settings.infill.fill_density = percent;
            settings.infill.fill_angle = angle;
            let plan = FillPlan::new(&settings);
            let paths = &fill(&stack(&layers), &plan)[4][0];
            let spacing = mm(plan.spacing[kind as usize] as i64);
            let density = length(paths, kind) * spacing / (side * side);
            let off = density / percent * 100.0 - 1.0;
            assert!(off.abs() < 0.02, "{percent} % at {angle} degrees: off by {off}");
            // The comparison can fail.
            assert!(
                (length(&paths[1..], kind) * spacing / (side * side) / percent * 100.0 - 1.0).abs() > 0.02
            );
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let layers: Vec<_> = (0..30)
        .map(|i| vec![island(circle(0.0, 0.0, 20.0 - 0.4 * f64::from(i), 90), vec![square(1.0, 2.0, 5.0)])])
        .collect();
    let plan = FillPlan::new(&settings());
    let with = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| fill(&stack(&layers), &plan))
    };
    assert_eq!(with(1), with(4));
}

#[test]
fn a_shift_by_whole_rows_shifts_the_paths() {
    // The phase belongs to the mesh frame: along the rows any shift, across them whole rows.
    let plan = |angle: f64| {
        let mut s = settings();
        s.infill.fill_angle = angle;
        s.infill.fill_pattern = crate::settings::FillPattern::AlignedRectilinear;
        FillPlan::new(&s)
    };
    let pitch = |angle| plan(angle).line_frame(FillKind::Sparse, 4).pitch() as i32;
    for (angle, dx, dy) in [(45.0, 123_457, 123_457), (0.0, 987, 3 * pitch(0.0)), (90.0, -2 * pitch(90.0), 5)]
    {
        let paths = |dx: i32, dy: i32| {
            let moved =
                |ring: Vec<Point2>| ring.iter().map(|p| Point2::new(p.x + dx, p.y + dy)).collect::<Vec<_>>();
            let layer = vec![island(moved(circle(0.0, 0.0, 17.0, 77)), vec![moved(square(1.0, 2.0, 5.0))])];
            fill(&stack(&vec![layer; 9]), &plan(angle)).swap_remove(4)
        };
        let mut here = paths(0, 0);
        for p in here.iter_mut().flatten().flat_map(|p| &mut p.points) {
            *p = Point2::new(p.x + dx, p.y + dy);
        }
        assert_eq!(here, paths(dx, dy), "{angle}");
        assert_ne!(here, paths(dx + 1, dy), "{angle}");
    }
}

#[test]
fn nothing_in_gives_nothing_out() {
    let plan = FillPlan::new(&settings());
    assert!(fill(&[], &plan).is_empty());
    let bare = Island::default();
    let layers = vec![vec![], vec![bare.clone(), bare]];
    assert_eq!(fill(&stack(&layers), &plan), vec![vec![], vec![vec![], vec![]]]);
}
