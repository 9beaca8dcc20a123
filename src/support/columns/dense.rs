//! Columns → layers with their dense parts.

use super::contacts::Contact;
use super::heights::Step;
use super::shape::without_slivers;
use crate::span::algebra::{and, or, sub};
use crate::span::{RowFrame, Rows};
use crate::support::{LayerKind, SupportLayer, SupportPlan};
use rayon::prelude::*;
use std::sync::Arc;

/// The layers of all columns. Length = layers.
pub fn dense(
    frame: &RowFrame,
    layers: &[Step],
    contacts: &[Contact],
    areas: &[Arc<Rows>],
    plan: &SupportPlan,
) -> Vec<SupportLayer> {
    // What of each layer has nothing of the one below under it: it stands on the part.
    let stands: Vec<Rows> = (0..areas.len())
        .into_par_iter()
        .map(|i| match i.checked_sub(1).map(|b| &areas[b]) {
            Some(below) if plan.bottom_interface > 0 && !Arc::ptr_eq(below, &areas[i]) => {
                sub(&areas[i], below)
            }
            _ => Rows::default(),
        })
        .collect();
    let under = |i: usize| i..contacts.len().min(i.saturating_add(plan.top_interface as usize));
    let over = |i: usize| (i + 1).saturating_sub(plan.bottom_interface as usize)..i + 1;
    (0..layers.len())
        .into_par_iter()
        .map(|i| {
            let all = union(contacts[under(i)].iter().map(|c| &c.dense));
            let mut layer = SupportLayer {
                print_z: layers[i].top,
                height: layers[i].top - layers[i].bottom,
                kind: LayerKind::Columns,
                ..SupportLayer::default()
            };
            let area = &*areas[i];
            layer.interface = without_slivers(&and(area, &all), plan.width, frame);
            let bottom = sub(&and(area, &union(stands[over(i)].iter())), &layer.interface);
            layer.bottom_interface = without_slivers(&bottom, plan.width, frame);
            let is_dense = !layer.interface.is_empty() || !layer.bottom_interface.is_empty();
            if is_dense {
                let rest = sub(&sub(area, &layer.interface), &layer.bottom_interface);
                layer.base = without_slivers(&rest, plan.width, frame);
                // Too narrow for lines of its own.
                let slivers = sub(&rest, &layer.base);
                let dense = if layer.interface.is_empty() {
                    &mut layer.bottom_interface
                } else {
                    &mut layer.interface
                };
                *dense = or(dense, &slivers);
            } else {
                layer.base = area.clone();
            }
            if plan.top_interface > 0 {
                layer.contact = and(&layer.interface, &contacts[i].dense);
            }
            layer
        })
        .collect()
}

fn union<'a>(mut areas: impl Iterator<Item = &'a Rows>) -> Rows {
    let first = areas.next().cloned().unwrap_or_default();
    areas.fold(first, |all, area| or(&all, area))
}
