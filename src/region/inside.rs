//! Which parts of a line lie inside areas: edges sorted into cells, exact crossings.

use super::offset;
use crate::contour::{ExPolygon, Ring};
use crate::lattice::{self, Point2};

/// The edges of disjoint areas \[nm\] in square cells, for questions about points and lines.
#[derive(Debug)]
pub struct Edges {
    /// In the order of the rings.
    edges: Vec<[Point2; 2]>,
    /// Where each cell's part of `in_cells` begins, row by row, and where the last ends.
    starts: Vec<u32>,
    /// Indices of the edges that pass through each cell, with [`FIRST`].
    in_cells: Vec<u32>,
    low: Point2,
    /// Cells are 2^shift nm wide.
    shift: u32,
    columns: usize,
    rows: usize,
}

/// Marks the first cell of an edge in each row, from the left.
const FIRST: u32 = 1 << 31;

/// Least width of a cell, as a power of two \[nm\].
const LEAST_SHIFT: u32 = 12;

impl Edges {
    /// Sorts the edges of `areas`.
    pub fn new(areas: &[ExPolygon]) -> Self {
        let rings = || areas.iter().flat_map(ExPolygon::rings);
        let mut edges = Vec::with_capacity(rings().map(Vec::len).sum());
        rings().for_each(|ring| edges.extend(ring_edges(ring)));
        let (low, high) = bounds(edges.iter().map(|e| e[0]));
        let (width, height) = (high.x.abs_diff(low.x), high.y.abs_diff(low.y));
        let cells = |shift: u32| ((width >> shift) as usize + 1) * ((height >> shift) as usize + 1);
        let mut shift = LEAST_SHIFT;
        while cells(shift) > 2 * edges.len().max(1) {
            shift += 1;
        }
        let (columns, rows) = ((width >> shift) as usize + 1, (height >> shift) as usize + 1);
        let starts = vec![0; columns * rows + 1];
        let mut all = Self { edges, starts, in_cells: Vec::new(), low, shift, columns, rows };
        let mut starts = std::mem::take(&mut all.starts);
        for &[a, b] in &all.edges {
            all.pass(a, b, |from, to| starts[from..to].iter_mut().for_each(|n| *n += 1));
        }
        let mut sum = 0;
        for n in &mut starts {
            sum += *n;
            *n = sum;
        }
        let mut in_cells = vec![0; sum as usize];
        // From the last to the first, so that every cell keeps the order of the rings.
        for (i, &[a, b]) in all.edges.iter().enumerate().rev() {
            all.pass(a, b, |from, to| {
                for (cell, start) in (from..to).zip(&mut starts[from..to]) {
                    *start -= 1;
                    in_cells[*start as usize] = i as u32 | if cell == from { FIRST } else { 0 };
                }
            });
        }
        (all.starts, all.in_cells) = (starts, in_cells);
        all
    }

    /// The row at a height, or the column at an X, cut off at the ends of the table.
    fn row(&self, y: i32) -> usize {
        if y > self.low.y { ((y.abs_diff(self.low.y) >> self.shift) as usize).min(self.rows - 1) } else { 0 }
    }

    fn column(&self, x: i32) -> usize {
        let last = self.columns - 1;
        if x > self.low.x { ((x.abs_diff(self.low.x) >> self.shift) as usize).min(last) } else { 0 }
    }

    /// Calls `cells` with the range of cells in each row that the segment (a, b) passes through.
    fn pass(&self, a: Point2, b: Point2, mut cells: impl FnMut(usize, usize)) {
        let (left, right) = (a.x.min(b.x), a.x.max(b.x));
        let (first, last) = (self.row(a.y.min(b.y)), self.row(a.y.max(b.y)));
        let (from, to) = (self.column(left), self.column(right));
        if first == last || from == to {
            for row in first..=last {
                cells(row * self.columns + from, row * self.columns + to + 1);
            }
            return;
        }
        let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
        let (dx, dy) = high.minus(low);
        let slope = dx as f64 / dy as f64;
        for row in first..=last {
            // The part of the segment in this row, a little longer than it is.
            let up = |row: usize| {
                let way = ((row as u64) << self.shift) as i64 + i64::from(self.low.y) - i64::from(low.y);
                way.clamp(0, dy) as f64 * slope
            };
            let start = if row == first { 0.0 } else { up(row) };
            let end = if row == last { dx as f64 } else { up(row + 1) };
            let at = |by: f64| ((f64::from(low.x) + by) as i32).clamp(left, right);
            let (from, to) = (at(start.min(end) - 2.0), at(start.max(end) + 2.0));
            cells(row * self.columns + self.column(from), row * self.columns + self.column(to) + 1);
        }
    }

    /// Whether a point is inside; on the border either.
    pub fn contains(&self, p: Point2) -> bool {
        let row = self.row(p.y) * self.columns;
        let range = self.starts[row] as usize..self.starts[row + self.column(p.x) + 1] as usize;
        let mut inside = false;
        for &i in self.in_cells[range].iter().filter(|&&i| i & FIRST != 0) {
            let [a, b] = self.edges[(i & !FIRST) as usize];
            // Does it cross the line that runs from p to the left?
            let rises = a.y <= p.y && p.y < b.y;
            let falls = b.y <= p.y && p.y < a.y;
            if rises && lattice::cross(a, b, p) < 0 || falls && lattice::cross(a, b, p) > 0 {
                inside = !inside;
            }
        }
        inside
    }

    /// Where the segment (a, b) meets edges, as shares of its length: added to `at`, unsorted, some of
    /// them several times.
    fn crossings(&self, a: Point2, b: Point2, at: &mut Vec<f64>) {
        self.pass(a, b, |from, to| {
            let range = self.starts[from] as usize..self.starts[to] as usize;
            for &i in &self.in_cells[range] {
                meet(a, b, self.edges[(i & !FIRST) as usize], at);
            }
        });
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
                    piece(i, from, to, self.contains(a.toward(b, 0.5 * (from + to))));
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
        let low = |a: i32, b: i32| a.min(b).saturating_sub(reach);
        let high = |a: i32, b: i32| a.max(b).saturating_add(reach);
        let (from, to) = (self.column(low(a.x, b.x)), self.column(high(a.x, b.x)));
        for row in self.row(low(a.y, b.y))..=self.row(high(a.y, b.y)) {
            let row = row * self.columns;
            let range = self.starts[row + from] as usize..self.starts[row + to + 1] as usize;
            let edges = self.in_cells[range].iter().map(|i| (i & !FIRST) as usize);
            if let Some(i) = edges.into_iter().find(|&i| close(self.edges[i])) {
                *hint = i;
                return true;
            }
        }
        false
    }
}

/// Adds the shares of the segment (a, b) at which it meets the edge (c, d).
fn meet(a: Point2, b: Point2, [c, d]: [Point2; 2], at: &mut Vec<f64>) {
    let apart = c.x.max(d.x) < a.x.min(b.x)
        || c.x.min(d.x) > a.x.max(b.x)
        || c.y.max(d.y) < a.y.min(b.y)
        || c.y.min(d.y) > a.y.max(b.y);
    if apart {
        return;
    }
    let (c_side, d_side) = (lattice::cross(a, b, c), lattice::cross(a, b, d));
    if c_side > 0 && d_side > 0 || c_side < 0 && d_side < 0 {
        return;
    }
    let (a_side, b_side) = (lattice::cross(c, d, a), lattice::cross(c, d, b));
    if a_side > 0 && b_side > 0 || a_side < 0 && b_side < 0 {
        return;
    }
    if a_side == b_side {
        // On one line: what is inside changes where the edge ends.
        let (ux, uy) = b.minus(a);
        let length2 = (ux * ux + uy * uy).max(1) as f64;
        for p in [c, d] {
            let (vx, vy) = p.minus(a);
            at.push(((ux * vx + uy * vy) as f64 / length2).clamp(0.0, 1.0));
        }
    } else {
        at.push(a_side as f64 / (a_side as f64 - b_side as f64));
    }
}

/// The lowest and the highest coordinates; the origin without any point.
pub fn bounds(points: impl IntoIterator<Item = Point2>) -> (Point2, Point2) {
    let mut points = points.into_iter();
    let first = points.next().unwrap_or_default();
    points.fold((first, first), |(low, high), p| {
        (Point2::new(low.x.min(p.x), low.y.min(p.y)), Point2::new(high.x.max(p.x), high.y.max(p.y)))
    })
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
