//! Every plane against every triangle.
//!
//! The slicer that needs no idea and no memory: the yardstick of the comparisons in McMains and Séquin
//! (1999) and in Minetto, Volpato, Stolfi, Gregori and da Silva, "An optimal algorithm for 3D triangle
//! mesh slicing", Computer-Aided Design 92 (2017). Time p n + m, no memory beyond the segments.

use super::{ALL_BELOW, Segment, below, corners};
use crate::mesh::Mesh;

/// The segments on each plane, ordered by triangle; `planes` \[nm\], mesh frame.
pub fn run(mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    planes.iter().map(|&z| plane(mesh, z)).collect()
}

fn plane(mesh: &Mesh, z: i32) -> Vec<Segment> {
    let mut segments = Vec::new();
    for triangle in 0..mesh.triangles.len() as u32 {
        let corner = corners(mesh, triangle);
        // Some corners below and some not.
        if !matches!(below(corner, z), 0 | ALL_BELOW) {
            segments.push(Segment::cut(triangle, corner, z));
        }
    }
    segments
}
