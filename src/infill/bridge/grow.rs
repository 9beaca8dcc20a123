//! Growing areas on rows along a direction.

use crate::span::algebra::{and, dilate, erode, or};
use crate::span::{RowFrame, Rows, RowsBuilder, Span};
use std::f64::consts::PI;

/// `area` and what can be reached from it inside `own` on straight ways of at most `reach` \[nm\] in
/// either direction, `degrees` counter-clockwise from the rows.
pub fn along(area: &Rows, own: &Rows, frame: &RowFrame, degrees: f64, reach: f64) -> Rows {
    let (sin, cos) = libm::sincos(degrees.rem_euclid(180.0) * PI / 180.0);
    let reach = (reach.max(0.0) * frame.scale()).min(1e9);
    // A way stays in its row up to half the distance of rows, then for the whole of it in each.
    let step = if sin > FLAT { frame.pitch() as f64 / sin } else { f64::INFINITY };
    let mut all = area.clone();
    for up in [1, -1] {
        let by = |from: f64, to: f64| ((to - from) * cos).round() as i32 * up;
        let (mut from, mut to) = (0.0, step / 2.0);
        let mut front = area.clone();
        loop {
            all = or(&all, &lengthen(&front, own, by(from, reach.min(to))));
            if to > reach {
                break;
            }
            front = and(&moved(&front, up, by(from, to)), own);
            if front.is_empty() {
                break;
            }
            (from, to) = (to, to + step);
        }
    }
    all
}

/// Flatter ways stay in their row \[sine\].
const FLAT: f64 = 1e-6;

/// The spans of `area`, longer by `by` \[units\] at the end, or by `-by` at the start, inside the spans of
/// `own` that hold them.
fn lengthen(area: &Rows, own: &Rows, by: i32) -> Rows {
    let mut out = RowsBuilder::new(area.first());
    for (k, row) in area.iter() {
        let whole = own.row(k);
        for s in row {
            let i = whole.partition_point(|w| w.end <= s.start);
            let w = whole.get(i).copied().unwrap_or(*s);
            let w = Span { start: w.start.min(s.start), end: w.end.max(s.end) };
            let (start, end) = (s.start.saturating_add(by.min(0)), s.end.saturating_add(by.max(0)));
            out.push(start.max(w.start), end.min(w.end));
        }
        out.end_row();
    }
    out.finish()
}

/// An area moved one row up (1) or down (-1) and by `by` \[units\] along it.
fn moved(area: &Rows, up: i32, by: i32) -> Rows {
    let mut out = RowsBuilder::new(area.first() + up);
    for (_, row) in area.iter() {
        for s in row {
            out.push(s.start.saturating_add(by), s.end.saturating_add(by));
        }
        out.end_row();
    }
    out.finish()
}

/// An area without what is narrower than `across` rows or `along` \[units\] to either side.
pub fn open(area: &Rows, across: u32, along: i32) -> Rows {
    let core = erode(area, across, along);
    if core.is_empty() { core } else { and(area, &dilate(&core, across, along)) }
}
