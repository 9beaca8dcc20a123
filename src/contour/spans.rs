//! Which triangle meets which planes, and runs of planes of about equal work.

use super::trace::TraceError;
use crate::mesh::Mesh;
use crate::slice::chunk::{self, PlaneSearch};
use rayon::prelude::*;
use std::ops::Range;

/// The planes that a triangle meets, `first..end`, not empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) triangle: u32,
    pub(super) first: u32,
    pub(super) end: u32,
}

impl Span {
    /// Whether the triangle meets any plane of a run.
    pub(super) fn meets(&self, run: &Range<usize>) -> bool {
        (self.first as usize) < run.end && self.end as usize > run.start
    }
}

/// The planes that each triangle meets, for those that meet any, in blocks of consecutive triangles; and the
/// number of segments on each plane.
pub(super) fn spans(
    mesh: &Mesh,
    planes: &[i32],
    threads: usize,
) -> Result<(Vec<Vec<Span>>, Vec<u64>), TraceError> {
    // How many planes lie at or below each vertex: half the searches that triangles would need.
    let search = PlaneSearch::new(planes);
    let level: Vec<u32> =
        mesh.vertices.par_iter().with_min_len(1 << 12).map(|v| search.at_or_below(v.z)).collect();
    // Every task counts all planes: no more tasks than pay for that.
    let block = (mesh.triangles.len() / (4 * threads)).max(1 << 14).max(planes.len());
    let blocks: Result<Vec<Block>, TraceError> = mesh
        .triangles
        .par_chunks(block)
        .enumerate()
        .map(|(b, triangles)| {
            let mut step = vec![0i64; planes.len() + 1];
            // Memory that is not written to is not there.
            let mut spans = Vec::with_capacity(triangles.len());
            for (t, corners) in (b * block..).zip(triangles) {
                let [a, b, c] = *corners;
                let get = |v: u32| level.get(v as usize).copied();
                let (Some(a), Some(b), Some(c)) = (get(a), get(b), get(c)) else {
                    return Err(missing_vertex(t, *corners, level.len()));
                };
                let (first, end) = (a.min(b).min(c), a.max(b).max(c));
                if first < end {
                    step[first as usize] += 1;
                    step[end as usize] -= 1;
                    spans.push(Span { triangle: t as u32, first, end });
                }
            }
            Ok((spans, step))
        })
        .collect();
    let (spans, steps): (Vec<_>, Vec<_>) = blocks?.into_iter().unzip();
    let mut now = 0;
    let per_plane = (0..planes.len())
        .map(|k| {
            now += steps.iter().map(|step| step[k]).sum::<i64>();
            now as u64
        })
        .collect();
    Ok((spans, per_plane))
}

/// The spans of some triangles, and per plane how many begin less how many end there.
type Block = (Vec<Span>, Vec<i64>);

fn missing_vertex(triangle: usize, corners: [u32; 3], vertices: usize) -> TraceError {
    let vertex = corners[0].max(corners[1]).max(corners[2]);
    TraceError::Vertex { triangle, vertex, vertices }
}

/// Runs of planes of about equal work, several per thread.
///
/// More and smaller ones where the segments of the runs in hand, at `segment_bytes` each, would
/// exceed the budget; fewer where triangles that span several runs would be listed so often that the
/// lists do.
pub(super) fn runs(
    per_plane: &[u64],
    threads: usize,
    segment_bytes: u64,
    memory_budget: u64,
) -> Vec<Range<usize>> {
    let total: u64 = per_plane.iter().sum();
    let in_hand = total.saturating_mul(segment_bytes).saturating_mul(threads as u64);
    let share = if threads == 1 { 1 } else { 8 * threads as u64 };
    let mut parts = share.max(in_hand.div_ceil(memory_budget.max(1))).min(per_plane.len().max(1) as u64);
    loop {
        let runs = chunk::runs(per_plane, (total / parts).max(1));
        // A triangle is listed again for every border of a run that it crosses.
        let again: u64 = runs.iter().skip(1).map(|r| per_plane[r.start].min(per_plane[r.start - 1])).sum();
        if parts == 1 || again * size_of::<Span>() as u64 <= memory_budget {
            return runs;
        }
        parts /= 2;
    }
}

/// Triangles sorted by a plane of the run.
pub(super) struct Buckets {
    base: Vec<u32>,
    triangles: Vec<u32>,
}

impl Buckets {
    /// Counting sort of (plane, triangle) pairs, each plane below `planes`.
    pub(super) fn new<I: Iterator<Item = (u32, u32)>>(planes: usize, pairs: impl Fn() -> I) -> Self {
        let mut base = vec![0u32; planes + 2];
        for (plane, _) in pairs() {
            base[plane as usize + 2] += 1;
        }
        for k in 2..base.len() {
            base[k] += base[k - 1];
        }
        let mut triangles = vec![0; base[planes + 1] as usize];
        for (plane, triangle) in pairs() {
            let cursor = &mut base[plane as usize + 1];
            triangles[*cursor as usize] = triangle;
            *cursor += 1;
        }
        Self { base, triangles }
    }

    /// Those of a plane.
    pub(super) fn of(&self, plane: usize) -> &[u32] {
        &self.triangles[self.range(plane)]
    }

    /// Where those of a plane are.
    pub(super) fn range(&self, plane: usize) -> Range<usize> {
        self.base[plane] as usize..self.base[plane + 1] as usize
    }

    /// One of them.
    pub(super) fn triangle(&self, at: usize) -> u32 {
        self.triangles[at]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn buckets_keep_the_order_of_their_pairs() {
        let pairs = [(2, 7), (0, 1), (2, 3), (3, 9)];
        let buckets = Buckets::new(4, || pairs.iter().copied());
        assert_eq!(buckets.of(0), [1]);
        assert!(buckets.of(1).is_empty());
        assert_eq!(buckets.of(2), [7, 3]);
        assert_eq!(buckets.of(3), [9]);
    }
}
