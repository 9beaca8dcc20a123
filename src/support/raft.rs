//! Layers under the part that hold it to the bed and even the bed out.

use super::{LayerKind, SupportLayer, SupportPlan};
use crate::lattice::nm;
use crate::settings::{FloatOrPercent, LengthOrPixels, Settings};
use crate::span::algebra::{and, or, sub};
use crate::span::components::label;
use crate::span::morph::{dilate_disc, offset_disc};
use crate::span::{Rows, RowsBuilder};

/// Layers below the topmost reach this much further out \[mm\], as in PrusaSlicer.
const STEP: f64 = 0.5;

/// The layers of a raft.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Heights {
    /// Height of each layer's upper side and its thickness \[nm\], lowest first; empty without a raft.
    pub layers: Vec<(i32, i32)>,
    /// Number of dense layers, which are the topmost.
    pub dense: usize,
    /// How far the topmost layer reaches beyond the part \[nm\].
    pub expansion: i64,
    /// Height of the part's underside above the bed \[nm\]: 0 without a raft, else a gap above its top.
    pub part_z: i32,
}

impl Heights {
    /// Those that the settings ask for, as in PrusaSlicer: the first layer is `first_layer_height` thick, the
    /// others three quarters of the nozzle's bore, but not less than `layer_height` nor more than
    /// `support_material_layer_height`; half of them, rounded up, are dense. The part lies
    /// `raft_contact_distance` above the topmost, or on it where supports are soluble.
    pub fn new(settings: &Settings) -> Self {
        let a = &settings.adhesion;
        let layers = a.raft_layers as usize;
        if layers == 0 {
            return Self::default();
        }
        let height = |mm: f64| nm(mm).clamp(1, 1 << 30) as i32;
        let own = height(settings.raft_layer_height());
        let first = height(settings.slicing.first_layer_height.of(settings.slicing.layer_height));
        let mut top = 0i32;
        let layers: Vec<(i32, i32)> = (0..layers)
            .map(|i| {
                let thickness = if i == 0 { first } else { own };
                top = top.saturating_add(thickness);
                (top, thickness)
            })
            .collect();
        let gap = if settings.has_soluble_supports() { 0.0 } else { a.raft_contact_distance };
        let gap = nm(gap).clamp(0, 1 << 30) as i32;
        Self {
            dense: layers.len().div_ceil(2),
            expansion: nm(a.raft_expansion),
            part_z: top.saturating_add(gap),
            layers,
        }
    }

    /// Height of the raft's upper side \[nm\]; 0 without one.
    pub fn top(&self) -> i32 {
        self.layers.last().map_or(0, |l| l.0)
    }
}

/// The raft under a part whose first layer has the outline `first`, and under `columns`, what stands on its top.
///
/// Dense layers lie under the part alone, its holes filled and narrow gaps closed; what carries columns beside
/// it is loose. The areas are as large in every style: with grid, PrusaSlicer's grow to whole cells. The single layer of a raft that has no other is dense under the part and loose around it.
pub fn raft(first: &Rows, columns: &Rows, heights: &Heights, plan: &SupportPlan) -> Vec<SupportLayer> {
    let frame = &plan.frame;
    let t = |k: i32| frame.t(k);
    let grow = |area: &Rows, nm: f64| dilate_disc(area, frame.units(nm), t);
    let closing = frame.units(plan.closing);
    let close = |area: &Rows| or(area, &offset_disc(&dilate_disc(area, closing, t), -closing, t));
    let step = nm(STEP) as f64;
    let top = close(&grow(&without_holes(first), heights.expansion as f64));
    let (dense, feet) = (grow(&top, step), grow(columns, step));
    let base = close(&or(&dense, &feet));
    let bed = grow(&base, (plan.first_expansion - step).max(0.0));
    let last = heights.layers.len().saturating_sub(1);
    let of_layer = |(i, &(print_z, height)): (usize, &(i32, i32))| {
        let mut layer = SupportLayer { print_z, height, ..SupportLayer::default() };
        if i + heights.dense > last {
            layer.kind = LayerKind::RaftInterface;
            layer.interface = if i == last { top.clone() } else { dense.clone() };
            layer.base = sub(columns, &layer.interface);
        }
        if i == 0 {
            layer.kind = LayerKind::RaftFirst;
            layer.base = sub(&bed, &layer.interface);
        } else if layer.interface.is_empty() {
            layer.kind = LayerKind::RaftBase;
            layer.base = base.clone();
        }
        if i == last {
            layer.contact = and(&layer.interface, first);
        }
        layer
    };
    heights.layers.iter().enumerate().map(of_layer).collect()
}

/// An area and what it surrounds.
fn without_holes(area: &Rows) -> Rows {
    let Some(low) = area.spans().iter().map(|s| s.start).min() else { return Rows::default() };
    let high = area.spans().iter().map(|s| s.end).max().unwrap_or(low);
    let (low, high) = (low.saturating_sub(1), high.saturating_add(1));
    // What is not of the area, in a box with a margin on all sides, so that all of the outside is one part.
    let mut outside = RowsBuilder::new(area.first() - 1);
    for k in area.first() - 1..=area.end() {
        let mut from = low;
        for s in area.row(k) {
            outside.push(from, s.start);
            from = s.end;
        }
        outside.push(from, high);
        outside.end_row();
    }
    let outside = outside.finish();
    let part = label(&outside);
    let mut holes = RowsBuilder::new(outside.first());
    for k in outside.first()..outside.end() {
        for i in outside.range(k).filter(|i| part[*i] != 0) {
            holes.push(outside.spans()[i].start, outside.spans()[i].end);
        }
        holes.end_row();
    }
    or(area, &holes.finish())
}

/// The settings of a part on a raft: its first layer is like the others.
pub fn part_settings(settings: &Settings) -> Settings {
    let mut own = settings.clone();
    own.slicing.first_layer_height = FloatOrPercent::Float(own.slicing.layer_height);
    own.slicing.elefant_foot_compensation = LengthOrPixels::Length(0.0);
    own.widths.first_layer_extrusion_width = FloatOrPercent::Float(0.0);
    own
}

#[cfg(test)]
#[path = "raft_tests.rs"]
mod tests;
