//! A bucket of triangles for every plane, and a list of active ones.
//!
//! Gregori, Volpato, Minetto and da Silva, "Slicing triangle meshes: an asymptotically optimal algorithm",
//! Proc. 14th ICCSA (2014); Minetto, Volpato, Stolfi, Gregori and da Silva, "An optimal algorithm for 3D
//! triangle mesh slicing", Computer-Aided Design 92 (2017). A triangle goes into the bucket of the first
//! plane above its lowest vertex, which even spacing gives in constant time. From plane to plane the
//! active triangles gain that plane's bucket and lose those that end below the plane.
//!
//! Time n + p + m, memory n + p: optimal. Planes that are not evenly spaced go to
//! [`super::interval_tree`] instead of the papers' binary search.

use super::interval_tree;
use super::{Segment, corners, extent};
use crate::mesh::Mesh;

/// The segments on each plane, in the order of the active list; `planes` \[nm\], mesh frame, ascending.
pub fn run(mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    match Spacing::of(planes) {
        Some(spacing) => run_uniform(mesh, planes, spacing),
        None => interval_tree::run(mesh, planes),
    }
}

fn run_uniform(mesh: &Mesh, planes: &[i32], spacing: Spacing) -> Vec<Vec<Segment>> {
    let buckets = Buckets::new(mesh, planes, spacing);
    let mut active: Vec<Entry> = Vec::new();
    let mut layers = Vec::with_capacity(planes.len());
    for (k, &z) in planes.iter().enumerate() {
        active.retain(|entry| entry.z_max >= z);
        active.extend_from_slice(buckets.of(k));
        let cut = |entry: &Entry| Segment::cut(entry.triangle, corners(mesh, entry.triangle), z);
        layers.push(active.iter().map(cut).collect());
    }
    layers
}

/// Planes at even distances, but for their rounding to the lattice.
#[derive(Clone, Copy)]
struct Spacing {
    /// The lowest plane \[nm\].
    base: i64,
    /// From the lowest plane to the highest \[nm\].
    extent: i64,
    /// Steps between them.
    steps: i64,
}

impl Spacing {
    /// The spacing of ascending planes; `None` where it is uneven, or below the lattice.
    fn of(planes: &[i32]) -> Option<Self> {
        let &[base, .., top] = planes else { return None };
        let (base, top) = (i64::from(base), i64::from(top));
        let (extent, steps) = (top - base, planes.len() as i64 - 1);
        // Each of the three heights compared may have been rounded by half a nanometre.
        let even =
            |(i, &z): (usize, &i32)| ((i64::from(z) - base) * steps - i as i64 * extent).abs() <= 2 * steps;
        (extent >= steps && planes.iter().enumerate().all(even)).then_some(Self { base, extent, steps })
    }

    /// The first plane above `z`; `planes` are those that the spacing was made from.
    fn first_above(self, z: i32, planes: &[i32]) -> usize {
        let estimate = (i64::from(z) - self.base) * self.steps / self.extent;
        let mut k = estimate.clamp(0, self.steps) as usize;
        // Rounding moves a plane across `z` at most; the estimate is a step or two off at most.
        while k > 0 && planes[k - 1] > z {
            k -= 1;
        }
        while k < planes.len() && planes[k] <= z {
            k += 1;
        }
        k
    }
}

/// A triangle on its way through the planes.
#[derive(Clone, Copy, Default)]
struct Entry {
    z_max: i32,
    triangle: u32,
}

/// Triangles by the first plane that cuts them.
struct Buckets {
    /// Per plane its first place; length = planes + 2.
    base: Vec<u32>,
    entries: Vec<Entry>,
}

impl Buckets {
    fn new(mesh: &Mesh, planes: &[i32], spacing: Spacing) -> Self {
        let found: Vec<(u32, Entry)> = (0..mesh.triangles.len() as u32)
            .filter_map(|triangle| {
                let (z_min, z_max) = extent(corners(mesh, triangle));
                let first = spacing.first_above(z_min, planes);
                let cut = planes.get(first).is_some_and(|&z| z <= z_max);
                cut.then_some((first as u32, Entry { z_max, triangle }))
            })
            .collect();
        let mut base = vec![0u32; planes.len() + 2];
        for (first, _) in &found {
            base[*first as usize + 2] += 1;
        }
        for k in 2..base.len() {
            base[k] += base[k - 1];
        }
        let mut entries = vec![Entry::default(); found.len()];
        for (first, entry) in found {
            let cursor = &mut base[first as usize + 1];
            entries[*cursor as usize] = entry;
            *cursor += 1;
        }
        Self { base, entries }
    }

    fn of(&self, plane: usize) -> &[Entry] {
        &self.entries[self.base[plane] as usize..self.base[plane + 1] as usize]
    }
}
