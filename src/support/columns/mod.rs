//! Columns under what hangs.

mod cells;
mod clearance;
mod contacts;
mod dense;
mod fall;
mod foot;
mod heights;
mod shape;
#[cfg(test)]
mod tests;

use super::overhang::Overhang;
use super::{Part, SupportLayer, SupportPlan};

/// Columns under all overhangs, lowest layer first.
///
/// What hangs is projected downwards until it meets the part or the bed; in style grid as whole cells. All
/// columns share one list of layers. Nothing lies within `xy_gap` of the part beside it, within `top_gap` of
/// the part above or within `bottom_gap` of the part below; what has no room is left out.
pub fn columns(part: Part, overhangs: &[Overhang], plan: &SupportPlan) -> Vec<SupportLayer> {
    let hanging = contacts::hanging(part, overhangs, plan);
    let layers = heights::layers(part, &hanging, plan);
    let contacts = contacts::contacts(part, hanging, &layers, plan);
    let mut areas = fall::fall(part, &layers, &contacts, plan);
    if plan.on_bed_only {
        fall::keep_to_bed(&mut areas);
    }
    let mut columns = dense::dense(part.frame, &layers, &contacts, &areas, plan);
    foot::widen(part, &mut columns, plan);
    columns.retain(|layer| !layer.is_empty());
    columns
}
