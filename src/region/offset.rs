//! Offsets of areas: inwards for walls, outwards for skirts.
//!
//! A point belongs to the inset when no edge's strip of the given depth and no joint between two
//! strips covers it. The strips' borders, added to the outline, give a *raw* curve that may cross
//! itself; its winding number at a point is the outline's less the number of strips and joints there,
//! so the inset is where that is positive (Chen & McMains, "Polygon offsetting by computing winding
//! numbers", ASME DETC 2005). This file builds the raw curves, which the polygon library unites, for
//! those areas that the faster `wavefront` cannot do.

use super::boolean::{self, Winding};
use super::wavefront;
use crate::contour::{ExPolygon, Ring};
use crate::lattice::{LIMIT, Point2};

/// How far a mitred corner may reach from its vertex, in multiples of the offset; beyond it the corner
/// is cut off square, one offset away. 2 cuts corners sharper than 60 degrees.
pub const MITER_LIMIT: f64 = 2.0;

/// How far the chords of a round joint may lie inside its arc \[nm\].
pub const ARC_TOLERANCE: f64 = 5_000.0;

/// Detours up to this are removed from the results of offsets \[nm\], which would grow vertices
/// otherwise from one offset to the next.
pub const SIMPLIFY: f64 = 2_000.0;

/// How the gap that opens at a corner is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Join {
    /// Both edges are prolonged to their crossing, up to [`MITER_LIMIT`].
    Miter,
    /// An arc about the vertex, to within [`ARC_TOLERANCE`].
    Round,
}

/// The areas moved inwards by `distance` \[nm\] with mitred corners: points that are at least that far
/// from every edge. A negative distance moves outwards. Each area is taken by itself.
///
/// The result is canonical and simplified by at most [`SIMPLIFY`].
pub fn inset(polygons: &[ExPolygon], distance: i64) -> Vec<ExPolygon> {
    if distance < 0 {
        return outset(polygons, -distance, Join::Miter);
    }
    let mut result: Vec<ExPolygon> = polygons.iter().flat_map(|p| inset_one(p, distance)).collect();
    if polygons.len() > 1 {
        result.sort_unstable_by(|a, b| a.contour.cmp(&b.contour));
    }
    result
}

/// The areas grown by `distance` \[nm\]; areas that meet merge. A negative distance moves inwards.
///
/// The result is canonical and simplified by at most [`SIMPLIFY`].
pub fn outset(polygons: &[ExPolygon], distance: i64, join: Join) -> Vec<ExPolygon> {
    if distance < 0 {
        return inset(polygons, -distance);
    }
    if join == Join::Miter
        && let Some(grown) = wavefront::outset(polygons, distance)
    {
        return grown;
    }
    let raw: Vec<Ring> =
        polygons.iter().flat_map(ExPolygon::rings).map(|r| raw_curve(r, -(distance as f64), join)).collect();
    simplified(boolean::union(&raw, Winding::Positive))
}

/// The inset of one area by the fast route if that is proven right, else by the polygon library.
fn inset_one(polygon: &ExPolygon, distance: i64) -> Vec<ExPolygon> {
    wavefront::inset(polygon, distance).unwrap_or_else(|| raw_inset(polygon, distance as f64))
}

/// The inset of one area by the fast route alone; `None` where its result is not proven right.
pub fn fast_inset(polygon: &ExPolygon, distance: i64) -> Option<Vec<ExPolygon>> {
    wavefront::inset(polygon, distance)
}

/// The inset of one area by way of the polygon library.
pub fn raw_inset(polygon: &ExPolygon, distance: f64) -> Vec<ExPolygon> {
    let raw: Vec<Ring> = polygon.rings().map(|r| raw_curve(r, distance, Join::Miter)).collect();
    simplified(boolean::union(&raw, Winding::Positive))
}

fn simplified(mut polygons: Vec<ExPolygon>) -> Vec<ExPolygon> {
    for polygon in &mut polygons {
        simplify(&mut polygon.contour, SIMPLIFY);
        polygon.holes.iter_mut().for_each(|h| simplify(h, SIMPLIFY));
        polygon.holes.retain(|h| h.len() > 2);
    }
    polygons.retain(|p| p.contour.len() > 2);
    polygons
}

/// Drops vertices that lie within `tolerance` \[nm\] of the line that replaces them.
///
/// Greedy along the ring, from its first point, which stays: a run of vertices gives way to one edge as
/// long as each of them is within the tolerance of it.
pub(super) fn simplify(ring: &mut Ring, tolerance: f64) {
    if ring.len() < 4 {
        return;
    }
    let n = ring.len();
    let limit = tolerance * tolerance;
    let (mut from, mut kept) = (0, 1);
    while from < n {
        let mut to = from + 1;
        while to < n && to - from < LONGEST_RUN {
            let (a, b) = (ring[from], ring[if to + 1 == n { 0 } else { to + 1 }]);
            if !ring[from + 1..=to].iter().all(|&p| distance2(p, a, b) <= limit) {
                break;
            }
            to += 1;
        }
        if to < n {
            // Never ahead of what is still to be read.
            ring[kept] = ring[to];
            kept += 1;
        }
        from = to;
    }
    ring.truncate(kept);
}

/// Most vertices that one edge replaces, which bounds the time that simplification takes.
const LONGEST_RUN: usize = 64;

/// Squared distance of `p` from the segment (a, b) \[nm²\].
pub(super) fn distance2(p: Point2, a: Point2, b: Point2) -> f64 {
    let (ux, uy) = b.minus(a);
    let (vx, vy) = p.minus(a);
    let (ux, uy, vx, vy) = (ux as f64, uy as f64, vx as f64, vy as f64);
    let (length2, along) = (ux * ux + uy * uy, ux * vx + uy * vy);
    if along <= 0.0 || length2 <= 0.0 {
        return vx * vx + vy * vy;
    }
    if along >= length2 {
        let (wx, wy) = (vx - ux, vy - uy);
        return wx * wx + wy * wy;
    }
    let side = ux * vy - uy * vx;
    side * side / length2
}

/// The border of a ring's strips of depth `d` \[nm\] on its left; on its right when `d` is negative.
fn raw_curve(ring: &[Point2], d: f64, join: Join) -> Ring {
    let mut ring = ring.to_vec();
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    let n = ring.len();
    if n < 3 {
        return Ring::new();
    }
    let edges: Vec<Vector> = (0..n).map(|i| Vector::between(ring[i], ring[(i + 1) % n])).collect();
    let length: Vec<f64> = edges.iter().map(|e| e.length()).collect();
    let unit: Vec<Vector> = edges.iter().zip(&length).map(|(e, l)| e.times(1.0 / l)).collect();
    let mut curve = Curve { points: Ring::with_capacity(3 * n), d };
    for i in 0..n {
        let before = if i == 0 { n - 1 } else { i - 1 };
        let (a, b) = (unit[before], unit[i]);
        let (turn, dot) = (a.cross(b), a.dot(b));
        curve.corner(ring[i], a, b, turn, dot, length[before].min(length[i]), join);
    }
    curve.points
}

/// A direction or a displacement \[nm\].
#[derive(Clone, Copy, Debug)]
struct Vector {
    x: f64,
    y: f64,
}

impl Vector {
    fn between(a: Point2, b: Point2) -> Self {
        let (x, y) = b.minus(a);
        Self { x: x as f64, y: y as f64 }
    }

    fn times(self, k: f64) -> Self {
        Self { x: self.x * k, y: self.y * k }
    }

    fn plus(self, v: Self) -> Self {
        Self { x: self.x + v.x, y: self.y + v.y }
    }

    fn cross(self, v: Self) -> f64 {
        self.x * v.y - self.y * v.x
    }

    fn dot(self, v: Self) -> f64 {
        self.x * v.x + self.y * v.y
    }

    fn length(self) -> f64 {
        self.dot(self).sqrt()
    }

    /// Turned by a right angle to the left.
    fn left(self) -> Self {
        Self { x: -self.y, y: self.x }
    }
}

/// A raw curve in the making.
struct Curve {
    points: Ring,
    /// Depth of the strips \[nm\], positive to the left.
    d: f64,
}

impl Curve {
    /// `v` moved by `by` \[nm\] and rounded to the lattice.
    fn push(&mut self, v: Point2, by: Vector) {
        let limit = f64::from(LIMIT - 1);
        // The way is rounded before it is added, so that the result moves with its input.
        let part = |c: i32, by: f64| (f64::from(c) + by.round()).clamp(-limit, limit) as i32;
        self.points.push(Point2::new(part(v.x, by.x), part(v.y, by.y)));
    }

    /// The joint at `v` between the strips of the edges with unit directions `a` and `b`, the shorter of
    /// which has length `room`.
    #[expect(clippy::too_many_arguments, reason = "one corner's geometry, computed once by the caller")]
    fn corner(&mut self, v: Point2, a: Vector, b: Vector, turn: f64, dot: f64, room: f64, join: Join) {
        let d = self.d;
        let (from, to) = (a.left(), b.left());
        // Both strips' borders cross at v + miter; tan(half the turn) = |turn| / (1 + dot).
        let miter = |d: f64| from.plus(to).times(d / (1.0 + dot));
        let folds = dot <= -1.0 + 1e-12;
        if turn * d > 0.0 && !folds {
            // The strips overlap. A shallow corner's are cut at their crossing, which counts their
            // common part once instead of twice; other corners go back to the vertex.
            if dot > 0.9 && turn.abs() * d.abs() <= room * (1.0 + dot) {
                self.push(v, miter(d));
            } else {
                self.push(v, from.times(d));
                self.push(v, Vector { x: 0.0, y: 0.0 });
                self.push(v, to.times(d));
            }
        } else if join == Join::Round {
            self.push(v, from.times(d));
            let middle = if folds { a.times(d.signum()) } else { from.plus(to) };
            self.arc(v, from, middle, to);
            self.push(v, to.times(d));
        } else if (1.0 + dot) * MITER_LIMIT * MITER_LIMIT >= 2.0 {
            self.push(v, miter(d));
        } else {
            // A square cap: the turn is taken in two equal steps. tan(quarter of the turn).
            let (sine, cosine) = ((0.5 * (1.0 - dot)).sqrt(), (0.5 * (1.0 + dot)).max(0.0).sqrt());
            let t = d.abs() * sine / (1.0 + cosine);
            self.push(v, from.times(d).plus(a.times(t)));
            self.push(v, to.times(d).plus(b.times(-t)));
        }
    }

    /// The points strictly between two normals of an arc about `v`; `middle` points halfway.
    fn arc(&mut self, v: Point2, from: Vector, middle: Vector, to: Vector) {
        let cosine = middle.dot(from) / middle.length();
        if (1.0 - cosine) * self.d.abs() <= ARC_TOLERANCE {
            return;
        }
        let middle = middle.times(1.0 / middle.length());
        self.arc(v, from, from.plus(middle), middle);
        self.push(v, middle.times(self.d));
        self.arc(v, middle, middle.plus(to), to);
    }
}
