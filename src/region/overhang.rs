//! Walls that run over air.

use super::Island;
use super::Wall;
use super::inside::{Cover, Edges};
use super::offset::{self, Join};
use crate::contour::{ExPolygon, Ring};
use std::cell::OnceCell;

/// The layer below, as far as walls lie on it.
pub struct Support<'a> {
    below: Cover<'a>,
    /// How far a wall's centre line may lie outside the layer below \[nm\].
    reach: i64,
    /// The layer below grown by that.
    grown: OnceCell<Edges>,
}

impl<'a> Support<'a> {
    /// The areas `below`; walls whose centre line lies more than `reach` \[nm\] outside hang in air.
    pub fn new(below: &'a [ExPolygon], reach: i64) -> Self {
        Self { below: Cover::new(below), reach, grown: OnceCell::new() }
    }

    /// Flags the parts of an island's walls that hang in air, and gives them corners where those begin
    /// and end.
    pub fn flag(&self, island: &mut Island) {
        let outer = island.walls.iter().filter(|w| w.depth == 0).map(|w| &w.ring);
        // What lies inside these does so too.
        if self.below.holds(&outer.collect::<Vec<_>>()) || self.reaches(&island.walls) {
            return;
        }
        let grow = || offset::outset(self.below.areas(), self.reach, Join::Miter);
        let grown = self.grown.get_or_init(|| Edges::new(&grow()));
        let least = self.reach as f64;
        island.walls.iter_mut().for_each(|wall| flag(wall, grown, least));
    }
}

impl Support<'_> {
    /// Whether all parts of walls outside of the layer below are easily seen to be within reach of it.
    fn reaches(&self, walls: &[Wall]) -> bool {
        let (edges, reach, mut hint) = (self.below.edges(), self.reach as f64, 0);
        walls.iter().all(|wall| {
            let ring = &wall.ring;
            let end = |i: usize| ring[if i + 1 == ring.len() { 0 } else { i + 1 }];
            let mut near = true;
            edges.cut(ring, |i, from, to, inside| {
                if near && !inside {
                    let (a, b) = (ring[i].toward(end(i), from), ring[i].toward(end(i), to));
                    near = edges.within(a, b, reach, &mut hint);
                }
            });
            near
        })
    }
}

/// A part of a wall, all of it supported or all of it not.
struct Part {
    /// Edge and share of its length where the part begins.
    edge: usize,
    from: f64,
    length: f64,
    hangs: bool,
}

/// Flags what of a wall lies outside of `support`; parts shorter than `least` \[nm\] count to their
/// neighbours.
fn flag(wall: &mut Wall, support: &Edges, least: f64) {
    let ring = &wall.ring;
    let end = |i: usize| ring[if i + 1 == ring.len() { 0 } else { i + 1 }];
    let mut parts: Vec<Part> = Vec::new();
    support.cut(ring, |edge, from, to, inside| {
        let length = (to - from) * ring[edge].distance(end(edge));
        match parts.last_mut() {
            Some(last) if last.hangs != inside => last.length += length,
            _ => parts.push(Part { edge, from, length, hangs: !inside }),
        }
    });
    // First what hangs for a moment only, then what lies on something for a moment.
    for hangs in [true, false] {
        merge(&mut parts, hangs, least);
    }
    wall.overhang.clear();
    if parts.iter().all(|p| !p.hangs) {
        return;
    }
    if parts.len() == 1 {
        wall.overhang = vec![true; ring.len()];
        return;
    }
    let mut next = parts.iter().peekable();
    // The ring's first edge belongs to the last part when that runs on across its start.
    let mut hangs = parts.last().is_some_and(|p| p.hangs);
    let (mut points, mut flags) = (Ring::with_capacity(ring.len() + parts.len()), Vec::new());
    for (i, &a) in ring.iter().enumerate() {
        points.push(a);
        flags.push(hangs);
        while let Some(part) = next.next_if(|p| p.edge == i) {
            hangs = part.hangs;
            let p = a.toward(end(i), part.from);
            if points.last() == Some(&p) {
                flags.pop();
                flags.push(hangs);
            } else if p != end(i) {
                points.push(p);
                flags.push(hangs);
            }
        }
    }
    (wall.ring, wall.overhang) = (points, flags);
    if !wall.overhang.contains(&true) {
        wall.overhang.clear();
    }
}

/// Gives parts shorter than `least` that hang, or do not, to their neighbours. The ring is closed: its
/// last part runs on in its first where both are alike.
fn merge(parts: &mut Vec<Part>, hangs: bool, least: f64) {
    let n = parts.len();
    if n < 2 {
        return;
    }
    let joined = parts[0].hangs == parts[n - 1].hangs;
    let around = parts[0].length + parts[n - 1].length;
    for (i, part) in parts.iter_mut().enumerate() {
        let length = if joined && (i == 0 || i + 1 == n) { around } else { part.length };
        if part.hangs == hangs && length < least {
            part.hangs = !hangs;
        }
    }
    parts.dedup_by(|part, last| {
        let same = part.hangs == last.hangs;
        if same {
            last.length += part.length;
        }
        same
    });
}
