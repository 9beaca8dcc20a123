//! Sparse infill printed several layers thick.

use super::shapes::*;
use super::*;
use crate::settings::Settings;
use crate::settings::flow::{Flow, FlowRole};

const THIN: f64 = 0.1;

fn thin(every: u32) -> Settings {
    let mut s = settings();
    s.slicing.layer_height = THIN;
    s.infill.infill_every_layers = every;
    // Anchors and links belong to walls: they are as long on every layer.
    (s.infill.infill_anchor, s.infill.infill_anchor_max) =
        (crate::settings::FloatOrPercent::Float(0.0), crate::settings::FloatOrPercent::Float(0.0));
    s
}

fn filled(layers: &[Vec<Island>], s: &Settings) -> Vec<Vec<FillPath>> {
    let height = (THIN * 1e6) as i64;
    let layers: Vec<FillLayer> = (0i64..)
        .zip(layers)
        .map(|(i, islands)| FillLayer { islands, print_z: (i + 1) * height, height })
        .collect();
    fill(&layers, &FillPlan::new(s)).into_iter().map(|l| l.into_iter().flatten().collect()).collect()
}

/// Volume of a layer's sparse infill \[mm³\].
fn volume(paths: &[FillPath], s: &Settings) -> f64 {
    let of = |p: &FillPath| {
        let flow = Flow::new(FlowRole::Infill, THIN * f64::from(p.layers), false, s);
        length(std::slice::from_ref(p), p.kind) * flow.mm3_per_mm()
    };
    paths.iter().filter(|p| p.kind == FillKind::Sparse).map(of).sum()
}

#[test]
fn the_volume_stays() {
    let layers = vec![vec![island(square(0.0, 0.0, 120.0), vec![])]; 31];
    let total = |every| {
        let s = thin(every);
        filled(&layers, &s).iter().map(|l| volume(l, &s)).sum::<f64>()
    };
    let one = total(1);
    for every in 2..=4 {
        let many = total(every);
        assert!((many / one - 1.0).abs() < 0.02, "{every}: {many} for {one}");
    }
}

#[test]
fn no_line_is_thicker_than_the_nozzle_nor_under_a_skin() {
    let side = |i: usize| if i < 15 { 40.0 } else { 20.0 };
    let layers: Vec<_> = (0..30).map(|i| vec![island(square(0.0, 0.0, side(i)), vec![])]).collect();
    let s = thin(9);
    let mut thick = [0; 10];
    for (i, paths) in filled(&layers, &s).iter().enumerate() {
        for p in paths {
            thick[p.layers as usize] += 1;
            assert!(p.layers == 1 || p.kind == FillKind::Sparse);
            assert!(f64::from(p.layers) * THIN <= s.printer.nozzle_diameter + 1e-9);
            assert!(p.layers == 1 || p.layers as usize <= i, "the first layer is printed alone");
            // Layers 12 to 14 have a skin outside the upper block.
            let outside = p.points.iter().any(|p| p.x.abs().max(p.y.abs()) > 14_000_000);
            let range = i + 1 - p.layers as usize..=i;
            assert!(p.layers == 1 || !outside || !(12..15).any(|l| range.contains(&l)), "layer {i}");
        }
    }
    assert!(thick[4] > 0 && thick[5..].iter().all(|&n| n == 0), "{thick:?}");
}
