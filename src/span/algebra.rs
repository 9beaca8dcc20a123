//! Set operations, dilation and erosion of areas on the rows of one frame.

use super::{Rows, RowsBuilder, Span};

/// The part common to both.
pub fn and(a: &Rows, b: &Rows) -> Rows {
    let (first, end) = (a.first().max(b.first()), a.end().min(b.end()));
    if first >= end {
        return Rows::default();
    }
    let most = a.spans().len().max(b.spans().len());
    let mut out = RowsBuilder::with_capacity(first, (end - first) as usize, most);
    for k in first..end {
        and_row(a.row(k), b.row(k), |s, _| out.push(s.start, s.end));
        out.end_row();
    }
    out.finish()
}

/// The intersection of two rows; each piece comes with the index of its span in `a`.
#[inline]
pub fn and_row(a: &[Span], b: &[Span], mut piece: impl FnMut(Span, usize)) {
    let (mut i, mut j) = (0, 0);
    while i < a.len() && j < b.len() {
        let (start, end) = (a[i].start.max(b[j].start), a[i].end.min(b[j].end));
        if start < end {
            piece(Span { start, end }, i);
        }
        if a[i].end <= b[j].end {
            i += 1;
        } else {
            j += 1;
        }
    }
}

/// The part of `a` outside `b`.
pub fn sub(a: &Rows, b: &Rows) -> Rows {
    let mut out = RowsBuilder::with_capacity(a.first(), (a.end() - a.first()) as usize, a.spans().len());
    for (k, row) in a.iter() {
        let cut = b.row(k);
        let mut j = 0;
        for span in row {
            let mut start = span.start;
            while j < cut.len() && cut[j].end <= start {
                j += 1;
            }
            let mut i = j;
            while i < cut.len() && cut[i].start < span.end {
                out.push(start, cut[i].start);
                start = start.max(cut[i].end);
                i += 1;
            }
            out.push(start, span.end);
        }
        out.end_row();
    }
    out.finish()
}

/// Everything in either.
pub fn or(a: &Rows, b: &Rows) -> Rows {
    if a.is_empty() {
        return b.clone();
    }
    if b.is_empty() {
        return a.clone();
    }
    let (first, end) = (a.first().min(b.first()), a.end().max(b.end()));
    let mut out = RowsBuilder::new(first);
    for k in first..end {
        let (x, y) = (a.row(k), b.row(k));
        let (mut i, mut j) = (0, 0);
        while i < x.len() || j < y.len() {
            let from_a = j == y.len() || i < x.len() && x[i].start <= y[j].start;
            let s = if from_a { x[i] } else { y[j] };
            if from_a {
                i += 1
            } else {
                j += 1
            }
            out.push(s.start, s.end);
        }
        out.end_row();
    }
    out.finish()
}

/// Grows an area by `across` rows to either side and by `along` \[units\] at either end: dilation by
/// a rectangle.
pub fn dilate(area: &Rows, across: u32, along: i32) -> Rows {
    if area.is_empty() {
        return Rows::default();
    }
    let k = across as i32;
    let (first, end) = (area.first() - k, area.end() + k);
    let mut out = RowsBuilder::with_capacity(first, (end - first) as usize, area.spans().len());
    let mut window: Vec<Span> = Vec::new();
    for row in first..end {
        window.clear();
        for near in row - k..=row + k {
            window.extend_from_slice(area.row(near));
        }
        window.sort_unstable();
        for s in &window {
            out.push(s.start.saturating_sub(along), s.end.saturating_add(along));
        }
        out.end_row();
    }
    out.finish()
}

/// Shrinks an area by `across` rows from either side and by `along` \[units\] at either end: erosion
/// by a rectangle.
pub fn erode(area: &Rows, across: u32, along: i32) -> Rows {
    let k = across as i32;
    let (first, end) = (area.first() + k, area.end() - k);
    if first >= end {
        return Rows::default();
    }
    let mut out = RowsBuilder::new(first);
    let (mut kept, mut next) = (Vec::new(), Vec::new());
    for row in first..end {
        kept.clear();
        kept.extend_from_slice(area.row(row - k));
        for near in row - k + 1..=row + k {
            next.clear();
            and_row(&kept, area.row(near), |s, _| next.push(s));
            std::mem::swap(&mut kept, &mut next);
        }
        for s in &kept {
            out.push(s.start.saturating_add(along), s.end.saturating_sub(along));
        }
        out.end_row();
    }
    out.finish()
}

/// Fills gaps that are one row wide: closing by two rows, so that a row gains what both its
/// neighbours have.
pub fn close_rows(area: &Rows) -> Rows {
    let mut out =
        RowsBuilder::with_capacity(area.first(), (area.end() - area.first()) as usize, area.spans().len());
    let mut spans = Vec::new();
    for (k, row) in area.iter() {
        spans.clear();
        spans.extend_from_slice(row);
        and_row(area.row(k - 1), area.row(k + 1), |s, _| spans.push(s));
        if spans.len() > row.len() {
            spans.sort_unstable();
        }
        for s in &spans {
            out.push(s.start, s.end);
        }
        out.end_row();
    }
    out.finish()
}
