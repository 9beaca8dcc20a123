//! Areas that can be printed: closed, wide enough, without slivers.

use crate::span::algebra::{and, and_row, or, sub};
use crate::span::morph::{dilate_disc, erode_disc};
use crate::span::{RowFrame, Rows, RowsBuilder, Span};

/// Rows that [`box_around`] treats alike.
const BLOCK: i32 = 16;

/// What lies at most `by` \[units\] from an area along and across the rows, and something beyond.
pub fn box_around(area: &Rows, by: i64, frame: &RowFrame) -> Rows {
    if area.is_empty() {
        return Rows::default();
    }
    let across = (by / frame.pitch().max(1)).clamp(0, 1 << 20) as i32 + 1;
    let along = by.clamp(0, 1 << 30) as i32 + 1;
    let (first, end) = (area.first() - across, area.end() + across);
    let mut out = RowsBuilder::with_capacity(first, (end - first) as usize, area.spans().len());
    let mut near: Vec<Span> = Vec::new();
    for begin in (first..end).step_by(BLOCK as usize) {
        let rows = end.min(begin + BLOCK) - begin;
        near.clear();
        (begin - across..begin + rows + across).for_each(|k| near.extend_from_slice(area.row(k)));
        near.sort_unstable();
        let mut kept = 0;
        for i in 0..near.len() {
            let s = near[i];
            let grown = Span { start: s.start.saturating_sub(along), end: s.end.saturating_add(along) };
            if kept > 0 && grown.start <= near[kept - 1].end {
                near[kept - 1].end = near[kept - 1].end.max(grown.end);
            } else {
                near[kept] = grown;
                kept += 1;
            }
        }
        for _ in 0..rows {
            near[..kept].iter().for_each(|s| out.push(s.start, s.end));
            out.end_row();
        }
    }
    out.finish()
}

/// The area with gaps up to twice `radius` \[nm\] closed.
pub fn closed(area: &Rows, radius: f64, frame: &RowFrame) -> Rows {
    let (by, t) = (frame.units(radius), |k| frame.t(k));
    erode_disc(&dilate_disc(area, by, t), by, t)
}

/// The area, grown by half a line of `width` \[nm\] where it is narrower than a line and `needed`.
pub fn widened(area: &Rows, needed: &Rows, width: f64, frame: &RowFrame) -> Rows {
    if needed.is_empty() {
        return area.clone();
    }
    let (by, t) = (frame.units(0.5 * width), |k| frame.t(k));
    let wide = dilate_disc(&erode_disc(area, by, t), by + frame.pitch(), t);
    let narrow = sub(needed, &wide);
    if narrow.is_empty() { area.clone() } else { or(area, &dilate_disc(&narrow, by, t)) }
}

/// The area without what is narrower than half a line of `width` \[nm\], along the rows or across them.
pub fn without_slivers(area: &Rows, width: f64, frame: &RowFrame) -> Rows {
    let least = frame.units(0.5 * width);
    // Rows that lie within half a line of each other are one, as far as lines are concerned.
    let rows = (least / frame.pitch().max(1)).clamp(1, 8) as i32;
    let mut out =
        RowsBuilder::with_capacity(area.first(), (area.end() - area.first()) as usize, area.spans().len());
    for (_, row) in area.iter() {
        row.iter().filter(|s| s.length() >= least).for_each(|s| out.push(s.start, s.end));
        out.end_row();
    }
    high(&out.finish(), rows)
}

/// The parts that are at least as many rows high.
fn high(area: &Rows, rows: i32) -> Rows {
    if rows == 2 {
        return two_high(area);
    }
    let mut core = trimmed(area);
    for step in 1..rows {
        core = and(&core, &moved(area, -step));
    }
    (1..rows).fold(core.clone(), |all, step| or(&all, &moved(&core, step)))
}

/// What a row has in common with the one below it or above it: the same for two rows, in one pass.
fn two_high(area: &Rows) -> Rows {
    let mut out =
        RowsBuilder::with_capacity(area.first(), (area.end() - area.first()) as usize, area.spans().len());
    let mut found = Vec::new();
    for (k, row) in area.iter() {
        found.clear();
        and_row(row, area.row(k - 1), |s, _| found.push(s));
        let below = found.len();
        and_row(row, area.row(k + 1), |s, _| found.push(s));
        if below > 0 && below < found.len() {
            found.sort_unstable();
        }
        found.iter().for_each(|s| out.push(s.start, s.end));
        out.end_row();
    }
    trimmed(&out.finish())
}

/// The area without empty rows at its ends, so that equal areas are equal.
fn trimmed(area: &Rows) -> Rows {
    let rows = || (area.first()..area.end()).filter(|k| !area.row(*k).is_empty());
    let (first, end) = (rows().next().unwrap_or(0), rows().next_back().map_or(0, |k| k + 1));
    let mut out = RowsBuilder::with_capacity(first, (end - first) as usize, area.spans().len());
    for k in first..end {
        area.row(k).iter().for_each(|s| out.push(s.start, s.end));
        out.end_row();
    }
    out.finish()
}

/// The area some rows further.
fn moved(area: &Rows, rows: i32) -> Rows {
    let mut out = RowsBuilder::with_capacity(
        area.first() + rows,
        (area.end() - area.first()) as usize,
        area.spans().len(),
    );
    for (_, row) in area.iter() {
        row.iter().for_each(|s| out.push(s.start, s.end));
        out.end_row();
    }
    out.finish()
}
