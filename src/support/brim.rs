//! Loops on the first layer that hold the print to the bed.

use super::Strand;
use crate::contour::ExPolygon;
use crate::settings::AdhesionSettings;
use crate::settings::flow::Flow;

/// The brim around `first`, the outlines of the part's first layer; it keeps clear of `others`, the supports.
pub fn brim(
    first: &[ExPolygon],
    others: &[ExPolygon],
    flow: Flow,
    settings: &AdhesionSettings,
) -> Vec<Strand> {
    let _ = (first, others, flow, settings);
    Vec::new()
}
