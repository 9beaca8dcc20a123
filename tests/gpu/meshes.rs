//! Small meshes for the device tests, and adjacency by the definition.

use microtome::lattice::{LIMIT, Point3};
use microtome::mesh::{Adjacency, Mesh, OPEN};
use std::collections::BTreeMap;

/// A mesh from plain numbers.
pub fn mesh(vertices: Vec<(i32, i32, i32)>, triangles: Vec<[u32; 3]>) -> Mesh {
    let vertices = vertices.into_iter().map(|(x, y, z)| Point3::new(x, y, z)).collect();
    Mesh { vertices, triangles, origin: [0; 3] }
}

/// The i-th forward half-edge of an edge meets its i-th reverse one.
pub fn adjacency(mesh: &Mesh) -> Adjacency {
    let mut edges: BTreeMap<(u32, u32), [Vec<u32>; 2]> = BTreeMap::new();
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (triangle[i], triangle[(i + 1) % 3]);
            edges.entry((a.min(b), a.max(b))).or_default()[usize::from(a > b)].push((3 * t + i) as u32);
        }
    }
    let mut twin = vec![OPEN; 3 * mesh.triangles.len()];
    for [forward, reverse] in edges.values() {
        for (&f, &r) in forward.iter().zip(reverse) {
            (twin[f as usize], twin[r as usize]) = (r, f);
        }
    }
    Adjacency { twin }
}

/// A box from corner to corner.
pub fn cuboid(low: (i32, i32, i32), high: (i32, i32, i32)) -> Mesh {
    let corner = |i: u32| {
        let side = |bit: u32, low, high| if i >> bit & 1 == 1 { high } else { low };
        (side(0, low.0, high.0), side(1, low.1, high.1), side(2, low.2, high.2))
    };
    let triangles = vec![
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
    ];
    mesh((0..8).map(corner).collect(), triangles)
}

/// A torus around z; `quads` × `quads` pairs of triangles.
pub fn torus(quads: u32, ring: f64, tube: f64) -> Mesh {
    let angle = |i: u32| f64::from(i) / f64::from(quads) * std::f64::consts::TAU;
    let mut vertices = Vec::new();
    for i in 0..quads {
        for j in 0..quads {
            let r = ring + tube * angle(j).cos();
            let at = (r * angle(i).cos(), r * angle(i).sin(), tube * angle(j).sin());
            vertices.push((at.0 as i32, at.1 as i32, at.2 as i32));
        }
    }
    let id = |i: u32, j: u32| (i % quads) * quads + j % quads;
    let quad = |i, j| {
        let (a, b, c, d) = (id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    mesh(vertices, (0..quads).flat_map(|i| (0..quads).flat_map(move |j| quad(i, j))).collect())
}

/// A double cone: two fans of `blades` triangles, all of which share one of two vertices.
pub fn fan(blades: u32, radius: f64) -> Mesh {
    let mut vertices = vec![(0, 0, -(radius as i32)), (0, 0, radius as i32)];
    for i in 0..blades {
        let a = f64::from(i) / f64::from(blades) * std::f64::consts::TAU;
        vertices.push(((radius * a.cos()) as i32, (radius * a.sin()) as i32, 0));
    }
    let blade = |i: u32| {
        let (a, b) = (2 + i, 2 + (i + 1) % blades);
        [[0, b, a], [1, a, b]]
    };
    mesh(vertices, (0..blades).flat_map(blade).collect())
}

/// A sphere: an octahedron's faces split `depth` times and pushed outwards.
pub fn sphere(depth: u32, radius: f64) -> Mesh {
    let mut points: Vec<[f64; 3]> = Vec::new();
    let mut known: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let mut triangles = Vec::new();
    let mut id = |p: [f64; 3]| {
        let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
        let p = p.map(|c| c / length);
        *known.entry(p.map(|c| (c * 1e12) as i64)).or_insert_with(|| {
            points.push(p);
            points.len() as u32 - 1
        })
    };
    let mut faces = Vec::new();
    for i in 0..8 {
        let sign = |bit: i32| if i >> bit & 1 == 1 { -1.0 } else { 1.0 };
        let (x, y, z) = ([sign(0), 0.0, 0.0], [0.0, sign(1), 0.0], [0.0, 0.0, sign(2)]);
        faces.push(if sign(0) * sign(1) * sign(2) > 0.0 { [x, y, z] } else { [y, x, z] });
    }
    for _ in 0..depth {
        let middle = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| (a[i] + b[i]) / 2.0);
        faces = faces
            .into_iter()
            .flat_map(|[a, b, c]| {
                let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    for face in faces {
        triangles.push(face.map(&mut id));
    }
    let at = |p: &[f64; 3]| {
        let [x, y, z] = p.map(|c| (c * radius) as i32);
        (x, y, z)
    };
    mesh(points.iter().map(at).collect(), triangles)
}

/// Triangles between random vertices of a small grid or of the whole lattice: shared, open and
/// over-shared edges, horizontal triangles, vertices on planes, extreme slopes.
pub fn soup(triangles: usize, seed: u64, reach: i32) -> Mesh {
    let mut random = Random(seed);
    let corners = triangles as u64 / 2 + 4;
    let mut c = || (random.next() % (2 * reach as u64 + 1)) as i32 - reach;
    let vertices = (0..corners).map(|_| (c(), c(), c())).collect();
    let mut list = Vec::new();
    while list.len() < triangles {
        let t = [0; 3].map(|_| (random.next() % corners) as u32);
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            list.push(t);
        }
    }
    mesh(vertices, list)
}

/// Ascending planes, some of them through vertices.
pub fn planes(mesh: &Mesh, count: usize) -> Vec<i32> {
    let z = || mesh.vertices.iter().map(|v| i64::from(v.z));
    let (low, high) = (z().min().unwrap_or(0) - 2, z().max().unwrap_or(0) + 2);
    let spread = (count - count / 4) as i64;
    let even = (0..spread).map(|i| low + (high - low) * i / (spread - 1).max(1));
    let mut planes: Vec<i64> = even.chain(z().take(count / 4)).collect();
    planes.sort_unstable();
    planes.dedup();
    planes.into_iter().map(|z| z.clamp(1 - i64::from(LIMIT), i64::from(LIMIT) - 1) as i32).collect()
}

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }
}
