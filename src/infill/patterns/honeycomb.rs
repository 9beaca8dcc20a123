//! Honeycomb: hexagonal cells whose walls are all printed, one side of each printed twice.
//!
//! The lines are strands: each runs straight for a length `d`, turns by 60 degrees, crosses over on a
//! slant, turns back, and so on. Neighbours mirror each other, so that they run side by side, one line
//! spacing `w` apart, and part again around a cell. With cells of side `L` in a regular lattice the
//! strands are `sqrt(3)/2 L` apart on average and repeat after `3 L`, the straight parts are
//! `d = L + w / sqrt(3)` long and the slants `L - 2 w / sqrt(3)`.
//!
//! Length of lines per area = `(4 L - 2 w / sqrt(3)) / (3 L sqrt(3)/2 L)` = density / spacing, so that
//! `L = w (4 + sqrt(16 - 12 density)) / (3 sqrt(3) density)`. At full density the slants vanish and
//! the strands are straight lines one spacing apart.
//!
//! From layer to layer the strands turn by 60 degrees about the middle of a cell: cells lie upon each
//! other, and of each cell's three pairs of sides another one is double.

use super::clip::{Strands, clip};
use super::join::join;
use super::{Sparse, Spec};
use crate::infill::FillPath;

/// Strands of one layer.
pub fn strands(spec: &Spec) -> Strands {
    let (w, root3) = (spec.spacing, 3f64.sqrt());
    let side = w * (4.0 + (16.0 - 12.0 * spec.density.min(1.0)).sqrt()) / (3.0 * root3 * spec.density);
    let pitch = 0.5 * root3 * side;
    Strands::new(
        spec.angle + 60.0 * (spec.layer % 3) as f64,
        pitch,
        (0.5 * (pitch - w)).max(0.0),
        1.5 * side,
        side + w / root3,
    )
}

/// Lays the strands of one layer.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    let strands = strands(&sparse.spec());
    let regions = sparse.compared.regions;
    let outline = sparse.outline();
    let pieces = clip(&strands, regions, outline.as_deref(), sparse.least());
    join(&pieces, &regions.rings, &sparse.anchors(), &sparse.open(), sparse.paths(found));
}
