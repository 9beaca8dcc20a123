//! The first layer as it was before it was shrunk against an elephant's foot.

use crate::span::Rows;
use crate::span::algebra::{or, sub};
use crate::span::beyond::{beyond, thick_half_widths};
use crate::support::{Part, SupportPlan};
use std::borrow::Cow;
use std::f64::consts::SQRT_2;
use std::sync::Arc;

/// The part's outlines, the first one grown back as far as the second one goes: what has been taken from
/// the first layer is squeezed out again, so that nothing of the second one hangs for that.
pub fn grown_back<'a>(part: Part<'a>, plan: &SupportPlan) -> Cow<'a, [Arc<Rows>]> {
    let [first, second, ..] = part.outlines else { return Cow::Borrowed(part.outlines) };
    if plan.first_shrink <= 0.0 || Arc::ptr_eq(first, second) {
        return Cow::Borrowed(part.outlines);
    }
    // At a right angle the corner goes that far.
    let reach = part.frame.units(plan.first_shrink * SQRT_2);
    let widths = thick_half_widths(reach, part.frame.pitch(), 1);
    let mut outlines = part.outlines.to_vec();
    outlines[0] = Arc::new(or(first, &sub(second, &beyond(second, first, &widths))));
    Cow::Owned(outlines)
}
