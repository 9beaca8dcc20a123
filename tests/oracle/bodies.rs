//! Small closed bodies and a plain adjacency, sharing no code with the library's own.

use microtome::lattice::Point3;
use microtome::mesh::{Adjacency, Mesh, OPEN};
use std::collections::BTreeMap;

/// Marsaglia's xorshift64.
pub struct Random(pub u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(0x9E37_79B9_7F4A_7C15u64.wrapping_mul(seed + 1))
    }

    pub fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % n
    }

    pub fn within(&mut self, bound: i32) -> i32 {
        self.below(2 * bound as u64 + 1) as i32 - bound
    }

    pub fn shuffle<T>(&mut self, items: &mut [T]) {
        for i in (1..items.len()).rev() {
            items.swap(i, self.below(i as u64 + 1) as usize);
        }
    }
}

/// Half-edges in both directions of an edge paired in the order of their ids.
pub fn adjacency(mesh: &Mesh) -> Adjacency {
    let mut edges: BTreeMap<(u32, u32), [Vec<u32>; 2]> = BTreeMap::new();
    for (t, corners) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            edges.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)].push((3 * t + i) as u32);
        }
    }
    let mut twin = vec![OPEN; 3 * mesh.triangles.len()];
    for [forward, reverse] in edges.values() {
        for (&f, &r) in forward.iter().zip(reverse) {
            twin[f as usize] = r;
            twin[r as usize] = f;
        }
    }
    Adjacency { twin }
}

/// A mesh from triangles given by their corners; equal corners are welded.
pub fn weld(soup: &[[Point3; 3]]) -> Mesh {
    let mut ids = BTreeMap::new();
    let mut mesh = Mesh::default();
    for corners in soup {
        let triangle = corners.map(|p| {
            *ids.entry(p).or_insert_with(|| {
                mesh.vertices.push(p);
                mesh.vertices.len() as u32 - 1
            })
        });
        if triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0] {
            mesh.triangles.push(triangle);
        }
    }
    mesh
}

/// An axis-parallel box.
pub fn cuboid(low: Point3, high: Point3) -> Vec<[Point3; 3]> {
    let corner = |i: usize| {
        let pick = |bit: usize, low, high| if i >> bit & 1 == 1 { high } else { low };
        Point3::new(pick(0, low.x, high.x), pick(1, low.y, high.y), pick(2, low.z, high.z))
    };
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
        .iter()
        .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
        .map(|t| t.map(corner))
        .collect()
}

/// A surface closed in both directions from a map of (u, v) in 0..nu × 0..nv.
fn grid(nu: usize, nv: usize, wrap_v: bool, at: impl Fn(usize, usize) -> Point3) -> Vec<[Point3; 3]> {
    let rows = if wrap_v { nv } else { nv - 1 };
    (0..nu)
        .flat_map(|u| (0..rows).map(move |v| (u, v)))
        .flat_map(|(u, v)| {
            let (next_u, next_v) = ((u + 1) % nu, if wrap_v { (v + 1) % nv } else { v + 1 });
            let q = [at(u, v), at(next_u, v), at(next_u, next_v), at(u, next_v)];
            [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]
        })
        .collect()
}

pub fn sphere(radius: f64, n: usize) -> Vec<[Point3; 3]> {
    grid(2 * n, n + 1, false, |u, v| {
        let (longitude, latitude) =
            (u as f64 * std::f64::consts::PI / n as f64, (v as f64 / n as f64 - 0.5) * std::f64::consts::PI);
        let ring = if v == 0 || v == n { 0.0 } else { latitude.cos() };
        round(radius * ring * longitude.cos(), radius * ring * longitude.sin(), radius * latitude.sin())
    })
}

/// A torus standing upright: its planes have one contour or two.
pub fn torus(radius: f64, tube: f64, n: usize) -> Vec<[Point3; 3]> {
    grid(3 * n, n, true, |u, v| {
        let (u, v) =
            (u as f64 * std::f64::consts::TAU / (3 * n) as f64, v as f64 * std::f64::consts::TAU / n as f64);
        let ring = radius + tube * v.cos();
        round(-tube * v.sin(), ring * u.cos(), ring * u.sin())
    })
}

fn round(x: f64, y: f64, z: f64) -> Point3 {
    Point3::new(x.round() as i32, y.round() as i32, z.round() as i32)
}

/// Closed tetrahedra with corners on a coarse grid, so that many share corners, edges and faces, lie
/// on planes or are flat; every second one may be inside out.
pub fn tetrahedra(random: &mut Random, count: usize, grid: i32, step: i32) -> Vec<[Point3; 3]> {
    (0..count)
        .flat_map(|_| {
            let mut corner = || {
                let mut c = || random.within(grid) * step;
                Point3::new(c(), c(), c())
            };
            let [a, b, c, d] = [corner(), corner(), corner(), corner()];
            [[a, c, b], [a, b, d], [b, c, d], [c, a, d]]
        })
        .collect()
}

/// Facets in another order, corners rotated, vertices renumbered: the same body.
pub fn shuffled(mesh: &Mesh, random: &mut Random) -> Mesh {
    let mut order: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    random.shuffle(&mut order);
    let mut vertices = mesh.vertices.clone();
    for (old, &new) in order.iter().enumerate() {
        vertices[new as usize] = mesh.vertices[old];
    }
    let mut triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .map(|t| {
            let mut t = t.map(|v| order[v as usize]);
            t.rotate_left(random.below(3) as usize);
            t
        })
        .collect();
    random.shuffle(&mut triangles);
    Mesh { vertices, triangles, origin: mesh.origin }
}
