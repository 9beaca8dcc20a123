//! What of a layer hangs in air and needs support.

mod bed;
mod bridged;
mod carry;
mod foot;
mod islands;
mod slope;
#[cfg(test)]
mod tests;

use super::{Part, SupportPlan};
use crate::infill::Bridge;
use crate::span::algebra::{and, or, sub};
use crate::span::components::smaller_than;
use crate::span::morph::dilate_disc;
use crate::span::{RowFrame, Rows};
use rayon::prelude::*;
use std::sync::Arc;

/// What of one layer hangs.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Overhang {
    /// What needs support, a part of the layer's outline beyond the layer below.
    pub area: Rows,
    /// Those connected parts of the layer that nothing at all lies under; within `area`.
    pub islands: Rows,
    /// What hangs and holds itself as a bridge; not in `area`.
    pub bridged: Rows,
}

/// Where the user wants supports and where not. Empty, or one entry per layer of the part.
#[derive(Clone, Copy, Debug, Default)]
pub struct Modifiers<'a> {
    /// What hangs in these is supported, however steep.
    pub enforced: &'a [Arc<Rows>],
    /// What hangs in these is not supported.
    pub blocked: &'a [Arc<Rows>],
}

/// The bridges that the infill lays over air.
#[derive(Clone, Copy, Debug)]
pub struct Bridges<'a> {
    /// Per layer, on the rows of `frame`.
    pub of_layer: &'a [Vec<Bridge>],
    /// The rows of the bridges' areas.
    pub frame: &'a RowFrame,
}

/// What hangs on each layer. Length = layers.
///
/// A layer may reach as far beyond the one below as the threshold's slope, or half an outer wall, allows; see
/// [`SupportPlan::threshold`]. Where it reaches further, the strip beyond the layer below is taken whole.
/// Islands are taken however small, bridges that are held at both ends are left out where
/// `plan.spare_bridges` says so, and without `plan.auto` only enforcers and `plan.enforce_layers` count.
/// Connected parts smaller than a square of half a wall's width, 0.05 mm² with walls of 0.45 mm, are left
/// out: no bead is laid there. The first layer counts as it was before it was shrunk against an elephant's
/// foot.
pub fn overhangs(part: Part, modifiers: Modifiers, bridges: Bridges, plan: &SupportPlan) -> Vec<Overhang> {
    let outlines = foot::grown_back(part, plan);
    let part = Part { outlines: &outlines, ..part };
    let finder = Finder { part, modifiers, bridges, plan };
    let mut found: Vec<Overhang> =
        (0..part.outlines.len()).into_par_iter().map(|i| finder.overhang(i)).collect();
    if plan.on_bed_only {
        bed::keep_over_bed(part.outlines, &mut found);
        found.par_iter_mut().for_each(|o| finder.drop_crumbs(o));
    }
    found.par_iter_mut().zip(modifiers.blocked).for_each(|(o, blocked)| {
        if !o.area.is_empty() && !blocked.is_empty() {
            o.area = sub(&o.area, blocked);
            finder.drop_crumbs(o);
        }
    });
    found
}

#[derive(Clone, Copy)]
struct Finder<'a> {
    part: Part<'a>,
    modifiers: Modifiers<'a>,
    bridges: Bridges<'a>,
    plan: &'a SupportPlan,
}

impl Finder<'_> {
    fn overhang(&self, i: usize) -> Overhang {
        let Some(below) = i.checked_sub(1).and_then(|b| self.part.outlines.get(b)) else {
            return Overhang::default();
        };
        let own = &self.part.outlines[i];
        if Arc::ptr_eq(own, below) {
            return Overhang::default();
        }
        let mut found = if i < self.plan.enforce_layers as usize {
            let area = sub(own, below);
            let islands = if area.is_empty() { Rows::default() } else { islands::islands(own, below) };
            Overhang { area, islands, bridged: Rows::default() }
        } else if self.plan.auto {
            self.by_slope(i, own, below)
        } else {
            Overhang::default()
        };
        if let Some(enforcer) = self.modifiers.enforced.get(i).filter(|e| !e.is_empty()) {
            let wanted = and(&sub(own, below), enforcer);
            found.area = or(&found.area, &wanted);
            found.bridged = sub(&found.bridged, &wanted);
        }
        self.drop_crumbs(&mut found);
        found
    }

    /// What is too far out, and islands.
    fn by_slope(&self, i: usize, own: &Rows, below: &Rows) -> Overhang {
        let (part, plan) = (self.part, self.plan);
        let bridged = match self.bridges.of_layer.get(i) {
            Some(laid) if plan.spare_bridges && !laid.is_empty() => {
                bridged::bridged(own, below, part.frame, (laid, self.bridges.frame), plan)
            }
            _ => Rows::default(),
        };
        let reach = slope::Reach { part, plan, layer: i };
        let islands = islands::islands(own, below);
        let far = or(&reach.exceeded(&bridged), &islands);
        if far.is_empty() {
            return Overhang { bridged, ..Overhang::default() };
        }
        let hanging = sub(&sub(own, below), &bridged);
        let near = dilate_disc(&far, reach.units(1) + part.frame.pitch(), |k| part.frame.t(k));
        Overhang { area: and(&hanging, &near), islands, bridged }
    }

    /// Takes away what no bead is laid in, and brings the islands into line.
    fn drop_crumbs(&self, found: &mut Overhang) {
        if found.area.is_empty() {
            found.islands = Rows::default();
            return;
        }
        let side = self.plan.half_wall * 1e-6;
        let least = (side * side / self.part.frame.mm2_per_unit()).min(1e18) as i64;
        let crumbs = smaller_than(&found.area, least);
        if !crumbs.is_empty() {
            found.area = sub(&found.area, &crumbs);
        }
        if !found.islands.is_empty() {
            found.islands = and(&found.islands, &found.area);
        }
    }
}
