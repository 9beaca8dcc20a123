//! Skins that hang in air or over sparse infill: which they are, how they are anchored, and in which
//! direction they are laid.
//!
//! A bridge is a connected patch of a bottom skin with nothing below it. Its lines should run from one
//! support to another, so many directions are measured on the patch itself and the best is taken; then
//! the patch is grown along that direction until its lines rest on what lies below.

mod direction;
mod grow;
mod lines;

#[cfg(test)]
mod tests;

use crate::lattice::nm;
use crate::settings::Settings;
use crate::span::algebra::{and, dilate, or, sub};
use crate::span::components::{label, smaller_than};
use crate::span::{RowFrame, Rows, RowsBuilder, Span};
use direction::Measure;

/// Smaller patches are left to the walls around them \[mm²\].
const LEAST: f64 = 0.5;
/// Patches less than twice this apart are one bridge, and it reaches this far beyond them \[nm\].
const NEAR: f64 = 850_000.0;
/// Smaller or narrower patches over sparse infill are laid as any other solid infill \[mm², nm\].
const LEAST_OVER_SPARSE: (f64, f64) = (6.0, 2.4e6);
/// A rest of a skin smaller than this beside a bridge becomes part of it \[mm²\].
const CRUMB: f64 = 1.5;

/// An area to be bridged by parallel lines.
#[derive(Clone, Debug, PartialEq)]
pub struct Bridge {
    /// The area, a part of the layer's infill, anchors included.
    pub rows: Rows,
    /// Direction of its lines, counter-clockwise from +x, 0 to below 180 \[degrees\].
    pub degrees: f64,
}

/// How to bridge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BridgePlan {
    /// How far lines reach onto their supports at most \[nm\].
    pub anchor: f64,
    /// The direction of all bridges over air, if it is not to be measured \[degrees\].
    pub degrees: Option<f64>,
    /// Bridges span air, not only sparse infill; false where supports touch what they hold.
    pub over_air: bool,
}

impl BridgePlan {
    /// The plan of a filament job.
    pub fn new(settings: &Settings) -> Self {
        let i = &settings.infill;
        let degrees = Some(i.bridge_angle).filter(|a| *a > 0.0);
        let over_air = !settings.has_soluble_supports();
        Self { anchor: nm(i.external_infill_margin) as f64, degrees, over_air }
    }
}

/// The rows on which a layer is divided.
#[derive(Clone, Copy, Debug)]
pub struct Grid<'a> {
    /// The rows.
    pub frame: &'a RowFrame,
    /// Their direction \[degrees\].
    pub degrees: f64,
}

impl Grid<'_> {
    /// Total length of spans \[units\] that make an area \[mm²\].
    fn length(&self, area: f64) -> i64 {
        (area / self.frame.mm2_per_unit()).min(1e18) as i64
    }
}

/// The bridges over air of a layer whose infill is `own`.
///
/// `bottom` is the skin that shows below, a part of `own`, and `below` the outline of the layer below. No
/// two bridges overlap; together they hold all of `bottom` that hangs in air, but for crumbs, and reach out
/// of it where they are anchored. `usual` is their direction \[degrees\] where none is supported.
pub fn over_air(
    own: &Rows,
    bottom: &Rows,
    below: &Rows,
    grid: Grid,
    usual: f64,
    plan: &BridgePlan,
) -> Vec<Bridge> {
    let air = sub(bottom, below);
    if air.is_empty() {
        return Vec::new();
    }
    let pitch = grid.frame.pitch();
    let near = grid.frame.units(NEAR);
    let grown = dilate(&air, (near / pitch).clamp(1, 100) as u32, length(near));
    let patches = parts(&grown, &air, grid.length(LEAST));
    let mut found: Vec<Bridge> = Vec::with_capacity(patches.len());
    for (wider, patch) in &patches {
        let measured = || Measure::new(patch, below, grid).best();
        let degrees = plan.degrees.or_else(measured).unwrap_or(usual).rem_euclid(180.0);
        let wider = or(&and(wider, own), patch);
        let rest = plan.anchor - NEAR;
        let mut rows = grow::along(&wider, own, grid.frame, degrees - grid.degrees, rest);
        // Every patch belongs to its own bridge, and where anchors meet, the first has them.
        for (i, (_, other)) in patches.iter().enumerate() {
            let taken = found.get(i).map_or(other, |bridge| &bridge.rows);
            if i != found.len() && meet(&rows, taken) {
                rows = sub(&rows, taken);
            }
        }
        found.push(Bridge { rows, degrees });
    }
    let mut crumbs = smaller_than(&sub(bottom, &union(&found)), grid.length(CRUMB));
    for bridge in &mut found {
        if crumbs.spans().is_empty() {
            break;
        }
        if meet(&bridge.rows, &crumbs) {
            let near = dilate(&bridge.rows, 1, length(pitch));
            let taken = and(&crumbs, &near);
            crumbs = sub(&crumbs, &taken);
            bridge.rows = or(&bridge.rows, &taken);
        }
    }
    found
}

/// The bridges over sparse infill of a layer: the parts of `solid`, its solid infill that shows neither
/// above nor below, over `sparse`, the sparse area of the layer below, but for small and narrow ones, with
/// anchors inside `solid`. Lines run at `degrees`.
pub fn over_sparse(
    solid: &Rows,
    sparse: &Rows,
    grid: Grid,
    degrees: f64,
    plan: &BridgePlan,
) -> Option<Bridge> {
    let (area, width) = LEAST_OVER_SPARSE;
    let shrink = grid.frame.units(width / 2.0);
    let across = (shrink / grid.frame.pitch()).max(1) as i32;
    let over = and(solid, sparse);
    // Most layers have none but narrow strips: seen before anything is computed.
    let long = over.spans().iter().filter(|s| s.length() > 2 * shrink).take(2 * across as usize + 1);
    if long.count() <= 2 * across as usize {
        return None;
    }
    let wide = grow::open(&over, across as u32, length(shrink));
    let mut rows = Rows::default();
    for (patch, _) in parts(&wide, &wide, grid.length(area)) {
        let grown = grow::along(&patch, solid, grid.frame, degrees - grid.degrees, plan.anchor);
        rows = or(&rows, &grown);
    }
    (!rows.is_empty()).then(|| Bridge { rows, degrees: degrees.rem_euclid(180.0) })
}

/// The direction \[degrees\] that crosses most of the lines of sparse infill at `lines` \[degrees\], equally
/// many of each: where the sines of the angles in between have the greatest sum. `usual` where it is one of
/// those directions, or there are no lines.
pub fn across(lines: &[f64], usual: f64) -> f64 {
    if let [line] = lines {
        return (line + 90.0).rem_euclid(180.0);
    }
    let crossed = |degrees: f64| {
        let sine = |line: &f64| libm::sin((degrees - line).to_radians()).abs();
        lines.iter().map(sine).sum::<f64>()
    };
    // Between the lines' own directions the sum is a single sine, with its peak at the mean normal; these
    // whole degrees hold every peak of the patterns there are, and are near that of any.
    let most = (0..180).map(|d| crossed(f64::from(d))).fold(crossed(usual), f64::max);
    let best = |d: &f64| crossed(*d) >= most - 1e-6;
    let all = (0..180).map(f64::from).filter(best);
    [usual].into_iter().filter(best).chain(all).next().unwrap_or(usual).rem_euclid(180.0)
}

/// Bridges of the same direction as one, in the order of the first of each.
pub fn by_direction(bridges: Vec<Bridge>) -> Vec<Bridge> {
    let mut sorted: Vec<(usize, Bridge)> = Vec::with_capacity(bridges.len());
    for bridge in bridges {
        let first = sorted.iter().find(|(_, b)| b.degrees == bridge.degrees).map(|(first, _)| *first);
        sorted.push((first.unwrap_or(sorted.len()), bridge));
    }
    sorted.sort_by_key(|(first, _)| *first);
    let bridges: Vec<Bridge> = sorted.into_iter().map(|(_, bridge)| bridge).collect();
    let like = |a: &Bridge, b: &Bridge| a.degrees == b.degrees;
    bridges.chunk_by(like).map(|same| Bridge { rows: union(same), degrees: same[0].degrees }).collect()
}

/// All bridges' rows.
pub fn union(bridges: &[Bridge]) -> Rows {
    if let [one] = bridges {
        return one.rows.clone();
    }
    let of =
        |b: &Bridge| b.rows.iter().flat_map(|(k, row)| row.iter().map(move |&s| (k, s))).collect::<Vec<_>>();
    let mut all: Vec<(i32, Span)> = bridges.iter().flat_map(of).collect();
    all.sort_unstable();
    let mut at = all.first().map_or(0, |first| first.0);
    let mut out = RowsBuilder::new(at);
    for (k, s) in all {
        while at < k {
            out.end_row();
            at += 1;
        }
        out.push(s.start, s.end);
    }
    out.end_row();
    out.finish()
}

/// True when two areas have rows in common on which they are near each other.
fn meet(a: &Rows, b: &Rows) -> bool {
    let (first, end) = (a.first().max(b.first()) - 1, a.end().min(b.end()) + 1);
    (first..end).any(|k| {
        let ends = |rows: &Rows| (-1..=1).filter_map(|j| bounds(rows.row(k + j))).reduce(hull);
        matches!((ends(a), ends(b)), (Some(a), Some(b)) if a.start <= b.end && b.start <= a.end)
    })
}

/// From the first to the last span of a row.
fn bounds(row: &[Span]) -> Option<Span> {
    Some(Span { start: row.first()?.start, end: row.last()?.end })
}

fn hull(a: Span, b: Span) -> Span {
    Span { start: a.start.min(b.start), end: a.end.max(b.end) }
}

/// The connected parts of an area, each with what it holds of another one, if that has at least a total
/// length \[units\].
fn parts(area: &Rows, other: &Rows, least: i64) -> Vec<(Rows, Rows)> {
    let part = label(area);
    let count = part.iter().max().map_or(0, |&m| m as usize + 1);
    let mut built: Vec<Option<(i32, RowsBuilder)>> = Vec::new();
    built.resize_with(count, || None);
    for (k, _) in area.iter() {
        for i in area.range(k) {
            let (row, out) = built[part[i] as usize].get_or_insert_with(|| (k, RowsBuilder::new(k)));
            // Parts are connected, so that none has an empty row.
            if *row < k {
                out.end_row();
            }
            *row = k;
            out.push(area.spans()[i].start, area.spans()[i].end);
        }
    }
    let one = |(_, mut out): (i32, RowsBuilder)| {
        out.end_row();
        let part = out.finish();
        let held = and(other, &part);
        (held.length() >= least).then_some((part, held))
    };
    built.into_iter().flatten().filter_map(one).collect()
}

fn length(units: i64) -> i32 {
    units.clamp(0, i32::MAX.into()) as i32
}
