//! Skins and shells of round bodies against their definition, point by point.

use super::shapes::*;
use super::*;
use crate::span::tests::Random;

/// Layers of a body of revolution with the given radii and thickness of walls \[mm\].
fn turned(radii: &[f64], walls: f64) -> Vec<Vec<Island>> {
    let layer = |&r: &f64| {
        let mut disc = island(circle(1.0, -2.0, r, 720), vec![]);
        disc.infill =
            if r > walls { island(circle(1.0, -2.0, r - walls, 720), vec![]).infill } else { vec![] };
        vec![disc]
    };
    radii.iter().map(layer).collect()
}

/// Distance from a point to the nearest line of the kinds asked for \[mm\].
fn nearest(p: Point2, paths: &[FillPath], is_asked: impl Fn(FillKind) -> bool) -> f64 {
    let mut least = f64::INFINITY;
    for w in paths.iter().filter(|f| is_asked(f.kind)).flat_map(|f| f.points.windows(2)) {
        let (ux, uy) = w[1].minus(w[0]);
        let (vx, vy) = p.minus(w[0]);
        let (ux, uy, vx, vy) = (ux as f64, uy as f64, vx as f64, vy as f64);
        let f = ((ux * vx + uy * vy) / (ux * ux + uy * uy).max(1.0)).clamp(0.0, 1.0);
        let (dx, dy) = (vx - f * ux, vy - f * uy);
        least = least.min(dx * dx + dy * dy);
    }
    least.sqrt() * 1e-6
}

const PITCH: f64 = 0.41;

/// Checks what lies at random points of every layer; returns how many were clear cases of
/// [top, solid, sparse].
fn check(radii: &[f64], angle: f64, margin: f64, seed: u64) -> [u32; 3] {
    let mut s = settings();
    s.infill.fill_angle = angle;
    s.infill.external_infill_margin = margin;
    s.infill.fill_density = 10.0;
    let plan = FillPlan::new(&s);
    let layers = turned(radii, 0.9);
    let filled = fill(&stack(&layers), &plan);
    let mut random = Random(seed);
    let mut cases = [0; 3];
    for i in 1..radii.len() {
        let inner = radii[i] - 0.9 - PITCH;
        for _ in 0..if inner > 0.0 { 60 } else { 0 } {
            // More of them outside, where the skins are.
            let rho = inner * (random.below(1_000_000) as f64 * 1e-6).sqrt().sqrt();
            let (sin, cos) = libm::sincos(random.below(1_000_000) as f64 * 1e-6 * std::f64::consts::TAU);
            let p = at(1.0 + rho * cos, -2.0 + rho * sin);
            let radius = |j: i64| usize::try_from(j).ok().and_then(|j| radii.get(j)).copied().unwrap_or(0.0);
            let i = i as i64;
            let (above, below) = (radius(i + 1), radius(i - 1));
            let shell = (1..=3).map(|m| radius(i + m).min(radius(i - m))).fold(f64::INFINITY, f64::min);
            let skin = (0..3).map(|m| radius(i + m + 1).min(radius(i - m - 1))).fold(f64::INFINITY, f64::min);
            let paths = &filled[i as usize][0];
            let solid = nearest(p, paths, |k| k != FillKind::Sparse);
            let top = nearest(p, paths, |k| k == FillKind::TopSolid);
            let case = format!("seed {seed}, {angle} degrees, layer {i}, radius {rho}, shell {shell}");
            if rho > shell + PITCH {
                assert!(solid < 0.8 * PITCH, "{case}: {solid} mm from a solid line");
                cases[1] += 1;
            }
            if rho > above + PITCH && below > radius(i) {
                assert!(top < 0.8 * PITCH, "{case}: {top} mm from a top line");
                cases[0] += 1;
            }
            let widened = (3.4 * PITCH).max(margin + 0.1);
            if rho < skin - widened - 2.0 * PITCH {
                assert!(solid > 0.25 * PITCH, "{case}: a solid line at {solid} mm");
                cases[2] += 1;
            }
        }
    }
    cases
}

#[test]
fn cones_spheres_and_steps_are_as_solid_as_defined() {
    let cone: Vec<f64> = (0..24).map(|i| 22.0 - 0.9 * f64::from(i)).collect();
    let funnel: Vec<f64> = cone.iter().rev().copied().collect();
    let sphere: Vec<f64> =
        (0..40).map(|i| (16.0 - (0.8 * f64::from(i) - 15.5f64).powi(2) / 16.0) + 2.0).collect();
    let steps: Vec<f64> = (0..30).map(|i| 20.0 - 5.0 * f64::from(i / 10)).collect();
    let mut all = [0; 3];
    for (n, radii) in [cone, funnel, sphere, steps].iter().enumerate() {
        for (angle, margin) in [(45.0, 0.0), (0.0, 3.0), (30.0, 1.5), (117.0, 0.0)] {
            let cases = check(radii, angle, margin, 1000 + 7 * n as u64 + angle as u64);
            all.iter_mut().zip(cases).for_each(|(a, c)| *a += c);
        }
    }
    assert!(all.iter().all(|&n| n > 200), "{all:?}");
}

#[test]
fn slopes_get_a_shell_when_asked() {
    use crate::settings::VerticalShell::{Disabled, Enabled, Partial};
    // Three layers up, the outline is still outside of the infill: nothing is exposed but the pole.
    let radii: Vec<f64> = (0..40).map(|i| 30.0 - 0.4 * f64::from(i)).collect();
    let solid = |shell| {
        let mut s = settings();
        s.infill.ensure_vertical_shell_thickness = shell;
        let filled = fill(&stack(&turned(&radii, 1.35)), &FillPlan::new(&s));
        // The nearest to where the walls of the layer above end: half of that is over the infill.
        let at_wall = |i: usize| {
            let p = at(1.0 + radii[i] - 1.35 - 0.35, -2.0);
            nearest(p, &filled[i][0], |k| k != FillKind::Sparse)
        };
        let mm: f64 = filled[10..30].iter().map(|l| length(&l[0], FillKind::Solid)).sum();
        (mm, at_wall(15))
    };
    let [disabled, partial, enabled] = [Disabled, Partial, Enabled].map(solid);
    assert!(disabled.0 <= partial.0 && partial.0 <= enabled.0, "{disabled:?} {partial:?} {enabled:?}");
    assert!(enabled.0 > 1.1 * disabled.0, "{disabled:?} {enabled:?}");
    assert!(enabled.1 < 0.45, "{enabled:?}");
}

#[test]
fn skins_grow_within_their_region() {
    // Two regions, 0.6 mm apart: the left one has a step, the right one none.
    let bar = |x0: f64, x1: f64| vec![at(x0, 0.0), at(x1, 0.0), at(x1, 30.0), at(x0, 30.0)];
    let layers: Vec<Vec<Island>> = (0..20)
        .map(|i| {
            let left = if i < 10 { 30.0 } else { 20.0 };
            let mut both = island(bar(0.0, 50.0), vec![]);
            both.infill = [bar(0.0, left - 0.3), bar(30.3, 50.0)]
                .into_iter()
                .flat_map(|r| island(r, vec![]).infill)
                .collect();
            if i >= 10 {
                both.outline = island(bar(0.0, left), vec![]).outline;
                let right = island(bar(30.0, 50.0), vec![]);
                return vec![both, Island { infill: vec![], ..right }];
            }
            vec![both]
        })
        .collect();
    let mut s = settings();
    for (margin, from) in [(0.0, 20.0), (3.0, 17.0), (5.0, 15.0)] {
        s.infill.external_infill_margin = margin;
        let filled = fill(&stack(&layers), &FillPlan::new(&s));
        let tops = filled[9].iter().flatten().filter(|p| p.kind == FillKind::TopSolid);
        let x: Vec<f64> = tops.flat_map(|p| &p.points).map(|p| f64::from(p.x) * 1e-6).collect();
        let (low, high) = x.iter().fold((f64::MAX, f64::MIN), |(l, h), &x| (l.min(x), h.max(x)));
        assert!((low - from).abs() < 0.5 && high < 29.71, "margin {margin}: {low} to {high}");
        for below in [8, 7] {
            let solid = filled[below].iter().flatten().filter(|p| p.kind == FillKind::Solid);
            let high = solid.flat_map(|p| &p.points).map(|p| f64::from(p.x) * 1e-6).fold(0.0, f64::max);
            assert!(high < 29.71, "margin {margin}, layer {below}: {high}");
        }
    }
}

#[test]
fn what_is_exposed_on_both_sides_is_a_bottom() {
    // A sheet one layer thick between two blocks, and a sheet on the bed.
    let side = |i: usize| if i == 0 || i == 8 { 40.0 } else { 12.0 };
    let layers: Vec<_> = (0..16).map(|i| vec![island(square(0.0, 0.0, side(i)), vec![])]).collect();
    let plan = FillPlan::new(&settings());
    let filled = fill(&stack(&layers), &plan);
    for i in [0, 8] {
        assert!(length(&filled[i][0], FillKind::TopSolid) < 1e-9, "layer {i}");
        let solid = |k| matches!(k, FillKind::Solid | FillKind::Bridge);
        let mm = [FillKind::Solid, FillKind::Bridge].map(|k| length(&filled[i][0], k));
        assert!(mm.iter().sum::<f64>() > 0.85 * (1600.0 - 144.0) / PITCH, "layer {i}: {mm:?}");
        assert!(nearest(at(-15.0, 10.0), &filled[i][0], solid) < PITCH, "layer {i}");
    }
    assert!(length(&filled[15][0], FillKind::TopSolid) > 100.0);
}

#[test]
fn monotonic_lines_have_no_links() {
    let layers = vec![vec![island(circle(0.0, 0.0, 12.0, 200), vec![square(1.0, 2.0, 5.0)])]; 9];
    let points = |pattern| {
        let mut s = settings();
        s.infill.top_fill_pattern = pattern;
        let filled = fill(&stack(&layers), &FillPlan::new(&s)).swap_remove(8).swap_remove(0);
        let tops = filled.iter().filter(|p| p.kind == FillKind::TopSolid);
        tops.map(|p| p.points.len()).max().unwrap()
    };
    assert_eq!(points(crate::settings::FillPattern::MonotonicLines), 2);
    assert!(points(crate::settings::FillPattern::Monotonic) > 20);
}
