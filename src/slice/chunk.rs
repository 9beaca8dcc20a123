//! Runs of planes sized from exact counts, so that memory is a setting and not an accident.

use super::crossing;
use crate::mesh::Mesh;
use std::ops::Range;

/// Bytes that one segment takes: 8 for its start, 4 for its link.
pub const BYTES_PER_SEGMENT: u64 = 12;

/// Number of segments on each plane. `planes` \[nm\], mesh frame, ascending; length = planes.
pub fn segments_per_plane(mesh: &Mesh, planes: &[i32]) -> Vec<u64> {
    let mut step = vec![0i64; planes.len() + 1];
    for t in &mesh.triangles {
        let z = t.map(|v| mesh.vertices[v as usize].z);
        let (first, end) = crossing::plane_range(z[0].min(z[1]).min(z[2]), z[0].max(z[1]).max(z[2]), planes);
        step[first] += 1;
        step[end] -= 1;
    }
    let mut now = 0i64;
    step[..planes.len()]
        .iter()
        .map(|d| {
            now += d;
            now as u64
        })
        .collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_cover_every_plane_once_and_keep_the_limit() {
        assert_eq!(runs(&[], 10), vec![]);
        assert_eq!(runs(&[3, 3, 3, 3], 6), vec![0..2, 2..4]);
        assert_eq!(runs(&[3, 30, 3], 6), vec![0..1, 1..2, 2..3]);
        assert_eq!(runs(&[0, 0, 0], 1), vec![0..3]);
    }
}
