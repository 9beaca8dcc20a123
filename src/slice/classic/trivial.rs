//! Every plane against every triangle.
//!
//! The slicer that needs no idea: the yardstick of the comparisons in McMains and Séquin (1999) and in
//! Minetto, Volpato, Stolfi, Gregori and da Silva, "An optimal algorithm for 3D triangle mesh slicing",
//! Computer-Aided Design 92 (2017). As there, each triangle's lowest and highest z are computed
//! beforehand, so that a plane and a triangle that do not meet cost two comparisons.
//!
//! Time p n + m, memory n.

use super::{Segment, corners, extent};
use crate::mesh::Mesh;

/// The segments on each plane, ordered by triangle; `planes` \[nm\], mesh frame.
pub fn run(mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    let extents: Vec<(i32, i32)> =
        (0..mesh.triangles.len() as u32).map(|triangle| extent(corners(mesh, triangle))).collect();
    planes.iter().map(|&z| plane(mesh, &extents, z)).collect()
}

fn plane(mesh: &Mesh, extents: &[(i32, i32)], z: i32) -> Vec<Segment> {
    let mut segments = Vec::new();
    for (triangle, &(z_min, z_max)) in (0..).zip(extents) {
        // One jump, seldom taken, and not one per comparison, of which half would be guessed wrong.
        if (z_min < z) & (z <= z_max) {
            segments.push(Segment::cut(triangle, corners(mesh, triangle), z));
        }
    }
    segments
}
