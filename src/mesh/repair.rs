//! Mending what can be mended without guessing.

use super::{Mesh, audit};

/// Turns every triangle of a mesh whose total signed volume is negative; returns whether it did.
///
/// A part exported inside out slices into holes only; turning it is what its author meant. Build the
/// [`super::Adjacency`] afterwards.
pub fn flip_if_inside_out(mesh: &mut Mesh) -> bool {
    let inside_out = audit::volume6(mesh) < 0;
    if inside_out {
        for t in &mut mesh.triangles {
            t.swap(1, 2);
        }
    }
    inside_out
}
