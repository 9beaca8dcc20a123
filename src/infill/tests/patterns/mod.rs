//! Tests of the sparse patterns.

mod layers;
mod walls;

use super::shapes::*;
use super::stays_inside::{random_island, worst};
use super::*;
use crate::settings::FloatOrPercent::Float;
use crate::settings::{FillPattern, Settings};
use crate::span::tests::Random;

/// All patterns.
pub const ALL: [FillPattern; 11] = [
    FillPattern::Rectilinear,
    FillPattern::Monotonic,
    FillPattern::MonotonicLines,
    FillPattern::AlignedRectilinear,
    FillPattern::Line,
    FillPattern::ZigZag,
    FillPattern::Grid,
    FillPattern::Triangles,
    FillPattern::Stars,
    FillPattern::Cubic,
    FillPattern::Honeycomb,
];

/// Settings with a pattern at a density, without links and anchors.
fn lines_of(pattern: FillPattern, percent: f64) -> Settings {
    let mut s = with(pattern, percent);
    s.infill.infill_anchor_max = Float(0.0);
    s
}

/// Settings with a pattern at a density.
fn with(pattern: FillPattern, percent: f64) -> Settings {
    let mut s = settings();
    s.infill.fill_pattern = pattern;
    s.infill.fill_density = percent;
    s
}

/// Volume of sparse lines over that of a block's inside, a square of 97 mm as a block of 100 mm has.
fn filled(s: &Settings, layers: usize) -> f64 {
    let side = 97.0;
    let layers = vec![vec![island(square(0.3, 0.4, side), vec![])]; layers + 6];
    let plan = FillPlan::new(s);
    let fills = &fill(&stack(&layers), &plan)[3..layers.len() - 3];
    let sum: f64 = fills.iter().flatten().map(|f| length(f, FillKind::Sparse)).sum();
    sum / fills.len() as f64 * mm(plan.sparse_spacing(4, 1) as i64) / (side * side)
}

#[test]
fn every_pattern_has_the_density_asked_for() {
    for pattern in ALL {
        // Cubes repeat after some layers, honeycombs after three.
        let layers = if pattern == FillPattern::Cubic { 50 } else { 3 };
        for percent in [5.0, 10.0, 20.0, 40.0, 80.0] {
            let mut s = lines_of(pattern, percent);
            let links = if pattern == FillPattern::ZigZag {
                // Links are the pattern's own: 2 a line, sqrt(2) lines' distances long on average, half
                // of them used.
                s.infill.fill_angle = 45.0;
                2f64.sqrt() * 2f64.sqrt() * mm(FillPlan::new(&s).spacing[0] as i64) / percent * 100.0 / 97.0
            } else {
                0.0
            };
            let off = filled(&s, layers) / (percent / 100.0) - 1.0 - links;
            assert!(off.abs() < 0.02, "{pattern:?} at {percent} %: off by {off}, links {links}");
        }
        // The comparison can fail.
        let off = filled(&lines_of(pattern, 21.5), layers) / 0.2 - 1.0;
        assert!(off > 0.03, "{pattern:?}: {off}");
    }
}

#[test]
fn links_and_anchors_add_what_is_stated() {
    // At 20 % on a block of 100 mm, in per cent of the lines.
    for (pattern, low, high) in [
        (FillPattern::Rectilinear, 4.0, 4.5),
        (FillPattern::MonotonicLines, -0.1, 0.1),
        (FillPattern::Line, 6.5, 7.5),
        (FillPattern::ZigZag, 4.0, 4.5),
        (FillPattern::Grid, 2.0, 2.7),
        (FillPattern::Triangles, 3.0, 4.0),
        (FillPattern::Stars, 2.0, 3.0),
        (FillPattern::Cubic, 2.5, 3.5),
        (FillPattern::Honeycomb, 3.3, 4.3),
    ] {
        let layers = if pattern == FillPattern::Cubic { 50 } else { 3 };
        let more = (filled(&with(pattern, 20.0), layers) / 0.2 - 1.0) * 100.0;
        assert!(low < more && more < high, "{pattern:?}: {more}");
    }
}

#[test]
fn thick_lines_lie_closer() {
    use crate::settings::flow::{Flow, FlowRole};
    let mut s = with(FillPattern::AlignedRectilinear, 20.0);
    s.slicing.layer_height = 0.1;
    s.infill.infill_every_layers = 5;
    let plan = FillPlan::new(&s);
    let spacing =
        |layers: u32| Flow::new(FlowRole::Infill, f64::from(layers) * 0.1, false, &s).spacing_nm() as f64;
    for layers in 1..=4 {
        assert_eq!(plan.sparse_spacing(4, layers), spacing(layers));
    }
    assert!(plan.sparse_spacing(4, 2) < plan.sparse_spacing(4, 1));
    // No line is thicker than the nozzle is wide.
    assert_eq!(plan.thick_spacing.len(), 3);
}

/// Layers of nasty shapes, partly covered, so that some of the sparse area ends at skins.
fn random_job(seed: u64, pattern: FillPattern) -> (Vec<Vec<Island>>, FillPlan) {
    let mut random = Random(seed);
    let mut s = with(pattern, [8.0, 15.0, 30.0, 60.0][random.below(4) as usize]);
    s.infill.fill_angle = [45.0, 0.0, 30.0, 117.0][random.below(4) as usize];
    s.infill.infill_anchor_max = [Float(50.0), Float(5.0), Float(1.0)][random.below(3) as usize];
    let base = random_island(&mut random);
    let layers =
        (0..12).map(|i| vec![if i == 8 { random_island(&mut random) } else { base.clone() }]).collect();
    (layers, FillPlan::new(&s))
}

#[test]
fn every_pattern_stays_inside() {
    for pattern in ALL {
        let mut sparse = 0;
        for seed in 1..6 {
            let (layers, plan) = random_job(seed, pattern);
            for (i, (paths, layer)) in fill(&stack(&layers), &plan).iter().zip(&layers).enumerate().skip(3) {
                let paths: Vec<FillPath> =
                    paths[0].iter().filter(|p| p.kind == FillKind::Sparse).cloned().collect();
                assert!(paths.iter().all(|p| p.points.len() >= 2));
                sparse += paths.len();
                let worst = worst(&paths, &layer[0]);
                assert!(worst < 3.5, "{pattern:?}, seed {seed}, layer {i}: {worst} nm outside");
            }
        }
        assert!(sparse > 100, "{pattern:?}: {sparse}");
    }
}

#[test]
fn threads_and_runs_do_not_matter() {
    for pattern in ALL {
        let (layers, plan) = random_job(7, pattern);
        let with = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| fill(&stack(&layers), &plan))
        };
        assert_eq!(with(1), with(4), "{pattern:?}");
    }
}
