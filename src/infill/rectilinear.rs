//! Parallel lines, joined to zig-zag paths.
//!
//! Every path climbs from row to row, and a line is laid only after all lines that it overlaps on
//! the row below: the surface of a region grows in one sweep (PrusaSlicer calls this monotonic).
//! Two lines on neighbouring rows are joined at their ends
//! - along the border, when both ends lie on it with no other crossing between them and the way is
//!   no longer than the limit; such a way cannot leave the area;
//! - straight, when at least one end lies inside, the other within the limit, and no edge of the
//!   border is in between.
//!
//! Otherwise the path ends and another begins.

use super::anchor::Open;
use super::border::{Border, INSIDE, Obstacles, Run};
use crate::lattice::Point2;
use crate::span::Rows;
use crate::span::algebra::and_row;
use std::cell::LazyCell;
use std::ops::{Deref, Range};

/// A way between two lines may be this many times their distance,
const LINK_LIMIT: f64 = 3.0;
/// and no longer than this \[nm\].
const LONGEST_LINK: f64 = 50e6;

/// Which ways lead from a line to the next.
#[derive(Clone, Copy, Debug)]
pub struct Links<'a, O> {
    /// The longest along the border \[nm\]; 0 = none.
    pub border: f64,
    /// The longest straight one, as reach along the rows \[nm\]; 0 = none.
    pub straight: f64,
    /// Which parts of the border may be used.
    pub open: &'a O,
}

impl<'a, O> Links<'a, O> {
    /// Those of lines at a distance \[nm\], where there is no other limit than theirs.
    pub fn near(pitch: f64, open: &'a O) -> Self {
        let limit = (LINK_LIMIT * pitch).min(LONGEST_LINK);
        Self { border: limit, straight: limit, open }
    }
}

/// Lines joined to a path.
#[derive(Clone, Debug)]
pub struct Chain {
    /// The region that it lies in.
    pub region: usize,
    /// At least two points \[nm\].
    pub points: Vec<Point2>,
    /// The crossings at its ends, or [`INSIDE`].
    pub ends: [u32; 2],
}

/// A line on a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// The row.
    pub row: i32,
    /// Where it starts and ends \[units\].
    pub s: [i32; 2],
    /// The crossings at its ends, or [`INSIDE`].
    pub hit: [u32; 2],
}

/// Joins the lines of one layer in `area`, which lies inside the border, and reports the chains no
/// shorter than `least` \[nm\] region by region. Returns the stretches of border that links use, by the
/// crossing from which they lead forwards on their ring.
pub fn chains<O: Open>(
    border: &Border,
    area: &Rows,
    least: f64,
    links: Links<'_, O>,
    mut found: impl FnMut(Chain),
) -> Vec<u32> {
    let (lines, offset) = lines(border, area);
    if lines.is_empty() {
        return Vec::new();
    }
    let mut line_at = vec![INSIDE; border.trace.hits.len()];
    for (i, l) in lines.iter().enumerate() {
        for h in l.hit {
            if h != INSIDE {
                line_at[h as usize] = i as u32;
            }
        }
    }
    let above = overlaps(&lines, &offset);
    let mut waiting = vec![0u32; lines.len()];
    for range in &above {
        for i in range.clone() {
            waiting[i as usize] += 1;
        }
    }
    let mut sweep = Sweep {
        border,
        lines: &lines,
        line_at,
        above,
        waiting,
        laid: vec![false; lines.len()],
        ready: Vec::new(),
        links,
        least,
        last: None,
        points: Vec::new(),
        ends: [INSIDE; 2],
        used: Vec::new(),
    };
    for (region, rings) in border.regions.iter().enumerate() {
        sweep.region(offset[region]..offset[region + 1], rings.clone(), |points, ends| {
            found(Chain { region, points, ends });
        });
    }
    sweep.used
}

/// The lines of `area`, region by region, rows ascending; with each region's first line.
pub fn lines(border: &Border, area: &Rows) -> (Vec<Line>, Vec<u32>) {
    let regions = border.regions.len();
    let own = &border.trace.rows;
    let mut found: Vec<(u32, Line)> = Vec::with_capacity(area.spans().len());
    let mut offset = vec![0u32; regions + 1];
    for row in own.first().max(area.first())..own.end().min(area.end()) {
        let base = own.range(row).start;
        and_row(own.row(row), area.row(row), |piece, i| {
            let whole = own.spans()[base + i];
            let ends = border.trace.ends[base + i];
            let region = border.region_of_ring[border.hit(ends[0]).ring as usize];
            let hit = [
                if piece.start == whole.start { ends[0] } else { INSIDE },
                if piece.end == whole.end { ends[1] } else { INSIDE },
            ];
            found.push((region, Line { row, s: [piece.start, piece.end], hit }));
            offset[region as usize + 1] += 1;
        });
    }
    for r in 0..regions {
        offset[r + 1] += offset[r];
    }
    // Stable: rows keep ascending within a region.
    found.sort_by_key(|f| f.0);
    (found.into_iter().map(|f| f.1).collect(), offset)
}

/// Per line the lines of its region on the next row that it overlaps.
fn overlaps(lines: &[Line], offset: &[u32]) -> Vec<Range<u32>> {
    let mut out = Vec::with_capacity(lines.len());
    for w in offset.windows(2) {
        let end = w[1];
        // Rows and positions ascend, so both bounds only move forward.
        let (mut from, mut to) = (w[0], w[0]);
        for l in &lines[w[0] as usize..end as usize] {
            let before = |x: &Line, s: i32| x.row <= l.row || x.row == l.row + 1 && x.s[1] <= s;
            let starts = |x: &Line, s: i32| x.row <= l.row || x.row == l.row + 1 && x.s[0] < s;
            while from < end && before(&lines[from as usize], l.s[0]) {
                from += 1;
            }
            to = to.max(from);
            while to < end && starts(&lines[to as usize], l.s[1]) {
                to += 1;
            }
            out.push(from..to);
        }
    }
    out
}

/// How a path goes on from the end of a line.
#[derive(Clone, Copy, Debug)]
enum Link {
    Border(Run),
    Straight,
}

struct Sweep<'a, O> {
    border: &'a Border<'a>,
    lines: &'a [Line],
    /// Per crossing the line that ends there.
    line_at: Vec<u32>,
    above: Vec<Range<u32>>,
    /// Per line how many lines below it are still to be laid.
    waiting: Vec<u32>,
    laid: Vec<bool>,
    /// Lines that may be laid next, the latest on top: it is the nearest.
    ready: Vec<u32>,
    links: Links<'a, O>,
    /// Shorter paths are left out \[nm\].
    least: f64,
    /// Where the last path ended.
    last: Option<Point2>,
    /// The path in the making, and the crossings at its ends.
    points: Vec<Point2>,
    ends: [u32; 2],
    /// The stretches of border used by links.
    used: Vec<u32>,
}

impl<'a, O: Open> Sweep<'a, O> {
    /// Lays all lines of a region.
    fn region(
        &mut self,
        lines: Range<u32>,
        rings: Range<usize>,
        mut found: impl FnMut(Vec<Point2>, [u32; 2]),
    ) {
        let border = self.border;
        let obstacles = LazyCell::new(|| Obstacles::new(border, rings));
        for source in lines {
            if self.waiting[source as usize] == 0 {
                self.ready.push(source);
            }
            while let Some(line) = self.ready.pop() {
                if self.laid[line as usize] {
                    continue;
                }
                self.climb(line, &obstacles);
                let length = self.points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
                if length >= self.least {
                    self.last = self.points.last().copied();
                    found(self.points.clone(), self.ends);
                }
            }
        }
    }

    /// Makes the path that begins with a line and climbs as far as it can.
    fn climb(&mut self, first: u32, obstacles: &impl Deref<Target = Obstacles<'a>>) {
        self.lay(first);
        let links = [self.link(first, 0, obstacles), self.link(first, 1, obstacles)];
        // Leave where it goes on, else begin near the last path's end.
        let mut leave = match (links[0].is_some(), links[1].is_some()) {
            (true, false) => 0,
            (false, true) => 1,
            _ => self.farther_end(first),
        };
        let mut next = links[leave];
        let mut points = std::mem::take(&mut self.points);
        points.clear();
        points.extend([self.end(first, 1 - leave), self.end(first, leave)]);
        self.ends[0] = self.lines[first as usize].hit[1 - leave];
        let mut last = first;
        while let Some((line, link)) = next {
            if let Link::Border(run) = link {
                points.extend(self.border.vertices(run));
                self.used.push(self.border.stretch(self.lines[last as usize].hit[leave], run));
            }
            self.lay(line);
            last = line;
            points.push(self.end(line, leave));
            leave = 1 - leave;
            points.push(self.end(line, leave));
            next = self.link(line, leave, obstacles);
        }
        self.ends[1] = self.lines[last as usize].hit[leave];
        points.dedup();
        self.points = points;
    }

    /// Marks a line as laid and releases the lines that waited for it.
    fn lay(&mut self, line: u32) {
        self.laid[line as usize] = true;
        for i in self.above[line as usize].clone().rev() {
            self.waiting[i as usize] -= 1;
            if self.waiting[i as usize] == 0 {
                self.ready.push(i);
            }
        }
    }

    /// How to go on from an end of a line: the next line, which is entered at the same end.
    fn link(
        &self,
        line: u32,
        end: usize,
        obstacles: &impl Deref<Target = Obstacles<'a>>,
    ) -> Option<(u32, Link)> {
        let from = self.lines[line as usize];
        let is_free = |i: u32| !self.laid[i as usize] && self.waiting[i as usize] == 0;
        if from.hit[end] != INSIDE
            && let Some(run) = self.border.up(from.hit[end])
        {
            let next = self.line_at[run.to as usize];
            if next != INSIDE && self.lines[next as usize].hit[end] == run.to {
                let usable = is_free(next)
                    && self.links.border > 0.0
                    && self.border.is_short(from.hit[end], run, self.links.border)
                    && self.border.is_open(from.hit[end], run, self.links.open);
                return usable.then_some((next, Link::Border(run)));
            }
        }
        if self.links.straight <= 0.0 {
            return None;
        }
        let frame = self.border.frame;
        let reach = |i: &u32| (i64::from(self.lines[*i as usize].s[end]) - i64::from(from.s[end])).abs();
        let next = self.above[line as usize].clone().filter(|&i| is_free(i)).min_by_key(reach)?;
        let to = self.lines[next as usize];
        if from.hit[end] != INSIDE && to.hit[end] != INSIDE || reach(&next) > frame.units(self.links.straight)
        {
            return None;
        }
        let edge = |id: u32| (id != INSIDE).then(|| self.border.hit(id)).map(|h| (h.ring, h.edge));
        let a = (i64::from(from.s[end]), frame.t(from.row));
        let b = (i64::from(to.s[end]), frame.t(to.row));
        obstacles
            .is_free(from.row, a, b, [edge(from.hit[end]), edge(to.hit[end])])
            .then_some((next, Link::Straight))
    }

    fn end(&self, line: u32, end: usize) -> Point2 {
        let l = self.lines[line as usize];
        self.border.frame.xy(l.s[end], self.border.frame.t(l.row))
    }

    /// The end of a line that is farther from where the last path ended.
    fn farther_end(&self, line: u32) -> usize {
        let Some(last) = self.last else { return 1 };
        usize::from(self.end(line, 0).distance(last) <= self.end(line, 1).distance(last))
    }
}
