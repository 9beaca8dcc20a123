//! Connected parts of a layer that nothing lies under.

use crate::span::components::label;
use crate::span::{Rows, RowsBuilder, Span};

/// The connected parts of `own` that no span of `below` overlaps.
pub fn islands(own: &Rows, below: &Rows) -> Rows {
    let bare = bare(own, below);
    if bare.is_empty() {
        return bare;
    }
    let part = label(&bare);
    let mut stands = vec![false; part.len()];
    for (k, row) in bare.iter() {
        for near in [k - 1, k + 1] {
            let (bare_near, near) = (bare.row(near), own.row(near));
            for (s, i) in row.iter().zip(bare.range(k)) {
                stands[part[i] as usize] |= meets(*s, near, |n| bare_near.binary_search(&n).is_err());
            }
        }
    }
    let mut out = RowsBuilder::new(bare.first());
    for (k, row) in bare.iter() {
        for (s, i) in row.iter().zip(bare.range(k)) {
            if !stands[part[i] as usize] {
                out.push(s.start, s.end);
            }
        }
        out.end_row();
    }
    out.finish()
}

/// Whole spans of `own` over none of `below`.
fn bare(own: &Rows, below: &Rows) -> Rows {
    let mut out = RowsBuilder::new(own.first());
    for (k, row) in own.iter() {
        let under = below.row(k);
        let mut j = 0;
        for s in row {
            while j < under.len() && under[j].end <= s.start {
                j += 1;
            }
            if under.get(j).is_none_or(|u| u.start >= s.end) {
                out.push(s.start, s.end);
            }
        }
        out.end_row();
    }
    out.finish()
}

/// True when a span overlaps one of a row that is as asked for.
fn meets(span: Span, row: &[Span], is_asked: impl Fn(Span) -> bool) -> bool {
    let first = row.partition_point(|r| r.end <= span.start);
    row[first..].iter().take_while(|r| r.start < span.end).any(|r| is_asked(*r))
}
