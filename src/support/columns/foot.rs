//! Columns stand on the bed with a wider foot.

use super::clearance::Clearance;
use super::heights::Step;
use super::shape::box_around;
use crate::span::algebra::{or, sub};
use crate::span::morph::dilate_disc;
use crate::support::{Part, SupportLayer, SupportPlan};

/// Widens what lies on the bed, in steps of about a line, so that it does not come out behind a thin wall.
pub fn widen(part: Part, columns: &mut [SupportLayer], plan: &SupportPlan) {
    let Some(first) = columns.first_mut().filter(|l| l.bottom_z() == 0) else { return };
    let frame = part.frame;
    let clearance = Clearance::new(part, plan);
    let own = or(&or(&first.base, &first.interface), &first.bottom_interface);
    let around = box_around(&own, frame.units(plan.first_expansion) + clearance.widest(), frame);
    let free = clearance.of(Step { bottom: 0, top: first.print_z }, &around).with_gaps;
    let steps = (plan.first_expansion / plan.width.max(1.0)).ceil().clamp(0.0, 1000.0);
    let mut foot = own;
    for _ in 0..steps as u32 {
        let grown = dilate_disc(&foot, frame.units(plan.first_expansion / steps), |k| frame.t(k));
        foot = sub(&grown, &free);
    }
    first.base = sub(&sub(&foot, &first.interface), &first.bottom_interface);
}
