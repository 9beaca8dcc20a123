//! Which areas become solid.

use super::shapes::*;
use crate::infill::FillPlan;
use crate::infill::skin::{Areas, Level, Skins, Stack};
use crate::region::Island;
use crate::span::algebra::or;
use crate::span::{RowFrame, Rows, scan};
use std::f64::consts::PI;
use std::sync::Arc;

/// Sparse, solid and top infill of every layer on the rows of `frame`; skins over air count as solid.
fn all_areas(layers: &[Vec<Island>], plan: &FillPlan, frame: &RowFrame) -> Vec<[Rows; 3]> {
    let outline =
        |l: &Vec<Island>| Arc::new(scan(l.iter().flat_map(|i| i.outline.rings()).map(|r| &r[..]), frame));
    let infill = |l: &Vec<Island>| {
        Arc::new(scan(l.iter().flat_map(|i| &i.infill).flat_map(|e| e.rings()).map(|r| &r[..]), frame))
    };
    let outlines: Vec<_> = layers.iter().map(outline).collect();
    let own: Vec<_> = layers.iter().map(infill).collect();
    let levels: Vec<Level> =
        stack(layers).iter().map(|l| Level { top: l.print_z, bottom: l.print_z - l.height }).collect();
    let stack = Stack { outlines: &outlines, own: &own, levels: &levels, frame, plan };
    let skins: Vec<Skins> = (0..layers.len()).map(|i| stack.skins(i)).collect();
    let parts = |i: usize| {
        let Areas { sparse, solid, top, bottom } = stack.divide(i, &skins);
        let solid = or(&solid, &bottom);
        assert_eq!(sparse.length() + solid.length() + top.length(), own[i].length());
        [sparse, solid, top]
    };
    (0..layers.len()).map(parts).collect()
}

/// Areas of sparse, solid and top infill of layer `i` \[mm²\].
fn areas(layers: &[Vec<Island>], i: usize, plan: &FillPlan) -> [f64; 3] {
    let frame = plan.area_frame();
    all_areas(layers, plan, &frame).swap_remove(i).map(|r| r.length() as f64 * frame.mm2_per_unit())
}

/// Asserts areas up to what skins are grown by: at most 1.6 mm along an edge of the given length \[mm\].
fn expect(found: [f64; 3], solid: f64, top: f64, edge: f64, what: &str) {
    let slack = 1.6 * edge + 0.01 * (solid + top);
    for (name, found, expected) in [("top", found[2], top), ("skin", found[1] + found[2], solid + top)] {
        let low = if expected == 0.0 { 0.0 } else { expected - 0.01 * (solid + top) };
        let high = if expected == 0.0 { 0.0 } else { expected + slack };
        assert!((low..=high).contains(&found), "{what}: {name} {found}, expected {low} to {high}");
    }
}

/// A plan without growth into the part.
fn plan() -> FillPlan {
    FillPlan { margin: 0.0, ..FillPlan::new(&settings()) }
}

fn boxes(sides: &[f64]) -> Vec<Vec<Island>> {
    sides.iter().map(|&s| vec![island(square(0.0, 0.0, s), vec![])]).collect()
}

#[test]
fn a_step_is_solid_for_three_layers() {
    let rectangle = |w: f64| vec![at(0.0, 0.0), at(w, 0.0), at(w, 40.0), at(0.0, 40.0)];
    let layers: Vec<_> =
        (0..20).map(|i| vec![island(rectangle(if i < 10 { 40.0 } else { 20.0 }), vec![])]).collect();
    for (i, solid, top) in [(0, 1600.0, 0.0), (2, 1600.0, 0.0), (3, 0.0, 0.0), (6, 0.0, 0.0), (7, 800.0, 0.0)]
    {
        expect(areas(&layers, i, &plan()), solid, top, 40.0, &format!("layer {i}"));
    }
    for (i, solid, top) in
        [(9, 0.0, 800.0), (10, 0.0, 0.0), (16, 0.0, 0.0), (17, 800.0, 0.0), (19, 0.0, 800.0)]
    {
        expect(areas(&layers, i, &plan()), solid, top, 40.0, &format!("layer {i}"));
    }
}

#[test]
fn slivers_beside_a_skin_are_solid() {
    // The layers above cover a strip of the lower ones beside the wall at x = 0: too narrow for sparse
    // lines once the skin has grown, or wide enough.
    let rectangle = |w: f64| vec![at(0.0, 0.0), at(w, 0.0), at(w, 40.0), at(0.0, 40.0)];
    let sparse = |strip: f64| {
        let layers: Vec<_> =
            (0..20).map(|i| vec![island(rectangle(if i < 10 { 40.0 } else { strip }), vec![])]).collect();
        areas(&layers, 9, &plan())[0]
    };
    assert_eq!(sparse(1.7), 0.0);
    assert!(sparse(6.0) > 150.0, "{}", sparse(6.0));
}

#[test]
fn a_pyramid_has_a_frame_on_every_layer() {
    let layers = boxes(&(0..15).map(|i| 60.0 - 4.0 * f64::from(i)).collect::<Vec<_>>());
    let area = |i: usize| (60.0 - 4.0 * i as f64).powi(2);
    for i in 3..8 {
        let side = 4.0 * area(i).sqrt();
        let (top, all) = (area(i) - area(i + 1), area(i) - area(i + 3));
        expect(areas(&layers, i, &plan()), all - top, top, side, &format!("layer {i}"));
    }
}

#[test]
fn a_blind_hole_gets_a_floor() {
    let hole = || circle(3.0, 2.0, 8.0, 200);
    let layers: Vec<_> = (0..14)
        .map(|i| vec![island(square(0.0, 0.0, 40.0), if i < 5 { vec![hole()] } else { vec![] })])
        .collect();
    for i in [5, 6, 7] {
        expect(areas(&layers, i, &plan()), PI * 64.0, 0.0, PI * 16.0, &format!("layer {i}"));
    }
    for i in [3, 4, 8] {
        expect(areas(&layers, i, &plan()), 0.0, 0.0, 0.0, &format!("layer {i}"));
    }
}

#[test]
fn a_bridge_is_solid_between_its_pillars() {
    let bar = |x0: f64, x1: f64| vec![at(x0, 0.0), at(x1, 0.0), at(x1, 12.0), at(x0, 12.0)];
    let layers: Vec<_> = (0..20)
        .map(|i| {
            if i < 10 {
                vec![island(bar(0.0, 10.0), vec![]), island(bar(40.0, 50.0), vec![])]
            } else {
                vec![island(bar(0.0, 50.0), vec![])]
            }
        })
        .collect();
    for i in [10, 11, 12] {
        expect(areas(&layers, i, &plan()), 360.0, 0.0, 24.0, &format!("layer {i}"));
    }
    expect(areas(&layers, 9, &plan()), 0.0, 0.0, 0.0, "pillars");
    expect(areas(&layers, 13, &plan()), 0.0, 0.0, 0.0, "above the skin");
}

#[test]
fn a_sphere_closes_towards_its_pole() {
    let radius = 20.0f64;
    let at_layer = |i: usize| (radius * radius - (0.2 * i as f64 + 0.1).powi(2)).sqrt();
    let layers: Vec<_> = (0..100).map(|i| vec![island(circle(0.0, 0.0, at_layer(i), 720), vec![])]).collect();
    let area = |i: usize| PI * at_layer(i).powi(2);
    for i in [90, 94, 96] {
        let (top, all) = (area(i) - area(i + 1), area(i) - area(i + 3));
        expect(areas(&layers, i, &plan()), all - top, top, 2.0 * PI * at_layer(i), &format!("layer {i}"));
    }
    // On the flanks the walls cover what is exposed.
    let walled: Vec<_> = (0..100)
        .map(|i| {
            let mut sphere = island(circle(0.0, 0.0, at_layer(i), 720), vec![]);
            sphere.infill = island(circle(0.0, 0.0, at_layer(i) - 0.9, 720), vec![]).infill;
            vec![sphere]
        })
        .collect();
    expect(areas(&walled, 20, &plan()), 0.0, 0.0, 0.0, "flank");
    expect(areas(&walled, 50, &plan()), 0.0, 0.0, 0.0, "flank");
}

#[test]
fn crumbs_vanish_and_patches_beside_a_wall_stay() {
    let layers = |hole: Vec<_>| -> Vec<Vec<Island>> {
        (0..20)
            .map(|i| vec![island(square(0.0, 0.0, 20.0), if i < 10 { vec![hole.clone()] } else { vec![] })])
            .collect()
    };
    let floor = |hole| {
        let [_, solid, _] = areas(&layers(hole), 10, &plan());
        solid
    };
    assert_eq!(floor(square(0.0, 0.0, 0.3)), 0.0);
    assert!(floor(square(0.0, 0.0, 5.0)) > 24.0);
    // The same narrow strip is a crumb inside and a skin beside the border.
    let strip = |x: f64| vec![at(x, -9.0), at(x + 0.06, -9.0), at(x + 0.06, 9.0), at(x, 9.0)];
    assert_eq!(floor(strip(0.0)), 0.0);
    let mut cut = settings();
    cut.infill.fill_angle = 90.0;
    let narrower: Vec<_> = (0..20)
        .map(|i| {
            let x = if i < 10 { 9.94 } else { 10.0 };
            vec![island(vec![at(-10.0, -10.0), at(x, -10.0), at(x, 10.0), at(-10.0, 10.0)], vec![])]
        })
        .collect();
    let [_, solid, _] = areas(&narrower, 10, &plan());
    assert!(solid > 1.3 * 20.0, "{solid}");
}

#[test]
fn settings_widen_the_skin() {
    let layers = boxes(&[30.0; 30]);
    let is_solid = |change: fn(&mut crate::settings::InfillSettings)| -> Vec<usize> {
        let mut s = settings();
        change(&mut s.infill);
        let plan = FillPlan::new(&s);
        (0..30).filter(|&i| areas(&layers, i, &plan)[0] == 0.0).collect()
    };
    assert_eq!(is_solid(|_| {}), [0, 1, 2, 27, 28, 29]);
    assert_eq!(is_solid(|s| s.top_solid_layers = 1), [0, 1, 2, 29]);
    assert_eq!(is_solid(|s| (s.top_solid_layers, s.bottom_solid_layers) = (0, 0)), [0usize; 0]);
    assert_eq!(is_solid(|s| s.top_solid_min_thickness = 1.0), [0, 1, 2, 25, 26, 27, 28, 29]);
    assert_eq!(is_solid(|s| s.bottom_solid_min_thickness = 0.9), [0, 1, 2, 3, 4, 27, 28, 29]);
    assert_eq!(is_solid(|s| s.solid_infill_every_layers = 10), [0, 1, 2, 10, 20, 27, 28, 29]);
    assert_eq!(is_solid(|s| s.fill_density = 100.0).len(), 30);
    assert_eq!(is_solid(|s| s.solid_infill_below_area = 899.0).len(), 6);
    assert_eq!(is_solid(|s| s.solid_infill_below_area = 905.0).len(), 30);
}
