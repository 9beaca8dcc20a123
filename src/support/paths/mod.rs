//! Areas of support → lines.

use super::{Strand, SupportLayer, SupportPlan};

/// The lines of all layers, in the layers' order; within a layer in the order in which they are to be laid.
pub fn strands(layers: &[SupportLayer], plan: &SupportPlan) -> Vec<Vec<Strand>> {
    let _ = plan;
    vec![Vec::new(); layers.len()]
}
