//! Rings that do not touch → areas with holes, by one exact sweep.
//!
//! A line sweeps over the vertices in the order of (x, y), keeping the edges that it meets sorted from
//! bottom to top. Edges that become neighbours are tested with exact integers, in the manner of Shamos
//! and Hoey, "Geometric intersection problems" (1976). If no two edges touch, the winding number and
//! the enclosing ring at each ring's first vertex are those of the edge just below it.

use super::{ExPolygon, Ring};
use crate::lattice::{Point2, cross};
use std::cmp::Ordering;

/// The areas bounded by closed rings \[nm\] with solid on their left, if no two edges touch.
///
/// A point is inside when the rings wind around it at least once; rings between two insides or two
/// outsides vanish. Contours of the result run counter-clockwise, holes clockwise, each ring starts at
/// its smallest point, holes and polygons are sorted. Rings of fewer than three points are dropped.
///
/// # Errors
/// The rings themselves, unchanged, when edges cross, overlap, have no length, or touch other than in
/// the vertex that neighbours of one ring share.
pub fn nest(rings: Vec<Ring>) -> Result<Vec<ExPolygon>, Vec<Ring>> {
    if let [ring] = rings.as_slice()
        && let Some(start) = convex(ring)
    {
        let places = [Place { start, fate: Fate::Contour }];
        return Ok(assemble(rings, &places));
    }
    match Sweep::new(&rings).run() {
        Some(places) => Ok(assemble(rings, &places)),
        None => Err(rings),
    }
}

/// Where a convex counter-clockwise ring is smallest; `None` for other rings.
///
/// Left turns all along with one smallest point are one turn in all, so such a ring needs no sweep.
fn convex(ring: &[Point2]) -> Option<u32> {
    let n = ring.len();
    let (mut a, mut b) = (*ring.get(n.checked_sub(2)?)?, *ring.last()?);
    let mut start = None;
    for (i, &c) in ring.iter().enumerate() {
        if cross(a, b, c) <= 0 {
            return None;
        }
        if b < a && b < c && start.replace(if i == 0 { n - 1 } else { i - 1 } as u32).is_some() {
            return None;
        }
        (a, b) = (b, c);
    }
    start
}

/// Where a ring ended up.
#[derive(Clone, Copy, Debug, Default)]
struct Place {
    /// Index of the vertex with the smallest (x, y).
    start: u32,
    /// What becomes of the ring.
    fate: Fate,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Fate {
    /// Not the border of an area.
    #[default]
    Dropped,
    /// The contour of an area.
    Contour,
    /// A hole in the area of this ring.
    HoleOf(u32),
}

/// An edge on the sweep line, directed by (x, y).
#[derive(Clone, Copy, Debug)]
struct Edge {
    left: Point2,
    right: Point2,
    ring: u32,
    /// Index of the vertex at `right`.
    head: u32,
    /// Winding number just above the edge.
    above: i32,
    /// The area that lies just above the edge, by its contour ring; `OUTSIDE` for none.
    area: u32,
}

const OUTSIDE: u32 = u32::MAX;

/// A vertex, sorted by its place: x and y as one number.
type Event = (u64, u32, u32);

struct Sweep<'a> {
    rings: &'a [Ring],
    events: Vec<Event>,
    line: Vec<Edge>,
    places: Vec<Place>,
}

fn key(p: Point2) -> u64 {
    let part = |c: i32| u64::from(c.cast_unsigned() ^ 1 << 31);
    part(p.x) << 32 | part(p.y)
}

impl<'a> Sweep<'a> {
    fn new(rings: &'a [Ring]) -> Self {
        let mut events = Vec::with_capacity(rings.iter().map(Vec::len).sum());
        for (r, ring) in rings.iter().enumerate().filter(|(_, ring)| ring.len() > 2) {
            events.extend(ring.iter().enumerate().map(|(i, &p)| (key(p), r as u32, i as u32)));
        }
        events.sort_unstable();
        Self { rings, events, line: Vec::new(), places: vec![Place::default(); rings.len()] }
    }

    fn run(mut self) -> Option<Vec<Place>> {
        let mut started = vec![false; self.rings.len()];
        for e in 0..self.events.len() {
            let (place, r, i) = self.events[e];
            // Every touch of vertices ends here, so the sweep below knows none.
            if self.events.get(e + 1).is_some_and(|next| next.0 == place) {
                return None;
            }
            let ring = &self.rings[r as usize];
            let n = ring.len();
            let (v, at) = (ring[i as usize], i as usize);
            let (before, after) =
                (if at == 0 { n - 1 } else { at - 1 }, if at + 1 == n { 0 } else { at + 1 });
            let (p, q) = (ring[before], ring[after]);
            let first = !std::mem::replace(&mut started[r as usize], true);
            if first {
                self.places[r as usize].start = i;
            }
            match (p < v, q < v) {
                (false, false) => self.open(v, (p, before as u32), (q, after as u32), r, first)?,
                (true, true) => self.close(v, r, i)?,
                (true, false) => self.pass(v, (q, after as u32), r, i)?,
                (false, true) => self.pass(v, (p, before as u32), r, i)?,
            }
        }
        Some(self.places)
    }

    /// Where on the line the edge into vertex `i` of ring `r` at `v` is; `None` when another one passes
    /// there.
    fn find(&self, v: Point2, r: u32, i: u32) -> Option<usize> {
        let at = self.line.partition_point(|e| cross(e.left, e.right, v) > 0);
        let edge = self.line.get(at)?;
        (edge.ring == r && edge.head == i).then_some(at)
    }

    /// Both edges at `v` begin there.
    fn open(&mut self, v: Point2, p: (Point2, u32), q: (Point2, u32), r: u32, first: bool) -> Option<()> {
        let at = self.line.partition_point(|e| cross(e.left, e.right, v) > 0);
        if self.line.get(at).is_some_and(|e| cross(e.left, e.right, v) == 0) {
            return None;
        }
        let below = at.checked_sub(1).map(|b| self.line[b]);
        let (winding, area) = below.map_or((0, OUTSIDE), |e| (e.above, e.area));
        // The ring comes from p and leaves to q: at a left turn here the edge to q is the lower one.
        let (low, high, step) = match cross(p.0, v, q.0).cmp(&0) {
            Ordering::Equal => return None,
            Ordering::Greater => (q, p, 1),
            Ordering::Less => (p, q, -1),
        };
        if first {
            self.places[r as usize].fate = match (winding, step) {
                (0, 1) => Fate::Contour,
                (1, -1) => Fate::HoleOf(area),
                _ => Fate::Dropped,
            };
        }
        let between = match self.places[r as usize].fate {
            Fate::Dropped => area,
            Fate::Contour if step == 1 => r,
            Fate::Contour => OUTSIDE,
            Fate::HoleOf(area) if step == 1 => area,
            Fate::HoleOf(_) => OUTSIDE,
        };
        let edge = |to: (Point2, u32), above: i32, area: u32| Edge {
            left: v,
            right: to.0,
            ring: r,
            head: to.1,
            above,
            area,
        };
        let pair = [edge(low, winding + step, between), edge(high, winding, area)];
        if let Some(below) = below {
            self.clear(&below, &pair[0])?;
        }
        if let Some(above) = self.line.get(at) {
            self.clear(&pair[1], above)?;
        }
        self.line.splice(at..at, pair);
        Some(())
    }

    /// One edge at `v` ends, the other begins.
    fn pass(&mut self, v: Point2, to: (Point2, u32), r: u32, i: u32) -> Option<()> {
        let at = self.find(v, r, i)?;
        let edge = Edge { left: v, right: to.0, head: to.1, ..self.line[at] };
        if at > 0 {
            self.clear(&self.line[at - 1], &edge)?;
        }
        if let Some(above) = self.line.get(at + 1) {
            self.clear(&edge, above)?;
        }
        self.line[at] = edge;
        Some(())
    }

    /// Both edges at `v` end there.
    fn close(&mut self, v: Point2, r: u32, i: u32) -> Option<()> {
        let at = self.find(v, r, i)?;
        let partner = self.line.get(at + 1)?;
        if partner.ring != r || partner.head != i {
            return None;
        }
        self.line.drain(at..at + 2);
        if at > 0 && at < self.line.len() {
            self.clear(&self.line[at - 1], &self.line[at])?;
        }
        Some(())
    }

    /// That an edge which starts out below another one stays there, which is decided where the first of
    /// the two ends.
    fn clear(&self, low: &Edge, high: &Edge) -> Option<()> {
        let apart = match low.right.cmp(&high.right) {
            Ordering::Less => cross(high.left, high.right, low.right) < 0,
            Ordering::Greater => cross(low.left, low.right, high.right) > 0,
            Ordering::Equal => low.ring == high.ring && low.head == high.head,
        };
        apart.then_some(())
    }
}

/// Rings that stay, grouped.
fn assemble(rings: Vec<Ring>, places: &[Place]) -> Vec<ExPolygon> {
    let mut slot = vec![0usize; rings.len()];
    let mut polygons: Vec<ExPolygon> = Vec::new();
    let mut holes: Vec<(u32, Ring)> = Vec::new();
    for (r, (mut ring, place)) in rings.into_iter().zip(places).enumerate() {
        if place.fate == Fate::Dropped {
            continue;
        }
        ring.rotate_left(place.start as usize);
        match place.fate {
            Fate::HoleOf(area) => holes.push((area, ring)),
            _ => {
                slot[r] = polygons.len();
                polygons.push(ExPolygon { contour: ring, holes: Vec::new() });
            }
        }
    }
    for (area, ring) in holes {
        if let Some(polygon) = slot.get(area as usize).and_then(|&s| polygons.get_mut(s)) {
            polygon.holes.push(ring);
        }
    }
    for polygon in &mut polygons {
        polygon.holes.sort_unstable();
    }
    polygons.sort_unstable_by(|a, b| a.contour.cmp(&b.contour));
    polygons
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(points: &[(i32, i32)]) -> Ring {
        points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    #[test]
    fn convex_rings_need_no_sweep() {
        let square = ring(&[(2, 2), (0, 2), (0, 0), (2, 0)]);
        assert_eq!(convex(&square), Some(2));
        for start in 0..4 {
            let mut turned = square.clone();
            turned.rotate_left(start);
            assert_eq!(
                nest(vec![turned]).unwrap_or_default()[0].contour,
                ring(&[(0, 0), (2, 0), (2, 2), (0, 2)])
            );
        }
        // A clockwise ring, a notch, a straight corner, a ring that runs around twice, nothing.
        assert_eq!(convex(&ring(&[(0, 0), (0, 2), (2, 2), (2, 0)])), None);
        assert_eq!(convex(&ring(&[(0, 0), (4, 0), (4, 4), (3, 1)])), None);
        assert_eq!(convex(&ring(&[(0, 0), (1, 0), (2, 0), (2, 2)])), None);
        assert_eq!(convex(&ring(&[(0, 0), (4, 0), (4, 4), (0, 4), (1, 1), (3, 1), (3, 3), (1, 3)])), None);
        assert_eq!(convex(&ring(&[(0, 0), (9, 3), (0, 6), (6, 0), (6, 7)])), None, "a pentagram");
        assert_eq!(convex(&[]), None);
    }
}
