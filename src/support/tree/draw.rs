//! The skeleton → areas.

use super::grow::{Node, Skeleton};
use super::seeds::touching;
use super::{Held, Stage, per_layer};
use crate::span::algebra::{and, or, sub};
use crate::span::components::label;
use crate::span::{RowFrame, Rows, RowsBuilder};
use crate::support::{LayerKind, SupportLayer};

/// The layers of supports, lowest first.
pub fn draw(skeleton: &Skeleton, stage: &Stage) -> Vec<SupportLayer> {
    let plan = stage.plan;
    let frame = &plan.frame;
    let doubled = match plan.tree.double_wall {
        none if none <= 0.0 => f64::INFINITY,
        // The setting is the diameter whose section is meant.
        diameter => stage.units(0.5e6 * diameter),
    };
    let layers = per_layer(stage.layers.len(), |j| {
        let Held { interface, contact, strips, ribs, .. } = &stage.held[j];
        let foot = |r: f64| match j {
            0 => r + stage.units(plan.first_expansion).min(r),
            _ => r,
        };
        let may_stand = |n: &&Node| n.to_plate || !plan.on_bed_only;
        let all = skeleton[j].iter().filter(may_stand).map(|n| (n.at, foot(n.r)));
        let base = or(&or(&discs(all, frame), strips), &ribs.rows);
        let base = sub(&sub(&base, interface), &stage.keep_out[j]);
        let thick =
            skeleton[j].iter().filter(may_stand).filter(|n| n.r >= doubled).map(|n| (n.at, foot(n.r)));
        let thick = and(&discs(thick, frame), &base);
        SupportLayer {
            print_z: stage.layers[j].top,
            height: stage.layers[j].height,
            kind: LayerKind::Branches,
            base,
            thick,
            interface: interface.clone(),
            contact: contact.clone(),
            bottom_interface: Rows::default(),
        }
    });
    standing(layers, stage)
}

/// Discs, middle and radius \[units\], as rows.
pub fn discs(all: impl Iterator<Item = ([f64; 2], f64)>, frame: &RowFrame) -> Rows {
    let mut chords: Vec<(i32, i32, i32)> = Vec::new();
    for ([s, t], r) in all {
        let (s, t, r) = (s.round() as i64, t.round() as i64, r.round() as i64);
        for k in frame.row_below(t - r) + 1..=frame.row_below(t + r) {
            let d = frame.t(k) - t;
            let half = (r * r - d * d).max(0).isqrt();
            chords.push((k, (s - half) as i32, (s + half) as i32));
        }
    }
    chords.sort_unstable();
    let Some(&(first, ..)) = chords.first() else { return Rows::default() };
    let mut out = RowsBuilder::new(first);
    let mut at = first;
    for (k, start, end) in chords {
        while at < k {
            out.end_row();
            at += 1;
        }
        out.push(start, end);
    }
    out.end_row();
    out.finish()
}

/// Leaves out what stands neither on the bed nor, where that is allowed, on the part.
fn standing(layers: Vec<SupportLayer>, stage: &Stage) -> Vec<SupportLayer> {
    let mut out: Vec<SupportLayer> = Vec::with_capacity(layers.len());
    let mut below = Rows::default();
    for (j, mut layer) in layers.into_iter().enumerate() {
        let mut all = or(&layer.base, &layer.interface);
        if j > 0 {
            let ground = match stage.plan.on_bed_only {
                true => below,
                false => or(&below, &stage.keep_out[j - 1]),
            };
            let loose = apart_from(&all, &ground);
            if !loose.is_empty() {
                all = sub(&all, &loose);
                for area in [&mut layer.base, &mut layer.thick, &mut layer.interface, &mut layer.contact] {
                    *area = sub(area, &loose);
                }
            }
        }
        below = all;
        out.push(layer);
    }
    while out.last().is_some_and(SupportLayer::is_empty) {
        out.pop();
    }
    out
}

/// The connected parts of `area` that do not overlap `ground`.
pub fn apart_from(area: &Rows, ground: &Rows) -> Rows {
    let part = label(area);
    let stands = touching(area, &part, ground);
    let mut out = RowsBuilder::new(area.first());
    for (k, row) in area.iter() {
        for (i, s) in area.range(k).zip(row) {
            if !stands[part[i] as usize] {
                out.push(s.start, s.end);
            }
        }
        out.end_row();
    }
    out.finish()
}
