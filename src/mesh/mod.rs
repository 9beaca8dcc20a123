//! Bytes to an indexed triangle mesh on the lattice.

use crate::lattice::Point3;

/// An indexed triangle mesh on the lattice.
///
/// World position of a vertex \[nm\] = `origin + vertex`. Moving a part changes `origin` alone, so a
/// part gives the same toolpaths wherever it stands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mesh {
    /// Vertices \[nm\], relative to `origin`, each coordinate within ±[`crate::lattice::LIMIT`].
    pub vertices: Vec<Point3>,
    /// Vertex ids, counter-clockwise seen from outside; the three ids of a triangle differ.
    pub triangles: Vec<[u32; 3]>,
    /// World position of the lattice's zero \[nm\].
    pub origin: [i64; 3],
}

/// The half-edge that a half-edge meets: half-edge `3 t + i` runs from corner `i` to corner
/// `(i + 1) % 3` of triangle `t`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Adjacency {
    /// Per half-edge the opposite half-edge's id, or [`OPEN`]. Length = 3 × triangles.
    pub twin: Vec<u32>,
}

/// Marks a half-edge without a partner.
pub const OPEN: u32 = u32::MAX;
