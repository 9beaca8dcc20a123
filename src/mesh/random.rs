//! Random data for tests, the same on every machine.

use super::Mesh;
use crate::lattice::Point3;

/// A small generator of random test data (SplitMix64, Steele et al. 2014).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ x >> 31
    }

    pub(super) fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    /// Triangles with differing corners among a few vertices: over-shared, flipped, duplicated.
    pub(super) fn mesh(&mut self, vertices: usize, triangles: usize) -> Mesh {
        let vertices: Vec<Point3> = (0..vertices as i32).map(|i| Point3::new(i, i * i, i * i % 97)).collect();
        let mut corners = || {
            let a = self.below(vertices.len());
            let b = (a + 1 + self.below(vertices.len() - 1)) % vertices.len();
            let c = (0..vertices.len()).filter(|c| ![a, b].contains(c)).nth(self.below(vertices.len() - 2));
            [a, b, c.unwrap_or(0)].map(|v| v as u32)
        };
        let triangles = (0..triangles).map(|_| corners()).collect();
        Mesh { vertices, triangles, origin: [0; 3] }
    }
}
