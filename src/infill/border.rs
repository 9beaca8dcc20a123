//! The border of the infill area between two rows: ways along it, and obstacles in it.

use super::anchor::Open;
use crate::lattice::Point2;
use crate::span::{Hit, RowFrame, Trace};
use std::ops::Range;

/// Marks a line's end that is not on the border.
pub const INSIDE: u32 = u32::MAX;

/// The rings of an infill area with their crossings on one family of rows.
#[derive(Debug)]
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

    /// True when `open` holds all along the way.
    pub fn is_open(&self, from: u32, run: Run, open: &impl Open) -> bool {
        if open.is_all() {
            return true;
        }
        let mut at = self.point(from);
        self.vertices(run).chain([self.point(run.to)]).all(|p| {
            let from = std::mem::replace(&mut at, p);
            open.reach(from, p) >= from.distance(p)
        })
    }

    /// The crossing from which a way leads forwards on its ring: its beginning, or its end.
    pub fn stretch(&self, from: u32, run: Run) -> u32 {
        if run.forward { from } else { run.to }
    }
}

/// A point in the frame's coordinates.
pub type St = (i64, i64);

/// The pieces of border in each strip between two rows, for some rings.
#[derive(Debug)]
pub struct Obstacles<'a> {
    border: &'a Border<'a>,
    first: i32,
    /// Per strip its first piece; the last entry is the total.
    offset: Vec<u32>,
    pieces: Vec<Piece>,
}

/// Consecutive edges of a ring that run through one strip.
#[derive(Clone, Copy, Debug)]
struct Piece {
    strip: i32,
    ring: u32,
    /// The first edge, and how many there are.
    edge: u32,
    count: u32,
    /// Bounds along the rows.
    low: i32,
    high: i32,
}

impl<'a> Obstacles<'a> {
    /// Sorts the border of `rings` into strips; strip `k` lies between the rows `k` and `k + 1`.
    pub fn new(border: &'a Border<'a>, rings: Range<usize>) -> Self {
        let mut found = Vec::new();
        for ring in rings {
            let points = border.rings[ring];
            let (begin, end) = border.hits_of(ring as u32);
            let mut add = |strip: i32, edge: u32, count: usize| {
                let mut piece = Piece {
                    strip,
                    ring: ring as u32,
                    edge,
                    count: count as u32,
                    low: i32::MAX,
                    high: i32::MIN,
                };
                for i in 0..=count {
                    let s = border.frame.st(points[(edge as usize + i) % points.len()]).0;
                    piece.low = piece.low.min(s);
                    piece.high = piece.high.max(s);
                }
                found.push(piece);
            };
            match points.first() {
                // Without a crossing the ring lies in one strip.
                Some(&p) if begin == end => {
                    add(border.frame.row_below(border.frame.st(p).1.into()), 0, points.len())
                }
                _ => {
                    for id in begin..end {
                        let hit = border.hit(id);
                        add(
                            if hit.up { hit.row } else { hit.row - 1 },
                            hit.edge,
                            border.forward(id).count + 1,
                        );
                    }
                }
            }
        }
        let first = found.iter().map(|p| p.strip).min().unwrap_or(0);
        let strips = found.iter().map(|p| (p.strip - first) as usize + 1).max().unwrap_or(0);
        let mut offset = vec![0u32; strips + 1];
        for p in &found {
            offset[(p.strip - first) as usize + 1] += 1;
        }
        for i in 0..strips {
            offset[i + 1] += offset[i];
        }
        found.sort_by_key(|p| p.strip);
        Self { border, first, offset, pieces: found }
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
        self.pieces[range]
            .iter()
            .filter(|p| i64::from(p.low) <= high && low <= i64::from(p.high))
            .all(|p| self.is_apart(p, a, b, except))
    }

    fn is_apart(&self, piece: &Piece, a: St, b: St, except: [Option<(u32, u32)>; 2]) -> bool {
        let points = self.border.rings[piece.ring as usize];
        let st = |i: usize| {
            let (s, t) = self.border.frame.st(points[i % points.len()]);
            (i64::from(s), i64::from(t))
        };
        let first = piece.edge as usize;
        (first..first + piece.count as usize).all(|i| {
            let edge = (i % points.len()) as u32;
            except.contains(&Some((piece.ring, edge))) || !touch(a, b, st(i), st(i + 1))
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
