//! Sparse infill of several layers printed on one of them.

use super::skin::{Areas, Level};
use super::{FillKind, FillPlan};
use crate::span::algebra::{and, sub};
use crate::span::morph::dilate_disc;
use crate::span::{RowFrame, Rows, components};
use rayon::prelude::*;

/// Parts common to several layers that are smaller than this are printed layer by layer \[mm²\].
const LEAST: f64 = 4.0;

/// What is left of a layer beside them is printed where it is wider than this many solid lines.
const STRIP: f64 = 2.0;

/// A part of a layer's sparse area, to be printed so many layers thick, this one the topmost.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Thick {
    /// The area.
    pub rows: Rows,
    /// Number of layers.
    pub layers: u32,
}

/// Divides the sparse areas of all layers, which are taken, among the layers on which they are printed:
/// layer → parts.
///
/// Layers go together as many as the plan says and the nozzle's bore allows, the first layer alone.
/// What all of a group have in common is printed on the topmost of them, so never under a skin; the rest
/// on its own layer.
pub fn combine(areas: &mut [Areas], levels: &[Level], frame: &RowFrame, plan: &FillPlan) -> Vec<Vec<Thick>> {
    let least = (LEAST / frame.mm2_per_unit()).min(1e18) as i64;
    let parts: Vec<Vec<Vec<Thick>>> = groups(areas, levels, plan)
        .into_par_iter()
        .map(|group| {
            let common = common(group, least);
            let count = group.len();
            let mut out: Vec<Vec<Thick>> = group
                .iter_mut()
                .map(|a| {
                    let own = std::mem::take(&mut a.sparse);
                    let rows = if common.is_empty() { own } else { rest(&own, &common, frame, plan) };
                    let part = Thick { rows, layers: 1 };
                    if part.rows.is_empty() { Vec::new() } else { vec![part] }
                })
                .collect();
            if let Some(last) = out.last_mut()
                && !common.is_empty()
            {
                last.push(Thick { rows: common, layers: count as u32 });
            }
            out
        })
        .collect();
    parts.into_iter().flatten().collect()
}

/// The layers that go together.
fn groups<'a>(areas: &'a mut [Areas], levels: &[Level], plan: &FillPlan) -> Vec<&'a mut [Areas]> {
    let mut rest = areas;
    let mut out = Vec::new();
    let mut at = 0;
    while at < levels.len().min(at + rest.len()) {
        let thickness = |n: usize| levels.get(at + n - 1).map(|l| l.top - levels[at].bottom);
        let fits = |n: &usize| thickness(*n).is_some_and(|t| t <= plan.thickest);
        let most = if at == 0 { 1 } else { plan.combine as usize };
        let count = (2..=most).take_while(fits).last().unwrap_or(1);
        let (group, behind) = rest.split_at_mut(count);
        out.push(group);
        rest = behind;
        at += count;
    }
    out
}

/// The sparse area that all layers of a group have.
fn common(group: &[Areas], least: i64) -> Rows {
    let [first, others @ ..] = group else { return Rows::default() };
    if others.is_empty() {
        return Rows::default();
    }
    let mut common = first.sparse.clone();
    for a in others {
        if a.sparse != common {
            common = and(&common, &a.sparse);
        }
    }
    let small = components::smaller_than(&common, least);
    if small.is_empty() { common } else { sub(&common, &small) }
}

/// What is left of a layer's sparse area beside the common one, without narrow strips: on slopes each
/// layer has one, which would hold links and no lines.
fn rest(own: &Rows, common: &Rows, frame: &RowFrame, plan: &FillPlan) -> Rows {
    let rest = sub(own, common);
    if rest.is_empty() {
        return rest;
    }
    let strip = frame.units(STRIP * plan.spacing[FillKind::Solid as usize]);
    let grown = |rows: &Rows| dilate_disc(rows, strip, |k| frame.t(k));
    let wide = sub(&rest, &grown(common));
    if wide.is_empty() { wide } else { and(&rest, &grown(&wide)) }
}
