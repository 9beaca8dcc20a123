//! Columns, branches and the loose layers of a raft.

use super::crumb;
use super::fill::Fill;
use super::laying::Laying;
use super::outline::outlines;
use crate::settings::SupportPattern;
use crate::span::Rows;
use crate::span::algebra::and;
use crate::support::{LayerKind, Strand, StrandKind, SupportLayer, SupportPlan};
use std::f64::consts::PI;

/// Whether both have the same lines, but for what turns from layer to layer.
pub fn is_same(a: &SupportLayer, b: &SupportLayer) -> bool {
    is_on_bed(a) == is_on_bed(b) && a.kind == b.kind && a.base == b.base && a.thick == b.thick
}

/// It lies on the bed.
pub fn is_on_bed(layer: &SupportLayer) -> bool {
    layer.print_z == layer.height
}

/// The lines of layer `i`.
pub fn lay(layer: &SupportLayer, i: usize, plan: &SupportPlan) -> Vec<Strand> {
    if layer.base.is_empty() {
        return Vec::new();
    }
    let mut laying = Laying::new(StrandKind::Base, plan.width, plan.spacing);
    if is_on_bed(layer) {
        (laying.width, laying.spacing) = (first_width(plan), plan.first_spacing);
        first(&layer.base, plan, &mut laying);
    } else if layer.kind == LayerKind::Branches {
        branches(layer, plan, &mut laying);
    } else {
        let areas = outlines(&layer.base, &plan.frame, crumb(plan));
        let walled = plan.sheath || layer.kind == LayerKind::RaftBase;
        laying.fill(&areas, pattern(i, plan), walled);
    }
    laying.strands
}

/// What lies on the bed: a wall, and lines across those of the columns.
fn first(area: &Rows, plan: &SupportPlan, laying: &mut Laying) {
    let areas = outlines(area, &plan.frame, crumb(plan));
    if plan.first_density <= 0.0 {
        return areas.iter().for_each(|a| laying.walls(a, plan.first_spacing, 1));
    }
    let lines = Fill::Lines { degrees: plan.angle + 90.0, pitch: plan.first_spacing / plan.first_density };
    laying.fill(&areas, lines, true);
}

/// Width of a line on the bed \[nm\], by the rounded flanks that it has.
pub fn first_width(plan: &SupportPlan) -> f64 {
    plan.first_spacing + f64::from(plan.first_height) * (1.0 - PI / 4.0)
}

/// The columns' pattern on layer `i`.
fn pattern(i: usize, plan: &SupportPlan) -> Fill {
    let (degrees, pitch) = (plan.angle, plan.cell);
    match plan.pattern {
        SupportPattern::Rectilinear => Fill::Lines { degrees, pitch },
        SupportPattern::RectilinearGrid => {
            Fill::Lines { degrees: degrees + if i.is_multiple_of(2) { 0.0 } else { 90.0 }, pitch }
        }
        SupportPattern::Honeycomb => Fill::Honeycomb {
            degrees,
            spacing: plan.spacing,
            density: (plan.spacing / pitch).min(1.0),
            turn: i % 3,
        },
    }
}

/// Walls and nothing within.
fn branches(layer: &SupportLayer, plan: &SupportPlan, laying: &mut Laying) {
    for area in outlines(&layer.base, &plan.frame, crumb(plan)) {
        laying.walls(&area, plan.spacing, 1);
    }
    if layer.thick.is_empty() {
        return;
    }
    // Inside the first wall.
    let thick = outlines(&and(&layer.thick, &layer.base), &plan.frame, crumb(plan));
    laying.inner_walls(&thick);
}
