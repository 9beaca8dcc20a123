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

/// Examines a mesh with its adjacency.
pub fn audit(mesh: &Mesh, adjacency: &Adjacency) -> Audit {
    let (edges, (shells, volume6)) =
        rayon::join(|| edges(mesh, adjacency), || (shells(adjacency), volume6(mesh)));
    Audit {
        triangles: mesh.triangles.len() as u64,
        open_edges: adjacency.twin.iter().filter(|&&t| t == OPEN).count() as u64,
        over_shared_edges: edges.over_shared,
        flipped_edges: edges.flipped,
        duplicate_triangles: edges.duplicates,
        shells,
        volume_mm3: volume6 as f64 / (6.0 * NM_PER_MM * NM_PER_MM * NM_PER_MM),
        bounds: mesh.world_bounds().unwrap_or_default(),
    }
}

/// Six times the signed volume \[nm³\], exact: the sum of a · (b × c) over the triangles (Gauss).
pub(super) fn volume6(mesh: &Mesh) -> i128 {
    let term = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| {
            let p = mesh.vertices[v as usize];
            [i64::from(p.x), i64::from(p.y), i64::from(p.z)]
        });
        // Coordinates are below 2^30: components of the cross product below 2^61.
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        (0..3).map(|i| i128::from(a[i]) * i128::from(cross[i])).sum::<i128>()
    };
    mesh.triangles.par_chunks(1 << 14).map(|run| run.iter().map(term).sum::<i128>()).sum()
}

/// Pieces connected over paired edges, by flooding.
fn shells(adjacency: &Adjacency) -> u64 {
    let mut seen = vec![false; adjacency.twin.len() / 3];
    let mut shells = 0;
    let mut stack = Vec::new();
    for start in 0..seen.len() {
        if seen[start] {
            continue;
        }
        shells += 1;
        seen[start] = true;
        stack.push(start);
        while let Some(t) = stack.pop() {
            for &twin in &adjacency.twin[3 * t..3 * t + 3] {
                let n = (twin / 3) as usize;
                if twin != OPEN && !seen[n] {
                    seen[n] = true;
                    stack.push(n);
                }
            }
        }
    }
    shells
}

#[derive(Default)]
struct Edges {
    over_shared: u64,
    flipped: u64,
    duplicates: u64,
}

/// Edges that are not simply one half-edge each way, and the duplicates among their triangles.
///
/// A pair or an open half-edge stands for its edge; an edge with two such representatives is over-
/// shared or flipped. Each vertex has a word of 32 bits in which the edges to higher vertices leave a
/// hashed mark; only at vertices where a mark was met twice are edges compared exactly.
fn edges(mesh: &Mesh, adjacency: &Adjacency) -> Edges {
    let twin = &adjacency.twin;
    let mut marks = vec![0u32; mesh.vertices.len()];
    let mut doubtful = vec![false; mesh.vertices.len()];
    let mut reversed = Vec::new();
    for (t, c) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let h = 3 * t + i;
            // Of a pair the lower id stands for the edge; OPEN is above every id.
            if (twin[h] as usize) < h {
                continue;
            }
            let [lo, hi] = key(c[i], c[(i + 1) % 3]);
            let mark = 1 << (hi.wrapping_mul(0x9E37_79B9) >> 27);
            doubtful[lo as usize] |= marks[lo as usize] & mark != 0;
            marks[lo as usize] |= mark;
        }
        let [a, b, d] = [twin[3 * t], twin[3 * t + 1], twin[3 * t + 2]].map(|w| w / 3);
        if a == b && b == d && a != OPEN / 3 {
            reversed.push(t as u32);
        }
    }
    let mut edges: Vec<([u32; 2], u32)> = Vec::new();
    for (t, c) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let key = key(c[i], c[(i + 1) % 3]);
            if doubtful[key[0] as usize] {
                edges.push((key, (3 * t + i) as u32));
            }
        }
    }
    edges.par_sort_unstable();
    let mut found = Edges::default();
    let mut suspects = reversed;
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        let closed = edge.iter().any(|e| twin[e.1 as usize] != OPEN);
        found.over_shared += u64::from(edge.len() > 2);
        found.flipped += u64::from(edge.len() > 1 && !closed);
        if edge.len() > 2 || !closed {
            suspects.extend(edge.iter().map(|e| e.1 / 3));
        }
    }
    found.duplicates = duplicates(mesh, suspects);
    found
}

fn key(a: u32, b: u32) -> [u32; 2] {
    [a.min(b), a.max(b)]
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
