//! Monotonic lines: rectilinear lines, laid in one sweep, each of its own from wall to wall.
//!
//! Length of lines per area = density / spacing, and nothing on top of it.

use super::Sparse;
use super::straight::{Hold, lay as straight};
use crate::infill::FillPath;

/// Lays the lines of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    let spec = sparse.spec();
    straight(sparse, spec.turned(), spec.pitch(1.0), Hold::Loose, found);
}
