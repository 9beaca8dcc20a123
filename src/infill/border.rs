//! The border of the infill area between two rows: ways along it, and obstacles in it.

use crate::lattice::Point2;
use crate::span::{Hit, RowFrame, Trace};
use std::ops::Range;

/// Marks a line's end that is not on the border.
pub const INSIDE: u32 = u32::MAX;

/// The rings of an infill area with their crossings on one family of rows.
pub struct Border<'a> {
    /// Rings \[nm\].
    pub rings: &'a [&'a [Point2]],
    /// The rings of each separate region.
    pub regions: &'a [Range<usize>],
    /// Per ring its region.
    pub region_of_ring: &'a [u32],
    /// Their crossings.
    pub trace: &'a Trace,
    /// The rows.
    pub frame: &'a RowFrame,
}

/// The way along a ring from one crossing to the next.
#[derive(Clone, Copy, Debug)]
pub struct Run {
    /// The crossing it leads to.
    pub to: u32,
    /// The first vertex on the way.
    vertex: usize,
    /// Number of vertices on the way.
    count: usize,
    ring: u32,
    forward: bool,
}

impl Border<'_> {
    /// A crossing.
    pub fn hit(&self, id: u32) -> Hit {
        self.trace.hits[id as usize]
    }

    /// Where a crossing lies \[nm\].
    pub fn point(&self, id: u32) -> Point2 {
        let h = self.hit(id);
        self.frame.xy(h.s, self.frame.t(h.row))
    }

    /// The way along the border from a crossing up to the next row, unless the border turns back.
    pub fn up(&self, from: u32) -> Option<Run> {
        let h = self.hit(from);
        let run = if h.up { self.forward(from) } else { self.backward(from) };
        (self.hit(run.to).row == h.row + 1).then_some(run)
    }

    /// From a crossing to the next one on its ring.
    fn forward(&self, from: u32) -> Run {
        let a = self.hit(from);
        let (begin, end) = self.hits_of(a.ring);
        let to = if from + 1 < end { from + 1 } else { begin };
        let n = self.rings[a.ring as usize].len();
        let (ea, eb) = (a.edge as usize, self.hit(to).edge as usize);
        let count = if to > from { eb - ea } else { eb + n - ea };
        Run { to, vertex: (ea + 1) % n, count, ring: a.ring, forward: true }
    }

    /// From a crossing to the one before it on its ring.
    fn backward(&self, from: u32) -> Run {
        let a = self.hit(from);
        let (begin, end) = self.hits_of(a.ring);
        let to = if from > begin { from - 1 } else { end - 1 };
        let n = self.rings[a.ring as usize].len();
        let (ea, eb) = (a.edge as usize, self.hit(to).edge as usize);
        let count = if to < from { ea - eb } else { ea + n - eb };
        Run { to, vertex: ea, count, ring: a.ring, forward: false }
    }

    fn hits_of(&self, ring: u32) -> (u32, u32) {
        let r = ring as usize;
        (self.trace.ring_hits[r], self.trace.ring_hits[r + 1])
    }

    /// The vertices on the way \[nm\], without the crossings at its ends.
    pub fn vertices(&self, run: Run) -> impl Iterator<Item = Point2> + '_ {
        let ring = self.rings[run.ring as usize];
        let n = ring.len();
        (0..run.count).map(move |i| {
            let at = if run.forward { run.vertex + i } else { run.vertex + n + n - i };
            ring[at % n]
        })
    }

    /// True when the way is no longer than `limit` \[nm\].
    pub fn is_short(&self, from: u32, run: Run, limit: f64) -> bool {
        let mut length = 0.0;
        let mut at = self.point(from);
        for p in self.vertices(run).chain([self.point(run.to)]) {
            length += at.distance(p);
            at = p;
            if length > limit {
                return false;
            }
        }
        true
    }
}

/// A point in the frame's coordinates.
pub type St = (i64, i64);

/// The pieces of border in each strip between two rows, for some rings.
#[derive(Debug, Default)]
pub struct Obstacles {
    first: i32,
    offset: Vec<u32>,
    edges: Vec<Edge>,
}

/// An edge of a ring, in the frame's coordinates.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ring: u32,
    edge: u32,
    a: St,
    b: St,
}

impl Obstacles {
    /// Sorts the edges of `rings` into strips; strip `k` lies between the rows `k` and `k + 1`.
    pub fn new(border: &Border, rings: Range<usize>) -> Self {
        let mut found: Vec<(i32, Edge)> = Vec::new();
        for ring in rings {
            let points = border.rings[ring];
            let st = |p: Point2| {
                let (s, t) = border.frame.st(p);
                (i64::from(s), i64::from(t))
            };
            for (i, &p) in points.iter().enumerate() {
                let (a, b) = (st(p), st(points[(i + 1) % points.len()]));
                let edge = Edge { ring: ring as u32, edge: i as u32, a, b };
                // The closed strips: an edge on a row bounds the strips on either side.
                let low = border.frame.row_below(a.1.min(b.1) - 1);
                let high = border.frame.row_below(a.1.max(b.1));
                found.extend((low..=high).map(|strip| (strip, edge)));
            }
        }
        let Some(first) = found.iter().map(|f| f.0).min() else { return Self::default() };
        found.sort_by_key(|f| f.0);
        let strips = found.last().map_or(0, |f| (f.0 - first) as usize + 1);
        let mut offset = vec![0u32; strips + 1];
        for f in &found {
            offset[(f.0 - first) as usize + 1] += 1;
        }
        for i in 0..strips {
            offset[i + 1] += offset[i];
        }
        Self { first, offset, edges: found.into_iter().map(|f| f.1).collect() }
    }

    /// True when the segment from `a` to `b` in strip `k` touches no edge but those on which its own
    /// ends lie (`except`: ring and edge).
    pub fn is_free(&self, k: i32, a: St, b: St, except: [Option<(u32, u32)>; 2]) -> bool {
        let at = i64::from(k) - i64::from(self.first);
        if at < 0 || at + 1 >= self.offset.len() as i64 {
            return true;
        }
        let range = self.offset[at as usize] as usize..self.offset[at as usize + 1] as usize;
        let (low, high) = (a.0.min(b.0), a.0.max(b.0));
        self.edges[range].iter().all(|e| {
            e.a.0.max(e.b.0) < low
                || e.a.0.min(e.b.0) > high
                || except.contains(&Some((e.ring, e.edge)))
                || !touch(a, b, e.a, e.b)
        })
    }
}

/// True when two closed segments have a point in common or may have (both collinear).
fn touch(a: St, b: St, c: St, d: St) -> bool {
    side(a, b, c) * side(a, b, d) <= 0 && side(c, d, a) * side(c, d, b) <= 0
}

/// -1, 0 or 1: on which side of the line a-b point c lies.
fn side(a: St, b: St, c: St) -> i32 {
    let product = |x: i64, y: i64| i128::from(x) * i128::from(y);
    let cross = product(b.0 - a.0, c.1 - a.1) - product(b.1 - a.1, c.0 - a.0);
    cross.signum() as i32
}
