//! Cubic: cubes that stand on a corner, cut by the layers.
//!
//! The cubes' faces are three families of planes at right angles to each other, all equally steep: at
//! `tan = sqrt(2)` to the layers. A layer cuts them in three families of lines at 60 degrees, which move
//! sideways by `1 / sqrt(2)` of the height. The meeting points of three lines part to triangles and close
//! again.
//!
//! Each family has a third of the density: its lines are 3 spacing / density apart, and a cube's edge
//! measures `sqrt(2/3)` of that. Length of lines per area = density / spacing.

use super::Sparse;
use super::crossing::{self, Family};
use super::triangles;
use crate::infill::FillPath;
use std::f64::consts::FRAC_1_SQRT_2;

/// The three families at a height \[nm\].
pub fn families(angle: f64, z: f64) -> [Family; 3] {
    triangles::families(angle).map(|family| Family { phase: FRAC_1_SQRT_2 * z, ..family })
}

/// Lays the lines of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    let spec = sparse.spec();
    crossing::lay(sparse, &families(spec.angle, spec.z), spec.pitch(3.0), found);
}
