//! Line: parallel lines, turned by 90 degrees from layer to layer, anchored to the walls but not linked.
//!
//! Length of lines per area = density / spacing: they are spacing / density apart.

use super::Sparse;
use super::straight::{Hold, lay as straight};
use crate::infill::FillPath;

/// Lays the lines of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    let spec = sparse.spec();
    straight(sparse, spec.turned(), spec.pitch(1.0), Hold::Anchored, found);
}
