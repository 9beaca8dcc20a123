//! Columns under what hangs.

use super::overhang::Overhang;
use super::{Part, SupportLayer, SupportPlan};

/// Columns under all overhangs, lowest layer first.
pub fn columns(part: Part, overhangs: &[Overhang], plan: &SupportPlan) -> Vec<SupportLayer> {
    let _ = (part, overhangs, plan);
    Vec::new()
}
