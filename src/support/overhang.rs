//! What of a layer hangs in air and needs support.

use super::{Part, SupportPlan};
use crate::infill::Bridge;
use crate::span::{RowFrame, Rows};
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
    let _ = (modifiers, bridges, plan);
    vec![Overhang::default(); part.outlines.len()]
}
