//! Vertices rounded to a coarser grid, so that cracks narrower than it close.

use super::Mesh;
use crate::lattice::{LIMIT, Point3};
use rayon::prelude::*;

/// What rounding to a grid did.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Snapped {
    /// Vertices that fell together with an earlier one.
    pub merged: u64,
    /// Triangles dropped because two of their corners fell together, by their index before; ascending.
    pub dropped: Vec<u32>,
}

/// Rounds every vertex to the nearest multiple of `grid` \[nm\] in world coordinates, halves away from
/// zero, and welds what then coincides. A grid of 1 nm or less changes nothing.
///
/// Vertices keep the order of their first occurrence, so the result is that of a file with rounded
/// coordinates. Build the [`super::Adjacency`] afterwards.
pub fn snap(mesh: &mut Mesh, grid: i64) -> Snapped {
    if grid <= 1 {
        return Snapped::default();
    }
    let [x, y, z] = mesh.origin;
    let round = |local: i32, origin: i64| {
        let world = i128::from(origin) + i128::from(local);
        let (grid, limit) = (i128::from(grid), i128::from(LIMIT));
        let rounded = (2 * world + grid * world.signum()) / (2 * grid) * grid - i128::from(origin);
        // The next multiple may lie beyond the lattice; then the one before it is as good.
        if rounded.abs() < limit { rounded as i32 } else { local }
    };
    mesh.vertices.par_iter_mut().for_each(|v| *v = Point3::new(round(v.x, x), round(v.y, y), round(v.z, z)));

    let mut sorted: Vec<(Point3, u32)> = mesh.vertices.iter().copied().zip(0..).collect();
    sorted.par_sort_unstable();
    let mut first: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        for (_, id) in same {
            first[*id as usize] = same[0].1;
        }
    }
    drop(sorted);
    let mut new_id = vec![0u32; first.len()];
    let mut kept = 0;
    for id in 0..first.len() {
        if first[id] as usize == id {
            mesh.vertices[kept] = mesh.vertices[id];
            new_id[id] = kept as u32;
            kept += 1;
        } else {
            new_id[id] = new_id[first[id] as usize];
        }
    }
    let merged = (first.len() - kept) as u64;
    mesh.vertices.truncate(kept);

    let mut dropped = Vec::new();
    let mut index = 0;
    mesh.triangles.retain_mut(|t| {
        *t = t.map(|v| new_id[v as usize]);
        let whole = t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        if !whole {
            dropped.push(index);
        }
        index += 1;
        whole
    });
    Snapped { merged, dropped }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, sphere};
    use crate::mesh::{Adjacency, audit};

    #[test]
    fn coordinates_round_in_the_world_halves_away_from_zero() {
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        mesh.origin = [14_999 + 500_000, -500_000 - 5_000, 505_000 + 4_999];
        let report = snap(&mut mesh, 10_000);
        assert_eq!(report, Snapped::default());
        let world = mesh.world_bounds().unwrap_or_default();
        assert_eq!(world, [[10_000, -1_010_000, 10_000], [1_010_000, -10_000, 1_010_000]]);
        let before = mesh.clone();
        snap(&mut mesh, 1);
        assert_eq!(mesh, before);
    }

    #[test]
    fn what_coincides_is_welded_and_what_collapses_dropped() {
        let mut mesh = sphere(0.05, 40, 20);
        let before = mesh.triangles.len();
        let report = snap(&mut mesh, 10_000);
        assert_eq!(mesh.triangles.len() + report.dropped.len(), before);
        assert!(report.merged > 0 && !report.dropped.is_empty());
        let mut sorted = mesh.vertices.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), mesh.vertices.len());
        let found = audit(&mesh, &Adjacency::build(&mesh));
        assert_eq!(found.open_edges, 0, "merging vertices opens no edges");
    }

    #[test]
    fn the_lattices_end_is_not_crossed() {
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        mesh.vertices[0] = Point3::new(LIMIT - 1, 1 - LIMIT, LIMIT - 3);
        snap(&mut mesh, 1_000_000);
        assert!(mesh.vertices.iter().all(|v| [v.x, v.y, v.z].iter().all(|c| c.abs() < LIMIT)));
    }
}
