//! Runs of planes sized from exact counts, so that memory is a setting and not an accident.

use crate::mesh::Mesh;
use rayon::prelude::*;
use std::ops::Range;

/// Bytes that one segment takes: 8 for its start, 4 for its link.
pub const BYTES_PER_SEGMENT: u64 = 12;

/// Number of segments on each plane. `planes` \[nm\], mesh frame, ascending; length = planes.
pub fn segments_per_plane(mesh: &Mesh, planes: &[i32]) -> Vec<u64> {
    let search = PlaneSearch::new(planes);
    let level: Vec<u32> =
        mesh.vertices.par_iter().with_min_len(1 << 12).map(|v| search.at_or_below(v.z)).collect();
    // Every task counts all planes: no more tasks than pay for that.
    let block = (mesh.triangles.len() / (2 * rayon::current_num_threads())).max(1 << 15).max(planes.len());
    let tasks: Vec<Vec<i64>> = mesh
        .triangles
        .par_chunks(block)
        .map(|triangles| {
            let mut step = vec![0i64; planes.len() + 1];
            for &[a, b, c] in triangles {
                let (a, b, c) = (level[a as usize], level[b as usize], level[c as usize]);
                step[a.min(b).min(c) as usize] += 1;
                step[a.max(b).max(c) as usize] -= 1;
            }
            step
        })
        .collect();
    let mut now = 0i64;
    (0..planes.len())
        .map(|k| {
            now += tasks.iter().map(|step| step[k]).sum::<i64>();
            now as u64
        })
        .collect()
}

/// Counts planes at or below a height, from a table of evenly spaced cells.
pub struct PlaneSearch<'a> {
    planes: &'a [i32],
    base: i64,
    shift: u32,
    /// Per cell the number of planes below it; one more entry than cells.
    below: Vec<u32>,
}

impl<'a> PlaneSearch<'a> {
    /// For ascending planes \[nm\].
    pub fn new(planes: &'a [i32]) -> Self {
        let base = planes.first().map_or(0, |&z| i64::from(z));
        let extent = planes.last().map_or(0, |&z| i64::from(z)) - base;
        // About two cells per plane.
        let wanted = 2 * planes.len() as i64 + 1;
        let shift = (0..40).find(|s| extent >> s < wanted).unwrap_or(40);
        let cells = (extent >> shift) + 1;
        let below = (0..=cells)
            .map(|cell| planes.partition_point(|&z| i64::from(z) < base + (cell << shift)) as u32)
            .collect();
        Self { planes, base, shift, below }
    }

    /// How many planes lie at or below `z` \[nm\].
    #[inline]
    pub fn at_or_below(&self, z: i32) -> u32 {
        let above_base = i64::from(z) - self.base;
        if above_base < 0 {
            return 0;
        }
        let cell = (above_base >> self.shift) as usize;
        match self.below.get(cell..cell + 2) {
            Some(&[from, to]) => {
                let within = &self.planes[from as usize..to as usize];
                from + within.partition_point(|&plane| plane <= z) as u32
            }
            _ => self.planes.len() as u32,
        }
    }
}

/// Cuts the planes into contiguous runs of at most `limit` segments each.
///
/// A plane that alone exceeds the limit gets a run of its own; the caller decides whether that fits.
/// Runs cover all planes in order, also those without segments.
pub fn runs(per_plane: &[u64], limit: u64) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    let (mut from, mut sum) = (0, 0u64);
    for (k, &n) in per_plane.iter().enumerate() {
        if k > from && sum + n > limit {
            runs.push(from..k);
            (from, sum) = (k, 0);
        }
        sum += n;
    }
    if from < per_plane.len() {
        runs.push(from..per_plane.len());
    }
    runs
}

/// Per run its lists: what meets several runs is listed for each. `planes_of` are the planes that an item
/// meets, not none; blocks and the items in them keep their order.
pub fn by_run<T: Copy + Send>(
    blocks: Vec<Vec<T>>,
    planes: usize,
    runs: &[Range<usize>],
    planes_of: impl Fn(&T) -> Range<u32> + Sync,
) -> Vec<Vec<Vec<T>>> {
    if runs.len() < 2 {
        return vec![blocks];
    }
    let mut run_of = vec![0u32; planes];
    for (r, run) in runs.iter().enumerate() {
        run_of[run.clone()].fill(r as u32);
    }
    let blocks: Vec<Vec<Vec<T>>> = blocks
        .into_par_iter()
        .map(|block| {
            let runs_of = |item: &T| {
                let Range { start, end } = planes_of(item);
                run_of[start as usize] as usize..=run_of[end as usize - 1] as usize
            };
            // Counted first, so that no list is moved while it grows.
            let mut counts = vec![0; runs.len()];
            for item in &block {
                counts[runs_of(item)].iter_mut().for_each(|n| *n += 1);
            }
            let mut lists: Vec<Vec<T>> = counts.into_iter().map(Vec::with_capacity).collect();
            for item in block {
                lists[runs_of(&item)].iter_mut().for_each(|list| list.push(item));
            }
            lists
        })
        .collect();
    let mut per_run: Vec<Vec<Vec<T>>> = runs.iter().map(|_| Vec::with_capacity(blocks.len())).collect();
    for block in blocks {
        for (lists, list) in per_run.iter_mut().zip(block) {
            lists.push(list);
        }
    }
    per_run
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::slice::{cpu, crossing};

    #[test]
    fn counts_are_those_of_the_twin() {
        let mesh = shapes::torus(10.0, 3.0, 200, 100);
        for planes in [vec![], vec![0, 0, 1], (-50..50).map(|i| i * 67_890).collect::<Vec<i32>>()] {
            let (first, count) = cpu::count(&mesh, &planes);
            let mut expected = vec![0; planes.len()];
            for (first, count) in first.into_iter().zip(count) {
                expected[first as usize..(first + count) as usize].iter_mut().for_each(|n| *n += 1);
            }
            assert_eq!(segments_per_plane(&mesh, &planes), expected);
        }
    }

    #[test]
    fn searching_agrees_with_bisection() {
        for planes in [vec![], vec![7], vec![3, 3, 3], vec![-9, 0, 1, 1, 1 << 29], vec![-(1 << 30), 1 << 30]]
        {
            let search = PlaneSearch::new(&planes);
            for z in [-(1 << 30), -10, -9, -8, 0, 1, 2, 3, 4, 7, 8, 1 << 29, (1 << 29) + 1, 1 << 30] {
                assert_eq!(search.at_or_below(z) as usize, crossing::plane_range(z, z, &planes).0, "{z}");
            }
        }
    }

    #[test]
    fn runs_cover_every_plane_once_and_keep_the_limit() {
        assert!(runs(&[], 10).is_empty());
        assert_eq!(runs(&[3, 3, 3, 3], 6), vec![0..2, 2..4]);
        assert_eq!(runs(&[3, 30, 3], 6), vec![0..1, 1..2, 2..3]);
        assert_eq!(runs(&[0, 0, 0], 1), vec![0..3]);
    }
}
