//! What is wrong with a mesh, counted. Linear in its triangles; runs on every job.

use super::{Adjacency, Mesh, OPEN};
use crate::lattice::NM_PER_MM;
use rayon::prelude::*;

/// The state of a mesh.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Audit {
    /// Triangles.
    pub triangles: u64,
    /// Half-edges without a partner. 0 for a closed mesh.
    pub open_edges: u64,
    /// Undirected edges with more than two half-edges.
    pub over_shared_edges: u64,
    /// Undirected edges with two half-edges or more, all the same way: neighbours that disagree about
    /// the outside.
    pub flipped_edges: u64,
    /// Triangles whose three vertices an earlier triangle has already, either way round.
    pub duplicate_triangles: u64,
    /// Pieces connected over paired edges.
    pub shells: u64,
    /// Signed volume \[mm³\], positive when facets face outwards. Depends on the lattice's zero when
    /// the mesh is open.
    pub volume_mm3: f64,
    /// Lowest and highest world coordinates \[nm\]; zeros without vertices.
    pub bounds: [[i64; 3]; 2],
}

/// The pieces of a mesh that are connected over paired edges.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Shells {
    /// Per triangle the number of its shell; shells are numbered by their first triangle. Empty where
    /// there is one shell at most.
    pub of: Vec<u32>,
    /// Per shell six times its signed volume \[nm³\], as [`Audit::volume_mm3`]. At least one entry.
    pub volume6: Vec<i128>,
}

/// Examines a mesh with its adjacency.
pub fn audit(mesh: &Mesh, adjacency: &Adjacency) -> Audit {
    audit_shells(mesh, adjacency).0
}

/// [`audit`], and the shells that it found.
pub fn audit_shells(mesh: &Mesh, adjacency: &Adjacency) -> (Audit, Shells) {
    let (edges, (count, shells)) = rayon::join(
        || edges(mesh, adjacency),
        || {
            let (count, parent) = shells(adjacency);
            let found = match count {
                0 | 1 => Shells { of: Vec::new(), volume6: vec![volume6(mesh)] },
                _ => {
                    let of = numbered(parent);
                    let volume6 = volumes6(mesh, &of, count as usize);
                    Shells { of, volume6 }
                }
            };
            (count, found)
        },
    );
    let volume6: i128 = shells.volume6.iter().sum();
    let audit = Audit {
        triangles: mesh.triangles.len() as u64,
        open_edges: edges.open,
        over_shared_edges: edges.over_shared,
        flipped_edges: edges.flipped,
        duplicate_triangles: edges.duplicates,
        shells: count,
        volume_mm3: volume6 as f64 / (6.0 * NM_PER_MM * NM_PER_MM * NM_PER_MM),
        bounds: mesh.world_bounds().unwrap_or_default(),
    };
    (audit, shells)
}

/// Per piece of a mesh six times its signed volume \[nm³\]; `of` gives each triangle's piece, below
/// `pieces`.
pub(super) fn volumes6(mesh: &Mesh, of: &[u32], pieces: usize) -> Vec<i128> {
    let add = |mut sums: Vec<i128>, (triangles, of): (&[[u32; 3]], &[u32])| {
        for (t, &piece) in triangles.iter().zip(of) {
            sums[piece as usize] += determinant(mesh, t);
        }
        sums
    };
    let none = || vec![0i128; pieces];
    // One list of sums per task pays while it is short against the task.
    if pieces > 1 << 12 {
        return add(none(), (&mesh.triangles, of));
    }
    mesh.triangles.par_chunks(1 << 16).zip(of.par_chunks(1 << 16)).fold(none, add).reduce(none, |mut a, b| {
        a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        a
    })
}

/// Union-find parents, each at most its triangle, to numbers from 0 by first triangle.
pub(super) fn numbered(mut parent: Vec<u32>) -> Vec<u32> {
    let mut next = 0;
    for t in 0..parent.len() {
        let up = parent[t] as usize;
        // What is before `t` is a number already.
        parent[t] = if up == t {
            next += 1;
            next - 1
        } else {
            parent[up]
        };
    }
    parent
}

/// Six times the signed volume \[nm³\], exact: the sum of a · (b × c) over the triangles (Gauss).
pub(super) fn volume6(mesh: &Mesh) -> i128 {
    mesh.triangles.par_chunks(1 << 14).map(|run| run.iter().map(|t| determinant(mesh, t)).sum::<i128>()).sum()
}

#[inline(always)]
fn determinant(mesh: &Mesh, t: &[u32; 3]) -> i128 {
    let corner = |k: usize| {
        let p = mesh.vertices[t[k] as usize];
        (i64::from(p.x), i64::from(p.y), i64::from(p.z))
    };
    let ((ax, ay, az), (bx, by, bz), (cx, cy, cz)) = (corner(0), corner(1), corner(2));
    // Coordinates are below 2^30, so components of the cross product are below 2^61.
    let (x, y, z) = (by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx);
    let term = |a: i64, b: i64| i128::from(a) * i128::from(b);
    term(ax, x) + term(ay, y) + term(az, z)
}

/// Pieces connected over paired edges, by union-find (Tarjan 1975) with path halving: every union of
/// two pieces makes one less. In file order neighbours are mostly at hand in the cache.
/// Returns their number, and a parent for each triangle, never above the triangle.
fn shells(adjacency: &Adjacency) -> (u64, Vec<u32>) {
    let triangles = (adjacency.twin.len() / 3) as u32;
    let mut parent: Vec<u32> = (0..triangles).collect();
    let mut shells = u64::from(triangles);
    for (t, twins) in adjacency.twin.as_chunks::<3>().0.iter().enumerate() {
        let mut root = find(&mut parent, t as u32);
        for &twin in twins {
            // Each pair once; OPEN is above every id.
            if twin / 3 < t as u32 {
                let other = find(&mut parent, twin / 3);
                if other != root {
                    parent[other.max(root) as usize] = other.min(root);
                    root = other.min(root);
                    shells -= 1;
                }
            }
        }
    }
    (shells, parent)
}

fn find(parent: &mut [u32], mut t: u32) -> u32 {
    loop {
        let up = parent[t as usize];
        if up == t {
            return t;
        }
        let above = parent[up as usize];
        parent[t as usize] = above;
        t = above;
    }
}

#[derive(Default)]
struct Edges {
    open: u64,
    over_shared: u64,
    flipped: u64,
    duplicates: u64,
}

/// Edges that are not simply one half-edge each way, and the duplicates among their triangles.
///
/// A pair, by its lower half-edge, or an open half-edge represents its edge; an edge with several
/// representatives is over-shared or flipped. Each vertex has a word of 64 bits in which the edges to
/// higher vertices leave a hashed mark; only at vertices where a mark was met twice (about one in
/// twenty, by chance) are the edges compared exactly.
fn edges(mesh: &Mesh, adjacency: &Adjacency) -> Edges {
    /// Cleared where a mark was met twice.
    const CERTAIN: u64 = 1 << 63;
    let twin = &adjacency.twin;
    let mut found = Edges::default();
    // A mark is a cleared bit, as zeros from the allocator that are read first and written then cost two
    // page faults.
    let mut marks = vec![u64::MAX; mesh.vertices.len()];
    let mut suspects = Vec::new();
    for (t, c) in mesh.triangles.iter().enumerate() {
        let twins = &twin[3 * t..3 * t + 3];
        for i in 0..3 {
            found.open += u64::from(twins[i] == OPEN);
            // OPEN is above every id.
            if twins[i] as usize > 3 * t + i {
                let (lo, hi) = key(c[i], c[(i + 1) % 3]);
                // 63 marks.
                let mark = 1u64 << (mix(hi ^ lo.rotate_left(16)) >> 26).min(62);
                let marks = &mut marks[lo as usize];
                let again = if *marks & mark == 0 { CERTAIN } else { 0 };
                *marks &= !(mark | again);
            }
        }
        // A triangle back to back with its own reverse.
        if twins[0] != OPEN && twins[0] / 3 == twins[1] / 3 && twins[1] / 3 == twins[2] / 3 {
            suspects.push(t as u32);
        }
    }
    let mut represented = Vec::new();
    for (t, c) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let h = 3 * t + i;
            let (lo, hi) = key(c[i], c[(i + 1) % 3]);
            if twin[h] as usize > h && marks[lo as usize] & CERTAIN == 0 {
                represented.push((u64::from(lo) << 32 | u64::from(hi), h as u32));
            }
        }
    }
    represented.sort_unstable();
    for edge in represented.chunk_by(|a, b| a.0 == b.0).filter(|edge| edge.len() > 1) {
        let paired = edge.iter().filter(|e| twin[e.1 as usize] != OPEN).count();
        found.over_shared += u64::from(edge.len() + paired > 2);
        found.flipped += u64::from(paired == 0);
        for &(_, h) in edge {
            suspects.push(h / 3);
            if twin[h as usize] != OPEN {
                suspects.push(twin[h as usize] / 3);
            }
        }
    }
    found.duplicates = duplicates(mesh, suspects);
    found
}

/// Spreads the bits of a word upwards.
fn mix(x: u32) -> u32 {
    let x = x.wrapping_mul(0x9E37_79B9);
    (x ^ x >> 15).wrapping_mul(0x85EB_CA6B)
}

fn key(a: u32, b: u32) -> (u32, u32) {
    (a.min(b), a.max(b))
}

fn duplicates(mesh: &Mesh, mut suspects: Vec<u32>) -> u64 {
    suspects.sort_unstable();
    suspects.dedup();
    let mut sets: Vec<[u32; 3]> = suspects
        .iter()
        .map(|&t| {
            let mut set = mesh.triangles[t as usize];
            set.sort_unstable();
            set
        })
        .collect();
    sets.sort_unstable();
    sets.windows(2).filter(|w| w[0] == w[1]).count() as u64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Point3;
    use crate::mesh::random::Random;
    use crate::mesh::shapes::cuboid;
    use std::collections::BTreeMap;

    fn report(mesh: &Mesh) -> Audit {
        audit(mesh, &Adjacency::build(mesh))
    }

    #[test]
    fn planted_faults_are_counted() {
        let clean = cuboid([0.0; 3], [1.0, 2.0, 3.0]);
        let good = report(&clean);
        assert_eq!((good.triangles, good.shells, good.volume_mm3), (12, 1, 6.0));
        assert_eq!(good.bounds, [[0; 3], [1_000_000, 2_000_000, 3_000_000]]);

        let mut holed = clean.clone();
        holed.triangles.remove(3);
        assert_eq!(report(&holed).open_edges, 3);

        let mut flipped = clean.clone();
        flipped.triangles[3].swap(0, 1);
        let found = report(&flipped);
        assert_eq!((found.flipped_edges, found.open_edges, found.over_shared_edges), (3, 6, 0));

        let mut doubled = clean.clone();
        doubled.triangles.push(clean.triangles[3]);
        let found = report(&doubled);
        assert_eq!((found.duplicate_triangles, found.over_shared_edges, found.open_edges), (1, 3, 3));

        let mut lid = clean.clone();
        let [a, b, c] = clean.triangles[3];
        lid.triangles.extend([[a, b, c], [c, b, a]]);
        assert_eq!(report(&lid).duplicate_triangles, 2);
        let leaf = Mesh { triangles: vec![[a, b, c], [b, a, c]], ..clean.clone() };
        let found = report(&leaf);
        assert_eq!((found.duplicate_triangles, found.open_edges, found.over_shared_edges), (1, 0, 0));
        assert_eq!(report(&Mesh::default()), Audit::default());
    }

    #[test]
    fn bodies_that_touch_along_an_edge_share_it_four_times() {
        // Two tetrahedra on the edge 0-1.
        let vertices = (0..6).map(|i| Point3::new(i * i, i * i * i, i)).collect();
        let body = |c: u32, d: u32| vec![[0, 1, c], [1, 0, d], [0, c, d], [1, d, c]];
        let mesh = Mesh { vertices, triangles: [body(2, 3), body(4, 5)].concat(), origin: [0; 3] };
        let found = report(&mesh);
        assert_eq!((found.over_shared_edges, found.open_edges, found.duplicate_triangles), (1, 0, 0));
    }

    #[test]
    fn random_soups_agree_with_plain_counting() {
        for seed in 0..300 {
            let mut random = Random(seed);
            let mesh = random.mesh(3 + seed as usize % 40, seed as usize);
            let mut edges: BTreeMap<(u32, u32), (u64, u64)> = BTreeMap::new();
            let mut sets: BTreeMap<[u32; 3], u64> = BTreeMap::new();
            for t in &mesh.triangles {
                for i in 0..3 {
                    let (a, b) = (t[i], t[(i + 1) % 3]);
                    let uses = edges.entry(key(a, b)).or_default();
                    if a < b { uses.0 += 1 } else { uses.1 += 1 }
                }
                let mut set = *t;
                set.sort_unstable();
                *sets.entry(set).or_default() += 1;
            }
            let count = |f: &dyn Fn(&(u64, u64)) -> bool| edges.values().filter(|e| f(e)).count() as u64;
            let found = report(&mesh);
            assert_eq!(found.over_shared_edges, count(&|e| e.0 + e.1 > 2), "seed {seed}");
            assert_eq!(found.flipped_edges, count(&|e| e.0.max(e.1) > 1 && e.0.min(e.1) == 0), "seed {seed}");
            assert_eq!(
                found.open_edges,
                edges.values().map(|e| e.0.abs_diff(e.1)).sum::<u64>(),
                "seed {seed}"
            );
            assert_eq!(found.duplicate_triangles, sets.values().map(|n| n - 1).sum::<u64>(), "seed {seed}");
        }
    }

    #[test]
    fn shells_are_counted_in_any_order() {
        use crate::mesh::shapes::{merge, moved, torus};
        let ring = torus(10.0, 2.0, 40, 20);
        let mut mesh =
            merge(&[ring.clone(), moved(ring.clone(), [3.0, 0.0, 0.0]), moved(ring, [0.0, 0.0, 9.0])]);
        let n = mesh.triangles.len();
        mesh.triangles = (0..n).map(|i| mesh.triangles[i * 1009 % n]).collect();
        assert_eq!(report(&mesh).shells, 3);
        mesh.triangles.truncate(1);
        assert_eq!(report(&mesh).shells, 1);
    }

    #[test]
    fn volume_is_exact_at_the_lattices_corners() {
        let m = crate::lattice::LIMIT - 1;
        let mut mesh = cuboid([0.0; 3], [1.0; 3]);
        for v in &mut mesh.vertices {
            *v = Point3::new(m * v.x.signum(), m * v.y.signum(), m * v.z.signum());
        }
        assert_eq!(volume6(&mesh), 48 * i128::from(m).pow(3));
    }
}
