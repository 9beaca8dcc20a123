//! Which half-edge meets which.
//!
//! On an undirected edge the i-th half-edge one way pairs with the i-th the other way, counted by
//! half-edge id; the surplus stays open. Any such pairing closes contours and keeps winding, because
//! both sides of an edge compute the same crossing points; this one does not depend on the machine.
//!
//! The half-edges that still wait for a partner hang in short lists at one endpoint of their edge: the
//! one that fewer triangles touch, so that the hub of a fan keeps no list. A mesh on which the lists
//! grow long all the same (thousands of triangles on one edge) is sorted instead: the same pairs.

use super::{Adjacency, Mesh, OPEN};
use rayon::prelude::*;

/// List steps per half-edge, on average, after which sorting is the better way.
const PATIENCE: usize = 16;

impl Adjacency {
    /// Pairs the half-edges of a mesh. The triangles' vertex ids must be below the number of vertices.
    pub fn build(mesh: &Mesh) -> Self {
        let twin = pair_by_lists(mesh).unwrap_or_else(|| pair_by_sorting(mesh));
        Self { twin }
    }
}

/// A half-edge that waits for its partner, in the list of its edge's owner.
#[derive(Clone, Copy)]
struct Waiting {
    /// The endpoint that does not own the list.
    other: u32,
    /// Half-edge id.
    half_edge: u32,
    /// 1 when the half-edge leaves the owner, 0 when it arrives.
    leaves: u32,
    /// The next one in this list, or in the list of free places.
    next: u32,
}

/// `None` when the lists take more than [`PATIENCE`] steps per half-edge.
fn pair_by_lists(mesh: &Mesh) -> Option<Vec<u32>> {
    let mut degree = vec![0u32; mesh.vertices.len()];
    for v in mesh.triangles.as_flattened() {
        degree[*v as usize] += 1;
    }
    let mut twin = vec![OPEN; 3 * mesh.triangles.len()];
    let mut head = vec![OPEN; mesh.vertices.len()];
    let mut pool: Vec<Waiting> = Vec::new();
    let mut free = OPEN;
    // Lists are searched from their youngest entry. Once an edge has two waiting the same way, the
    // older must be found, so the search goes on to the end.
    let mut over_shared = false;
    let mut patience = PATIENCE.saturating_mul(twin.len());
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (from, to) = (triangle[i], triangle[(i + 1) % 3]);
            let leaves = (degree[from as usize], from) < (degree[to as usize], to);
            let (owner, other) = if leaves { (from, to) } else { (to, from) };
            let leaves = u32::from(leaves);
            let half_edge = (3 * t + i) as u32;
            let first = head[owner as usize];
            let (mut at, mut before) = (first, OPEN);
            let (mut found, mut found_before) = (OPEN, OPEN);
            while at != OPEN {
                patience = patience.checked_sub(1)?;
                let waiting = pool[at as usize];
                if waiting.other == other {
                    if waiting.leaves == leaves {
                        over_shared = true;
                    } else {
                        (found, found_before) = (at, before);
                        if !over_shared {
                            break;
                        }
                    }
                }
                (before, at) = (at, waiting.next);
            }
            if found == OPEN {
                let waiting = Waiting { other, half_edge, leaves, next: first };
                head[owner as usize] = if free == OPEN {
                    pool.push(waiting);
                    pool.len() as u32 - 1
                } else {
                    let place = free;
                    free = pool[place as usize].next;
                    pool[place as usize] = waiting;
                    place
                };
            } else {
                let partner = pool[found as usize];
                twin[half_edge as usize] = partner.half_edge;
                twin[partner.half_edge as usize] = half_edge;
                if found_before == OPEN {
                    head[owner as usize] = partner.next;
                } else {
                    pool[found_before as usize].next = partner.next;
                }
                pool[found as usize].next = free;
                free = found;
            }
        }
    }
    Some(twin)
}

/// Sorts by edge, then pairs run by run. Slower on ordinary meshes, good on all.
fn pair_by_sorting(mesh: &Mesh) -> Vec<u32> {
    let mut edges: Vec<([u32; 2], bool, u32)> = mesh
        .triangles
        .par_iter()
        .enumerate()
        .flat_map_iter(|(t, c)| {
            (0..3).map(move |i| {
                let (from, to) = (c[i], c[(i + 1) % 3]);
                ([from.min(to), from.max(to)], from < to, (3 * t + i) as u32)
            })
        })
        .collect();
    edges.par_sort_unstable();
    let mut twin = vec![OPEN; edges.len()];
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        let (back, forth) = edge.split_at(edge.partition_point(|e| !e.1));
        for (a, b) in back.iter().zip(forth) {
            twin[a.2 as usize] = b.2;
            twin[b.2 as usize] = a.2;
        }
    }
    twin
}
