//! Triangles: three families of lines at 60 degrees, the same on all layers, which meet three by three.
//!
//! Each family has a third of the density: its lines are 3 spacing / density apart. Length of lines per
//! area = density / spacing.

use super::Sparse;
use super::crossing::{self, Family};
use crate::infill::FillPath;

/// The three families; each has a line through the mesh frame's zero.
pub fn families(angle: f64) -> [Family; 3] {
    [0.0, 120.0, 240.0].map(|turn| Family { degrees: angle + turn, phase: 0.0 })
}

/// Lays the lines of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    let spec = sparse.spec();
    crossing::lay(sparse, &families(spec.angle), spec.pitch(3.0), found);
}
