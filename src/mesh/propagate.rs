//! One winding for facets that contradict each other: passed on from neighbour to neighbour.
//!
//! Two triangles on an edge that no third one shares must run along it in opposite directions. A
//! union-find that also keeps whether two triangles agree (Tarjan 1975; the parity is that of a path
//! to the root) finds the pieces that can be wound consistently; then each piece is turned outwards.

use super::nesting::{self, Lies};
use super::{Mesh, audit};
use rayon::prelude::*;

/// What a repair of the winding did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Propagated {
    /// Triangles turned.
    pub(super) turned: u64,
    /// Triangles dropped because an earlier one has the same three vertices.
    pub(super) duplicates: u64,
}

/// Winds the triangles of a mesh consistently, and every piece of it outwards: a closed piece inside an
/// odd number of others is a cavity. Duplicate triangles are dropped first, since nothing says which
/// of several facets on an edge are neighbours.
///
/// Takes a sort of the edges. Build the [`super::Adjacency`] afterwards.
pub(super) fn propagate(mesh: &mut Mesh) -> Propagated {
    let duplicates = drop_duplicates(mesh);
    let edges = edges(mesh);
    let mut pieces = Pieces::new(mesh.triangles.len());
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [a, b] = edge {
            pieces.join(a.1 >> 1, b.1 >> 1, (a.1 ^ b.1) & 1 == 0);
        }
    }
    let mut turn: Vec<bool> = (0..mesh.triangles.len() as u32).map(|t| pieces.find(t).1).collect();
    flip(mesh, &turn);
    // Parents are roots by now.
    let of = audit::numbered(pieces.parent);
    let count = of.iter().max().map_or(0, |&n| n as usize + 1);
    let outward = outward(mesh, &of, count, &edges, &turn);
    for (turn, &piece) in turn.iter_mut().zip(&of) {
        *turn ^= !outward[piece as usize];
    }
    let again: Vec<bool> = of.iter().map(|&piece| !outward[piece as usize]).collect();
    flip(mesh, &again);
    Propagated { turned: turn.iter().filter(|t| **t).count() as u64, duplicates }
}

pub(super) fn flip(mesh: &mut Mesh, turn: &[bool]) {
    for (t, _) in mesh.triangles.iter_mut().zip(turn).filter(|(_, turn)| **turn) {
        t.swap(1, 2);
    }
}

/// Keeps the first of all triangles with the same three vertices, either way round; returns how many
/// were dropped.
pub(super) fn drop_duplicates(mesh: &mut Mesh) -> u64 {
    let mut sets: Vec<([u32; 3], u32)> = mesh
        .triangles
        .iter()
        .zip(0..)
        .map(|(t, id)| {
            let mut set = *t;
            set.sort_unstable();
            (set, id)
        })
        .collect();
    sets.par_sort_unstable();
    let mut later: Vec<u32> = sets.windows(2).filter(|w| w[0].0 == w[1].0).map(|w| w[1].1).collect();
    if later.is_empty() {
        return 0;
    }
    later.sort_unstable();
    let (mut index, mut next) = (0, later.iter().copied().peekable());
    mesh.triangles.retain(|_| {
        index += 1;
        next.next_if_eq(&(index - 1)).is_none()
    });
    later.len() as u64
}

/// (Edge, twice the triangle, plus one where it runs down in ids), sorted.
fn edges(mesh: &Mesh) -> Vec<(u64, u32)> {
    let mut edges: Vec<(u64, u32)> = mesh
        .triangles
        .par_iter()
        .enumerate()
        .flat_map_iter(|(t, c)| {
            (0..3).map(move |i| {
                let (a, b) = (c[i], c[(i + 1) % 3]);
                let edge = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
                (edge, (t as u32) << 1 | u32::from(a > b))
            })
        })
        .collect();
    edges.par_sort_unstable();
    edges
}

/// Sets of triangles, each with whether it must be turned to agree with its parent.
struct Pieces {
    parent: Vec<u32>,
    turned: Vec<bool>,
}

impl Pieces {
    fn new(triangles: usize) -> Self {
        Self { parent: (0..triangles as u32).collect(), turned: vec![false; triangles] }
    }

    /// Root, and whether `t` must be turned to agree with it. All on the way then hang at the root.
    fn find(&mut self, t: u32) -> (u32, bool) {
        let (mut root, mut turned) = (t, false);
        while self.parent[root as usize] != root {
            turned ^= self.turned[root as usize];
            root = self.parent[root as usize];
        }
        let (mut at, mut left) = (t, turned);
        while at != root {
            let (up, own) = (self.parent[at as usize], self.turned[at as usize]);
            (self.parent[at as usize], self.turned[at as usize]) = (root, left);
            left ^= own;
            at = up;
        }
        (root, turned)
    }

    /// Neighbours; `disagree` when they run the same way along their edge. What contradicts earlier
    /// neighbours (a one-sided surface) is left as it is.
    fn join(&mut self, a: u32, b: u32, disagree: bool) {
        let ((a, turn_a), (b, turn_b)) = (self.find(a), self.find(b));
        if a != b {
            let (root, child) = (a.min(b), a.max(b));
            self.parent[child as usize] = root;
            self.turned[child as usize] = turn_a ^ turn_b ^ disagree;
        }
    }
}

/// Per piece whether it faces the right way; `turned`: which triangles were turned to agree.
fn outward(mesh: &Mesh, of: &[u32], count: usize, edges: &[(u64, u32)], turned: &[bool]) -> Vec<bool> {
    let mut open = vec![0u32; count];
    for edge in edges.chunk_by(|a, b| a.0 == b.0) {
        if let [lone] = edge {
            open[of[(lone.1 >> 1) as usize] as usize] += 1;
        }
    }
    let mut sizes = vec![0u32; count];
    let mut minority = vec![0i64; count];
    for (&piece, &turned) in of.iter().zip(turned) {
        sizes[piece as usize] += 1;
        minority[piece as usize] += if turned { 1 } else { -1 };
    }
    let (volume, clear) = volumes(mesh, of, count);
    let telling = |piece: usize| open[piece] == 0 || clear[piece];
    let ask: Vec<u32> = (0..count).filter(|&p| telling(p)).map(|p| p as u32).collect();
    let mut depth = vec![0u32; count];
    if count > 1 {
        // A piece with many holes encloses nothing.
        let encloses = |piece: u32| u64::from(open[piece as usize]) * 4 < u64::from(sizes[piece as usize]);
        for Lies { shell, other, inside, outside } in nesting::lies(mesh, of, count, &ask) {
            depth[shell as usize] += u32::from(encloses(other) && inside > outside);
        }
    }
    (0..count)
        .map(|piece| {
            if telling(piece) && volume[piece] != 0.0 {
                (volume[piece] > 0.0) == depth[piece].is_multiple_of(2)
            } else {
                // Scraps: as most of their facets were.
                minority[piece] <= 0
            }
        })
        .collect()
}

/// Per piece its signed volume about the middle of its own bounds \[nm³\], and whether that is large
/// enough against the bounds to tell inside from outside though the piece be open.
fn volumes(mesh: &Mesh, of: &[u32], count: usize) -> (Vec<f64>, Vec<bool>) {
    let mut bounds = vec![[[f64::MAX; 3], [f64::MIN; 3]]; count];
    let at = |v: u32| {
        let p = mesh.vertices[v as usize];
        [p.x, p.y, p.z].map(f64::from)
    };
    for (t, &piece) in mesh.triangles.iter().zip(of) {
        let [lo, hi] = &mut bounds[piece as usize];
        for v in *t {
            let p = at(v);
            for k in 0..3 {
                lo[k] = lo[k].min(p[k]);
                hi[k] = hi[k].max(p[k]);
            }
        }
    }
    let mut volume = vec![0.0; count];
    for (t, &piece) in mesh.triangles.iter().zip(of) {
        let [lo, hi] = bounds[piece as usize];
        let [a, b, c] = t.map(|v| {
            let p = at(v);
            [0, 1, 2].map(|k| p[k] - 0.5 * (lo[k] + hi[k]))
        });
        let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
        volume[piece as usize] += (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0;
    }
    let clear = (0..count)
        .map(|piece| {
            let [lo, hi] = bounds[piece];
            let bulk: f64 = (0..3).map(|k| hi[k] - lo[k]).product();
            volume[piece].abs() > 0.02 * bulk
        })
        .collect();
    (volume, clear)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::Random;
    use crate::mesh::shapes::{self, cuboid, knot, merge, moved, torus};
    use crate::mesh::{Adjacency, audit};

    /// About the origin.
    fn sphere(radius: f64, around: usize, rings: usize) -> Mesh {
        moved(shapes::sphere(radius, around, rings), [0.0, 0.0, -radius])
    }

    fn half_flipped(mesh: &Mesh, seed: u64) -> Mesh {
        let mut random = Random(seed);
        let mut mesh = mesh.clone();
        for t in &mut mesh.triangles {
            if random.next().is_multiple_of(2) {
                t.swap(1, 2);
            }
        }
        mesh
    }

    /// Equal up to the corner with which triangles begin.
    fn same(a: &Mesh, b: &Mesh) -> bool {
        let turn = |t: &[u32; 3]| {
            let least = (0..3).min_by_key(|&i| t[i]).unwrap_or(0);
            [t[least], t[(least + 1) % 3], t[(least + 2) % 3]]
        };
        a.vertices == b.vertices && a.triangles.iter().map(turn).eq(b.triangles.iter().map(turn))
    }

    #[test]
    fn random_flips_are_undone() {
        let cavity = |mut m: Mesh| {
            m.triangles.iter_mut().for_each(|t| t.swap(1, 2));
            m
        };
        let bodies = [
            cuboid([0.0; 3], [1.0, 2.0, 3.0]),
            torus(10.0, 2.0, 40, 20),
            knot(10.0, 2.0, 3000),
            merge(&[
                sphere(9.0, 30, 15),
                cavity(sphere(7.0, 30, 15)),
                sphere(5.0, 30, 15),
                moved(cuboid([0.0; 3], [2.0; 3]), [20.0, 0.0, 0.0]),
                cavity(moved(cuboid([0.0; 3], [1.0; 3]), [20.5, 0.5, 0.5])),
            ]),
        ];
        for (i, body) in bodies.iter().enumerate() {
            for seed in 0..10 {
                let mut mesh = half_flipped(body, seed);
                assert!(!same(&mesh, body));
                let report = propagate(&mut mesh);
                assert!(same(&mesh, body), "body {i}, seed {seed}");
                assert!(report.turned > 0 && report.duplicates == 0);
                assert_eq!(propagate(&mut mesh), Propagated::default(), "nothing is left to do");
            }
        }
    }

    #[test]
    fn duplicates_go_and_holes_do_not_mislead() {
        let body = sphere(5.0, 60, 30);
        for seed in 0..5 {
            let mut random = Random(seed);
            let mut mesh = half_flipped(&body, seed);
            let n = mesh.triangles.len();
            for i in 0..n {
                if random.below(10) == 0 {
                    let mut copy = mesh.triangles[i];
                    copy.rotate_left(1);
                    mesh.triangles.push(copy);
                }
            }
            let mut holed = mesh.clone();
            assert!(propagate(&mut mesh).duplicates > 100);
            assert!(same(&mesh, &body), "seed {seed}");

            let mut intact = body.clone();
            let mut keep: Vec<bool> = (0..n).map(|_| random.below(10) > 0).collect();
            let mut kept = keep.iter();
            intact.triangles.retain(|_| *kept.next().unwrap_or(&false));
            keep.resize(holed.triangles.len(), false);
            let mut kept = keep.iter();
            holed.triangles.retain(|_| *kept.next().unwrap_or(&false));
            propagate(&mut holed);
            let wrong = holed.triangles.iter().zip(&intact.triangles).filter(|(a, b)| {
                let mut turned = [b[1], b[2], b[0]];
                let mut equal = *a == *b || **a == turned;
                turned.rotate_left(1);
                equal |= **a == turned;
                !equal
            });
            // Lone facets between holes cannot be told.
            assert!(wrong.count() < 20, "seed {seed}");
        }
    }

    #[test]
    fn a_one_sided_band_and_random_soups_come_to_an_end() {
        let n = 20u32;
        let band = |i: u32| if i < n { [2 * i, 2 * i + 1] } else { [1, 0] };
        let triangles = (0..n)
            .flat_map(|i| {
                let ([a, b], [c, d]) = (band(i), band(i + 1));
                [[a, b, c], [b, d, c]]
            })
            .collect();
        let mut mesh = Mesh { triangles, ..Random(1).mesh(2 * n as usize, 0) };
        propagate(&mut mesh);
        assert!(audit(&mesh, &Adjacency::build(&mesh)).flipped_edges <= 1);
        for seed in 0..200 {
            let mut mesh = Random(seed).mesh(3 + seed as usize % 30, seed as usize);
            let before = audit(&mesh, &Adjacency::build(&mesh)).duplicate_triangles;
            assert_eq!(propagate(&mut mesh).duplicates, before, "seed {seed}");
        }
    }
}
