//! Lines and links never leave the area, and regions grow in one sweep.

use super::shapes::*;
use super::*;
use crate::region::Island;
use crate::span::tests::Random;
use std::collections::BTreeMap;

/// A ring of random radius about (x, y), often deeply notched \[mm\].
fn star(random: &mut Random, x: f64, y: f64, radius: f64) -> Vec<Point2> {
    let corners = 5 + random.below(120);
    (0..corners)
        .map(|i| {
            let (s, c) = libm::sincos(i as f64 * std::f64::consts::TAU / corners as f64);
            let r = radius * (0.35 + 0.65 * random.below(1000) as f64 / 1000.0);
            at(x + r * c, y + r * s)
        })
        .collect()
}

/// Holes lie within the outer ring's smallest radius and apart from each other.
pub fn random_island(random: &mut Random) -> Island {
    let holes = (0..random.below(5)).map(|i| star(random, 2.0 * i as f64 - 4.0, -1.0, 0.95)).collect();
    let radius = 16.0 + random.below(10) as f64;
    island(star(random, 0.0, 0.0, radius), holes)
}

/// How far a point is outside an area \[nm\]; 0 inside.
pub fn outside(p: Point2, rings: &[Vec<Point2>]) -> f64 {
    let mut winding = 0;
    let mut nearest = f64::INFINITY;
    for ring in rings {
        for i in 0..ring.len() {
            let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
            let side = crate::lattice::cross(a, b, p);
            if a.y <= p.y && b.y > p.y && side > 0 {
                winding += 1;
            } else if b.y <= p.y && a.y > p.y && side < 0 {
                winding -= 1;
            }
            let (ux, uy) = b.minus(a);
            let (vx, vy) = p.minus(a);
            let long = (ux * ux + uy * uy) as f64;
            let f = if long > 0.0 { ((ux * vx + uy * vy) as f64 / long).clamp(0.0, 1.0) } else { 0.0 };
            let (dx, dy) = (vx as f64 - f * ux as f64, vy as f64 - f * uy as f64);
            nearest = nearest.min((dx * dx + dy * dy).sqrt());
        }
    }
    if winding != 0 { 0.0 } else { nearest }
}

/// The farthest that any of 8 points on every segment is outside \[nm\].
pub fn worst(paths: &[FillPath], island: &Island) -> f64 {
    let rings: Vec<Vec<Point2>> = island.infill.iter().flat_map(|e| e.rings().cloned()).collect();
    let mut worst = 0.0f64;
    for w in paths.iter().flat_map(|p| p.points.windows(2)) {
        let (dx, dy) = w[1].minus(w[0]);
        for i in 0..=8 {
            let p = Point2::new(w[0].x + (dx * i / 8) as i32, w[0].y + (dy * i / 8) as i32);
            // Whole nanometres cut off cost up to 1.5 nm.
            worst = worst.max(outside(p, &rings));
        }
    }
    worst
}

fn random_job(seed: u64) -> (Vec<Vec<Island>>, FillPlan) {
    let mut random = Random(seed);
    let mut s = settings();
    s.infill.fill_angle = [45.0, 0.0, 30.0, 117.0][random.below(4) as usize];
    s.infill.fill_density = [15.0, 40.0, 100.0][random.below(3) as usize];
    s.widths.first_layer_extrusion_width = crate::settings::FloatOrPercent::Float(0.6);
    s.widths.top_infill_extrusion_width = crate::settings::FloatOrPercent::Float(0.4);
    let base = random_island(&mut random);
    let layers =
        (0..9).map(|i| vec![if i % 3 == 0 { random_island(&mut random) } else { base.clone() }]).collect();
    (layers, FillPlan::new(&s))
}

#[test]
fn every_path_stays_inside() {
    let (mut kinds, mut links) = ([0; FillKind::COUNT], 0);
    for seed in 1..16 {
        let (layers, plan) = random_job(seed);
        for (i, (paths, layer)) in fill(&stack(&layers), &plan).iter().zip(&layers).enumerate() {
            for p in &paths[0] {
                assert!(p.points.len() >= 2);
                kinds[p.kind as usize] += 1;
                links += usize::from(p.points.len() > 3);
            }
            let worst = worst(&paths[0], &layer[0]);
            assert!(worst < 3.5, "seed {seed}, layer {i}: {worst} nm outside");
        }
    }
    assert!(kinds.iter().all(|&n| n > 40) && links > 1000, "{kinds:?} {links}");
}

#[test]
fn a_path_outside_is_noticed() {
    let (layers, plan) = random_job(3);
    let mut paths = fill(&stack(&layers), &plan).swap_remove(4).swap_remove(0);
    paths[0].points[0].x -= 50_000_000;
    assert!(worst(&paths, &layers[4][0]) > 1e6);
}

/// The lines of each kind in the order laid: row, start, end \[units\].
fn laid(paths: &[FillPath], kind: FillKind, plan: &FillPlan, i: usize) -> Vec<(i32, i32, i32)> {
    let frame = plan.line_frame(kind, i);
    let mut out = Vec::new();
    for w in paths.iter().filter(|p| p.kind == kind).flat_map(|p| p.points.windows(2)) {
        let [a, b] = [w[0], w[1]].map(|p| frame.st(p));
        let row = frame.nearest_row(a.1.into());
        let on_row = |t: i32| (i64::from(t) - frame.t(row)).abs() <= 2;
        if on_row(a.1) && on_row(b.1) {
            out.push((row, a.0.min(b.0), a.0.max(b.0)));
        }
    }
    out
}

#[test]
fn no_line_is_laid_before_one_below_it() {
    let mut pairs = 0;
    for seed in 1..20 {
        let (layers, plan) = random_job(seed);
        for (i, paths) in fill(&stack(&layers), &plan).iter().enumerate() {
            for kind in [FillKind::Solid, FillKind::TopSolid] {
                let mut rows: BTreeMap<i32, Vec<(i32, i32)>> = BTreeMap::new();
                for (row, start, end) in laid(&paths[0], kind, &plan, i) {
                    for above in rows.get(&(row + 1)).into_iter().flatten() {
                        assert!(
                            above.1 <= start + 4 || end <= above.0 + 4,
                            "seed {seed}, layer {i}, row {row}"
                        );
                    }
                    pairs += rows.get(&(row - 1)).map_or(0, Vec::len);
                    rows.entry(row).or_default().push((start, end));
                }
            }
        }
    }
    assert!(pairs > 1000);
}
