//! The reference twins of the kernels that turn segments into spans: the same buffers, bit for bit, in
//! plain serial Rust. They exist to be compared.

use super::scan::crossing;
use super::window::{REACH, st, t};
use super::{RowWindow, Rows, Span};
use crate::lattice::Point2;
use crate::mesh::OPEN;
use crate::shaders::SpanSizes;
use crate::slice::{Segments, cpu};

/// What `span_count.wgsl` finds.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counted {
    /// Per segment the rows that it crosses.
    pub count: Vec<u32>,
    /// Per segment the bucket of its lowest crossing, or 0.
    pub bucket: Vec<u32>,
    /// Per bucket from 1 on how many more crossings it has than the one before, modulo 2^32. Length =
    /// rows of all planes + 1.
    pub steps: Vec<u32>,
    /// Crossings of the run in 64 bits, the largest coordinate that is too large, 0; then per plane its
    /// open segments.
    pub totals: Vec<u32>,
}

/// How many rows of a plane lie at or below `at` \[units\].
fn rows_up_to(sizes: &SpanSizes, at: i32) -> u32 {
    let (mut low, mut high) = (0, sizes.rows);
    while low < high {
        let middle = low + (high - low) / 2;
        if t(sizes, middle) <= at { low = middle + 1 } else { high = middle }
    }
    low
}

/// Twin of `span_count.wgsl`. The segments are those of a run on `sizes.planes` planes.
pub fn count(sizes: &SpanSizes, segments: &Segments) -> Counted {
    let total = segments.start.len();
    let rows = sizes.planes as usize * sizes.rows as usize;
    let mut counted = Counted {
        count: vec![0; total],
        bucket: vec![0; total],
        steps: vec![0; rows + 1],
        totals: vec![0; 4 + sizes.planes as usize],
    };
    let mut sum = 0u64;
    for (slots, first) in segments.offset.windows(2).zip(&segments.first) {
        for slot in slots[0]..slots[1] {
            let plane = first + (slot - slots[0]);
            let slot = slot as usize;
            if segments.next[slot] == OPEN {
                counted.totals[4 + plane as usize] += 1;
                continue;
            }
            let [p, q] = ends(sizes, segments, slot);
            let begin = rows_up_to(sizes, p.1.min(q.1));
            let end = rows_up_to(sizes, p.1.max(q.1));
            if end > begin {
                let below = plane * sizes.rows;
                counted.count[slot] = end - begin;
                counted.bucket[slot] = 1 + below + begin;
                let steps = &mut counted.steps;
                for (at, by) in [(below + begin, 1), (below + end, u32::MAX)] {
                    steps[at as usize] = steps[at as usize].wrapping_add(by);
                }
                let reach = [p.0, p.1, q.0, q.1].map(i32::unsigned_abs).into_iter().max().unwrap_or(0);
                if reach >= REACH {
                    counted.totals[2] = counted.totals[2].max(reach);
                }
                sum += u64::from(end - begin);
            }
        }
    }
    counted.totals[0] = sum as u32;
    counted.totals[1] = (sum >> 32) as u32;
    counted
}

/// Twin of `span_fill.wgsl`: the keys of all buckets. The kernel leaves each bucket's keys in any order;
/// here they are in the order of the segments. `offset` and `row_offset` are prefix sums with the total
/// appended.
pub fn fill(
    sizes: &SpanSizes,
    segments: &Segments,
    counted: &Counted,
    offset: &[u32],
    row_offset: &[u32],
) -> Vec<u32> {
    let mut keys = vec![0; offset.last().map_or(0, |&total| total as usize)];
    let mut cursor = row_offset.to_vec();
    for (slot, (&count, &bucket)) in counted.count.iter().zip(&counted.bucket).enumerate() {
        for place in bucket..bucket + count {
            let [p, q] = ends(sizes, segments, slot);
            let up = q.1 > p.1;
            let (low, high) = if up { (p, q) } else { (q, p) };
            let at = t(sizes, (place - 1) % sizes.rows);
            let s = crossing(low.0, low.1, high.0, high.1, at.into());
            let cursor = &mut cursor[place as usize];
            keys[*cursor as usize] = (s as u32).wrapping_add(REACH) << 1 | u32::from(up);
            *cursor += 1;
        }
    }
    keys
}

/// Twin of `span_sort.wgsl`: sorts each bucket's keys, puts the spans in their place and returns how many
/// each row has.
pub fn sort(sizes: &SpanSizes, row_offset: &[u32], keys: &mut [u32]) -> Vec<u32> {
    let rows = sizes.planes as usize * sizes.rows as usize;
    row_offset[1..]
        .windows(2)
        .take(rows)
        .map(|ends| {
            let row = &mut keys[ends[0] as usize..ends[1] as usize];
            row.sort_unstable();
            pair(row)
        })
        .collect()
}

/// Pairs the sorted keys of a row into maximal stretches of non-zero winding, in their place.
fn pair(row: &mut [u32]) -> u32 {
    let (mut winding, mut opened, mut spans) = (0i32, 0, 0);
    let mut i = 0;
    while i < row.len() {
        let at = row[i] >> 1;
        let before = winding;
        while i < row.len() && row[i] >> 1 == at {
            winding += if row[i] & 1 == 0 { 1 } else { -1 };
            i += 1;
        }
        if before == 0 && winding != 0 {
            opened = at;
        } else if before != 0 && winding == 0 {
            row[2 * spans] = opened.wrapping_sub(REACH);
            row[2 * spans + 1] = at.wrapping_sub(REACH);
            spans += 1;
        }
    }
    spans as u32
}

/// Twin of `span_compact.wgsl`: the spans of all rows as (start, end), from where [`sort`] left them.
pub fn compact(row_offset: &[u32], keys: &[u32], span_offset: &[u32]) -> Vec<[i32; 2]> {
    let rows = row_offset[1..].iter().zip(span_offset.windows(2));
    rows.flat_map(|(&from, ends)| {
        let from = from as usize;
        let row = &keys[from..from + 2 * (ends[1] - ends[0]) as usize];
        row.chunks_exact(2).map(|span| [span[0] as i32, span[1] as i32])
    })
    .collect()
}

/// Coordinates (s, t) of a segment's ends.
fn ends(sizes: &SpanSizes, segments: &Segments, slot: usize) -> [(i32, i32); 2] {
    let at = |slot: usize| segments.start.get(slot).copied().unwrap_or(Point2::new(0, 0));
    [at(slot), at(segments.next[slot] as usize)].map(|p| st(sizes, p))
}

/// All steps, as [`super::gpu::GpuSpans::scan`] chains them: per plane its rows, `None` where segments end
/// in open edges. `None` altogether where a coordinate is too large or the crossings exceed 32 bits.
pub fn scan(window: &RowWindow, planes: u32, segments: &Segments) -> Option<Vec<Option<Rows>>> {
    let sizes = SpanSizes { planes, ..window.sizes() };
    let counted = count(&sizes, segments);
    if counted.totals[1] != 0 || counted.totals[2] != 0 {
        return None;
    }
    let offset = cpu::scan(&counted.count);
    let row_count = cpu::scan(&counted.steps);
    let row_offset = cpu::scan(&row_count[..row_count.len() - 1]);
    let mut keys = fill(&sizes, segments, &counted, &offset, &row_offset);
    let span_offset = cpu::scan(&sort(&sizes, &row_offset, &mut keys));
    let spans = compact(&row_offset, &keys, &span_offset);
    let rows = window.rows() as usize;
    let plane = |(k, &open): (usize, &u32)| {
        let offset = &span_offset[k * rows..=(k + 1) * rows];
        let range = offset[0] as usize..offset[rows] as usize;
        let spans = spans[range].iter().map(|&[start, end]| Span { start, end }).collect();
        if open > 0 { None } else { Rows::from_parts(window.first(), offset, spans) }
    };
    Some(counted.totals[4..].iter().enumerate().map(plane).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::span::tests::Random;
    use crate::span::{self, RowFrame};

    /// The edges of rings as segments on one plane.
    fn segments(rings: &[Vec<Point2>]) -> Segments {
        let mut segments = Segments::default();
        for ring in rings {
            let first = segments.start.len() as u32;
            segments.start.extend(ring);
            let count = ring.len() as u32;
            segments.next.extend((1..=count).map(|i| first + i % count));
        }
        let total = segments.start.len() as u32;
        (segments.first, segments.offset) = (vec![0; total as usize], (0..=total).collect());
        segments
    }

    fn trimmed(rows: &Rows) -> Rows {
        let offset: Vec<u32> = (rows.first()..rows.end()).map(|k| rows.range(k).start as u32).collect();
        let offset: Vec<u32> = offset.into_iter().chain([rows.spans().len() as u32]).collect();
        Rows::from_parts(rows.first(), &offset, rows.spans().to_vec()).unwrap()
    }

    #[test]
    fn the_twins_chain_equals_the_scan_of_rings() {
        let frames = [(0.0, [1, 0]), (90.0, [0, 1]), (45.0, [1, 1]), (135.0, [-1, 1])];
        for (degrees, axes) in frames {
            for seed in 1..200 {
                let mut random = Random(seed);
                // Often on rows; with repeated points, points back and forth, and long edges.
                let reach = if seed % 8 == 0 { 4_000 } else { 9 };
                let rings: Vec<Vec<Point2>> = (0..1 + random.below(3))
                    .map(|_| {
                        let corners = 1 + random.below(12);
                        let mut c = || random.within(-reach, reach) as i32 * 500;
                        (0..corners).map(|_| Point2::new(c(), c())).collect()
                    })
                    .collect();
                let frame = RowFrame::new(degrees, 0.0, 1e3 / RowFrame::new(degrees, 0.0, 1e6).scale());
                let lines = 2 * reach as u32 + 4;
                let first = -(reach as i32) - 2;
                let window = RowWindow::new(axes, first, frame.t(first), frame.pitch(), &[0], lines).unwrap();
                let rows = scan(&window, 1, &segments(&rings)).unwrap().remove(0).unwrap();
                let expected = span::scan(rings.iter().map(|r| &r[..]), &frame);
                assert_eq!(rows, trimmed(&expected), "seed {seed}, {degrees} degrees");
            }
        }
    }

    #[test]
    fn open_planes_and_far_diagonals_are_told() {
        let ring = vec![Point2::new(0, 0), Point2::new(5_000, 0), Point2::new(0, 7_000)];
        let window = RowWindow::new([1, 0], 0, 0, 1_000, &[0, 500], 9).unwrap();
        let mut open = segments(&[ring.clone(), ring]);
        let whole = scan(&window, 1, &open).unwrap().remove(0).unwrap();
        assert_eq!((whole.first(), whole.end()), (1, 14));
        open.next[2] = OPEN;
        assert_eq!(scan(&window, 1, &open), Some(vec![None]));
        let far = vec![Point2::new(0, 0), Point2::new(1 << 29, 1 << 29), Point2::new(0, 1 << 29)];
        let diagonal = RowWindow::new([1, 1], 0, 0, 1_000_000, &[0], 500).unwrap();
        assert_eq!(scan(&diagonal, 1, &segments(std::slice::from_ref(&far))), None);
        let axis = RowWindow::new([1, 0], 0, 0, 1_000_000, &[0], 500).unwrap();
        assert!(scan(&axis, 1, &segments(&[far])).is_some());
    }
}
