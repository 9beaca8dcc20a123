//! Sparse infill: the patterns.

mod rectilinear;

use super::regions::Compared;
use super::{FillPath, FillPlan};
use crate::span::Rows;

/// The sparse infill of a layer.
#[derive(Clone, Copy, Debug)]
pub struct Sparse<'a> {
    /// The layer's infill regions and the rows of areas. For lines of any direction:
    /// `compared.regions.trace(&lines)` finds the border on their rows, `compared.onto(area, ..)` the
    /// part of each row to be laid, `compared.regions.border(..)` is what `rectilinear::lay` links along.
    pub compared: Compared<'a>,
    /// What is to be filled, on the rows of areas; not empty.
    pub area: &'a Rows,
    /// Density above 0, pattern, angle, spacing.
    pub plan: &'a FillPlan,
    /// Index of the layer.
    pub layer: usize,
    /// Height of its upper side \[nm\].
    #[expect(dead_code, reason = "for patterns that change with the height")]
    pub print_z: i64,
    /// Number of layers that the lines are thick: the value of [`FillPath::layers`].
    pub layers: u32,
}

/// Lays the sparse infill of one layer: reports each path with the index of its region, region by
/// region, in the order in which they are to be laid.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    rectilinear::lay(sparse, found);
}
