//! A run of planes on a mesh whose triangles span many of them: contours kept from plane to plane.
//!
//! Between two planes most contours pass the same edges, and only their points move. So each contour
//! is kept as a list of prepared edges. While all of them reach the next plane, the next contour is
//! that list; where some end, the walk through the mesh replaces them until it meets the list again.
//! The idea of updating a status structure from plane to plane is that of McMains and Séquin, "A
//! coherent sweep plane slicer for layered manufacturing" (1999); here links come from the adjacency
//! and not from events.

use super::edge::Edge;
use super::finish::Finish;
use super::ring;
use super::spans::{Buckets, Span};
use super::surface::{Crossing, Surface};
use crate::lattice::Point2;
use crate::slice::crossing;
use std::ops::Range;

/// The state of a sweep over a run of planes.
pub(super) struct Front<'a> {
    surface: Surface<'a>,
    planes: &'a [i32],
    run: Range<usize>,
    /// Triangles by the plane where they begin.
    begin: Buckets,
    /// Per triangle one more than the plane whose walk passed it last.
    seen: Vec<u32>,
    loops: Vec<Loop>,
    /// Triangles of the open chains of the last plane.
    chained: Vec<u32>,
    /// Points in front of the place where the walk of an open chain began.
    before: Vec<Point2>,
    /// Edge lists to be used again.
    spare: Vec<Vec<Edge>>,
}

/// A closed contour of the last plane.
struct Loop {
    /// Its edges in order; the triangle entered by each ends at the next.
    edges: Vec<Edge>,
    /// The highest plane that all edges cross.
    top: i32,
    /// Order of its first point among those of its plane.
    key: u64,
}

/// How a walk ended.
enum Walked {
    Closed,
    Open,
}

impl<'a> Front<'a> {
    /// `lists` hold the spans that meet the run, and maybe others; `seen` has a word per triangle, zero or
    /// left by another run.
    pub(super) fn new(
        surface: Surface<'a>,
        planes: &'a [i32],
        lists: &[Vec<Span>],
        run: Range<usize>,
        seen: Vec<u32>,
    ) -> Self {
        let from = run.start as u32;
        let spans = || lists.iter().flatten().filter(|s| s.meets(&run));
        Self {
            surface,
            planes,
            begin: Buckets::new(run.len(), || spans().map(|s| (s.first.max(from) - from, s.triangle))),
            run,
            seen,
            loops: Vec::new(),
            chained: Vec::new(),
            before: Vec::new(),
            spare: Vec::new(),
        }
    }

    /// Gives the words back.
    pub(super) fn into_words(self) -> Vec<u32> {
        self.seen
    }

    /// Hands the contours of plane `k` to `finish`; to be called for all planes of the run in order.
    pub(super) fn plane(&mut self, k: usize, finish: &mut Finish<'_>) {
        let here = k - self.run.start;
        // Planes differ between runs, so what another run left does not matter.
        let (z, stamp) = (self.planes[k], k as u32 + 1);
        self.surface.touch(self.begin.of(here));
        let chained = std::mem::take(&mut self.chained);
        for i in 0..self.loops.len() {
            if self.loops[i].top < z {
                self.mend(i, z, stamp, finish);
            }
        }
        for &t in &chained {
            let heights = [0, 1, 2].map(|i| self.surface.corner(3 * t as usize + i).z >= z);
            if heights[0] | heights[1] | heights[2] {
                self.seed(t, z, stamp, finish);
            }
        }
        for i in self.begin.range(here) {
            self.seed(self.begin.triangle(i), z, stamp, finish);
        }
        self.loops.retain(|l| !l.edges.is_empty());
        for l in &mut self.loops {
            l.key = cut(&l.edges, self.surface, z, finish);
        }
        // Finished rings are sorted; most planes have the order of the one before.
        if !self.loops.is_sorted_by_key(|l| l.key) {
            self.loops.sort_by_key(|l| l.key);
        }
    }

    /// A walk from a triangle that the plane meets, unless one passed it already.
    fn seed(&mut self, t: u32, z: i32, stamp: u32, finish: &mut Finish<'_>) {
        if self.seen[t as usize] != stamp {
            let first = self.surface.entry(t as usize, z);
            let edge = Edge::new(first.below, first.above, first.edge as u32);
            self.walk(&[edge], 0, z, stamp, finish);
        }
    }

    /// Replaces a contour some of whose edges end below the plane. Every contour of the new plane
    /// passes an edge of one of the last plane or consists of triangles that begin here: a triangle
    /// that both planes meet has an edge that both cross.
    fn mend(&mut self, i: usize, z: i32, stamp: u32, finish: &mut Finish<'_>) {
        let mut old = std::mem::take(&mut self.loops[i].edges);
        for at in 0..old.len() {
            let edge = &old[at];
            if edge.top >= z && self.seen[edge.half_edge as usize / 3] != stamp {
                self.walk(&old, at, z, stamp, finish);
            }
        }
        old.clear();
        self.spare.push(old);
    }

    /// Follows the contour that enters a triangle by the edge `old[at]`, along the edges of `old` where
    /// they still hold.
    fn walk(&mut self, old: &[Edge], at: usize, z: i32, stamp: u32, finish: &mut Finish<'_>) {
        let mut edges = self.spare.pop().unwrap_or_default();
        match self.follow(old, at, z, stamp, &mut edges) {
            Walked::Closed => {
                let top = edges.iter().map(|e| e.top).min().unwrap_or(z);
                self.loops.push(Loop { edges, top, key: 0 });
            }
            Walked::Open => {
                self.leave_open(&edges, z, stamp, finish);
                edges.clear();
                self.spare.push(edges);
            }
        }
    }

    fn follow(&mut self, old: &[Edge], at: usize, z: i32, stamp: u32, edges: &mut Vec<Edge>) -> Walked {
        let first = old[at].half_edge;
        let turned = |i: usize| if i == old.len() { 0 } else { i };
        let mut here = at;
        loop {
            // Along the old contour as far as it holds. Its last edge joins its first.
            let from = edges.len();
            loop {
                edges.push(old[here]);
                here = turned(here + 1);
                if here == at || old[here].top < z {
                    break;
                }
            }
            for edge in &edges[from..] {
                self.seen[edge.half_edge as usize / 3] = stamp;
            }
            if here == at && old.len() > 1 {
                return Walked::Closed;
            }
            // Through the mesh until the next edge that holds.
            while old[here].top < z {
                here = turned(here + 1);
            }
            let target = old[here].half_edge;
            let Some(&last) = edges.last() else { return Walked::Open };
            let mut crossing = self.crossing(last.half_edge as usize);
            loop {
                self.surface.forward(&mut crossing, z);
                let entered = crossing.edge as u32;
                if entered == first {
                    return Walked::Closed;
                }
                if entered == target {
                    break;
                }
                match self.seen.get_mut(crossing.edge / 3) {
                    Some(seen) if *seen != stamp => *seen = stamp,
                    _ => return Walked::Open,
                }
                edges.push(Edge::new(crossing.below, crossing.above, entered));
            }
        }
    }

    /// The crossing of an edge that goes down.
    fn crossing(&self, half_edge: usize) -> Crossing {
        let next = if half_edge % 3 == 2 { half_edge - 2 } else { half_edge + 1 };
        Crossing { edge: half_edge, below: self.surface.corner(next), above: self.surface.corner(half_edge) }
    }

    /// Hands an open chain on whose walk began somewhere within it.
    fn leave_open(&mut self, edges: &[Edge], z: i32, stamp: u32, finish: &mut Finish<'_>) {
        let (Some(first), Some(last)) = (edges.first(), edges.last()) else { return };
        for edge in edges {
            finish.point(point(edge, self.surface, z));
            self.chained.push(edge.half_edge / 3);
        }
        let mut at = self.crossing(last.half_edge as usize);
        self.surface.forward(&mut at, z);
        finish.point(crossing::point(at.below, at.above, z));
        self.before.clear();
        let mut at = self.crossing(first.half_edge as usize);
        loop {
            at.edge = self.surface.twin[at.edge] as usize;
            match self.seen.get_mut(at.edge / 3) {
                Some(seen) if *seen != stamp => *seen = stamp,
                _ => break,
            }
            self.chained.push((at.edge / 3) as u32);
            self.surface.backward(&mut at, z);
            self.before.push(crossing::point(at.below, at.above, z));
        }
        finish.leave_open(&self.before);
    }
}

/// Hands the points of a closed contour on; returns the order of its smallest point.
fn cut(edges: &[Edge], surface: Surface<'_>, z: i32, finish: &mut Finish<'_>) -> u64 {
    finish.points(edges.iter().map(|edge| point(edge, surface, z)));
    finish.close().map_or(0, ring::key)
}

#[inline(always)]
fn point(edge: &Edge, surface: Surface<'_>, z: i32) -> Point2 {
    let (p, certain) = edge.cut(z);
    // The half-edge goes down, so it runs from the upper vertex.
    if certain { p } else { edge.cut_exactly(surface.corner(edge.half_edge as usize), z) }
}
