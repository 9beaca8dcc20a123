//! Triangles in groups of similar z extent.
//!
//! Tata, Fadel, Bagchi and Aziz, "Efficient slicing for layered manufacturing", Rapid Prototyping Journal
//! 4(4) (1998). Facets are sorted by their lowest z and cut into groups; inside a group those that reach
//! highest come first. A plane looks only at groups that begin below it, leaves each at its first facet
//! that ends below the plane, and forgets groups that lie wholly below. Facets that the plane does not
//! reach yet are only met in the group whose beginnings it is passing.
//!
//! The paper groups facets of equal extent, which parts from CAD have in plenty; scanned and smooth
//! meshes have none, so groups here are √n facets of consecutive lowest z. Time n log n + p √n + m, memory n.

use super::{Segment, corners, extent};
use crate::mesh::Mesh;

/// A triangle that some plane may cut.
struct Facet {
    z_min: i32,
    z_max: i32,
    triangle: u32,
}

/// The segments on each plane, group by group; `planes` \[nm\], mesh frame, ascending.
pub fn run(mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    let mut facets: Vec<Facet> = (0..mesh.triangles.len() as u32)
        .map(|triangle| {
            let (z_min, z_max) = extent(corners(mesh, triangle));
            Facet { z_min, z_max, triangle }
        })
        .collect();
    facets.retain(|f| f.z_min < f.z_max);
    facets.sort_unstable_by_key(|f| (f.z_min, f.triangle));
    let size = facets.len().isqrt().max(1);
    let mut groups = Vec::new();
    for group in facets.chunks_mut(size) {
        let lowest = group[0].z_min;
        group.sort_unstable_by_key(|f| (-f.z_max, f.triangle));
        groups.push((lowest, &*group));
    }
    let mut waiting = groups.into_iter().peekable();
    let mut live: Vec<&[Facet]> = Vec::new();
    let mut layers = Vec::with_capacity(planes.len());
    for &z in planes {
        live.extend(
            std::iter::from_fn(|| waiting.next_if(|&(lowest, _)| lowest < z)).map(|(_, group)| group),
        );
        live.retain(|group| group[0].z_max >= z);
        let mut segments = Vec::new();
        for group in &live {
            for facet in group.iter().take_while(|f| f.z_max >= z).filter(|f| f.z_min < z) {
                segments.push(Segment::cut(facet.triangle, corners(mesh, facet.triangle), z));
            }
        }
        layers.push(segments);
    }
    layers
}
