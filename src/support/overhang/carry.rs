//! Carries an area from one frame's rows to another's.

use crate::span::{EdgeScan, RowFrame, Rows, Span};

/// `area`, whose spans stand for the strips half a row to either side of them, on the rows of another frame.
pub fn carry(area: &Rows, from: &RowFrame, to: &RowFrame) -> Rows {
    if from == to || area.is_empty() {
        return area.clone();
    }
    let half = from.pitch() / 2;
    let mut edges = Vec::with_capacity(4 * area.spans().len());
    // The border of the strips, the area to the left of it.
    for k in area.first()..=area.end() {
        let (under, over) = (area.row(k - 1), area.row(k));
        let (low, high) = (from.t(k) - half, from.t(k + 1) - half);
        differences(under, over, |a, b| edges.push([from.xy(a, low), from.xy(b, low)]));
        for s in over {
            edges.push([from.xy(s.start, high), from.xy(s.start, low)]);
            edges.push([from.xy(s.end, low), from.xy(s.end, high)]);
        }
    }
    EdgeScan::new(to).scan(&edges)
}

/// The stretches that only one of two rows holds: forwards where it is `over`, backwards where it is `under`.
fn differences(under: &[Span], over: &[Span], mut stretch: impl FnMut(i32, i32)) {
    let end = |row: &[Span], i: usize| {
        row.get(i / 2).map_or(i32::MAX, |s| if i.is_multiple_of(2) { s.start } else { s.end })
    };
    let (mut i, mut j, mut at) = (0, 0, i32::MIN);
    while i < 2 * under.len() || j < 2 * over.len() {
        let next = end(under, i).min(end(over, j));
        match (i % 2 == 1, j % 2 == 1) {
            (true, false) if at < next => stretch(next, at),
            (false, true) if at < next => stretch(at, next),
            _ => {}
        }
        at = next;
        i += usize::from(i < 2 * under.len() && end(under, i) == at);
        j += usize::from(j < 2 * over.len() && end(over, j) == at);
    }
}
