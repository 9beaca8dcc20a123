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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::sphere;

    #[test]
    fn only_inside_out_meshes_are_turned() {
        let good = sphere(5.0, 20, 10);
        let mut mesh = good.clone();
        assert!(!flip_if_inside_out(&mut mesh));
        assert_eq!(mesh, good);
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert!(flip_if_inside_out(&mut mesh));
        assert_eq!(mesh, good);
    }
}
