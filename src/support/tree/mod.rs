//! Branches that grow together on their way down.

use super::overhang::Overhang;
use super::{Part, SupportLayer, SupportPlan};

/// Branches under all overhangs, lowest layer first.
pub fn tree(part: Part, overhangs: &[Overhang], plan: &SupportPlan) -> Vec<SupportLayer> {
    let _ = (part, overhangs, plan);
    Vec::new()
}
