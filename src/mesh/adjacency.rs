//! Which half-edge meets which.
//!
//! On an undirected edge the i-th half-edge one way pairs with the i-th the other way, counted by
//! half-edge id; the surplus stays open. Any such pairing closes contours and keeps winding, because
//! both sides of an edge compute the same crossing points; this one does not depend on the machine.
//!
//! The half-edges that still wait for a partner hang in short lists at one endpoint of their edge: the
//! one with the higher id, which a file has named last and will soon name again. Should the lists grow
//! long (the hub of a fan in wild order), it is the endpoint that fewer triangles touch; and should they
//! grow long all the same (thousands of triangles on one edge), the mesh is sorted instead: the same pairs.
//!
//! With several threads the triangles are cut into contiguous blocks. An edge with an endpoint that
//! only one block touches has all its half-edges there, so that block pairs them alone and keeps its list
//! at that endpoint; the edges between vertices of several blocks follow in a pass of their own.

use super::blocks::blocks;
use super::{Adjacency, Mesh, OPEN};
use rayon::prelude::*;
use std::sync::atomic::{AtomicU8, AtomicU32, Ordering::Relaxed};

/// List steps per half-edge, on average, after which the lists go to the endpoints with fewer triangles.
const HASTE: usize = 8;

/// List steps per half-edge, on average, after which sorting is the better way.
const PATIENCE: usize = 16;

impl Adjacency {
    /// Pairs the half-edges of a mesh. The triangles' vertex ids must be below the number of vertices.
    pub fn build(mesh: &Mesh) -> Self {
        let blocks = Blocks::new(mesh, blocks(mesh.triangles.len()));
        let twin = pair_by_lists(mesh, HASTE, &blocks, |_| 0)
            .or_else(|| {
                let degree = degrees(mesh);
                pair_by_lists(mesh, PATIENCE, &blocks, |v| degree[v as usize])
            })
            .unwrap_or_else(|| pair_by_sorting(mesh));
        Self { twin }
    }
}

/// How the triangles are cut into blocks.
struct Blocks {
    /// Triangles of a block.
    size: usize,
    /// Per vertex a bit for each block that touches it; empty for a single block.
    touched: Vec<AtomicU8>,
}

impl Blocks {
    /// At most eight.
    fn new(mesh: &Mesh, count: usize) -> Self {
        let triangles = &mesh.triangles;
        let (size, one) = (triangles.len().div_ceil(count).max(1), triangles.len().max(1));
        if size == one {
            return Self { size: one, touched: Vec::new() };
        }
        let touched: Vec<AtomicU8> = mesh.vertices.iter().map(|_| AtomicU8::new(0)).collect();
        triangles.par_chunks(size).enumerate().for_each(|(k, triangles)| {
            for &v in triangles.as_flattened() {
                let bits = &touched[v as usize];
                if bits.load(Relaxed) >> k & 1 == 0 {
                    bits.fetch_or(1 << k, Relaxed);
                }
            }
        });
        let blocks = Self { size, touched };
        // In no order that would leave the blocks much to do?
        if blocks.shared() > mesh.vertices.len() / 8 {
            return Self { size: one, touched: Vec::new() };
        }
        blocks
    }

    /// Vertices that several blocks touch.
    fn shared(&self) -> usize {
        (0..self.touched.len() as u32).filter(|&v| self.is_shared(v)).count()
    }

    #[inline(always)]
    fn is_shared(&self, vertex: u32) -> bool {
        self.touched.get(vertex as usize).is_some_and(|bits| {
            let bits = bits.load(Relaxed);
            bits & bits.wrapping_sub(1) != 0
        })
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

/// Of the two endpoints that may keep an edge's list, the one of less `weight` does. `None` when the lists
/// take more than `patience` steps per half-edge.
fn pair_by_lists(
    mesh: &Mesh,
    patience: usize,
    blocks: &Blocks,
    weight: impl Fn(u32) -> u32 + Sync,
) -> Option<Vec<u32>> {
    let triangles = &mesh.triangles;
    let head: Vec<AtomicU32> = mesh.vertices.iter().map(|_| AtomicU32::new(OPEN)).collect();
    let mut twin = vec![0; 3 * triangles.len()];
    let between: Option<Vec<Vec<u32>>> = twin
        .par_chunks_mut(3 * blocks.size)
        .zip(triangles.par_chunks(blocks.size))
        .enumerate()
        .map(|(k, (twin, triangles))| {
            twin.fill(OPEN);
            let mut between = Vec::new();
            let mut lists = Lists::new(&head, patience.saturating_mul(twin.len()));
            let first = (3 * k * blocks.size) as u32;
            for (t, triangle) in triangles.iter().enumerate() {
                for i in 0..3 {
                    let half_edge = (3 * t + i) as u32;
                    let edge = Edge::new(triangle, i, blocks, &weight);
                    if edge.shared {
                        between.push(first + half_edge);
                    } else if let Some(partner) = lists.partner(edge, half_edge)? {
                        twin[half_edge as usize] = first + partner;
                        twin[partner as usize] = first + half_edge;
                    }
                }
            }
            Some(between)
        })
        .collect();
    let between = between?.concat();
    if !between.is_empty() {
        let mut lists = Lists::new(&head, patience.saturating_mul(twin.len()));
        for half_edge in between {
            let triangle = &triangles[half_edge as usize / 3];
            let edge = Edge::new(triangle, half_edge as usize % 3, blocks, &weight);
            if let Some(partner) = lists.partner(edge, half_edge)? {
                twin[half_edge as usize] = partner;
                twin[partner as usize] = half_edge;
            }
        }
    }
    Some(twin)
}

/// How many corners of triangles each vertex is.
fn degrees(mesh: &Mesh) -> Vec<u32> {
    let mut degree = vec![0; mesh.vertices.len()];
    for v in mesh.triangles.as_flattened() {
        degree[*v as usize] += 1;
    }
    degree
}

/// A half-edge as its edge's owner sees it.
#[derive(Clone, Copy)]
struct Edge {
    /// The endpoint that keeps the list.
    owner: u32,
    other: u32,
    /// 1 when the half-edge leaves the owner, 0 when it arrives.
    leaves: u32,
    /// Whether both endpoints are shared by several blocks.
    shared: bool,
}

impl Edge {
    #[inline(always)]
    fn new(triangle: &[u32; 3], i: usize, blocks: &Blocks, weight: &impl Fn(u32) -> u32) -> Self {
        let (from, to) = (triangle[i], triangle[if i == 2 { 0 } else { i + 1 }]);
        let (a, b) = (blocks.is_shared(from), blocks.is_shared(to));
        // What several blocks touch keeps no list while they are at work.
        let leaves = (a, weight(from), to) < (b, weight(to), from);
        let (owner, other) = if leaves { (from, to) } else { (to, from) };
        Self { owner, other, leaves: u32::from(leaves), shared: a && b }
    }
}

/// The lists of waiting half-edges.
struct Lists<'a> {
    /// Per vertex the place of its list's first entry, or [`OPEN`]. Tasks at work at the same time write
    /// to different vertices.
    head: &'a [AtomicU32],
    pool: Vec<Waiting>,
    free: u32,
    /// Lists are searched from their youngest entry. Once an edge has two waiting the same way, the
    /// older must be found, so the search goes on to the end.
    over_shared: bool,
    /// Steps that are left.
    patience: usize,
}

impl<'a> Lists<'a> {
    fn new(head: &'a [AtomicU32], patience: usize) -> Self {
        Self { head, pool: Vec::new(), free: OPEN, over_shared: false, patience }
    }

    /// Takes the partner of a half-edge out of its list; without one, the half-edge waits. Half-edges
    /// come in ascending order. `None` when patience is at its end.
    #[inline(always)]
    fn partner(&mut self, edge: Edge, half_edge: u32) -> Option<Option<u32>> {
        let Edge { owner, other, leaves, .. } = edge;
        let head = &self.head[owner as usize];
        let first = head.load(Relaxed);
        let (mut at, mut before) = (first, OPEN);
        let (mut found, mut found_before) = (OPEN, OPEN);
        while at != OPEN {
            self.patience = self.patience.checked_sub(1)?;
            let waiting = self.pool[at as usize];
            if waiting.other == other {
                if waiting.leaves == leaves {
                    self.over_shared = true;
                } else {
                    (found, found_before) = (at, before);
                    if !self.over_shared {
                        break;
                    }
                }
            }
            (before, at) = (at, waiting.next);
        }
        if found == OPEN {
            let waiting = Waiting { other, half_edge, leaves, next: first };
            let place = self.free;
            if place == OPEN {
                head.store(self.pool.len() as u32, Relaxed);
                self.pool.push(waiting);
            } else {
                head.store(place, Relaxed);
                self.free = self.pool[place as usize].next;
                self.pool[place as usize] = waiting;
            }
            return Some(None);
        }
        let partner = self.pool[found as usize];
        if found_before == OPEN {
            head.store(partner.next, Relaxed);
        } else {
            self.pool[found_before as usize].next = partner.next;
        }
        self.pool[found as usize].next = self.free;
        self.free = found;
        Some(Some(partner.half_edge))
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::Random;
    use crate::mesh::shapes::{cylinder, fan, sphere, tetrahedron};

    fn by_id(mesh: &Mesh, patience: usize, count: usize) -> Option<Vec<u32>> {
        pair_by_lists(mesh, patience, &Blocks::new(mesh, count), |_| 0)
    }

    fn by_degree(mesh: &Mesh, patience: usize, count: usize) -> Option<Vec<u32>> {
        let degree = degrees(mesh);
        pair_by_lists(mesh, patience, &Blocks::new(mesh, count), |v| degree[v as usize])
    }

    /// What is wrong with a pairing, if anything.
    fn fault(mesh: &Mesh, twin: &[u32]) -> Option<String> {
        let ends = |h: usize| (mesh.triangles[h / 3][h % 3], mesh.triangles[h / 3][(h + 1) % 3]);
        (0..twin.len()).filter(|&h| twin[h] != OPEN).find_map(|h| {
            let w = twin[h] as usize;
            if twin[w] as usize != h {
                return Some(format!("the twin of the twin of {h} is {}", twin[w]));
            }
            let ((a, b), (c, d)) = (ends(h), ends(w));
            ((a, b) != (d, c)).then(|| format!("{h} runs {a} to {b}, its twin {c} to {d}"))
        })
    }

    #[test]
    fn pairs_are_mutual_and_opposite() {
        for mesh in [tetrahedron(1.0), sphere(5.0, 50, 20), cylinder(3.0, 9.0, 70)] {
            let mut twin = Adjacency::build(&mesh).twin;
            assert_eq!(twin.len(), 3 * mesh.triangles.len());
            assert!(!twin.contains(&OPEN));
            assert_eq!(fault(&mesh, &twin), None);
            twin.swap(0, 4);
            assert!(fault(&mesh, &twin).is_some(), "a planted fault must be seen");
        }
        assert_eq!(Adjacency::build(&Mesh::default()), Adjacency::default());
    }

    #[test]
    fn lists_and_sorting_give_the_same_pairs_on_the_worst_soups() {
        for seed in 0..400 {
            let mut random = Random(seed);
            let mesh = random.mesh(3 + seed as usize % 30, seed as usize);
            let twin = pair_by_sorting(&mesh);
            for count in [1, 2, 3, 8] {
                for pair in [by_id, by_degree] {
                    let lists = pair(&mesh, usize::MAX, count);
                    assert_eq!(lists.as_ref(), Some(&twin), "seed {seed}, {count} blocks");
                }
            }
            assert_eq!(fault(&mesh, &twin), None, "seed {seed}");
        }
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        // Edges with up to four half-edges, near each other in the file and far apart.
        let mut mesh = sphere(5.0, 300, 260);
        let n = mesh.triangles.len();
        for i in 0..n / 400 {
            let t = mesh.triangles[i * 190];
            mesh.triangles.insert(n - i * 3 % 1000, if i % 2 == 0 { t } else { [t[1], t[0], t[2]] });
            mesh.triangles[i * 200].rotate_left(1);
        }
        let expected = pair_by_sorting(&mesh);
        assert!(expected.contains(&OPEN));
        for count in [1, 2, 3, 8] {
            for pair in [by_id, by_degree] {
                assert_eq!(pair(&mesh, PATIENCE, count).as_ref(), Some(&expected), "{count} blocks");
            }
            let shared = Blocks::new(&mesh, count).shared();
            assert_eq!(shared > 0, count > 1);
            assert!(shared < mesh.vertices.len() / 8, "the blocks must have been at work");
            let pool = rayon::ThreadPoolBuilder::new().num_threads(count).build();
            let built = pool.map(|pool| pool.install(|| Adjacency::build(&mesh).twin));
            assert!(built.is_ok_and(|twin| twin == expected), "{count} threads");
        }
    }

    #[test]
    fn the_i_th_half_edge_one_way_meets_the_i_th_the_other_way() {
        let mesh = Mesh {
            triangles: vec![[0, 1, 2], [0, 1, 3], [1, 0, 4], [1, 0, 5], [0, 1, 6]],
            ..Random(1).mesh(7, 0)
        };
        let twin = Adjacency::build(&mesh).twin;
        assert_eq!([twin[0], twin[3], twin[6], twin[9], twin[12]], [6, 9, 0, 3, OPEN]);
    }

    #[test]
    fn a_fan_of_60_000_triangles_keeps_its_lists_short() {
        let mut mesh = fan(60_000);
        // With the hubs last, so that they would keep the lists by their ids.
        let last = mesh.vertices.len() as u32 - 1;
        mesh.vertices.reverse();
        mesh.triangles.iter_mut().for_each(|t| *t = t.map(|v| last - v));
        assert!(by_degree(&mesh, 2, 1).is_some());
        // In an order in which neighbours are far apart.
        let n = mesh.triangles.len();
        mesh.triangles = (0..n).map(|i| mesh.triangles[i * 7919 % n]).collect();
        let twin = by_degree(&mesh, 2, 1);
        assert!(twin.as_ref().is_some_and(|twin| !twin.contains(&OPEN)));
        assert!(by_id(&mesh, HASTE, 1).is_none(), "the hubs keep long lists");
        assert_eq!(Some(Adjacency::build(&mesh).twin), twin);
    }

    #[test]
    fn thousands_of_triangles_on_one_edge_are_sorted_instead() {
        let mut mesh = Random(1).mesh(5000, 0);
        mesh.triangles = (2..5000).map(|v| [0, 1, v]).collect();
        // The lists are at the other vertices where they can be, but 0-1 is one edge.
        assert_eq!(by_degree(&mesh, PATIENCE, 1), None);
        mesh.triangles.extend((2..5000).map(|v| [1, 0, v]));
        let twin = Adjacency::build(&mesh).twin;
        assert_eq!(fault(&mesh, &twin), None);
        assert_eq!(twin[0] as usize, 3 * 4998);
    }
}
