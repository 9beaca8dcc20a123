//! Sparse infill of several layers printed on one of them.

use super::FillPlan;
use super::skin::{Areas, Level};
use crate::span::Rows;

/// A part of a layer's sparse area, to be printed so many layers thick, this one the topmost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Thick {
    /// The area.
    pub rows: Rows,
    /// Number of layers.
    pub layers: u32,
}

/// Divides the sparse areas of all layers among the layers on which they are printed: layer → parts.
pub fn combine(areas: &mut [Areas], _levels: &[Level], _plan: &FillPlan) -> Vec<Vec<Thick>> {
    areas
        .iter_mut()
        .map(|a| {
            let rows = std::mem::take(&mut a.sparse);
            if rows.is_empty() { Vec::new() } else { vec![Thick { rows, layers: 1 }] }
        })
        .collect()
}
