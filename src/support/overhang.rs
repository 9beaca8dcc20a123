//! What of a layer hangs in air and needs support.

use super::{Part, SupportPlan};
use crate::infill::Bridge;
use crate::span::algebra::{and, sub};
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
pub fn overhangs(part: Part, modifiers: Modifiers, bridges: Bridges, plan: &SupportPlan) -> Vec<Overhang> {
    let _ = (modifiers, bridges);
    (0..part.outlines.len()).into_par_iter().map(|i| overhang(part, i, plan)).collect()
}

fn overhang(part: Part, i: usize, plan: &SupportPlan) -> Overhang {
    let Some(below) = i.checked_sub(1).map(|b| &part.outlines[b]) else { return Overhang::default() };
    let own = &part.outlines[i];
    if Arc::ptr_eq(own, below) || !plan.auto {
        return Overhang::default();
    }
    let beyond = sub(own, below);
    let reach = part.frame.units(reach(part, i, plan));
    let t = |k| part.frame.t(k);
    let far = sub(&beyond, &dilate_disc(below, reach, t));
    let area = and(&beyond, &dilate_disc(&far, reach + part.frame.pitch(), t));
    Overhang { area, ..Overhang::default() }
}

/// How far layer `i` may reach over the one below it \[nm\].
fn reach(part: Part, i: usize, plan: &SupportPlan) -> f64 {
    let (own, below) = (part.levels[i], part.levels[i - 1]);
    // From one cutting plane to the next.
    let rise = 0.5 * (own.top + own.bottom - below.top - below.bottom) as f64;
    plan.threshold.map_or(plan.half_wall, |degrees| rise / libm::tan(degrees.to_radians()))
}
