//! Mesh × planes → oriented segments with successor links.
//!
//! The scheme: a triangle meets a contiguous range of ascending planes, so *count* and *scan* give
//! every (triangle, plane) pair a fixed slot before anything is allocated; *emit* computes where the
//! contour enters the triangle on that plane and, through the adjacency, the slot in which it goes
//! on. No hash, no sort, no epsilon.

pub mod adaptive;
pub mod below;
pub mod chunk;
pub mod classic;
pub mod cpu;
pub mod crossing;
pub mod direction;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod planes;
pub mod section;

use crate::lattice::Point2;

/// The segments of a run of planes, triangle by triangle, each triangle's planes ascending.
///
/// The segment of triangle `t` on plane `k` (an index into the run) sits at
/// `offset[t] + k - first[t]`. It begins at `start` and ends where its successor begins; solid lies
/// on its left.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Segments {
    /// Per triangle the first plane that it meets. Length = triangles.
    pub first: Vec<u32>,
    /// Per triangle the slot of its first segment; the last entry is the total. Length = triangles + 1.
    pub offset: Vec<u32>,
    /// Per segment its start \[nm\], mesh frame.
    pub start: Vec<Point2>,
    /// Per segment its successor's slot, or [`crate::mesh::OPEN`] at an open edge.
    pub next: Vec<u32>,
}
