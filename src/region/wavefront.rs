//! The fast inset: every edge moves inwards until one vanishes, its neighbours meet, and so on.
//!
//! Edges move at unit speed. Where the direction turns left by an angle `a`, the two edges at that
//! corner lose `tan(a / 2)` of their length per unit of way, so the moment at which each edge vanishes
//! is known. The edge that vanishes first is taken out and its neighbours' corner turns by the sum of
//! both angles: the edge events of the straight skeleton (Aichholzer et al., "A novel type of skeleton
//! for polygons", 1995). Split events, in which the front meets itself, are left out: an exact sweep
//! tells afterwards whether the result touches itself, and such areas are left to the polygon library.

use super::offset::{self, MITER_LIMIT};
use super::shadow::{Course, Shadow};
use crate::contour::{ExPolygon, Ring, nest};
use crate::lattice::{LIMIT, Point2};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// The inset of one area by `distance` >= 0 \[nm\], when it is proven right; several areas or none when
/// holes eat it up.
pub(super) fn inset(polygon: &ExPolygon, distance: i64) -> Option<Vec<ExPolygon>> {
    inset_and_gaping(polygon, distance).map(|(inset, _)| inset)
}

/// The same, and whether some corner of the border lies more than [`GAPING`] times the distance from
/// what became of it. Where none does, and no ring is lost, discs of that radius reach every place but
/// shallow dents and corners.
pub(super) fn inset_and_gaping(polygon: &ExPolygon, distance: i64) -> Option<(Vec<ExPolygon>, bool)> {
    let origin = *polygon.contour.first()?;
    let mut rings = Vec::with_capacity(1 + polygon.holes.len());
    let mut gaping = false;
    for (i, ring) in polygon.rings().enumerate() {
        match Front::new(ring, origin)?.advance(distance as f64)? {
            Some((mut moved, gapes)) => {
                gaping |= gapes;
                offset::simplify(&mut moved, offset::SIMPLIFY);
                if moved.len() > 2 {
                    rings.push(moved);
                }
            }
            // Without its contour nothing is left of an area.
            None if i == 0 => return Some((Vec::new(), true)),
            None => gaping = true,
        }
    }
    Some((nest::nest(rings).ok()?, gaping))
}

/// The areas grown by `distance` \[nm\] with mitred corners, when that is proven right; not where they
/// meet.
pub(super) fn outset(polygons: &[ExPolygon], distance: i64) -> Option<Vec<ExPolygon>> {
    let origin = *polygons.first()?.contour.first()?;
    let mut rings = Vec::new();
    for ring in polygons.iter().flat_map(ExPolygon::rings) {
        // To grow is to inset the other side. A hole that closes leaves nothing.
        let outside: Ring = ring.iter().rev().copied().collect();
        if let Some((mut moved, _)) = Front::new(&outside, origin)?.advance(distance as f64)? {
            moved.reverse();
            offset::simplify(&mut moved, offset::SIMPLIFY);
            if moved.len() > 2 {
                rings.push(moved);
            }
        }
    }
    nest::nest(rings).ok()
}

/// An edge of the front with the vertex at its start.
#[derive(Clone, Copy, Debug)]
struct Edge {
    /// Where the start was at `born` \[nm\] from the origin.
    x: f64,
    y: f64,
    /// When the start began to move as it does \[nm of way\].
    born: f64,
    /// Unit direction.
    ux: f64,
    uy: f64,
    /// tan(half the turn) at the start, positive to the left.
    tau: f64,
    /// Length extrapolated back to the beginning \[nm\].
    length: f64,
    before: u32,
    after: u32,
    /// Index of the start in the ring that the front began as.
    vertex: u32,
    /// Counts changes of the edge, so that events can be told to be out of date.
    version: u32,
    /// The ring's vertex at the start of the source edge; [`CAP`] for caps.
    source: u32,
}

const CAP: u32 = u32::MAX;

struct Front<'a> {
    edges: Vec<Edge>,
    ring: &'a [Point2],
    origin: Point2,
    /// Source edges that vanished beside a corner that turns away from them, see [`Shadow`].
    doubtful: Vec<u32>,
}

/// Turns by more than this short of a half turn do not end at a usable corner.
const FOLD: f64 = 1e-9;

/// Pairs of a vanished edge and a run of edges of the front that are worth looking at instead of calling the
/// polygon library.
const MOST_PAIRS: usize = 2_000_000;

/// Opposite edges of the front that lie this close have nothing between them \[nm\].
const FLAT: f64 = 2_000.0;

/// A corner of a square goes 1.41 times the distance, one of 60 degrees twice.
const GAPING: f64 = 1.8;

impl<'a> Front<'a> {
    /// The front of a ring; `None` when it has edges without length or folds back inwards.
    fn new(ring: &'a [Point2], origin: Point2) -> Option<Self> {
        let n = ring.len();
        if n < 3 {
            return None;
        }
        let unit = |i: usize| {
            let (dx, dy) = ring[if i + 1 == n { 0 } else { i + 1 }].minus(ring[i]);
            let (dx, dy) = (dx as f64, dy as f64);
            let length = (dx * dx + dy * dy).sqrt();
            (dx / length, dy / length, length)
        };
        let mut edges: Vec<Edge> = Vec::with_capacity(n + 4);
        let (mut ax, mut ay, _) = unit(n - 1);
        for (i, p) in ring.iter().enumerate() {
            let (ux, uy, length) = unit(i);
            if length <= 0.0 {
                return None;
            }
            let (x, y) = p.minus(origin);
            let (turn, dot) = (ax * uy - ay * ux, ax * ux + ay * uy);
            let mut edge = Edge {
                x: x as f64,
                y: y as f64,
                born: 0.0,
                ux,
                uy,
                tau: turn / (1.0 + dot),
                length,
                before: 0,
                after: 0,
                vertex: i as u32,
                version: 0,
                source: i as u32,
            };
            if turn <= 0.0 && (1.0 + dot) * MITER_LIMIT * MITER_LIMIT < 2.0 {
                // A square cap, an edge without length, takes half of a sharp turn to the right.
                let (sine, cosine) = ((0.5 * (1.0 - dot)).sqrt(), (0.5 * (1.0 + dot)).max(0.0).sqrt());
                edge.tau = -sine / (1.0 + cosine);
                let (mx, my) = (ax + ux, ay + uy);
                let size = (mx * mx + my * my).sqrt();
                let (ux, uy) = if size > FOLD { (mx / size, my / size) } else { (ay, -ax) };
                edges.push(Edge { ux, uy, length: 0.0, source: CAP, ..edge });
            } else if 1.0 + dot < FOLD {
                return None;
            }
            edges.push(edge);
            (ax, ay) = (ux, uy);
        }
        let m = edges.len();
        for (i, edge) in edges.iter_mut().enumerate() {
            edge.before = (if i == 0 { m - 1 } else { i - 1 }) as u32;
            edge.after = (if i + 1 == m { 0 } else { i + 1 }) as u32;
        }
        Some(Self { edges, ring, origin, doubtful: Vec::new() })
    }

    /// Way until an edge vanishes; infinite when it does not.
    fn end(&self, e: &Edge) -> f64 {
        let shrink = e.tau + self.edges[e.after as usize].tau;
        if shrink > 0.0 { e.length / shrink } else { f64::INFINITY }
    }

    /// Length of an edge after `now` \[nm of way\].
    fn length(&self, i: usize, now: f64) -> f64 {
        let edge = &self.edges[i];
        edge.length - now * (edge.tau + self.edges[edge.after as usize].tau)
    }

    /// Takes out the shorter of two edges that lie on each other, back to back, and joins its other
    /// neighbour to what is left of the longer one. `None` when they gape by more than [`FLAT`].
    fn unzip(&mut self, corner: &mut Corner, now: f64) -> Option<()> {
        let (p, q) = (corner.before as usize, corner.after as usize);
        let (a, b) = (self.edges[p], self.edges[q]);
        let gape = (a.ux * b.uy - a.uy * b.ux).abs();
        let forward = a.ux * b.ux + a.uy * b.uy > 0.0;
        let shorter = corner.way_before.min(corner.way_after);
        if forward || gape * shorter > FLAT {
            return None;
        }
        // The half turns add up as the arguments of complex numbers do.
        let tau = if corner.way_before <= corner.way_after {
            corner.way_after -= corner.way_before;
            corner.before = a.before;
            corner.place = a.at(now);
            corner.way_before = self.length(a.before as usize, now);
            self.edges[p].version = u32::MAX;
            self.doubtful.push(a.source);
            a.tau
        } else {
            let next = self.edges[b.after as usize];
            corner.way_before -= corner.way_after;
            corner.after = b.after;
            corner.place = next.at(now);
            corner.way_after = self.length(b.after as usize, now);
            self.edges[q].version = u32::MAX;
            self.doubtful.push(b.source);
            next.tau
        };
        let (c, s) = corner.half;
        corner.half = (c - tau * s, s + tau * c);
        Some(())
    }

    /// The front after `way` \[nm\], or `Some(None)` when nothing is left of it, or `None` when it folds.
    /// With the ring it is told whether it gapes, see [`inset_and_gaping`].
    fn advance(mut self, way: f64) -> Option<Option<(Ring, bool)>> {
        let mut left = self.edges.len();
        // Ways are not negative, so their bits sort like the numbers.
        let mut events: BinaryHeap<Reverse<(u64, u32, u32)>> = BinaryHeap::new();
        for (i, edge) in self.edges.iter().enumerate() {
            let end = self.end(edge);
            if end <= way {
                events.push(Reverse((end.to_bits(), i as u32, 0)));
            }
        }
        let mut head = 0;
        while let Some(Reverse((end, i, version))) = events.pop() {
            let gone = self.edges[i as usize];
            if gone.version != version {
                continue;
            }
            let now = f64::from_bits(end);
            let (p, q) = (gone.before as usize, gone.after as usize);
            let (one, two) = (gone.tau, self.edges[q].tau);
            let mut corner = Corner {
                place: gone.at(now),
                half: (1.0 - one * two, one + two),
                before: p as u32,
                after: q as u32,
                way_before: 0.0,
                way_after: 0.0,
            };
            corner.way_before = self.length(p, now);
            corner.way_after = self.length(q, now);
            self.edges[i as usize].version = u32::MAX;
            if one < 0.0 || two < 0.0 {
                self.doubtful.push(gone.source);
            }
            left -= 1;
            while left > 3 && corner.folds() {
                self.unzip(&mut corner, now)?;
                left -= 1;
            }
            // A triangle with a turn beyond a half turn is inside out.
            if left < 3 || left == 3 && corner.folds() {
                return Some(None);
            }
            let (p, q) = (corner.before as usize, corner.after as usize);
            let tau = corner.half.1 / corner.half.0;
            let after = &mut self.edges[q];
            (after.x, after.y, after.born, after.tau) = (corner.place.0, corner.place.1, now, tau);
            after.before = p as u32;
            after.version += 1;
            self.edges[p].after = q as u32;
            self.edges[p].version += 1;
            self.edges[p].length = corner.way_before + now * (self.edges[p].tau + tau);
            let beyond = self.edges[q].after as usize;
            self.edges[q].length = corner.way_after + now * (tau + self.edges[beyond].tau);
            head = q;
            for j in [p, q] {
                let edge = &self.edges[j];
                let end = self.end(edge).max(now);
                if end <= way {
                    events.push(Reverse((end.to_bits(), j as u32, edge.version)));
                }
            }
        }
        let mut ring = Ring::with_capacity(left);
        let limit = f64::from(LIMIT - 1);
        let mut at = head;
        let mut gapes = false;
        for _ in 0..left {
            let edge = &self.edges[at];
            let (x, y) = edge.at(way);
            gapes = gapes || self.gapes(edge, (x, y), way);
            // The origin is added after rounding, so that the result moves with its input.
            let place = |origin: i32, by: f64| (f64::from(origin) + by.round()).clamp(-limit, limit) as i32;
            ring.push(Point2::new(place(self.origin.x, x), place(self.origin.y, y)));
            at = edge.after as usize;
        }
        let course = Course::new(&ring);
        if self.doubtful.len() * course.len() > MOST_PAIRS {
            return None;
        }
        let covers = |&i: &u32| i != CAP && Shadow::new(self.ring, i as usize, way).meets(&course);
        if self.doubtful.iter().any(covers) {
            return None;
        }
        Some(Some((ring, gapes)))
    }

    /// Whether one of the corners that have become the start of `edge`, now at `place`, was more than
    /// [`GAPING`] times the way from there.
    fn gapes(&self, edge: &Edge, place: (f64, f64), way: f64) -> bool {
        let most = (GAPING * way) * (GAPING * way);
        let n = self.ring.len();
        let mut vertex = edge.vertex as usize;
        // Those whose edges are gone come before it, back to the end of the edge before.
        let last = self.edges[edge.before as usize].vertex as usize;
        loop {
            let (x, y) = self.ring[vertex].minus(self.origin);
            let (dx, dy) = (x as f64 - place.0, y as f64 - place.1);
            if dx * dx + dy * dy > most {
                return true;
            }
            // Both edges at a square cap start from one corner.
            if vertex == last {
                return false;
            }
            vertex = if vertex == 0 { n - 1 } else { vertex - 1 };
            if vertex == last {
                return false;
            }
        }
    }
}

/// The corner that remains where edges vanished.
struct Corner {
    place: (f64, f64),
    /// Cosine and sine of half the turn, to a common factor.
    half: (f64, f64),
    before: u32,
    after: u32,
    /// Lengths of the edges at this corner \[nm\].
    way_before: f64,
    way_after: f64,
}

impl Corner {
    /// Whether it turns by a half turn or more.
    fn folds(&self) -> bool {
        self.half.0 <= FOLD * self.half.1
    }
}

impl Edge {
    /// Where the start is after `way` \[nm\] from the origin.
    fn at(&self, way: f64) -> (f64, f64) {
        let t = way - self.born;
        (self.x + t * (self.tau * self.ux - self.uy), self.y + t * (self.tau * self.uy + self.ux))
    }
}
