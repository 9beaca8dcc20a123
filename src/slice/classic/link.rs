//! Links for segments that an algorithm has found without them.

use super::{Segment, below, corners, edges, extent};
use crate::mesh::{Adjacency, Mesh, OPEN};
use crate::slice::{Segments, cpu, crossing};

/// Puts segments into the common buffers and links each to its successor over the adjacency, in time
/// n + m.
///
/// `layers` hold the segments on each of `planes` \[nm, mesh frame, ascending\] in any order.
pub fn link(mesh: &Mesh, adjacency: &Adjacency, planes: &[i32], layers: &[Vec<Segment>]) -> Segments {
    let mut first = vec![OPEN; mesh.triangles.len()];
    let mut counts = vec![0u32; mesh.triangles.len()];
    for (k, layer) in layers.iter().enumerate() {
        for segment in layer {
            let t = segment.triangle as usize;
            first[t] = first[t].min(k as u32);
            counts[t] += 1;
        }
    }
    for (t, first) in first.iter_mut().enumerate().filter(|(_, first)| **first == OPEN) {
        let (z_min, z_max) = extent(corners(mesh, t as u32));
        *first = crossing::plane_range(z_min, z_max, planes).0 as u32;
    }
    let offset = cpu::scan(&counts);
    let total = offset.last().map_or(0, |&total| total as usize);
    let mut start = vec![Default::default(); total];
    let mut next = vec![OPEN; total];
    for (k, (layer, &z)) in layers.iter().zip(planes).enumerate() {
        let slot = |t: usize| offset[t].wrapping_add(k as u32).wrapping_sub(first[t]);
        for segment in layer {
            let t = segment.triangle as usize;
            let [_, up] = edges(below(corners(mesh, segment.triangle), z));
            let twin = adjacency.twin[3 * t + up];
            let here = slot(t) as usize;
            start[here] = segment.start;
            next[here] = if twin == OPEN { OPEN } else { slot(twin as usize / 3) };
        }
    }
    Segments { first, offset, start, next }
}
