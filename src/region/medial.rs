//! The medial axis of the narrow parts of an area.
//!
//! Through every point of the border goes one largest disc that lies inside and touches the border
//! there; the centres of those discs are the medial axis, their radii half the width. A disc that
//! touches the border at `p`, with the normal `n` inwards, meets a point `q` when its radius is
//! |q - p|² / (2 n (q - p)), and a line in closed form too, so one pass over the edges nearby gives the
//! disc exactly (compare Ma, Bae & Choi, "3D medial axis point approximation using nearest neighbors and
//! the normal field", The Visual Computer 28, 2012). Walking along the border yields the axis in order,
//! once from either side, of which one is kept. No triangulation is needed, and nothing is done where
//! the area is wide.

use super::near::{Edge, Edges};

/// A point of the medial axis, relative to the origin of the edges \[nm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Centre of the disc.
    pub x: f64,
    pub y: f64,
    /// Its radius: half the width of the area there.
    pub r: f64,
}

impl Node {
    /// Whether the discs on the way straight to `other`, their radii changing evenly, reach over the
    /// border by no more than `slack` \[nm\]; `found` is scratch.
    pub fn leads_to(&self, other: &Self, edges: &Edges, slack: f64, found: &mut Vec<u32>) -> bool {
        let way = self.distance(other);
        let count = (4.0 * way / STEP).ceil().min(16.0);
        (1..count as u32).all(|k| {
            let t = f64::from(k) / count;
            let mix = |a: f64, b: f64| a + t * (b - a);
            let r = mix(self.r, other.r) - slack;
            edges.clear_of(mix(self.x, other.x), mix(self.y, other.y), r, found)
        })
    }

    /// Distance between the centres of two discs.
    pub fn distance(&self, other: &Self) -> f64 {
        let (dx, dy) = (self.x - other.x, self.y - other.y);
        (dx * dx + dy * dy).sqrt()
    }
}

/// Points of the border are looked at this far apart \[nm\].
pub(super) const STEP: f64 = 200_000.0;

/// How often the step at the end of an axis is halved to find where it ends.
const HALVINGS: u32 = 4;

/// Cosine of the least angle at a disc's centre between the two points that it touches: 120 degrees.
/// It is 180 in a straight channel and less 2 a where the sides meet at the angle 2 a; discs in corners
/// of more than 60 degrees, from which the axis would send a spur into each, lie below.
const OPPOSITE: f64 = -0.5;

/// Largest cosine of the angle between edges that may bound a channel: where discs touch corners, their
/// edges may stand at a right angle to it.
const FACING: f64 = 0.05;

/// Edges nearer than this in front of a border point touch it \[nm\].
const TOUCHING: f64 = 0.5;

/// The pieces of the medial axis of the area bounded by `edges` whose discs have a radius within
/// `radii` and pass `keep`, and between them reach over the border by no more than `slack`; each in the order of the border on one of its sides.
pub(super) fn axis(
    edges: &Edges,
    radii: std::ops::RangeInclusive<f64>,
    slack: f64,
    keep: impl FnMut(&Node) -> bool,
) -> Vec<Vec<Node>> {
    let mut walk = Walk {
        edges,
        least: *radii.start(),
        most: *radii.end(),
        slack,
        keep,
        near: Vec::new(),
        ahead: Vec::new(),
        found: Vec::new(),
        piece: Vec::new(),
        pieces: Vec::new(),
    };
    let mut run = Run::default();
    for (i, edge) in edges.all.iter().enumerate() {
        let count = (edge.length / LONGEST).ceil().max(1.0);
        for part in 0..count as u32 {
            let ends = [f64::from(part), f64::from(part) + 1.0].map(|k| k * edge.length / count);
            let (from, to) = (edge.at(ends[0]), edge.at(ends[1]));
            if !run.takes(from, to) {
                walk.run(&mut run);
                run.takes(from, to);
            }
            run.parts.push((i as u32, ends[0], ends[1]));
        }
    }
    walk.run(&mut run);
    walk.flush();
    walk.pieces
}

/// Parts of the border that are looked at together are at most this large \[nm\].
const LONGEST: f64 = 1e6;

/// Consecutive parts of the border and the box around them.
#[derive(Default)]
struct Run {
    parts: Vec<(u32, f64, f64)>,
    low: (f64, f64),
    high: (f64, f64),
}

impl Run {
    /// Grows the box by a part, unless it would become too large.
    fn takes(&mut self, a: (f64, f64), b: (f64, f64)) -> bool {
        let (mut low, mut high) = ((a.0.min(b.0), a.1.min(b.1)), (a.0.max(b.0), a.1.max(b.1)));
        if !self.parts.is_empty() {
            low = (low.0.min(self.low.0), low.1.min(self.low.1));
            high = (high.0.max(self.high.0), high.1.max(self.high.1));
            if high.0 - low.0 > LONGEST || high.1 - low.1 > LONGEST {
                return false;
            }
        }
        (self.low, self.high) = (low, high);
        true
    }
}

struct Walk<'a, F> {
    edges: &'a Edges,
    least: f64,
    most: f64,
    slack: f64,
    keep: F,
    /// The edges near the run in hand.
    near: Vec<u32>,
    /// Those that discs at the part in hand may touch, but for the one that it belongs to.
    ahead: Vec<(u32, Edge)>,
    found: Vec<u32>,
    piece: Vec<Node>,
    pieces: Vec<Vec<Node>>,
}

impl<F: FnMut(&Node) -> bool> Walk<'_, F> {
    fn run(&mut self, run: &mut Run) {
        let reach = 2.0 * self.most + STEP;
        let (low, high) = (run.low, run.high);
        self.edges.near((low.0 - reach, low.1 - reach), (high.0 + reach, high.1 + reach), &mut self.near);
        if !self.faced(run) {
            run.parts.clear();
            return;
        }
        for (i, from, to) in run.parts.drain(..) {
            let edge = self.edges.all[i as usize];
            let before = self.edges.all[edge.before as usize];
            if from <= 0.0 {
                self.fan(i, &before, &edge);
            }
            if self.look_ahead(i, &edge, from, to) {
                self.part(i, &edge, from, to);
            }
        }
    }

    /// Whether an edge nearby may face one of a run's: false only where all of them point the same way
    /// as the run does, but for so much that none of them can.
    fn faced(&self, run: &Run) -> bool {
        let all = &self.edges.all;
        let own =
            || run.parts.iter().flat_map(|p| [&all[p.0 as usize], &all[all[p.0 as usize].before as usize]]);
        let (x, y) = own().fold((0.0, 0.0), |(x, y), e| (x + e.ux, y + e.uy));
        let length = (x * x + y * y).sqrt();
        if length <= 0.0 {
            return true;
        }
        let along = |e: &Edge| (x * e.ux + y * e.uy) / length;
        let spread = own().map(along).fold(1.0, f64::min);
        if spread < 0.1 {
            return true;
        }
        // An edge faces another beyond the angle whose cosine is FACING; the run's own spread is taken off.
        let most = FACING * spread + ((1.0 - FACING * FACING) * (1.0 - spread * spread)).max(0.0).sqrt();
        self.near.iter().any(|&i| along(&all[i as usize]) <= most)
    }

    /// Gathers the edges that discs along an edge may touch, and tells whether one of them faces it.
    fn look_ahead(&mut self, own: u32, edge: &Edge, from: f64, to: f64) -> bool {
        let (reach, low, high) = (2.0 * self.most, from - self.most, to + self.most);
        let ahead = |other: &Edge, cosine: f64| {
            let (vx, vy) = (other.x - edge.x, other.y - edge.y);
            let across = edge.ux * vy - edge.uy * vx;
            let along = edge.ux * vx + edge.uy * vy;
            let far = across + other.length * (edge.ux * other.uy - edge.uy * other.ux);
            let further = along + other.length * cosine;
            across.min(far) < reach
                && across.max(far) > TOUCHING
                && along.min(further) < high
                && along.max(further) > low
        };
        let all = &self.edges.all;
        let others = || self.near.iter().map(|&i| (i, &all[i as usize])).filter(|(i, _)| *i != own);
        let cosine = |other: &Edge| edge.ux * other.ux + edge.uy * other.uy;
        // The axis is met from both sides; see `disc`.
        let faces = |c: f64, i: u32| c < FACING && i > own;
        if !others().any(|(i, f)| faces(cosine(f), i) && ahead(f, cosine(f))) {
            return false;
        }
        self.ahead.clear();
        self.ahead.extend(others().filter(|(_, f)| ahead(f, cosine(f))).map(|(i, f)| (i, *f)));
        true
    }

    /// Looks at an edge from `from` to `to`.
    fn part(&mut self, i: u32, edge: &Edge, from: f64, to: f64) {
        let normal = (-edge.uy, edge.ux);
        let count = ((to - from) / STEP).ceil().max(1.0);
        let mut last: Option<(f64, bool)> = None;
        for k in 0..count as u32 {
            let way = from + (f64::from(k) + 0.5) * (to - from) / count;
            let node = self.disc(i, edge.at(way), normal);
            if let Some((before, good)) = last
                && good != node.is_some()
            {
                // The axis begins or ends in between.
                let (mut inside, mut outside) = if good { (before, way) } else { (way, before) };
                let mut end = None;
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (inside + outside);
                    match self.disc(i, edge.at(middle), normal) {
                        Some(node) => (end, inside) = (Some(node), middle),
                        None => outside = middle,
                    }
                }
                end.into_iter().for_each(|node| self.push(node));
            }
            last = Some((way, node.is_some()));
            node.into_iter().for_each(|node| self.push(node));
        }
    }

    /// Looks in all directions from a corner to the right, where the discs roll around it.
    fn fan(&mut self, i: u32, before: &Edge, edge: &Edge) {
        let (cross, dot) =
            (before.ux * edge.uy - before.uy * edge.ux, before.ux * edge.ux + before.uy * edge.uy);
        // Less than 2 degrees need no disc of their own.
        if cross >= 0.0 || dot > 0.9994 {
            return;
        }
        self.ahead.clear();
        let faces = |f: &Edge| {
            f.ux * edge.ux + f.uy * edge.uy < FACING || f.ux * before.ux + f.uy * before.uy < FACING
        };
        let others = self.near.iter().filter(|&&f| f != i).map(|&f| (f, self.edges.all[f as usize]));
        self.ahead.extend(others);
        if !self.ahead.iter().any(|(other, f)| *other > i && faces(f)) {
            return;
        }
        let count = 1 + ((1.0 - dot) * 4.0) as u32;
        for k in 0..count {
            let t = (f64::from(k) + 0.5) / f64::from(count);
            let (ux, uy) = (before.ux + t * (edge.ux - before.ux), before.uy + t * (edge.uy - before.uy));
            let length = (ux * ux + uy * uy).sqrt();
            if length > 1e-6
                && let Some(node) = self.disc(i, (edge.x, edge.y), (-uy / length, ux / length))
            {
                self.push(node);
            }
        }
    }

    /// The largest disc inside that touches edge `own` at `p` with the given normal inwards, if the axis
    /// passes its centre and is to be kept.
    fn disc(&mut self, own: u32, p: (f64, f64), normal: (f64, f64)) -> Option<Node> {
        let (mut r, mut other, mut touch) = (self.most, u32::MAX, (0.0, 0.0));
        for &(i, ref edge) in &self.ahead {
            let (vx, vy) = (p.0 - edge.x, p.1 - edge.y);
            let distance = edge.ux * vy - edge.uy * vx;
            if distance < TOUCHING {
                continue;
            }
            // Distance and radius agree for the line; 1 - cos of the angle between the normals.
            let facing = 1.0 - (edge.ux * normal.1 - edge.uy * normal.0);
            if distance >= r * facing {
                continue;
            }
            let line = distance / facing;
            let along = (vx + line * normal.0) * edge.ux + (vy + line * normal.1) * edge.uy;
            if along >= 0.0 && along <= edge.length {
                (r, other, touch) = (line, i, edge.at(along));
                continue;
            }
            let q = edge.at(if along < 0.0 { 0.0 } else { edge.length });
            let (wx, wy) = (q.0 - p.0, q.1 - p.1);
            let ahead = wx * normal.0 + wy * normal.1;
            let square = wx * wx + wy * wy;
            if square < 2.0 * ahead * r {
                (r, other, touch) = (square / (2.0 * ahead), i, q);
            }
        }
        // The axis is met from both sides; the one that comes first in the border's order counts.
        if other == u32::MAX || other < own || r < self.least {
            return None;
        }
        let (x, y) = (p.0 + r * normal.0, p.1 + r * normal.1);
        let cosine = -(normal.0 * (touch.0 - x) + normal.1 * (touch.1 - y)) / r;
        let node = Node { x, y, r };
        (cosine <= OPPOSITE && (self.keep)(&node)).then_some(node)
    }

    fn push(&mut self, node: Node) {
        // Discs near a flat corner of the border fail; the axis goes on behind.
        let found = &mut self.found;
        if self.piece.last().is_some_and(|last| {
            last.distance(&node) > node.r.max(last.r) + STEP
                || !last.leads_to(&node, self.edges, self.slack, found)
        }) {
            self.flush();
        }
        self.piece.push(node);
    }

    fn flush(&mut self) {
        if self.piece.len() > 1 {
            self.pieces.push(std::mem::take(&mut self.piece));
        }
        self.piece.clear();
    }
}
