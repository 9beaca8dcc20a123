//! The reference twins of the kernels that keep what is out of reach: the same buffers, bit for bit, in plain
//! serial Rust. They exist to be compared.

use super::pairs::{Pairs, Place};

/// Twin of `beyond_count.wgsl`: how many spans of each row are left.
pub fn count(pairs: &Pairs) -> Vec<u32> {
    let mut counts = Vec::with_capacity(pairs.places.len());
    walk(pairs, |row, _| {
        counts.resize(row + 1, 0);
        counts[row] += 1;
    });
    counts.resize(pairs.places.len(), 0);
    counts
}

/// Twin of `beyond_fill.wgsl`: the spans that are left. `offset` is where each row's begin.
pub fn fill(pairs: &Pairs, offset: &[u32]) -> Vec<[i32; 2]> {
    let mut left = vec![[0; 2]; offset.last().map_or(0, |&total| total as usize)];
    let mut to = offset.to_vec();
    walk(pairs, |row, span| {
        left[to[row] as usize] = span;
        to[row] += 1;
    });
    left
}

/// Hands over the row and the ends of each span that is left.
fn walk(pairs: &Pairs, mut found: impl FnMut(usize, [i32; 2])) {
    for (row, place) in pairs.places.iter().enumerate() {
        for span in &pairs.spans[pairs.offset[row] as usize..pairs.offset[row + 1] as usize] {
            let mut at = span[0];
            while at < span[1] {
                let (covered, next) = look(pairs, place, at);
                if covered > at {
                    at = covered;
                } else {
                    let end = next.min(span[1]);
                    found(row, [at, end]);
                    at = end;
                }
            }
        }
    }
}

/// From a position on a row: the end of what covers it, or the position itself, and where what lies behind
/// it begins.
fn look(pairs: &Pairs, place: &Place, at: i32) -> (i32, i32) {
    let (mut covered, mut next) = (at, i32::MAX);
    for j in 0..=2 * place.reach {
        let by = pairs.widths[(place.width + j.abs_diff(place.reach)) as usize];
        let first = (place.first + j) as usize;
        let row = &pairs.cover[pairs.cover_offset[first] as usize..pairs.cover_offset[first + 1] as usize];
        if let Some(span) = row.get(row.partition_point(|s| s[1] + by <= at)) {
            if span[0] - by <= at {
                covered = covered.max(span[1] + by);
            } else {
                next = next.min(span[0] - by);
            }
        }
    }
    (covered, next)
}
