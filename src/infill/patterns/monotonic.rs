//! Monotonic: rectilinear lines, laid in one sweep over each region.
//!
//! Rectilinear lines are swept anyway, so the two are the same as sparse infill; what differs is the
//! order of a top skin's paths. Length of lines per area = density / spacing.

use super::{Sparse, rectilinear};
use crate::infill::FillPath;

/// Lays the lines of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    rectilinear::lay(sparse, found);
}
