//! Branches, layer by layer from the top to the plate.

use super::Stage;
use super::clearance::distance;
use super::field::Field;
use super::gather::gather;
use super::seeds::seed;

/// A branch in one layer: a disc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Node {
    /// Its middle in the frame's coordinates \[units\].
    pub at: [f64; 2],
    /// Radius \[units\].
    pub r: f64,
    /// Number of tips it carries.
    pub load: f64,
    /// Height of the highest of them above this layer \[units\].
    pub rise: f64,
    /// There is a way to the plate; when all have grown, it has been found.
    pub to_plate: bool,
    /// The node of the layer below that it stands on, or [`ON_PART`]; meaningless in the lowest layer.
    pub below: u32,
}

/// It stands on the part.
pub const ON_PART: u32 = u32::MAX;

/// Branches per layer, lowest first.
pub type Skeleton = Vec<Vec<Node>>;

/// Eight directions.
pub const AROUND: [[f64; 2]; 8] = {
    const D: f64 = std::f64::consts::FRAC_1_SQRT_2;
    [[1.0, 0.0], [D, D], [0.0, 1.0], [-D, D], [-1.0, 0.0], [-D, -D], [0.0, -1.0], [D, -D]]
};

/// Most that a radius grows by height.
const FLARE: f64 = 0.5;
/// A branch passes where there is room for so much of a tip.
const SQUEEZED: f64 = 0.5;
/// Greatest radius, in those of a thin branch.
const THICKEST: f64 = 4.0;
/// Two branches are one when the middle of one is this deep in the other's disc.
const JOINED: f64 = 0.7;

/// Grows all branches.
pub fn grow(stage: &Stage, field: &Field) -> Skeleton {
    let mut skeleton: Skeleton = vec![Vec::new(); stage.layers.len()];
    let base = stage.plan.base_z;
    for j in (0..stage.layers.len()).rev() {
        let mut nodes = Vec::new();
        if let Some(above) = skeleton.get_mut(j + 1) {
            let high = stage.units(f64::from((stage.layers[j].top - base).max(0)));
            let lean = libm::tan(stage.plan.tree.angle_slow.clamp(0.0, 80.0).to_radians());
            let towards = gather(above, lean * stage.rise(j), lean * high);
            let walk = Walk::new(stage, field, j);
            let mut moved: Vec<(Node, usize)> = Vec::with_capacity(above.len());
            for (i, (node, lean)) in above.iter().zip(towards).enumerate() {
                if let Some(node) = walk.descend(node, lean) {
                    moved.push((node, i));
                }
            }
            nodes = walk.join(moved, above);
        }
        seed(stage, field, j, &mut nodes);
        skeleton[j] = nodes;
    }
    ends(&mut skeleton);
    skeleton
}

/// Says of each branch whether it has come down to the plate.
fn ends(skeleton: &mut Skeleton) {
    for j in 1..skeleton.len() {
        let (lower, upper) = skeleton.split_at_mut(j);
        let (Some(below), Some(own)) = (lower.last(), upper.first_mut()) else { continue };
        for node in own {
            node.to_plate = below.get(node.below as usize).is_some_and(|b| b.to_plate);
        }
    }
}

/// Indices of points by position.
pub fn in_order(points: impl Iterator<Item = [f64; 2]>) -> Vec<usize> {
    let points: Vec<[f64; 2]> = points.collect();
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| {
        let ([s, t], [u, v]) = (points[a], points[b]);
        s.total_cmp(&u).then(t.total_cmp(&v)).then(a.cmp(&b))
    });
    order
}

/// The way from a layer to the one below it.
struct Walk<'a> {
    stage: &'a Stage<'a>,
    field: &'a Field,
    /// The lower layer.
    j: usize,
    /// From middle to middle \[units\].
    rise: f64,
    /// How far a branch may move: preferably, and at most \[units\].
    steps: [f64; 2],
    tip: f64,
}

impl<'a> Walk<'a> {
    fn new(stage: &'a Stage, field: &'a Field, j: usize) -> Self {
        let tree = &stage.plan.tree;
        let rise = stage.rise(j);
        let step = |degrees: f64| rise * libm::tan(degrees.clamp(0.0, 80.0).to_radians());
        let steps = [step(tree.angle_slow), step(tree.angle)];
        Self { stage, field, j, rise, steps, tip: stage.units(tree.tip_radius) }
    }

    fn room(&self, at: [f64; 2], limit: f64) -> f64 {
        distance(&self.stage.keep_out[self.j], &self.stage.plan.frame, at, limit)
    }

    /// Radius after so much more height: as thick as a branch of that length or as what it carries needs, but
    /// it grows steadily.
    fn radius(&self, r: f64, load: f64, rise: f64) -> f64 {
        let tree = &self.stage.plan.tree;
        let thin = self.stage.units(tree.radius).max(self.tip);
        let cone = self.tip + FLARE * rise;
        let by_length = cone.min(thin + tree.taper * rise);
        // The section of all tips together.
        let by_load = self.tip * load.sqrt();
        by_length.max(by_load).min(THICKEST * thin).clamp(r, r + FLARE * self.rise)
    }

    /// Where a branch goes on, if it does not stand on the part.
    fn descend(&self, node: &Node, lean: [f64; 2]) -> Option<Node> {
        let rise = node.rise + self.rise;
        let r = self.radius(node.r, node.load, rise);
        let wanted = [node.at[0] + lean[0], node.at[1] + lean[1]];
        let slack = 0.05 * self.tip;
        let fits = |at: [f64; 2]| {
            (!node.to_plate || self.field.leads_down(self.j, at)) && self.room(at, r) >= r - slack
        };
        let at = match [wanted, node.at].into_iter().find(|&at| fits(at)) {
            Some(at) => at,
            None => self.evade(node, r)?,
        };
        Some(Node { at, r, rise, below: ON_PART, ..*node })
    }

    /// The best place within reach for a branch that is in somebody's way.
    fn evade(&self, node: &Node, r: f64) -> Option<[f64; 2]> {
        // What cannot reach the plate ends on the part below it.
        if !node.to_plate && self.room(node.at, self.tip) <= 0.0 {
            return None;
        }
        let way = match node.to_plate && !self.field.leads_down(self.j, node.at) {
            true => self.field.way_down(self.j, node.at, 8),
            false => None,
        };
        let straight = way.map(|to| {
            let (u, v) = (to[0] - node.at[0], to[1] - node.at[1]);
            let apart = (u * u + v * v).sqrt().max(1.0);
            [u / apart, v / apart]
        });
        let least = SQUEEZED * self.tip;
        let mut best: Option<(f64, [f64; 2])> = None;
        let mut consider = |at: [f64; 2], moved: f64| {
            let room = self.room(at, r.max(least));
            if room < least {
                return;
            }
            let off = way.map_or(0.0, |to| {
                let (u, v) = (to[0] - at[0], to[1] - at[1]);
                (u * u + v * v).sqrt()
            });
            let lost = node.to_plate && way.is_none() && !self.field.leads_down(self.j, at);
            let lost = if lost { 4.0 * self.field.cell() } else { 0.0 };
            let cost = 2.0 * (r - room).max(0.0) + 2.0 * off + lost + 0.5 * moved;
            if best.is_none_or(|b| cost < b.0) {
                best = Some((cost, at));
            }
        };
        consider(node.at, 0.0);
        for step in self.steps {
            for [u, v] in straight.into_iter().chain(AROUND) {
                consider([node.at[0] + step * u, node.at[1] + step * v], step);
            }
        }
        best.map(|b| b.1)
    }

    /// Makes one of branches that one can hold; `above` are told what they stand on.
    fn join(&self, mut moved: Vec<(Node, usize)>, above: &mut [Node]) -> Vec<Node> {
        let order = in_order(moved.iter().map(|m| m.0.at));
        let widest = moved.iter().fold(0.0, |w: f64, m| w.max(m.0.r)) * JOINED;
        // Into which one each has gone.
        let mut into: Vec<usize> = (0..moved.len()).collect();
        for (place, &i) in order.iter().enumerate() {
            if into[i] != i {
                continue;
            }
            let begun = moved[i].0.at[0];
            for &k in &order[place + 1..] {
                let (own, other) = (moved[i].0, moved[k].0);
                // The joined branch moves a little: twice the distance is enough.
                if other.at[0] - begun > 2.0 * widest {
                    break;
                }
                let (u, v) = (other.at[0] - own.at[0], other.at[1] - own.at[1]);
                let deep = JOINED * own.r.max(other.r);
                if into[k] != k || u * u + v * v > deep * deep || own.to_plate != other.to_plate {
                    continue;
                }
                into[k] = i;
                moved[i].0 = self.joined(&own, &other);
            }
        }
        let mut number = vec![0; moved.len()];
        let mut out = Vec::with_capacity(moved.len());
        for i in 0..moved.len() {
            if into[i] == i {
                number[i] = out.len() as u32;
                out.push(moved[i].0);
            }
        }
        for (&(_, from), &into) in moved.iter().zip(&into) {
            above[from].below = number[into];
        }
        out
    }

    fn joined(&self, a: &Node, b: &Node) -> Node {
        let heavy = if b.load > a.load { b } else { a };
        let load = a.load + b.load;
        let share = b.load / load;
        let r = a.r.max(b.r);
        let middle = [0, 1].map(|k| a.at[k] + share * (b.at[k] - a.at[k]));
        let is_free = self.room(middle, r) >= r.min(self.room(heavy.at, r))
            && (!heavy.to_plate || self.field.leads_down(self.j, middle));
        let at = if is_free { middle } else { heavy.at };
        Node { at, r, load, rise: a.rise.max(b.rise), ..*heavy }
    }
}
