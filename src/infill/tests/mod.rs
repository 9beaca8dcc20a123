//! Tests of the whole stage on constructed layers.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod shapes;

use super::*;
use crate::lattice::mm;
use shapes::*;

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
