//! Whether anything is printed in air, and whether supports keep their distance.
//!
//! A check of the result, independent of how it was found: it is given what is printed, layer by layer, and
//! a [`Rule`]. [`in_air`] looks at areas, [`Ground`] and [`hanging`] at lines, [`clashes`] at distances.
//!
//! A point of a layer of the part is held where
//! - the layer lies on the plate, or
//! - it is at most the threshold's reach from the part's layer below or from support whose upper side lies
//!   at most [`Rule::contact`] below the layer, or
//! - it is in the clear distance between the two: near enough to both, or
//! - it is in a bridge: in [`Overhang::bridged`](super::overhang::Overhang::bridged) as an area; as a line,
//!   on a straight stretch whose ends are both held.
//!
//! A point of support is held where it lies on the plate or near enough to support that ends at its lower
//! side or to the part at most [`Rule::foot`] below it. Infill is not looked at: what lies on the part's
//! outline below is held.
//!
//! Areas are known on their rows only. Between two rows an edge may lie anywhere, so that everything that is
//! true of the rows is true of the print but for one [`pitch`](RowFrame::pitch) across the rows. Reaches are
//! therefore longer and distances shorter by that much: nothing is reported that the rows alone have made,
//! and what hangs or is too near by more than two pitches is found.

mod clearance;
mod ground;
mod lines;
#[cfg(test)]
mod tests;

pub use clearance::{Clash, Side, clashes};
pub use ground::Ground;
pub use lines::{Hanging, hanging};

use super::overhang::Overhang;
use super::raft::Heights;
use super::{LayerKind, Part, SupportLayer, SupportPlan, tree};
use crate::lattice::{Point2, nm};
use crate::settings::flow::{Flow, FlowRole};
use crate::settings::{Settings, SupportStyle};
use crate::span::algebra::or;
use crate::span::components::label;
use crate::span::{RowFrame, Rows};
use rayon::prelude::*;

/// Heights that differ by less are the same \[nm\].
const LEVEL: i64 = 2_000;

/// What is printed, on the rows of one frame.
#[derive(Clone, Copy, Debug)]
pub struct Print<'a> {
    /// The part.
    pub part: Part<'a>,
    /// What of it holds itself as a bridge: only `bridged` is read. Empty, or one for each layer.
    pub overhangs: &'a [Overhang],
    /// Supports and raft, by ascending height of their upper sides.
    pub supports: &'a [SupportLayer],
}

/// When something is held. Lengths in nanometres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Slopes this steep and steeper hold themselves \[degrees from horizontal\]; `None` = a layer may reach
    /// out by `half_wall`.
    pub threshold: Option<f64>,
    /// Half the width of an outer wall.
    pub half_wall: f64,
    /// Clear distance between support and the part beside.
    pub xy_gap: f64,
    /// Least clear distance between support and the part above.
    pub top_gap: i64,
    /// Least clear distance between support and the part below.
    pub bottom_gap: i64,
    /// Least clear distance between raft and part.
    pub raft_gap: i64,
    /// Most distance between support and what it holds: the gap, how far threads over air hang down, and
    /// what is lost where supports end at the part's layers.
    pub contact: i64,
    /// Most distance between the part and the support that stands on it.
    pub foot: i64,
    /// Between parts that are no further apart than this above each other supports find no room.
    pub room: i64,
    /// Greatest thickness of a layer of support.
    pub thickest: i64,
    /// Under what begins lower than this above the bed supports find no room either.
    pub room_on_bed: i64,
    /// How far support may reach over the support below it, beside what its slope gives; with branches half of
    /// what their roofs bridge.
    pub support_reach: f64,
    /// Tangent of the greatest slope of branches from upright; 0 for columns.
    pub support_slope: f64,
    /// A stretch of line over air is straight when it keeps this near to its chord.
    pub straight: f64,
}

impl Rule {
    /// What the settings of a job promise.
    pub fn new(settings: &Settings, plan: &SupportPlan) -> Self {
        let layer = settings.slicing.layer_height;
        let thread = Flow::bridging(FlowRole::SolidInfill, layer, false, settings);
        let drop = if settings.infill.thick_bridges { nm(thread.height - layer).max(0) } else { 0 };
        let most = nm(settings.adaptive_heights()[1]);
        // Supports that end at the part's layers end at the next one below the gap.
        let rounding = if plan.synchronized { most.max(nm(layer)) } else { 0 };
        let raft = Heights::new(settings);
        let raft_gap = i64::from((raft.part_z - raft.top()).max(0));
        let organic = plan.style == SupportStyle::Organic;
        Self {
            threshold: plan.threshold,
            half_wall: plan.half_wall,
            xy_gap: plan.xy_gap,
            top_gap: plan.top_gap.into(),
            bottom_gap: plan.bottom_gap.into(),
            raft_gap,
            contact: (i64::from(plan.top_gap) + drop + rounding).max(raft_gap),
            foot: i64::from(plan.bottom_gap) + i64::from(plan.heights[1]) + rounding,
            room: (i64::from(plan.top_gap) + drop + rounding)
                + i64::from(plan.bottom_gap)
                + i64::from(plan.heights[1])
                + rounding,
            thickest: plan.heights[1].into(),
            room_on_bed: i64::from(plan.base_z)
                + i64::from(if plan.base_z == 0 { plan.first_height } else { plan.heights[0] })
                + i64::from(plan.top_gap)
                + drop
                + rounding,
            // Roofs and their ribs bridge from branch to branch: nothing is further than half of that from one.
            support_reach: 0.5 * (plan.width + if organic { tree::longest_span(plan) } else { 0.0 }),
            support_slope: if organic { libm::tan(plan.tree.angle.to_radians()) } else { 0.0 },
            straight: plan.width,
        }
    }

    /// How far layer `i` of a part may reach over the one below it.
    pub fn reach(&self, part: Part, i: usize) -> f64 {
        let (Some(own), Some(below)) =
            (part.levels.get(i), i.checked_sub(1).and_then(|b| part.levels.get(b)))
        else {
            return self.half_wall;
        };
        // From the middle of a layer to that of the next: layers are cut there.
        let rise = 0.5 * (own.top + own.bottom - below.top - below.bottom) as f64;
        self.threshold.map_or(self.half_wall, |degrees| rise / libm::tan(degrees.to_radians()))
    }
}

/// What is printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum What {
    /// A layer of the part, by its number.
    Part(usize),
    /// A layer of supports or raft, by its number.
    Support(usize),
}

/// What of one layer is printed in air.
#[derive(Clone, Debug, PartialEq)]
pub struct InAir {
    /// The layer.
    pub what: What,
    /// Where.
    pub area: Rows,
    /// How much \[mm²\].
    pub mm2: f64,
    /// How much of it hangs together at most \[mm²\].
    pub largest_mm2: f64,
    /// How much of it no support could hold that keeps its distances to the part \[mm²\]; 0 for supports.
    pub cramped_mm2: f64,
    /// A point in the largest \[nm\].
    pub place: Point2,
    /// Height of its lower side above the bed \[nm\].
    pub z: i64,
}

/// What is printed in air: the part's layers from the lowest up, then those of supports. Only layers that
/// have something in air are listed.
pub fn in_air(print: &Print, rule: &Rule) -> Vec<InAir> {
    let part = (0..print.part.outlines.len()).into_par_iter().filter_map(|i| {
        let hanging = ground::part_in_air(print, i, rule);
        let cramped = ground::cramped(print, i, rule, &hanging);
        InAir::new(What::Part(i), hanging, &cramped, print.part.levels.get(i)?.bottom, print.part.frame)
    });
    let supports = print.supports.par_iter().enumerate().filter_map(|(j, layer)| {
        let hanging = ground::support_in_air(print, j, rule);
        let z = layer.bottom_z().into();
        InAir::new(What::Support(j), hanging, &Rows::default(), z, print.part.frame)
    });
    let mut all: Vec<InAir> = part.collect();
    all.par_extend(supports);
    all
}

impl InAir {
    fn new(what: What, area: Rows, cramped: &Rows, z: i64, frame: &RowFrame) -> Option<Self> {
        let (largest, place) = largest(&area, frame)?;
        let mm2 = |area: &Rows| area.length() as f64 * frame.mm2_per_unit();
        let (mm2, cramped_mm2) = (mm2(&area), mm2(cramped));
        Some(Self { what, area, mm2, largest_mm2: largest, cramped_mm2, place, z })
    }
}

/// Area of the largest connected part \[mm²\] and a point in it.
fn largest(area: &Rows, frame: &RowFrame) -> Option<(f64, Point2)> {
    let part = label(area);
    let mut length = vec![0i64; part.len()];
    for (span, &p) in area.spans().iter().zip(&part) {
        *length.get_mut(p as usize)? += span.length();
    }
    let (number, &most) = length.iter().enumerate().rev().max_by_key(|(_, l)| **l)?;
    let rows = (area.first()..area.end()).flat_map(|k| area.range(k).map(move |i| (k, i)));
    let mut own = rows.filter(|(_, i)| part.get(*i) == Some(&(number as u32)));
    // Where half of it is passed: well inside of compact shapes.
    let mut passed = 0;
    let (k, span) = own.find_map(|(k, i)| {
        let span = *area.spans().get(i)?;
        passed += span.length();
        (2 * passed >= most).then_some((k, span))
    })?;
    let place = frame.xy(span.start.midpoint(span.end), frame.t(k));
    Some((most as f64 * frame.mm2_per_unit(), place))
}

/// Everything that a layer of supports prints.
pub fn area(layer: &SupportLayer) -> Rows {
    if layer.interface.is_empty() && layer.bottom_interface.is_empty() {
        return layer.base.clone();
    }
    or(&or(&layer.base, &layer.interface), &layer.bottom_interface)
}

/// Supports that end near enough under layer `i` of the part to carry it.
pub fn supports_under(print: &Print, i: usize, rule: &Rule) -> Rows {
    let z = print.part.levels.get(i).map_or(0, |l| l.bottom);
    ground::ending(print, z - rule.contact - LEVEL..z + LEVEL)
}

/// The part of `area`, of layer `i` of the part, that no support could hold which keeps its distances: the
/// part is too near beside or below.
pub fn cramped(print: &Print, i: usize, rule: &Rule, area: &Rows) -> Rows {
    ground::cramped(print, i, rule, area)
}

/// Whether a layer belongs to the raft.
pub fn is_raft(kind: LayerKind) -> bool {
    matches!(kind, LayerKind::RaftFirst | LayerKind::RaftBase | LayerKind::RaftInterface)
}
