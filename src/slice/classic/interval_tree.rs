//! Stabbing queries: which triangles' z extents hold a given height.
//!
//! Edelsbrunner, "A new approach to rectangle intersections", Int. J. Computer Mathematics 13 (1983);
//! Preparata and Shamos, "Computational Geometry" (1985), section 8.8.1. Every node has a height and the
//! intervals that hold it and no ancestor's, once by lower and once by upper end; a query walks from
//! the root to a leaf and reads from each list just what it reports.
//!
//! Time n log n to build, log n + hits for a query; memory n. Planes may come in any order and spacing.

use super::{Segment, corners, extent};
use crate::mesh::Mesh;

/// The segments on each plane, node by node from the root; `planes` \[nm\], mesh frame.
pub fn run(mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    let tree = IntervalTree::new(mesh);
    planes
        .iter()
        .map(|&z| {
            let mut segments = Vec::new();
            tree.stab(z, |triangle| segments.push(Segment::cut(triangle, corners(mesh, triangle), z)));
            segments
        })
        .collect()
}

/// The z extents of a mesh's triangles, each without its lower end: those that a plane meets by the rule
/// of [`crate::slice::crossing::plane_range`].
pub struct IntervalTree {
    /// The heights of the nodes, ascending. The root of a range is its middle.
    heights: Vec<i32>,
    /// Per node its first place in both lists; length = nodes + 1.
    base: Vec<u32>,
    /// (z_min, triangle) by node, then from the lowest z_min up.
    by_low: Vec<(i32, u32)>,
    /// (z_max, triangle) by node, then from the highest z_max down.
    by_high: Vec<(i32, u32)>,
}

impl IntervalTree {
    /// Builds the tree of all triangles that are not horizontal.
    pub fn new(mesh: &Mesh) -> Self {
        let mut intervals: Vec<(i32, i32, u32)> = (0..mesh.triangles.len() as u32)
            .map(|triangle| {
                let (z_min, z_max) = extent(corners(mesh, triangle));
                (z_min, z_max, triangle)
            })
            .filter(|(z_min, z_max, _)| z_min < z_max)
            .collect();
        // Every interval holds its upper end, so every one finds a node.
        let mut heights: Vec<i32> = intervals.iter().map(|i| i.1).collect();
        heights.sort_unstable();
        heights.dedup();
        intervals.sort_unstable();
        let nodes: Vec<u32> = intervals.iter().map(|i| node_of(&heights, i.0, i.1)).collect();
        let mut base = vec![0u32; heights.len() + 1];
        for &node in &nodes {
            base[node as usize + 1] += 1;
        }
        for node in 1..base.len() {
            base[node] += base[node - 1];
        }
        let mut cursor = base.clone();
        let mut by_low = vec![(0, 0); intervals.len()];
        let mut by_high = by_low.clone();
        for (&node, &(z_min, z_max, triangle)) in nodes.iter().zip(&intervals) {
            let place = cursor[node as usize] as usize;
            by_low[place] = (z_min, triangle);
            by_high[place] = (z_max, triangle);
            cursor[node as usize] += 1;
        }
        for node in base.windows(2) {
            by_high[node[0] as usize..node[1] as usize].sort_unstable_by_key(|&(z_max, t)| (-z_max, t));
        }
        Self { heights, base, by_low, by_high }
    }

    /// Reports the triangles that plane `z` \[nm\] meets, each once.
    pub fn stab(&self, z: i32, mut report: impl FnMut(u32)) {
        let (mut from, mut to) = (0usize, self.heights.len());
        while from < to {
            let node = from.midpoint(to);
            let list = self.base[node] as usize..self.base[node + 1] as usize;
            if z <= self.heights[node] {
                // All of these end at the node's height or above it.
                let hits = self.by_low[list].iter().take_while(|(z_min, _)| *z_min < z);
                hits.for_each(|&(_, triangle)| report(triangle));
                to = node;
            } else {
                // All of these begin below the node's height.
                let hits = self.by_high[list].iter().take_while(|(z_max, _)| *z_max >= z);
                hits.for_each(|&(_, triangle)| report(triangle));
                from = node + 1;
            }
        }
    }
}

/// The node nearest to the root whose height the interval holds.
fn node_of(heights: &[i32], z_min: i32, z_max: i32) -> u32 {
    let (mut from, mut to) = (0usize, heights.len());
    loop {
        let node = from.midpoint(to);
        if heights[node] <= z_min {
            from = node + 1;
        } else if heights[node] > z_max {
            to = node;
        } else {
            return node as u32;
        }
    }
}
