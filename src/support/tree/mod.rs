//! Branches that grow together on their way down.
//!
//! What hangs becomes areas of contact, each on the layer whose top is a gap below it; what of their undersides
//! lies on nothing is carried by branches. These grow layer by layer towards the plate, lean towards their
//! neighbours and grow together, keep clear of the part, and are smoothed when all are known.
//!
//! Memory: per layer the clearance to the part, about twice the part's own rows; at most 32 MB for each field
//! that tells from where the bed can be reached; 40 bytes per branch and layer.

mod clearance;
mod contacts;
mod draw;
mod field;
mod gather;
mod grow;
mod heights;
mod near;
mod seeds;
mod smooth;

#[cfg(test)]
mod tests;

use super::overhang::Overhang;
use super::{Part, SupportLayer, SupportPlan};
use crate::span::Rows;
use rayon::prelude::*;
use std::sync::Arc;

/// Branches under all overhangs, lowest layer first.
pub fn tree(part: Part, overhangs: &[Overhang], plan: &SupportPlan) -> Vec<SupportLayer> {
    let mut wanted = contacts::wanted(part, overhangs, plan);
    let layers = heights::heights(part, &mut wanted, plan);
    if layers.is_empty() {
        return Vec::new();
    }
    let keep_out = clearance::clearance(part, &layers, plan);
    let held = contacts::held(part, overhangs, &wanted, &keep_out, plan);
    let stage = Stage { layers: &layers, keep_out: &keep_out, held: &held, plan };
    let field = field::Field::new(&stage);
    let mut skeleton = grow::grow(&stage, &field);
    smooth::smooth(&mut skeleton, &stage);
    draw::draw(&skeleton, &stage)
}

/// A layer of supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Layer {
    /// Height of its upper side above the bed \[nm\].
    top: i32,
    /// Its thickness \[nm\].
    height: i32,
}

/// What holds the part up, by layer.
#[derive(Clone, Debug, Default)]
struct Held {
    /// Dense, with what lies on it above.
    interface: Rows,
    /// The part of `interface` that the part lies upon.
    contact: Rows,
    /// Narrow strips that the part lies upon, laid as the branches are.
    strips: Rows,
    /// Both: what branches carry.
    all: Rows,
    /// The part of the next higher layer's `all` that lies neither on this layer's nor on the part.
    carried: Rows,
    /// Ribs in this layer, under what of that is a roof.
    ribs: seeds::Ribs,
}

/// What all steps need.
struct Stage<'a> {
    /// Layers of supports, lowest first.
    layers: &'a [Layer],
    /// Where no support may be, per layer.
    keep_out: &'a [Arc<Rows>],
    /// What holds the part up, per layer.
    held: &'a [Held],
    plan: &'a SupportPlan,
}

impl Stage<'_> {
    /// A length \[nm\] in units of the frame.
    fn units(&self, nm: f64) -> f64 {
        nm * self.plan.frame.scale()
    }

    /// How far apart in height the middles of layer `i` and the one above it are \[units\].
    fn rise(&self, i: usize) -> f64 {
        let above = self.layers.get(i + 1).map_or(self.layers[i].height, |l| l.height);
        self.units(0.5 * f64::from(self.layers[i].height + above))
    }

    /// Distance at which branches carry what spans from one to the next \[units\].
    ///
    /// A roof lies on ribs of a tip's width, which touch `top_rate` of it; a bridge is at most
    /// [`LONGEST_BRIDGE`] long.
    fn span(&self) -> f64 {
        span(self.plan)
    }
}

fn span(plan: &SupportPlan) -> f64 {
    longest_span(plan) * plan.frame.scale()
}

/// The distance of the ribs and posts that carry a roof, from middle to middle \[nm\]: its lines bridge that.
pub fn longest_span(plan: &SupportPlan) -> f64 {
    let tip = 2.0 * plan.tree.tip_radius;
    let wanted = tip / plan.tree.top_rate.max(0.01);
    let least = tip + plan.tree.distance;
    wanted.clamp(least, (tip + LONGEST_BRIDGE).max(least))
}

/// What the lines of a roof may span from one rib to the next \[nm\].
const LONGEST_BRIDGE: f64 = 4.2e6;

/// Runs `of` for all layers in parallel.
fn per_layer<T: Send>(count: usize, of: impl Fn(usize) -> T + Sync + Send) -> Vec<T> {
    (0..count).into_par_iter().map(of).collect()
}
