//! Random meshes, planes, and random numbers for the device tests.

use microtome::lattice::{LIMIT, Point3};
use microtome::mesh::Mesh;

/// Triangles between random vertices of a small grid or of the whole lattice: shared, open and
/// over-shared edges, horizontal triangles, vertices on planes, extreme slopes.
pub fn soup(triangles: usize, seed: u64, reach: i32) -> Mesh {
    let mut random = Random(seed);
    let corners = triangles as u64 / 2 + 4;
    let mut c = || (random.next() % (2 * reach as u64 + 1)) as i32 - reach;
    let vertices = (0..corners).map(|_| Point3::new(c(), c(), c())).collect();
    let mut list = Vec::new();
    while list.len() < triangles {
        let t = [0; 3].map(|_| (random.next() % corners) as u32);
        if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
            list.push(t);
        }
    }
    Mesh { vertices, triangles: list, origin: [0; 3] }
}

/// Ascending planes, some of them through vertices.
pub fn planes(mesh: &Mesh, count: usize) -> Vec<i32> {
    let z = || mesh.vertices.iter().map(|v| i64::from(v.z));
    let (low, high) = (z().min().unwrap_or(0) - 2, z().max().unwrap_or(0) + 2);
    let spread = (count - count / 4) as i64;
    let even = (0..spread).map(|i| low + (high - low) * (2 * i + 1) / (2 * spread));
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
