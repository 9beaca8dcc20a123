//! The part of a mesh under a plane.

use super::crossing;
use crate::lattice::{Point2, Point3};
use crate::mesh::Mesh;
use rayon::prelude::*;
use std::ops::Range;

/// A mesh cut off at a plane, still without a lid.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Below {
    /// What lies under the plane, in the frame of the whole mesh.
    pub mesh: Mesh,
    /// The vertices on the cut, sorted by (x, y): each position once. They come last.
    pub cut: Range<usize>,
}

impl Below {
    /// The id of a vertex on the cut.
    pub fn on_cut(&self, p: Point2) -> Option<u32> {
        let cut = &self.mesh.vertices[self.cut.clone()];
        cut.binary_search_by_key(&p, |v| v.xy()).ok().map(|at| (self.cut.start + at) as u32)
    }
}

/// Cuts a mesh at height `z` \[nm, mesh frame\] and keeps what is under it.
///
/// A vertex is above iff `z_vertex >= z`, as in slicing. Triangles without a vertex above stay as they
/// are; of one that is cut a triangle or two stay, with the crossing points of
/// [`crossing::point`], which neighbours share: the result is open along the cut alone. The edges
/// there run against the contours of the section.
pub fn below(mesh: &Mesh, z: i32) -> Below {
    let corners = |t: &[u32; 3]| t.map(|v| mesh.vertices[v as usize]);
    let crossings = |t: &[u32; 3]| {
        let c = corners(t);
        let (down, up) = crossing::down_up(c.map(|c| c.z), z);
        let at = |k: usize| crossing::point(c[k], c[(k + 1) % 3], z);
        (down, up, at(down), at(up))
    };
    let vertices_above = |t: &[u32; 3]| corners(t).iter().filter(|c| c.z >= z).count();

    let mut points: Vec<Point2> = mesh
        .triangles
        .par_iter()
        .with_min_len(1 << 12)
        .filter(|t| (1..=2).contains(&vertices_above(t)))
        .flat_map_iter(|t| {
            let (_, _, down, up) = crossings(t);
            [down, up]
        })
        .collect();
    points.par_sort_unstable();
    points.dedup();

    // Only vertices in use stay: the bounds of a mesh are those of its vertices.
    let mut id = vec![u32::MAX; mesh.vertices.len()];
    for t in mesh.triangles.iter().filter(|t| vertices_above(t) < 3) {
        for &v in t {
            if mesh.vertices[v as usize].z < z {
                id[v as usize] = 0;
            }
        }
    }
    let mut vertices = Vec::new();
    for (id, &v) in id.iter_mut().zip(&mesh.vertices) {
        if *id == 0 {
            *id = vertices.len() as u32;
            vertices.push(v);
        }
    }
    let base = vertices.len();
    vertices.extend(points.iter().map(|p| Point3::new(p.x, p.y, z)));
    let on_cut = |p: Point2| (base + points.partition_point(|q| *q < p)) as u32;

    let triangles = mesh
        .triangles
        .par_iter()
        .with_min_len(1 << 12)
        .flat_map_iter(|t| {
            let kept = t.map(|v| id[v as usize]);
            let parts = match vertices_above(t) {
                0 => [Some(kept), None],
                3 => [None, None],
                above => {
                    let (down, up, at_down, at_up) = crossings(t);
                    let (p, q) = (on_cut(at_up), on_cut(at_down));
                    if above == 2 {
                        [Some([kept[up], p, q]), None]
                    } else {
                        let (a, b) = (kept[(down + 1) % 3], kept[(down + 2) % 3]);
                        [Some([a, b, p]), Some([a, p, q])]
                    }
                }
            };
            // Where both crossings round to one point a part has no area, and its other edges meet.
            parts.into_iter().flatten().filter(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0])
        })
        .collect();
    let cut = base..vertices.len();
    Below { mesh: Mesh { vertices, triangles, origin: mesh.origin }, cut }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, sphere, torus};
    use crate::mesh::{Adjacency, OPEN};

    #[test]
    fn the_result_is_open_along_the_cut_alone() {
        for mesh in [cuboid([0.0; 3], [3.0; 3]), sphere(5.0, 40, 20), torus(9.0, 3.0, 40, 20)] {
            let [lo, hi] = mesh.bounds().unwrap_or_default();
            for step in 1..20 {
                let z = lo.z + (hi.z - lo.z) / 20 * step;
                let cut = below(&mesh, z);
                assert!(cut.mesh.vertices.iter().all(|v| v.z <= z));
                let twin = Adjacency::build(&cut.mesh).twin;
                let mut open = 0;
                for (h, _) in twin.iter().enumerate().filter(|(_, twin)| **twin == OPEN) {
                    let t = cut.mesh.triangles[h / 3];
                    let ends = [t[h % 3], t[(h + 1) % 3]];
                    assert!(ends.iter().all(|&v| cut.cut.contains(&(v as usize))));
                    open += 1;
                }
                assert!(open >= 4);
            }
        }
    }

    #[test]
    fn planes_beyond_the_mesh_keep_all_or_nothing() {
        let mesh = sphere(5.0, 40, 20);
        let [lo, hi] = mesh.bounds().unwrap_or_default();
        assert_eq!(below(&mesh, hi.z + 1).mesh, mesh);
        assert_eq!(below(&mesh, lo.z).mesh, Mesh { origin: mesh.origin, ..Mesh::default() });
        assert_eq!(below(&Mesh::default(), 0), Below::default());
    }

    #[test]
    fn a_vertex_on_the_plane_is_above_it() {
        let mesh = cuboid([0.0; 3], [2.0; 3]);
        let [_, hi] = mesh.bounds().unwrap_or_default();
        let cut = below(&mesh, hi.z);
        // All but the top: its four corners are crossings now.
        assert_eq!((cut.mesh.triangles.len(), cut.mesh.vertices.len(), cut.cut), (10, 8, 4..8));
        assert_eq!(cut.mesh.bounds(), mesh.bounds());
    }
}
