//! Bridges: skins that hang in air or over sparse infill.

use super::FillPlan;
use crate::span::{RowFrame, Rows};

/// An area to be bridged by parallel lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Bridge {
    /// The area, a part of the layer's infill, anchors included.
    pub rows: Rows,
    /// Direction of its lines \[degrees\].
    pub degrees: f64,
}

/// The bridges of a layer whose infill is `own`; what becomes a bridge is taken out of `bottom`, the
/// skin over air.
///
/// `below` is the outline of the layer below. All rows are of `frame`.
pub fn over_air(
    _own: &Rows,
    _bottom: &mut Rows,
    _below: &Rows,
    _frame: &RowFrame,
    _plan: &FillPlan,
) -> Vec<Bridge> {
    Vec::new()
}

/// The bridges of a layer over sparse infill; what becomes a bridge is taken out of `solid`, the solid
/// infill that shows neither above nor below.
///
/// `sparse_below` is the sparse area of the layer below, before layers are combined.
pub fn over_sparse(
    _own: &Rows,
    _solid: &mut Rows,
    _sparse_below: &Rows,
    _frame: &RowFrame,
    _plan: &FillPlan,
) -> Vec<Bridge> {
    Vec::new()
}
