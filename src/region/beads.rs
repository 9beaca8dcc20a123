//! Pieces of a medial axis → beads.

use super::medial::{Node, STEP};
use super::near::Edges;
use super::{Bead, BeadKind};
use crate::lattice::{LIMIT, Point2};

/// How the width of a bead follows from the width of the place that it fills \[nm\].
#[derive(Clone, Copy, Debug)]
pub(super) struct Shape {
    /// What the bead is.
    pub kind: BeadKind,
    /// Added to the diameter of the disc.
    pub add: f64,
    /// How far the discs between two points may reach over the border of the area.
    pub slack: f64,
    /// Beads shorter than this are crumbs.
    pub shortest: f64,
}

/// Points of a bead within this of the line that replaces them are dropped \[nm\], ...
const SIMPLIFY: f64 = 2_000.0;

/// ... if their widths are within this of the one there \[nm\].
const SIMPLIFY_WIDTH: f64 = 8_000.0;

/// Most points that one line replaces.
const LONGEST_RUN: usize = 64;

/// Cosine of the largest turn between two pieces that are joined: 60 degrees.
const STRAIGHT: f64 = 0.5;

/// The beads along the pieces of the axis of an area with these edges about `origin`. Pieces that carry
/// on from each other are joined.
pub(super) fn beads(pieces: Vec<Vec<Node>>, edges: &Edges, shape: &Shape, origin: Point2) -> Vec<Bead> {
    let limit = f64::from(LIMIT - 1);
    // The way is rounded before it is added, so that the result moves with its input.
    let place = |origin: i32, by: f64| (f64::from(origin) + by.round()).clamp(-limit, limit) as i32;
    join(pieces, edges, shape.slack)
        .into_iter()
        .filter(|nodes| length(nodes) >= shape.shortest)
        .filter_map(|nodes| {
            let nodes = simplified(&nodes);
            let mut bead = Bead { kind: shape.kind, ..Bead::default() };
            for node in &nodes {
                let point = Point2::new(place(origin.x, node.x), place(origin.y, node.y));
                if bead.points.last() != Some(&point) {
                    bead.points.push(point);
                    bead.widths.push((2.0 * node.r + shape.add).round() as i32);
                }
            }
            (bead.points.len() > 1).then_some(bead)
        })
        .collect()
}

fn length(nodes: &[Node]) -> f64 {
    nodes.iter().zip(nodes.iter().skip(1)).map(|(a, b)| a.distance(b)).sum()
}

/// An end of a piece.
#[derive(Clone, Copy)]
struct End {
    node: Node,
    /// Unit direction out of the piece.
    out: (f64, f64),
}

impl End {
    /// The end of `nodes` at their first point, or at their last.
    fn of(nodes: &[Node], last: bool) -> Option<Self> {
        let nth = |i: usize| if last { nodes.iter().rev().nth(i) } else { nodes.get(i) };
        let node = *nth(0)?;
        // Over some way, since single steps may be as short as a nanometre.
        let mut inner = *nth(1)?;
        for i in 2..nodes.len() {
            if node.distance(&inner) >= 0.5 * STEP {
                break;
            }
            inner = *nth(i)?;
        }
        let way = node.distance(&inner).max(1.0);
        Some(Self { node, out: ((node.x - inner.x) / way, (node.y - inner.y) / way) })
    }

    /// How straight the way on to `other` is, as the cosine of the turn; `None` when it is too far.
    fn joins(&self, other: &Self) -> Option<f64> {
        let way = self.node.distance(&other.node);
        if way > self.node.r.max(other.node.r) + STEP {
            return None;
        }
        let turn = -(self.out.0 * other.out.0 + self.out.1 * other.out.1);
        if way < 0.2 * STEP {
            return Some(turn);
        }
        let (dx, dy) = ((other.node.x - self.node.x) / way, (other.node.y - self.node.y) / way);
        let leave = self.out.0 * dx + self.out.1 * dy;
        let enter = -(other.out.0 * dx + other.out.1 * dy);
        Some(turn.min(leave).min(enter))
    }
}

/// Joins pieces that carry on from each other, the straightest first.
fn join(pieces: Vec<Vec<Node>>, edges: &Edges, slack: f64) -> Vec<Vec<Node>> {
    let ends: Vec<Option<End>> =
        pieces.iter().flat_map(|nodes| [End::of(nodes, false), End::of(nodes, true)]).collect();
    let (mut joints, mut found) = (Vec::new(), Vec::new());
    for (i, a) in ends.iter().enumerate() {
        for (j, b) in ends.iter().enumerate().skip(i + 1) {
            let own = i / 2 == j / 2;
            if let (Some(a), Some(b)) = (a, b)
                && let Some(straight) = a.joins(b)
                && straight >= STRAIGHT
                && a.node.leads_to(&b.node, edges, slack, &mut found)
                // A piece closes on itself when it is long enough to have an inside.
                && !(own && length(&pieces[i / 2]) < 4.0 * a.node.distance(&b.node) + STEP)
            {
                joints.push((straight, i, j));
            }
        }
    }
    joints.sort_by(|a, b| b.0.total_cmp(&a.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let mut mate: Vec<Option<usize>> = vec![None; ends.len()];
    for (_, i, j) in joints {
        if mate[i].is_none() && mate[j].is_none() {
            (mate[i], mate[j]) = (Some(j), Some(i));
        }
    }
    let mut done = vec![false; pieces.len()];
    let mut joined = Vec::with_capacity(pieces.len());
    // Open chains from their ends first; what is left then are closed ones.
    let open = (0..ends.len()).filter(|&i| mate[i].is_none());
    for start in open.chain((0..pieces.len()).map(|i| 2 * i)) {
        let (mut end, mut chain) = (start, Vec::new());
        while !done[end / 2] {
            done[end / 2] = true;
            let nodes = &pieces[end / 2];
            if end % 2 == 0 {
                chain.extend_from_slice(nodes);
            } else {
                chain.extend(nodes.iter().rev());
            }
            let Some(next) = mate[end ^ 1] else { break };
            end = next;
        }
        if mate[start].is_some()
            && let Some(first) = chain.first().copied()
        {
            chain.push(first);
        }
        if chain.len() > 1 {
            joined.push(chain);
        }
    }
    joined
}

/// Drops nodes that lie within [`SIMPLIFY`] of the line that replaces them.
fn simplified(nodes: &[Node]) -> Vec<Node> {
    let mut kept = Vec::new();
    let mut from = 0;
    kept.extend(nodes.first());
    while from + 1 < nodes.len() {
        let mut to = from + 1;
        while to + 1 < nodes.len() && to - from < LONGEST_RUN {
            let (a, b) = (nodes[from], nodes[to + 1]);
            if !nodes[from + 1..=to].iter().all(|p| within(p, &a, &b)) {
                break;
            }
            to += 1;
        }
        kept.push(nodes[to]);
        from = to;
    }
    kept
}

fn within(p: &Node, a: &Node, b: &Node) -> bool {
    let (ux, uy, vx, vy) = (b.x - a.x, b.y - a.y, p.x - a.x, p.y - a.y);
    let square = ux * ux + uy * uy;
    let along = if square > 0.0 { ((ux * vx + uy * vy) / square).clamp(0.0, 1.0) } else { 0.0 };
    let (wx, wy) = (vx - along * ux, vy - along * uy);
    let width = 2.0 * (p.r - a.r - along * (b.r - a.r));
    wx * wx + wy * wy <= SIMPLIFY * SIMPLIFY && width.abs() <= SIMPLIFY_WIDTH
}
