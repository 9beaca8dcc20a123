//! Areas of support → lines.
//!
//! The middle of a line lies half its width inside the border of its area, so that an area is covered as far as
//! it reaches and no further. Lines of one distance and direction lie at fixed places of the mesh frame, those
//! of columns above each other.

mod base;
mod dense;
mod fill;
mod laying;
mod outline;
mod shrink;
mod straighten;
#[cfg(test)]
mod tests;
mod thin;

use super::{LayerKind, Strand, SupportLayer, SupportPlan};
use crate::settings::{SupportPattern, SupportStyle};
use rayon::prelude::*;

/// The lines of all layers, in the layers' order; within a layer what is loose comes before what is dense, and
/// the lines of an area before the wall around it. Whoever prints them may choose among the lines of one kind.
pub fn strands(layers: &[SupportLayer], plan: &SupportPlan) -> Vec<Vec<Strand>> {
    let loose = each(layers, base_period(plan), base::is_same, |i| base::lay(&layers[i], i, plan));
    let dense = each(layers, dense_period(layers, plan), dense::is_same, |i| dense::lay(&layers[i], i, plan));
    let joined = loose.into_iter().zip(dense);
    joined
        .map(|(mut all, dense)| {
            all.extend(dense);
            all
        })
        .collect()
}

/// The strands of every layer; those of a layer that is the same as the one `period` below are taken from it.
fn each(
    layers: &[SupportLayer],
    period: usize,
    is_same: fn(&SupportLayer, &SupportLayer) -> bool,
    lay: impl Fn(usize) -> Vec<Strand> + Sync,
) -> Vec<Vec<Strand>> {
    let repeats = |i: usize| i.checked_sub(period).is_some_and(|below| is_same(&layers[i], &layers[below]));
    let own: Vec<Option<Vec<Strand>>> =
        (0..layers.len()).into_par_iter().map(|i| (!repeats(i)).then(|| lay(i))).collect();
    let mut all: Vec<Vec<Strand>> = Vec::with_capacity(layers.len());
    for (i, strands) in own.into_iter().enumerate() {
        let strands =
            strands.unwrap_or_else(|| i.checked_sub(period).map_or_else(Vec::new, |b| all[b].clone()));
        all.push(strands);
    }
    all
}

/// After how many layers the columns' lines are the same.
fn base_period(plan: &SupportPlan) -> usize {
    match plan.pattern {
        SupportPattern::Rectilinear => 1,
        SupportPattern::RectilinearGrid => 2,
        SupportPattern::Honeycomb => 3,
    }
}

/// After how many layers the dense layers' lines are the same.
fn dense_period(layers: &[SupportLayer], plan: &SupportPlan) -> usize {
    let turns = plan.style == SupportStyle::Snug || layers.iter().any(|l| l.kind == LayerKind::RaftInterface);
    if turns { 2 } else { 1 }
}

/// Parts of areas smaller than this share of a square as wide as a line are left out.
const CRUMB: f64 = 0.25;

/// The smallest area that is printed \[mm²\].
fn crumb(plan: &SupportPlan) -> f64 {
    let width = plan.width * 1e-6;
    CRUMB * width * width
}
