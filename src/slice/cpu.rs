//! The reference twin of the slicing shaders: the same buffers, bit for bit, in plain serial Rust.
//!
//! One function per kernel. It exists to be compared; the CPU backend takes a faster route to the
//! same contours.

use super::{Segments, crossing};
use crate::mesh::{Adjacency, Mesh, OPEN};

/// Twin of `slice_count.wgsl`: per triangle the first plane it meets and how many it meets.
/// `planes` \[nm\], mesh frame, ascending. Both results have length = triangles.
pub fn count(mesh: &Mesh, planes: &[i32]) -> (Vec<u32>, Vec<u32>) {
    mesh.triangles
        .iter()
        .map(|t| {
            let z = t.map(|v| mesh.vertices[v as usize].z);
            let (first, end) =
                crossing::plane_range(z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]), planes);
            (first as u32, (end - first) as u32)
        })
        .unzip()
}

/// Twin of the scan kernels: exclusive prefix sums with the total appended. Length = input + 1.
///
/// Sums wrap modulo 2^32 like the shader's; callers keep a run of planes below 2^32 segments (see
/// [`super::chunk`]).
pub fn scan(counts: &[u32]) -> Vec<u32> {
    let mut sum = 0u32;
    let mut out = Vec::with_capacity(counts.len() + 1);
    for &c in counts {
        out.push(sum);
        sum = sum.wrapping_add(c);
    }
    out.push(sum);
    out
}

/// Twin of `slice_emit.wgsl`: start and successor of every segment.
pub fn emit(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    first: Vec<u32>,
    offset: Vec<u32>,
) -> Segments {
    let total = offset.last().copied().unwrap_or(0) as usize;
    let mut start = Vec::with_capacity(total);
    let mut next = Vec::with_capacity(total);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let corner = triangle.map(|v| mesh.vertices[v as usize]);
        let n = offset[t + 1] - offset[t];
        for k in first[t]..first[t] + n {
            let z = planes[k as usize];
            let (down, up) = crossing::down_up(corner.map(|c| c.z), z);
            start.push(crossing::point(corner[down], corner[(down + 1) % 3], z));
            let twin = adjacency.twin[3 * t + up];
            next.push(if twin == OPEN {
                OPEN
            } else {
                let n = (twin / 3) as usize;
                offset[n] + (k - first[n])
            });
        }
    }
    Segments { first, offset, start, next }
}

/// All three steps.
pub fn slice(mesh: &Mesh, adjacency: &Adjacency, planes: &[i32]) -> Segments {
    let (first, counts) = count(mesh, planes);
    let offset = scan(&counts);
    emit(mesh, adjacency, planes, first, offset)
}
