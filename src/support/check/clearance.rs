//! Whether supports keep clear of the part.

use super::ground::around;
use super::{LEVEL, Print, Rule, area, is_raft, largest};
use crate::lattice::Point2;
use crate::span::algebra::{and, or};
use crate::span::morph::dilate_disc;
use crate::span::{RowFrame, Rows};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Supports in the part, or too near to it.
#[derive(Clone, Debug, PartialEq)]
pub struct Clash {
    /// The layer of supports.
    pub layer: usize,
    /// Which distance it does not keep.
    pub side: Side,
    /// Where.
    pub area: Rows,
    /// How much \[mm²\].
    pub mm2: f64,
    /// A point in it \[nm\].
    pub place: Point2,
    /// Height of the layer's upper side above the bed \[nm\].
    pub z: i64,
}

/// Where the part lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Side {
    /// At the same height: less than [`Rule::xy_gap`] away, or in the same place.
    Beside,
    /// Above: less than [`Rule::top_gap`] away.
    Above,
    /// Below: less than [`Rule::bottom_gap`] away.
    Below,
}

/// Where supports are in the part or nearer to it than they may be, lowest layer first.
///
/// Beside counts what of the part lies at a height between the layer's sides; above and below count only
/// what lies straight above or below. A raft keeps [`Rule::raft_gap`] instead.
pub fn clashes(print: &Print, rule: &Rule) -> Vec<Clash> {
    let of_layer = |j: usize| {
        let sides = [Side::Beside, Side::Above, Side::Below];
        sides.into_iter().filter_map(move |side| clash(print, j, side, rule))
    };
    (0..print.supports.len()).into_par_iter().flat_map_iter(of_layer).collect()
}

fn clash(print: &Print, j: usize, side: Side, rule: &Rule) -> Option<Clash> {
    let layer = print.supports.get(j)?;
    let (low, high) = (i64::from(layer.bottom_z()), i64::from(layer.print_z));
    let levels = print.part.levels;
    // Layers from the first whose upper side is above `from` to the last whose lower side is below `to`.
    let between = |from: i64, to: i64| {
        levels.partition_point(|l| l.top <= from)..levels.partition_point(|l| l.bottom < to)
    };
    let top_gap = if is_raft(layer.kind) { rule.raft_gap } else { rule.top_gap };
    let beside = between(low + LEVEL, high - LEVEL);
    let near = match side {
        Side::Beside => beside,
        Side::Above => beside.end..between(low, high + top_gap - LEVEL).end,
        Side::Below => between(low - rule.bottom_gap + LEVEL, high).start..beside.start,
    };
    let own = area(layer);
    let part = outlines(print, near, &own, rule, side);
    let frame = print.part.frame;
    let gap = match side {
        Side::Beside => frame.units(rule.xy_gap) - frame.pitch(),
        _ => 0,
    };
    let found = and(&own, &dilate_disc(&part, gap, |k| frame.t(k)));
    let (_, place) = largest(&found, frame)?;
    let mm2 = found.length() as f64 * frame.mm2_per_unit();
    Some(Clash { layer: j, side, area: found, mm2, place, z: high })
}

/// What some layers of the part have in common with the neighbourhood of a place.
fn outlines(print: &Print, layers: Range<usize>, place: &Rows, rule: &Rule, side: Side) -> Rows {
    let frame: &RowFrame = print.part.frame;
    let reach = if side == Side::Beside { frame.units(rule.xy_gap) } else { 0 };
    let mut all = Rows::default();
    let mut previous: Option<&Arc<Rows>> = None;
    for outline in print.part.outlines.get(layers).unwrap_or_default() {
        if previous.is_none_or(|p| !Arc::ptr_eq(p, outline)) {
            all = or(&all, &around(outline, place, reach, frame));
        }
        previous = Some(outline);
    }
    all
}
