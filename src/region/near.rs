//! Which edges of an area lie near a place.

use crate::contour::Ring;
use crate::lattice::Point2;

/// An edge, relative to the origin of its [`Edges`] \[nm\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// Start.
    pub x: f64,
    pub y: f64,
    /// Unit direction; the area lies on its left.
    pub ux: f64,
    pub uy: f64,
    /// Length.
    pub length: f64,
    /// The edge of the same ring that ends where this one starts.
    pub before: u32,
    /// Bounds in y.
    low: f64,
    high: f64,
    /// The first strip that it touches.
    strip: u32,
}

/// The edges of some rings, sorted into vertical strips.
///
/// The borders of a layer mostly run around it, so that a strip a millimetre wide meets few of them, and
/// a list per strip is built and asked in less time than a grid is cleared.
#[derive(Clone, Debug, Default)]
pub(super) struct Edges {
    /// Ring after ring, each in its own order.
    pub all: Vec<Edge>,
    left: f64,
    /// Where each strip's entries begin, and where the last one's end.
    starts: Vec<u32>,
    entries: Vec<u32>,
}

/// Width of a strip \[nm\].
const STRIP: f64 = 1e6;

/// Most strips; further ones share the last.
const MOST_STRIPS: usize = 4096;

impl Edges {
    /// The edges of closed rings, relative to `origin`. Edges without length are left out.
    pub fn new<'a>(rings: impl Iterator<Item = &'a Ring>, origin: Point2) -> Self {
        let mut all: Vec<Edge> = Vec::new();
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for ring in rings {
            let first = all.len();
            for (i, p) in ring.iter().enumerate() {
                let (dx, dy) = ring[if i + 1 == ring.len() { 0 } else { i + 1 }].minus(*p);
                let ((x, y), (dx, dy)) = (p.minus(origin), (dx as f64, dy as f64));
                let (x, y) = (x as f64, y as f64);
                let length = (dx * dx + dy * dy).sqrt();
                if length <= 0.0 {
                    continue;
                }
                (left, right) = (left.min(x), right.max(x));
                all.push(Edge {
                    x,
                    y,
                    ux: dx / length,
                    uy: dy / length,
                    length,
                    before: (all.len() as u32).wrapping_sub(1),
                    low: y.min(y + dy),
                    high: y.max(y + dy),
                    strip: 0,
                });
            }
            let last = all.len();
            if let Some(edge) = all.get_mut(first) {
                edge.before = (last - 1) as u32;
            }
        }
        if all.is_empty() {
            return Self::default();
        }
        let strips = (((right - left) / STRIP) as usize + 1).min(MOST_STRIPS);
        let mut edges = Self { all, left, starts: vec![0; strips + 1], entries: Vec::new() };
        for i in 0..edges.all.len() {
            let (from, to) = edges.strips(edges.all[i].x, edges.all[i].end().0);
            edges.all[i].strip = from as u32;
            edges.starts[from..=to].iter_mut().for_each(|n| *n += 1);
        }
        let mut end = 0;
        for start in &mut edges.starts {
            end += *start;
            *start = end;
        }
        // Filled from the back, so that every start arrives where it belongs.
        edges.entries = vec![0; end as usize];
        for i in (0..edges.all.len()).rev() {
            let (from, to) = edges.strips(edges.all[i].x, edges.all[i].end().0);
            for start in &mut edges.starts[from..=to] {
                *start -= 1;
                edges.entries[*start as usize] = i as u32;
            }
        }
        edges
    }

    fn strips(&self, x0: f64, x1: f64) -> (usize, usize) {
        let last = self.starts.len().saturating_sub(2);
        let strip = |x: f64| (((x - self.left) / STRIP).max(0.0) as usize).min(last);
        (strip(x0.min(x1)), strip(x0.max(x1)))
    }

    /// The edges whose boxes meet the one from `low` to `high`, each once.
    pub fn near(&self, low: (f64, f64), high: (f64, f64), found: &mut Vec<u32>) {
        found.clear();
        if self.all.is_empty() {
            return;
        }
        let (from, to) = self.strips(low.0, high.0);
        for strip in from..=to {
            let entries = self.starts[strip] as usize..self.starts[strip + 1] as usize;
            found.extend(self.entries[entries].iter().copied().filter(|&i| {
                let edge = &self.all[i as usize];
                edge.high >= low.1 && edge.low <= high.1 && strip == from.max(edge.strip as usize)
            }));
        }
    }

    /// Whether no edge comes nearer to a place than `distance`; `found` is scratch.
    pub fn clear_of(&self, x: f64, y: f64, distance: f64, found: &mut Vec<u32>) -> bool {
        self.near((x - distance, y - distance), (x + distance, y + distance), found);
        found.iter().all(|&i| self.all[i as usize].distance2(x, y) >= distance * distance)
    }
}

impl Edge {
    /// Where the edge ends.
    pub fn end(&self) -> (f64, f64) {
        self.at(self.length)
    }

    /// The place `way` along the edge.
    pub fn at(&self, way: f64) -> (f64, f64) {
        (self.x + way * self.ux, self.y + way * self.uy)
    }

    /// Squared distance of a place from the edge.
    fn distance2(&self, x: f64, y: f64) -> f64 {
        let (vx, vy) = (x - self.x, y - self.y);
        let along = (vx * self.ux + vy * self.uy).clamp(0.0, self.length);
        let (wx, wy) = (vx - along * self.ux, vy - along * self.uy);
        wx * wx + wy * wy
    }
}
