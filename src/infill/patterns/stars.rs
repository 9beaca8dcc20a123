//! Stars: three families of lines at 60 degrees, the same on all layers, which meet two by two: hexagons
//! with triangles around them (the trihexagonal tiling).
//!
//! As triangles, but with one family moved by half its pitch. Each has a third of the density: its lines
//! are 3 spacing / density apart. Length of lines per area = density / spacing.

use super::Sparse;
use super::crossing::{self, Family};
use super::triangles;
use crate::infill::FillPath;

/// The three families at a pitch \[nm\].
pub fn families(angle: f64, pitch: f64) -> [Family; 3] {
    let [a, b, c] = triangles::families(angle);
    [a, b, Family { phase: 0.5 * pitch, ..c }]
}

/// Lays the lines of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    let spec = sparse.spec();
    let pitch = spec.pitch(3.0);
    crossing::lay(sparse, &families(spec.angle, pitch), pitch, found);
}
