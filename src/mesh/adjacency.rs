//! Which half-edge meets which.
//!
//! On an undirected edge the i-th half-edge one way pairs with the i-th the other way, counted by
//! half-edge id; the surplus stays open. Any such pairing closes contours and keeps winding, because
//! both sides of an edge compute the same crossing points; this one does not depend on the machine.
//!
//! The half-edges that still wait for a partner hang in short lists at one endpoint of their edge: the
//! one that fewer triangles touch, so that the hub of a fan keeps no list. A mesh on which the lists
//! grow long all the same (thousands of triangles on one edge) is sorted instead: the same pairs.
//!
//! With several threads the triangles are cut into contiguous blocks. An edge with an endpoint that
//! only one block touches has all its half-edges there, so that block pairs them alone; the edges
//! between vertices of several blocks follow in a pass of their own.

use super::blocks::blocks;
use super::{Adjacency, Mesh, OPEN};
use rayon::prelude::*;

/// Marks the degree of a vertex that several blocks touch. It also makes the degree large, so that the
/// owner of an edge has the mark only where both endpoints have it. A degree itself is below: each
/// triangle counts once, and there are fewer than 2^31.
const SHARED: u32 = 1 << 31;

/// Vertices of one task while the blocks' degrees are added; any value gives the same result.
const RUN: usize = 1 << 14;

/// List steps per half-edge, on average, after which sorting is the better way.
const PATIENCE: usize = 16;

impl Adjacency {
    /// Pairs the half-edges of a mesh. The triangles' vertex ids must be below the number of vertices.
    pub fn build(mesh: &Mesh) -> Self {
        let twin = pair_by_lists(mesh, PATIENCE, blocks(mesh.triangles.len()));
        let twin = twin.unwrap_or_else(|| pair_by_sorting(mesh));
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

/// `None` when the lists take more than `patience` steps per half-edge.
fn pair_by_lists(mesh: &Mesh, patience: usize, count: usize) -> Option<Vec<u32>> {
    let triangles = &mesh.triangles;
    let mut size = triangles.len().div_ceil(count).max(1);
    let (mut degree, shared) = degrees(mesh, size);
    if shared > mesh.vertices.len() / 8 {
        // In no order that would leave the blocks much to do.
        degree.par_iter_mut().for_each(|degree| *degree &= !SHARED);
        size = triangles.len().max(1);
    }
    let mut twin = vec![0; 3 * triangles.len()];
    let between: Option<Vec<Vec<u32>>> = twin
        .par_chunks_mut(3 * size)
        .zip(triangles.par_chunks(size))
        .enumerate()
        .map(|(k, (twin, triangles))| {
            twin.fill(OPEN);
            let mut between = Vec::new();
            let mut lists = Lists::new(&degree, patience.saturating_mul(twin.len()));
            let first = (3 * k * size) as u32;
            for (t, triangle) in triangles.iter().enumerate() {
                for i in 0..3 {
                    let (edge, half_edge) = (lists.edge(triangle, i), (3 * t + i) as u32);
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
        let mut lists = Lists::new(&degree, patience.saturating_mul(twin.len()));
        for half_edge in between {
            let edge = lists.edge(&triangles[half_edge as usize / 3], half_edge as usize % 3);
            if let Some(partner) = lists.partner(edge, half_edge)? {
                twin[half_edge as usize] = partner;
                twin[partner as usize] = half_edge;
            }
        }
    }
    Some(twin)
}

/// How many triangles touch each vertex, marked where they are in several blocks of `size` triangles,
/// and the number of marks.
fn degrees(mesh: &Mesh, size: usize) -> (Vec<u32>, usize) {
    let mut counts: Vec<Vec<u32>> = mesh
        .triangles
        .par_chunks(size)
        .map(|triangles| {
            let mut degree = vec![0; mesh.vertices.len()];
            for v in triangles.as_flattened() {
                degree[*v as usize] += 1;
            }
            degree
        })
        .collect();
    let rest = counts.split_off(counts.len().min(1));
    let mut degree = counts.pop().unwrap_or_default();
    if rest.is_empty() {
        return (degree, 0);
    }
    let shared = degree.par_chunks_mut(RUN).enumerate().map(|(run, sums)| {
        for counts in &rest {
            for (sum, &n) in sums.iter_mut().zip(&counts[run * RUN..]) {
                let mark = if *sum != 0 && n != 0 { SHARED } else { 0 };
                *sum = sum.wrapping_add(n) | mark;
            }
        }
        sums.iter().filter(|&&sum| sum & SHARED != 0).count()
    });
    let shared = shared.sum();
    (degree, shared)
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

/// The lists of waiting half-edges.
struct Lists<'a> {
    degree: &'a [u32],
    /// Per vertex one more than the place of its list's first entry, 0 without: so the allocator
    /// delivers it without a pass over the memory.
    head: Vec<u32>,
    pool: Vec<Waiting>,
    free: u32,
    /// Lists are searched from their youngest entry. Once an edge has two waiting the same way, the
    /// older must be found, so the search goes on to the end.
    over_shared: bool,
    /// Steps that are left.
    patience: usize,
}

impl<'a> Lists<'a> {
    fn new(degree: &'a [u32], patience: usize) -> Self {
        let head = vec![0; degree.len()];
        Self { degree, head, pool: Vec::new(), free: OPEN, over_shared: false, patience }
    }

    #[inline(always)]
    fn edge(&self, triangle: &[u32; 3], i: usize) -> Edge {
        let (from, to) = (triangle[i], triangle[(i + 1) % 3]);
        let (a, b) = (self.degree[from as usize], self.degree[to as usize]);
        let leaves = (a, from) < (b, to);
        let (owner, other) = if leaves { (from, to) } else { (to, from) };
        Edge { owner, other, leaves: u32::from(leaves), shared: a & b & SHARED != 0 }
    }

    /// Takes the partner of a half-edge out of its list; without one, the half-edge waits. Half-edges
    /// come in ascending order. `None` when patience is at its end.
    #[inline(always)]
    fn partner(&mut self, edge: Edge, half_edge: u32) -> Option<Option<u32>> {
        let Edge { owner, other, leaves, .. } = edge;
        let first = self.head[owner as usize].wrapping_sub(1);
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
            self.head[owner as usize] = if place == OPEN {
                self.pool.push(waiting);
                self.pool.len() as u32
            } else {
                self.free = self.pool[place as usize].next;
                self.pool[place as usize] = waiting;
                place + 1
            };
            return Some(None);
        }
        let partner = self.pool[found as usize];
        if found_before == OPEN {
            self.head[owner as usize] = partner.next.wrapping_add(1);
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
                let lists = pair_by_lists(&mesh, usize::MAX, count);
                assert_eq!(lists.as_ref(), Some(&twin), "seed {seed}, {count} blocks");
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
            assert_eq!(pair_by_lists(&mesh, PATIENCE, count).as_ref(), Some(&expected), "{count} blocks");
            let size = mesh.triangles.len().div_ceil(count);
            let shared = degrees(&mesh, size).1;
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
        assert!(pair_by_lists(&mesh, 2, 1).is_some());
        // In an order in which neighbours are far apart.
        let n = mesh.triangles.len();
        mesh.triangles = (0..n).map(|i| mesh.triangles[i * 7919 % n]).collect();
        let twin = pair_by_lists(&mesh, 2, 1);
        assert!(twin.is_some_and(|twin| !twin.contains(&OPEN)));
    }

    #[test]
    fn thousands_of_triangles_on_one_edge_are_sorted_instead() {
        let mut mesh = Random(1).mesh(5000, 0);
        mesh.triangles = (2..5000).map(|v| [0, 1, v]).collect();
        // The lists are at the other vertices where they can be, but 0-1 is one edge.
        assert_eq!(pair_by_lists(&mesh, PATIENCE, 1), None);
        mesh.triangles.extend((2..5000).map(|v| [1, 0, v]));
        let twin = Adjacency::build(&mesh).twin;
        assert_eq!(fault(&mesh, &twin), None);
        assert_eq!(twin[0] as usize, 3 * 4998);
    }
}
