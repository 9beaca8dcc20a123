//! The dense layers.

use super::base::is_on_bed;
use super::crumb;
use super::fill::Fill;
use super::laying::Laying;
use super::outline::outlines;
use super::shrink::shrink;
use crate::contour::ExPolygon;
use crate::settings::{InterfacePattern, SupportStyle};
use crate::span::Rows;
use crate::span::algebra::sub;
use crate::support::{LayerKind, Strand, StrandKind, SupportLayer, SupportPlan};

/// Loops that one area can have.
const MOST_LOOPS: usize = 10_000;

/// Whether both have the same lines, but for what turns from layer to layer.
pub fn is_same(a: &SupportLayer, b: &SupportLayer) -> bool {
    is_on_bed(a) == is_on_bed(b)
        && a.kind == b.kind
        && a.interface == b.interface
        && a.contact == b.contact
        && a.bottom_interface == b.bottom_interface
}

/// The lines of layer `i`.
pub fn lay(layer: &SupportLayer, i: usize, plan: &SupportPlan) -> Vec<Strand> {
    let mut laying = Laying::new(StrandKind::Interface, plan.width, plan.spacing);
    let raft = layer.kind == LayerKind::RaftInterface;
    let pitch = if raft { plan.spacing } else { plan.interface_pitch };
    let lines = Fill::Lines { degrees: degrees(i, raft, plan), pitch };
    let how = if !raft && is_concentric(plan) { None } else { Some(lines) };
    let outlines = |area: &Rows| outlines(area, &plan.frame, crumb(plan));
    if plan.contact_loops && !layer.contact.is_empty() {
        dense(&outlines(&sub(&layer.interface, &layer.contact)), how, pitch, &mut laying);
        for area in outlines(&layer.contact) {
            laying.walls(&area, pitch, 1);
            let inside = shrink(&area, plan.spacing.round() as i64);
            dense(&inside, how, pitch, &mut laying);
        }
    } else {
        dense(&outlines(&layer.interface), how, pitch, &mut laying);
    }
    dense(&outlines(&layer.bottom_interface), how, pitch, &mut laying);
    laying.strands
}

/// Fills areas with lines, or with loops `pitch` \[nm\] apart.
fn dense(areas: &[ExPolygon], lines: Option<Fill>, pitch: f64, laying: &mut Laying) {
    match lines {
        Some(lines) => laying.fill(areas, lines, false),
        None => areas.iter().for_each(|a| laying.walls(a, pitch, MOST_LOOPS)),
    }
}

/// Direction of the lines: across the columns', or in style snug, whose columns may be narrow, slanting to
/// either side in turn.
fn degrees(i: usize, raft: bool, plan: &SupportPlan) -> f64 {
    let turn = if i.is_multiple_of(2) { 90.0 } else { 0.0 };
    match plan.style {
        _ if raft => plan.angle + turn,
        SupportStyle::Snug => plan.angle + 45.0 + turn,
        SupportStyle::Grid | SupportStyle::Organic => plan.angle + 90.0,
    }
}

/// Loops, whose lines are easily pulled off, where the support touches the part.
fn is_concentric(plan: &SupportPlan) -> bool {
    match plan.interface_pattern {
        InterfacePattern::Auto => plan.top_gap == 0,
        InterfacePattern::Rectilinear => false,
        InterfacePattern::Concentric => true,
    }
}
