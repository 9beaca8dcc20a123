//! Rings → spans: where rows run inside.
//!
//! A vertex on a row counts as above it, the same for both edges that share it, so that no case is
//! degenerate. A crossing is rounded to the nearest unit, halves towards +s: rounding is monotone and
//! the same for all edges, so it may merge positions but never swaps two.

use super::{RowFrame, Rows, RowsBuilder};
use crate::lattice::Point2;
use rayon::prelude::*;
use std::sync::Arc;

/// Where a ring crosses a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hit {
    /// The row.
    pub row: i32,
    /// Position along the row \[units\].
    pub s: i32,
    /// Index of the ring.
    pub ring: u32,
    /// Index of the edge's first vertex in the ring.
    pub edge: u32,
    /// The edge runs towards higher rows.
    pub up: bool,
}

/// Spans together with the border crossings that bound them.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    /// The area.
    pub rows: Rows,
    /// Per span of `rows` the hits at its start and its end.
    pub ends: Vec<[u32; 2]>,
    /// All crossings, ring by ring in walking order.
    pub hits: Vec<Hit>,
    /// Per ring its first hit; the last entry is the total. Length = rings + 1.
    pub ring_hits: Vec<u32>,
}

/// The non-zero winding interior of closed rings \[nm\] on the rows of a frame.
pub fn scan<'a>(rings: impl IntoIterator<Item = &'a [Point2]>, frame: &RowFrame) -> Rows {
    let mut hits = Vec::new();
    for (i, ring) in rings.into_iter().enumerate() {
        walk(ring, i as u32, frame, &mut hits);
    }
    sweep(&hits, |_, _| {})
}

/// The rows of every layer's closed rings; a layer like the one below shares its rows. Length = `layers`.
pub fn scan_layers<'a, R: Iterator<Item = &'a [Point2]>>(
    layers: usize,
    rings: impl Fn(usize) -> R + Sync,
    frame: &RowFrame,
) -> Vec<Arc<Rows>> {
    let scanned: Vec<Option<Arc<Rows>>> = (0..layers)
        .into_par_iter()
        .map(|i| {
            let is_same = i > 0 && rings(i).eq(rings(i - 1));
            (!is_same).then(|| Arc::new(scan(rings(i), frame)))
        })
        .collect();
    let mut last = Arc::default();
    let mut shared = Vec::with_capacity(scanned.len());
    for rows in scanned {
        last = rows.unwrap_or(last);
        shared.push(Arc::clone(&last));
    }
    shared
}

/// As [`scan`], keeping the crossings so that the border can be followed from a span's end.
pub fn trace<'a>(rings: impl IntoIterator<Item = &'a [Point2]>, frame: &RowFrame) -> Trace {
    let mut hits = Vec::new();
    let mut ring_hits = vec![0];
    for (i, ring) in rings.into_iter().enumerate() {
        walk(ring, i as u32, frame, &mut hits);
        ring_hits.push(hits.len() as u32);
    }
    let mut ends = Vec::with_capacity(hits.len() / 2);
    let rows = sweep(&hits, |a, b| ends.push([a, b]));
    Trace { rows, ends, hits, ring_hits }
}

/// Position of a crossing: the edge (s0, t0) to (s1, t1), t0 < t <= t1, at `t`, rounded to the
/// nearest unit, halves towards +s.
///
/// Differences fit 32 bits, so the product plus the bias stays below 2^64.
#[inline]
pub fn crossing(s0: i32, t0: i32, s1: i32, t1: i32, t: i64) -> i32 {
    let dt = (i64::from(t1) - i64::from(t0)) as u64;
    let u = (t - i64::from(t0)) as u64;
    let ds = i64::from(s1) - i64::from(s0);
    if ds >= 0 {
        s0.wrapping_add(((ds as u64 * u + dt / 2) / dt) as i32)
    } else {
        s0.wrapping_sub((((-ds) as u64 * u + (dt - 1) / 2) / dt) as i32)
    }
}

/// Appends the crossings of one ring in walking order.
fn walk(ring: &[Point2], index: u32, frame: &RowFrame, hits: &mut Vec<Hit>) {
    let Some(&last) = ring.last() else { return };
    let (mut s0, mut t0) = frame.st(last);
    let mut row0 = frame.row_below(t0.into());
    // The strip row0 <= t < next that holds the previous vertex: most edges stay in it.
    let (mut low, mut high) = (frame.t(row0), frame.t(row0 + 1));
    let divided = frame.sub_rows() > 1;
    let begun = hits.len();
    let mut closing = 0;
    for (i, &p) in ring.iter().enumerate() {
        let (s1, t1) = frame.st(p);
        if i64::from(t1) < low || i64::from(t1) >= high {
            // Steps to a neighbouring strip need no division.
            let row1 = match i64::from(t1) - low {
                _ if divided => frame.row_below(t1.into()),
                d if (frame.pitch()..2 * frame.pitch()).contains(&d) => row0 + 1,
                d if (-frame.pitch()..0).contains(&d) => row0 - 1,
                _ => frame.row_below(t1.into()),
            };
            let edge = if i == 0 { ring.len() - 1 } else { i - 1 } as u32;
            if row1 > row0 {
                for row in row0 + 1..=row1 {
                    let t = frame.t(row);
                    hits.push(Hit { row, s: crossing(s0, t0, s1, t1, t), ring: index, edge, up: true });
                }
            } else {
                for row in (row1 + 1..=row0).rev() {
                    let t = frame.t(row);
                    hits.push(Hit { row, s: crossing(s1, t1, s0, t0, t), ring: index, edge, up: false });
                }
            }
            row0 = row1;
            low = frame.t(row1);
            high = frame.t(row1 + 1);
        }
        if i == 0 {
            closing = hits.len() - begun;
        }
        (s0, t0) = (s1, t1);
    }
    // The closing edge was walked first; its crossings belong behind the others.
    hits[begun..].rotate_left(closing);
}

/// Sorts crossings into rows and pairs them; reports the hits that bound each span.
fn sweep(hits: &[Hit], mut bounds: impl FnMut(u32, u32)) -> Rows {
    let Some((first, last)) = hits.iter().fold(None, |r: Option<(i32, i32)>, h| match r {
        None => Some((h.row, h.row)),
        Some((a, b)) => Some((a.min(h.row), b.max(h.row))),
    }) else {
        return Rows::default();
    };
    let rows = (i64::from(last) - i64::from(first) + 1) as usize;
    let mut offset = vec![0u32; rows + 1];
    for h in hits {
        offset[(h.row - first) as usize + 1] += 1;
    }
    for i in 0..rows {
        offset[i + 1] += offset[i];
    }
    // Position in the high half, so that keys sort by it; below it the hit and its direction.
    let mut keys = vec![0u64; hits.len()];
    for (i, h) in hits.iter().enumerate() {
        let at = &mut offset[(h.row - first) as usize];
        let s = u64::from(h.s as u32 ^ 0x8000_0000);
        keys[*at as usize] = s << 32 | (i as u64) << 1 | u64::from(h.up);
        *at += 1;
    }
    let mut out = RowsBuilder::with_capacity(first, rows, hits.len() / 2);
    let mut begin = 0;
    for &end in &offset[..rows] {
        let row = &mut keys[begin as usize..end as usize];
        begin = end;
        row.sort_unstable();
        pair(row, |a, b| {
            let (a, b) = ((a as u32) >> 1, (b as u32) >> 1);
            out.push(hits[a as usize].s, hits[b as usize].s);
            bounds(a, b);
        });
        out.end_row();
    }
    out.finish()
}

/// Pairs the sorted keys of a row into maximal stretches of non-zero winding.
fn pair(row: &[u64], mut span: impl FnMut(u64, u64)) {
    let mut winding = 0i32;
    let mut open = 0u64;
    for group in row.chunk_by(|a, b| a >> 32 == b >> 32) {
        let before = winding;
        for key in group {
            winding += if key & 1 == 0 { 1 } else { -1 };
        }
        let facing = |up: u64| group.iter().copied().find(|k| k & 1 == up).unwrap_or(group[0]);
        if before == 0 && winding != 0 {
            open = facing(0);
        } else if before != 0 && winding == 0 {
            span(open, facing(1));
        }
    }
}
