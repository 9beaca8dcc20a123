//! Areas on rows → polygons.
//!
//! A ring runs through the very ends of the spans. Spans of neighbouring rows that overlap are joined, start
//! to start and end to end; where an area begins or ends, and where it parts or grows together, its border
//! runs half a row beyond the last row that it is on. So a ring never crosses another, nor itself.

use super::straighten::straighten;
use crate::contour::{ExPolygon, Ring};
use crate::span::components::label;
use crate::span::{RowFrame, Rows};

/// A point in the frame's coordinates (s, t) \[units\].
pub type St = (i64, i64);

/// Borders are straightened by up to this \[nm\], and by no more than half a row.
pub const TOLERANCE: f64 = 30e3;

/// A jump of a border from one row to the next is an edge along the rows if it is longer than so many rows
/// are wide,
const STEP_ROWS: i64 = 2;
/// and so many times as long as the jumps before and after it; else it is a part of a flat slope.
const STEP_RATIO: i64 = 4;

/// The connected parts of an area \[nm\], contours counter-clockwise, holes clockwise, in the order of their
/// first spans; scanned on the frame's rows they are the area again, within [`TOLERANCE`].
///
/// Parts and holes of less than `least` \[mm²\] are left out.
pub fn outlines(area: &Rows, frame: &RowFrame, least: f64) -> Vec<ExPolygon> {
    let tolerance = TOLERANCE.min(0.5 * frame.pitch() as f64 / frame.scale());
    outlines_within(tolerance, area, frame, least)
}

/// The same, straightened by up to `tolerance` \[nm\].
pub fn outlines_within(tolerance: f64, area: &Rows, frame: &RowFrame, least: f64) -> Vec<ExPolygon> {
    if area.is_empty() {
        return Vec::new();
    }
    let links = Links::new(area);
    let part = label(area);
    let parts = part.iter().max().map_or(0, |&p| p as usize + 1);
    let mut found: Vec<ExPolygon> = vec![ExPolygon::default(); parts];
    let tolerance = tolerance * frame.scale();
    let least = least * 1e12 * frame.scale() * frame.scale();
    let mut walk =
        Walk { area, frame, links: &links, seen: vec![false; area.spans().len()], ring: Vec::new() };
    for i in 0..area.spans().len() as u32 {
        // Every ring has a place where it turns from its way down to its way up.
        if walk.seen[i as usize] || is_start(links.down[start(i) as usize]) {
            continue;
        }
        walk.around(start(i));
        let twice = area2(&walk.ring);
        if 0.5 * (twice as f64).abs() < least {
            continue;
        }
        straighten(&mut walk.ring, tolerance);
        let ring: Ring = walk.ring.iter().map(|&(s, t)| frame.xy(s as i32, t)).collect();
        let own = &mut found[part[i as usize] as usize];
        if ring.len() < 3 {
        } else if twice > 0 {
            own.contour = ring;
        } else {
            own.holes.push(ring);
        }
    }
    found.retain(|p| !p.contour.is_empty());
    found
}

/// Twice the signed area of a ring \[units²\].
fn area2(ring: &[St]) -> i128 {
    let Some(&(s0, t0)) = ring.first() else { return 0 };
    let cross = |a: St, b: St| {
        i128::from(a.0 - s0) * i128::from(b.1 - t0) - i128::from(b.0 - s0) * i128::from(a.1 - t0)
    };
    ring.windows(2).map(|w| cross(w[0], w[1])).sum()
}

/// The start of span `i`; its end is the next number.
fn start(i: u32) -> u32 {
    2 * i
}

fn end(i: u32) -> u32 {
    2 * i + 1
}

fn is_start(node: u32) -> bool {
    node.is_multiple_of(2)
}

/// To which spans' ends the border goes on from each span's ends: a start to a start and an end to an end of
/// the next row, or a start to an end of the same row.
struct Links {
    up: Vec<u32>,
    down: Vec<u32>,
}

impl Links {
    fn new(area: &Rows) -> Self {
        let n = area.spans().len() as u32;
        // At first every span ends at its own row.
        let own: Vec<u32> = (0..n).flat_map(|i| [end(i), start(i)]).collect();
        let mut links = Self { up: own.clone(), down: own };
        for k in area.first()..area.end() {
            links.strip(area, k);
        }
        links
    }

    /// Joins the spans of row `k` with those of the row above.
    fn strip(&mut self, area: &Rows, k: i32) {
        let (below, above) = (area.range(k), area.range(k + 1));
        let spans = area.spans();
        let (mut i, mut j) = (below.start, above.start);
        // The last two that overlap.
        let mut last: Option<(u32, u32)> = None;
        while i < below.end && j < above.end {
            let (a, b) = (spans[i], spans[j]);
            if a.start < b.end && b.start < a.end {
                let here = (i as u32, j as u32);
                match last {
                    Some((x, y)) if x == here.0 => join(&mut self.down, end(y), start(here.1)),
                    Some((x, y)) if y == here.1 => join(&mut self.up, end(x), start(here.0)),
                    _ => {
                        self.close(last);
                        self.join(start(here.0), start(here.1));
                    }
                }
                last = Some(here);
            }
            if a.end <= b.end { i += 1 } else { j += 1 }
        }
        self.close(last);
    }

    /// Joins the ends of the last spans that hang together.
    fn close(&mut self, last: Option<(u32, u32)>) {
        if let Some((x, y)) = last {
            self.join(end(x), end(y));
        }
    }

    fn join(&mut self, below: u32, above: u32) {
        self.up[below as usize] = above;
        self.down[above as usize] = below;
    }
}

fn join(links: &mut [u32], a: u32, b: u32) {
    links[a as usize] = b;
    links[b as usize] = a;
}

/// The way along the border.
struct Walk<'a> {
    area: &'a Rows,
    frame: &'a RowFrame,
    links: &'a Links,
    /// Per span whether a ring has passed its start.
    seen: Vec<bool>,
    /// The ring in the making.
    ring: Vec<St>,
}

impl Walk<'_> {
    /// Follows the ring that comes down to a start and turns there.
    fn around(&mut self, from: u32) {
        self.ring.clear();
        let mut row = self.row_of(from / 2);
        let mut node = from;
        let pitch = self.frame.pitch();
        loop {
            // Material lies on the left: down along starts, up along ends.
            let up = !is_start(node);
            if !up {
                self.seen[node as usize / 2] = true;
            }
            let next = if up { self.links.up[node as usize] } else { self.links.down[node as usize] };
            let (s, t) = (self.s(node), self.frame.t(row));
            let (s_next, half) = (self.s(next), if up { t + pitch / 2 } else { t - (pitch - pitch / 2) });
            if is_start(next) == is_start(node) {
                row += if up { 1 } else { -1 };
                if self.is_step(node, next, up) {
                    self.push((s, half));
                    self.push((s_next, half));
                }
            } else {
                // Turned back: half a row beyond, across, and back.
                self.push((s, half));
                self.push((s_next, half));
            }
            self.push((s_next, self.frame.t(row)));
            node = next;
            if node == from {
                return;
            }
        }
    }

    /// Adds a point, in place of the last one if that lies on the way across the rows.
    fn push(&mut self, p: St) {
        if let [.., a, b] = self.ring[..]
            && a.0 == b.0
            && b.0 == p.0
            && (b.1 - a.1).signum() == (p.1 - b.1).signum()
        {
            self.ring.pop();
        }
        self.ring.push(p);
    }

    /// Whether the way from `a` to `b` on the next row is an edge along the rows.
    fn is_step(&self, a: u32, b: u32, up: bool) -> bool {
        let jump = (self.s(b) - self.s(a)).abs();
        if jump <= STEP_ROWS * self.frame.pitch() {
            return false;
        }
        let (on, back) =
            if up { (&self.links.up, &self.links.down) } else { (&self.links.down, &self.links.up) };
        let is_short = |from: u32, to: u32| {
            is_start(from) != is_start(to) || (self.s(to) - self.s(from)).abs() * STEP_RATIO < jump
        };
        is_short(a, back[a as usize]) && is_short(b, on[b as usize])
    }

    fn s(&self, node: u32) -> i64 {
        let span = self.area.spans()[node as usize / 2];
        i64::from(if is_start(node) { span.start } else { span.end })
    }

    /// The row that span `i` is on.
    fn row_of(&self, i: u32) -> i32 {
        let (mut low, mut high) = (self.area.first(), self.area.end());
        while low + 1 < high {
            let middle = low + (high - low) / 2;
            if self.area.range(middle).start as u32 <= i { low = middle } else { high = middle }
        }
        low
    }
}
