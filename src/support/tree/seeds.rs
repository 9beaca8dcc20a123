//! Where branches begin.

use super::Stage;
use super::clearance::{distance, touched};
use super::field::Field;
use super::grow::{AROUND, Node, ON_PART};
use super::near::Near;
use crate::span::components::label;
use crate::span::morph::{dilate_disc, erode_disc};
use crate::span::{RowFrame, Rows, RowsBuilder};

/// Half as much as a strip may reach beyond where the one below holds it and count as a wall that leans \[nm\].
const LEANS: f64 = 120_000.0;

/// Ribs under a roof, and where branches carry them.
#[derive(Clone, Debug, Default)]
pub struct Ribs {
    /// The ribs.
    pub rows: Rows,
    /// In the frame's coordinates.
    pub posts: Vec<[f64; 2]>,
}

/// Ribs along the rows, in each connected part of an area as many as keep no further apart than `span` from each
/// other, evenly; the same holds for the posts along a rib.
pub fn ribs(area: &Rows, width: f64, span: f64, frame: &RowFrame) -> Ribs {
    let part = label(area);
    let mut extent: Vec<(i32, i32)> = Vec::new();
    for (k, _) in area.iter() {
        for i in area.range(k) {
            let p = part[i] as usize;
            if p >= extent.len() {
                extent.resize(p + 1, (i32::MAX, i32::MIN));
            }
            extent[p] = (extent[p].0.min(k), extent[p].1.max(k));
        }
    }
    let pitch = frame.pitch() as f64;
    let every = (span / pitch).max(1.0);
    let wide = ((width / pitch).round() as i32).max(1);
    let mut posts = Vec::new();
    let mut out = RowsBuilder::new(area.first());
    for (k, row) in area.iter() {
        for (i, s) in area.range(k).zip(row) {
            let (first, last) = extent[part[i] as usize];
            let rows = f64::from(last - first + 1);
            let count = (rows / every).ceil().max(1.0);
            // The rib this row belongs to and the row's place in it.
            let n = (f64::from(k - first) * count / rows).floor();
            let middle = first + ((n + 0.5) * rows / count) as i32;
            let place = k - (middle - wide / 2);
            if (0..wide).contains(&place) {
                out.push(s.start, s.end);
            }
            if k == middle {
                let length = s.length() as f64;
                let count = (length / span).ceil().max(1.0);
                for m in 0..count as i32 {
                    let along = (f64::from(m) + 0.5) * length / count;
                    posts.push([f64::from(s.start) + along, frame.t(k) as f64]);
                }
            }
        }
        out.end_row();
    }
    Ribs { rows: out.finish(), posts }
}

/// Adds branches to those of layer `j` until each point of what they carry there has one nearby that carries the
/// same connected area.
pub fn seed(stage: &Stage, field: &Field, j: usize, nodes: &mut Vec<Node>) {
    let carried = &stage.held[j].carried;
    let Some(above) = stage.held.get(j + 1).filter(|_| !carried.is_empty()) else { return };
    let (frame, span) = (&stage.plan.frame, stage.span());
    let part = label(&above.all);
    let rests = touching(&above.all, &part, &stage.held[j].all);
    let far_out = far_out(stage, j);
    let low = [carried.spans().iter().map(|s| s.start).min(), Some(frame.t(carried.first()) as i32)];
    let high = [carried.spans().iter().map(|s| s.end).max(), Some(frame.t(carried.end()) as i32)];
    let [low, high] = [low, high].map(|c| c.map(|c| c.map_or(0.0, f64::from)));
    // Those that touch what they carry, and those that are near enough to a wall that leans.
    let mut touch = Near::new(low, high, span);
    let mut beside = Near::new(low, high, span);
    let note_both = |node: &Node, touch: &mut Near, beside: &mut Near| {
        note(&above.all, &part, frame, node, 0.0, touch);
        note(&above.all, &part, frame, node, 0.5 * span, beside);
    };
    nodes.iter().for_each(|node| note_both(node, &mut touch, &mut beside));
    let tip = stage.units(stage.plan.tree.tip_radius);
    let mut plant = |at: [f64; 2], tag: u32, free: f64, leans: bool| {
        if touch.any(at, tag, free) || leans && beside.any(at, tag, free) {
            return;
        }
        let Some(node) = place(stage, field, j, at, tip) else { return };
        touch.push(at, tag);
        note_both(&node, &mut touch, &mut beside);
        nodes.push(node);
    };
    let tag_at = |at: [f64; 2]| {
        let k = frame.nearest_row(at[1] as i64);
        let row = above.all.row(k);
        let i = row.partition_point(|x| f64::from(x.end) <= at[0]);
        let inside = row.get(i).is_some_and(|x| f64::from(x.start) <= at[0]);
        inside.then(|| part[above.all.range(k).start + i])
    };
    for &post in &stage.held[j].ribs.posts {
        if let Some(tag) = tag_at(post) {
            plant(post, tag, 0.5 * span, false);
        }
    }
    for (k, row) in carried.iter() {
        let t = frame.t(k) as f64;
        for s in row {
            let Some(tag) = tag_at([f64::from(s.start), t]) else { continue };
            let row = above.interface.row(k);
            let at = row.partition_point(|x| x.end <= s.start);
            let is_roof = row.get(at).is_some_and(|x| x.start < s.end);
            let leans = !is_roof && rests[tag as usize];
            let reach = match is_roof {
                // Half the diagonal between posts, and a little.
                true => 0.75 * span,
                // A strip that lies in part on the one below needs less.
                false if leans => span,
                false => 0.5 * span,
            };
            let count = (s.length() as f64 / tip).ceil().max(1.0);
            for m in 0..=count as i32 {
                let along = s.length() as f64 * f64::from(m) / count;
                let at = f64::from(s.start) + along;
                plant([at, t], tag, reach, leans && !holds(&far_out, k, at));
            }
        }
    }
}

/// Whether a position of row `k` is in an area.
fn holds(area: &Rows, k: i32, at: f64) -> bool {
    let row = area.row(k);
    let i = row.partition_point(|x| f64::from(x.end) <= at);
    row.get(i).is_some_and(|x| f64::from(x.start) <= at)
}

/// Per connected part of `area` whether it overlaps `ground`.
pub fn touching(area: &Rows, part: &[u32], ground: &Rows) -> Vec<bool> {
    let mut touches = vec![false; part.iter().max().map_or(0, |&m| m as usize + 1)];
    for (k, row) in area.iter() {
        let under = ground.row(k);
        let mut at = 0;
        for (i, s) in area.range(k).zip(row) {
            while at < under.len() && under[at].end <= s.start {
                at += 1;
            }
            if under.get(at).is_some_and(|u| u.start < s.end) {
                touches[part[i] as usize] = true;
            }
        }
    }
    touches
}

/// What of what layer `j` must carry reaches far beyond what the layer holds. The rest is a wall that leans out so
/// little from layer to layer that it holds itself for some way.
fn far_out(stage: &Stage, j: usize) -> Rows {
    let (frame, leans) = (&stage.plan.frame, stage.plan.frame.units(LEANS));
    let thick = erode_disc(&stage.held[j].carried, leans, |k| frame.t(k));
    dilate_disc(&thick, 2 * leans, |k| frame.t(k))
}

/// Notes a branch with all connected parts at most `more` from its disc.
fn note(all: &Rows, part: &[u32], frame: &RowFrame, node: &Node, more: f64, near: &mut Near) {
    let mut tags: Vec<u32> = Vec::new();
    touched(all, frame, node.at, node.r + more, |i| tags.push(part[i]));
    tags.sort_unstable();
    tags.dedup();
    tags.iter().for_each(|&tag| near.push(node.at, tag));
}

/// A branch that begins as near to a point as it has room.
fn place(stage: &Stage, field: &Field, j: usize, at: [f64; 2], tip: f64) -> Option<Node> {
    let frame = &stage.plan.frame;
    let room = |at| distance(&stage.keep_out[j], frame, at, tip);
    let mut best = (room(at), at);
    if best.0 < tip {
        for step in [0.5 * tip, tip] {
            for [u, v] in AROUND {
                let to = [at[0] + step * u, at[1] + step * v];
                let found = room(to);
                if found > best.0 + 0.1 * step {
                    best = (found, to);
                }
            }
        }
    }
    let (room, at) = best;
    let to_plate = field.leads_down(j, at) || field.way_down(j, at, 5).is_some();
    let stands = to_plate || !stage.plan.on_bed_only;
    (room > 0.0 && stands).then_some(Node { at, r: tip, load: 1.0, rise: 0.0, to_plate, below: ON_PART })
}
