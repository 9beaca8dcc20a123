//! Carries an area from one family of rows over to another.

use crate::lattice::Point2;
use crate::span::algebra::and;
use crate::span::{EdgeScan, RowFrame, Rows, Span};

/// `area`, a part of `own` on the rows of `frame`, on the rows `lines`, where the same region is
/// `own_on_lines`.
///
/// Every point of the region belongs to the nearest row of `frame`, and with it to `area` or not. Where
/// that row misses the region, because it is a tip beyond its last row or lies in a notch of it, the
/// point belongs to the next row on its own side, and else to what is nearest on its row. So the
/// region's border cuts no line short, and the parts of a region share its lines out without a rest.
pub fn onto(area: &Rows, own: &Rows, frame: &RowFrame, own_on_lines: &Rows, lines: &RowFrame) -> Rows {
    if area.is_empty() {
        return Rows::default();
    }
    if area.length() == own.length() {
        return own_on_lines.clone();
    }
    if lines == frame {
        return area.clone();
    }
    and(own_on_lines, &EdgeScan::new(lines).scan(&outline(area, own, frame)))
}

/// The border of `area` as cells half a row high, directed so that the area lies to the left.
pub fn outline(area: &Rows, own: &Rows, frame: &RowFrame) -> Vec<[Point2; 2]> {
    let reach = |a: Option<i32>| a.unwrap_or(0);
    let far = frame.pitch().clamp(1, 1 << 28) as i32;
    let low = reach(own.spans().iter().map(|s| s.start).min()).saturating_sub(far);
    let high = reach(own.spans().iter().map(|s| s.end).max()).saturating_add(far);
    let mut out = Vec::new();
    let mut cells = Cells::new(low, high);
    let (mut under, mut over): (Vec<Span>, Vec<Span>) = (Vec::new(), Vec::new());
    // Half a row before the first and behind the last one tips may reach.
    for k in own.first() - 1..=own.end() {
        let t = frame.t(k);
        let half = frame.pitch() / 2;
        for (side, t0) in [(-1, t - half), (1, t)] {
            let t1 = t0 + half + if side > 0 { frame.pitch() % 2 } else { 0 };
            cells.fill([area.row(k), own.row(k)], [area.row(k + side), own.row(k + side)], &mut over);
            across(&under, &over, |a, b| out.push([frame.xy(a, t0), frame.xy(b, t0)]));
            for s in &over {
                out.push([frame.xy(s.start, t1), frame.xy(s.start, t0)]);
                out.push([frame.xy(s.end, t0), frame.xy(s.end, t1)]);
            }
            std::mem::swap(&mut under, &mut over);
        }
    }
    let t = frame.t(own.end()) + frame.pitch() - frame.pitch() / 2;
    for s in &under {
        out.push([frame.xy(s.end, t), frame.xy(s.start, t)]);
    }
    out
}

/// The edges between two rows of cells, from start to end: forwards where only the upper one has the
/// area, backwards where only the lower one has it.
fn across(under: &[Span], over: &[Span], mut edge: impl FnMut(i32, i32)) {
    if under == over {
        return;
    }
    let ends = |row: &[Span], i: usize| {
        row.get(i / 2).map_or(i32::MAX, |s| if i.is_multiple_of(2) { s.start } else { s.end })
    };
    let (mut i, mut j, mut at) = (0, 0, i32::MIN);
    while i < 2 * under.len() || j < 2 * over.len() {
        let next = ends(under, i).min(ends(over, j));
        match (i % 2 == 1, j % 2 == 1) {
            (true, false) if at < next => edge(next, at),
            (false, true) if at < next => edge(at, next),
            _ => {}
        }
        at = next;
        if ends(under, i) == at && i < 2 * under.len() {
            i += 1;
        }
        if ends(over, j) == at && j < 2 * over.len() {
            j += 1;
        }
    }
}

/// Extends what is known of a row over all of its length.
struct Cells {
    low: i32,
    high: i32,
    /// Stretches that are known, and whether they belong to the area.
    known: Vec<(Span, bool)>,
}

impl Cells {
    fn new(low: i32, high: i32) -> Self {
        Self { low, high, known: Vec::new() }
    }

    /// The part of the row that belongs to the area: as its own spans say, `[area, own]`, where there
    /// are none as those of the row beside it, and else as the nearest of these.
    fn fill(&mut self, here: [&[Span]; 2], beside: [&[Span]; 2], out: &mut Vec<Span>) {
        out.clear();
        if here[0].is_empty() && beside[0].is_empty() {
            return;
        }
        if here[0] == here[1] && beside[0] == beside[1] {
            out.push(Span { start: self.low, end: self.high });
            return;
        }
        self.known.clear();
        divide(here[1], here[0], |s, inside| self.known.push((s, inside)));
        divide(beside[1], here[1], |s, hidden| {
            if !hidden {
                divide(&[s], beside[0], |s, inside| self.known.push((s, inside)));
            }
        });
        self.known.sort_unstable_by_key(|k| k.0.start);
        let mut at = self.low;
        for (i, &(s, inside)) in self.known.iter().enumerate() {
            let end = match self.known.get(i + 1) {
                Some(next) if next.1 == inside => next.0.start,
                Some(next) => ((i64::from(s.end) + i64::from(next.0.start)) / 2) as i32,
                None => self.high,
            };
            match out.last_mut() {
                Some(last) if inside && last.end == at => last.end = end,
                _ if inside => out.push(Span { start: at, end }),
                _ => {}
            }
            at = end;
        }
    }
}

/// Cuts the spans of `all` where those of `part` begin and end; tells of each piece whether it is in it.
fn divide(all: &[Span], part: &[Span], mut piece: impl FnMut(Span, bool)) {
    let mut j = 0;
    for s in all {
        let mut at = s.start;
        while j < part.len() && part[j].end <= at {
            j += 1;
        }
        let mut i = j;
        while i < part.len() && part[i].start < s.end {
            if at < part[i].start {
                piece(Span { start: at, end: part[i].start }, false);
            }
            let (start, end) = (at.max(part[i].start), s.end.min(part[i].end));
            piece(Span { start, end }, true);
            at = end;
            i += 1;
        }
        if at < s.end {
            piece(Span { start: at, end: s.end }, false);
        }
    }
}
