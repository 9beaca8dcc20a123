//! Which parts of a line lie inside areas: edges sorted into rows, exact crossings.

use super::offset;
use crate::contour::{ExPolygon, Ring};
use crate::lattice::{self, Point2};

/// The edges of disjoint areas \[nm\] in rows of equal height, for questions about points and lines.
#[derive(Debug)]
pub struct Edges {
    /// In the order of the rings.
    edges: Vec<[Point2; 2]>,
    /// Where each row's part of `in_rows` begins, and where the last ends.
    starts: Vec<u32>,
    /// Indices of the edges that reach into each row.
    in_rows: Vec<u32>,
    low: i32,
    /// Rows are 2^shift nm high.
    shift: u32,
}

/// Edges to a row, about.
const EDGES_PER_ROW: usize = 2;

/// Most rows.
const ROWS: usize = 4096;

impl Edges {
    /// Sorts the edges of `areas`.
    pub fn new(areas: &[ExPolygon]) -> Self {
        let rings = || areas.iter().flat_map(ExPolygon::rings);
        let mut edges = Vec::with_capacity(rings().map(Vec::len).sum());
        rings().for_each(|ring| edges.extend(ring_edges(ring)));
        let low = edges.iter().map(|e| e[0].y).min().unwrap_or(0);
        let high = edges.iter().map(|e| e[0].y).max().unwrap_or(0);
        let rows = (edges.len() / EDGES_PER_ROW).clamp(1, ROWS);
        let extent = high.abs_diff(low);
        let shift = (extent / rows as u32 + 1).next_power_of_two().ilog2();
        let rows = (extent >> shift) as usize + 1;
        let mut all = Self { edges, starts: vec![0; rows + 1], in_rows: Vec::new(), low, shift };
        for i in 0..all.edges.len() {
            let [a, b] = all.edges[i];
            let (first, last) = all.rows(a.y.min(b.y), a.y.max(b.y));
            all.starts[first..=last].iter_mut().for_each(|n| *n += 1);
        }
        let mut sum = 0;
        for n in &mut all.starts {
            sum += *n;
            *n = sum;
        }
        all.in_rows = vec![0; sum as usize];
        // From the last to the first, so that every row keeps the order of the rings.
        for i in (0..all.edges.len()).rev() {
            let [a, b] = all.edges[i];
            let (first, last) = all.rows(a.y.min(b.y), a.y.max(b.y));
            for row in first..=last {
                all.starts[row] -= 1;
                all.in_rows[all.starts[row] as usize] = i as u32;
            }
        }
        all
    }

    /// The first and the last row between two heights \[nm\], cut off at the ends of the table.
    fn rows(&self, low: i32, high: i32) -> (usize, usize) {
        let last = self.starts.len() - 2;
        let row = |y: i32| match y > self.low {
            true => ((y.abs_diff(self.low) >> self.shift) as usize).min(last),
            false => 0,
        };
        (row(low), row(high))
    }

    /// The edges that may reach between two heights \[nm\], some of them several times.
    fn between(&self, low: i32, high: i32) -> impl Iterator<Item = [Point2; 2]> + '_ {
        let (first, last) = self.rows(low, high);
        let range = self.starts[first] as usize..self.starts[last + 1] as usize;
        self.in_rows[range].iter().map(|&i| self.edges[i as usize])
    }

    /// Whether a point is inside; on the border either.
    pub fn contains(&self, p: Point2) -> bool {
        let crosses = |&[a, b]: &[Point2; 2]| {
            let rises = a.y <= p.y && p.y < b.y;
            let falls = b.y <= p.y && p.y < a.y;
            rises && lattice::cross(a, b, p) > 0 || falls && lattice::cross(a, b, p) < 0
        };
        self.between(p.y, p.y).filter(crosses).count() % 2 == 1
    }

    /// Where the segment (a, b) meets edges, as shares of its length: added to `at`, unsorted.
    fn crossings(&self, a: Point2, b: Point2, at: &mut Vec<f64>) {
        let (left, right) = (a.x.min(b.x), a.x.max(b.x));
        let (low, high) = (a.y.min(b.y), a.y.max(b.y));
        for [c, d] in self.between(low, high) {
            let apart =
                c.x.max(d.x) < left || c.x.min(d.x) > right || c.y.max(d.y) < low || c.y.min(d.y) > high;
            if apart {
                continue;
            }
            let (c_side, d_side) = (lattice::cross(a, b, c), lattice::cross(a, b, d));
            if c_side > 0 && d_side > 0 || c_side < 0 && d_side < 0 {
                continue;
            }
            let (a_side, b_side) = (lattice::cross(c, d, a), lattice::cross(c, d, b));
            if a_side > 0 && b_side > 0 || a_side < 0 && b_side < 0 {
                continue;
            }
            if a_side == b_side {
                // On one line: what is inside changes where the edge ends.
                let (ux, uy) = b.minus(a);
                let length2 = (ux * ux + uy * uy) as f64;
                for p in [c, d] {
                    let (vx, vy) = p.minus(a);
                    at.push(((ux * vx + uy * vy) as f64 / length2).clamp(0.0, 1.0));
                }
            } else {
                at.push(a_side as f64 / (a_side as f64 - b_side as f64));
            }
        }
    }

    /// Whether a closed ring lies inside and does not touch the border.
    pub fn holds(&self, ring: &Ring) -> bool {
        let mut at = Vec::new();
        ring_edges(ring).all(|[a, b]| {
            self.crossings(a, b, &mut at);
            at.is_empty()
        }) && ring.first().is_some_and(|&p| self.contains(p))
    }

    /// Calls `piece` with the parts of a closed ring between its corners and the border, in order: the
    /// index of the edge, the shares of its length where the part begins and ends, and whether it is
    /// inside.
    pub fn cut(&self, ring: &Ring, mut piece: impl FnMut(usize, f64, f64, bool)) {
        let mut at = Vec::new();
        let mut known = None;
        for (i, [a, b]) in ring_edges(ring).enumerate() {
            at.clear();
            self.crossings(a, b, &mut at);
            if at.is_empty() {
                let inside = known.unwrap_or_else(|| self.contains(a));
                known = Some(inside);
                piece(i, 0.0, 1.0, inside);
                continue;
            }
            at.push(1.0);
            at.sort_unstable_by(f64::total_cmp);
            let mut from = 0.0;
            for &to in at.iter().filter(|&&t| t > 0.0) {
                if to > from {
                    piece(i, from, to, self.contains(between(a, b, 0.5 * (from + to))));
                    from = to;
                }
            }
            // The next edge meets no edge only where this one's end is off the border.
            known = None;
        }
    }

    /// Length of the closed rings' parts that lie inside \[nm\].
    pub fn length_inside<'a>(&self, rings: impl IntoIterator<Item = &'a Ring>) -> f64 {
        let mut sum = 0.0;
        for ring in rings {
            self.cut(ring, |i, from, to, inside| {
                if inside {
                    sum += (to - from) * ring[i].distance(ring[if i + 1 == ring.len() { 0 } else { i + 1 }]);
                }
            });
        }
        sum
    }

    /// Whether the segment (a, b) lies within `distance` \[nm\] of one edge. `hint` is where the answer was
    /// found last; neighbours in a ring are near the same or neighbouring edges.
    pub fn within(&self, a: Point2, b: Point2, distance: f64, hint: &mut usize) -> bool {
        let limit = distance * distance;
        // Distance from a segment is convex, so that both ends speak for what is between them.
        let close =
            |[c, d]: [Point2; 2]| offset::distance2(a, c, d) <= limit && offset::distance2(b, c, d) <= limit;
        let n = self.edges.len();
        for i in *hint..(*hint + 4).min(n) {
            if close(self.edges[i]) {
                *hint = i;
                return true;
            }
        }
        let reach = distance as i32;
        let (low, high) = (a.y.min(b.y).saturating_sub(reach), a.y.max(b.y).saturating_add(reach));
        let (first, last) = self.rows(low, high);
        let range = self.starts[first] as usize..self.starts[last + 1] as usize;
        let found = self.in_rows[range].iter().find(|&&i| close(self.edges[i as usize]));
        if let Some(&i) = found {
            *hint = i as usize;
        }
        found.is_some()
    }
}

/// Areas \[nm\] and their edges.
#[derive(Debug)]
pub struct Cover<'a> {
    areas: &'a [ExPolygon],
    edges: Edges,
}

impl<'a> Cover<'a> {
    /// Sorts the edges of `areas`.
    pub fn new(areas: &'a [ExPolygon]) -> Self {
        Self { areas, edges: Edges::new(areas) }
    }

    /// The areas.
    pub fn areas(&self) -> &'a [ExPolygon] {
        self.areas
    }

    /// Their edges.
    pub fn edges(&self) -> &Edges {
        &self.edges
    }

    /// Whether all that closed rings bound, by an odd number of them, lies inside and does not touch the
    /// border.
    pub fn holds(&self, rings: &[&Ring]) -> bool {
        if !rings.iter().all(|ring| self.edges.holds(ring)) {
            return false;
        }
        // No border is crossed, so that every hole lies as a whole inside or outside of the rings.
        let holes = self.areas.iter().flat_map(|p| &p.holes).filter_map(|hole| hole.first());
        holes.into_iter().all(|&p| rings.iter().filter(|r| surrounds(r, p)).count() % 2 == 0)
    }
}

/// Whether a point is inside a ring.
fn surrounds(ring: &Ring, p: Point2) -> bool {
    let mut inside = false;
    let Some(mut a) = ring.last().copied() else { return false };
    for &b in ring {
        if (a.y <= p.y) != (b.y <= p.y) && (lattice::cross(a, b, p) > 0) == (a.y <= p.y) {
            inside = !inside;
        }
        a = b;
    }
    inside
}

/// The edges of a closed ring, from its first point on.
pub fn ring_edges(ring: &Ring) -> impl Iterator<Item = [Point2; 2]> + '_ {
    let ends = ring.iter().skip(1).chain(ring.first());
    ring.iter().zip(ends).map(|(&a, &b)| [a, b])
}

/// The point at share `t` of the way from `a` to `b`. The way is rounded before it is added, so that the
/// result moves with its input.
pub fn between(a: Point2, b: Point2, t: f64) -> Point2 {
    let (dx, dy) = b.minus(a);
    let part = |c: i32, d: i64| (i64::from(c) + (d as f64 * t).round() as i64) as i32;
    Point2::new(part(a.x, dx), part(a.y, dy))
}
