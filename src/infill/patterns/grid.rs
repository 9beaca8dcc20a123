//! Grid: two families of lines at right angles, the same on all layers.
//!
//! Each family has half of the density: its lines are 2 spacing / density apart. Length of lines per
//! area = density / spacing.

use super::Sparse;
use super::crossing::{self, Family};
use crate::infill::FillPath;

/// The directions of both families.
pub fn families(angle: f64) -> [Family; 2] {
    [0.0, 90.0].map(|turn| Family { degrees: angle + turn, phase: 0.0 })
}

/// Lays the lines of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    let spec = sparse.spec();
    crossing::lay(sparse, &families(spec.angle), spec.pitch(2.0), found);
}
