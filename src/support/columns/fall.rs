//! Contacts → what stands under them, layer by layer.

use super::clearance::{Clearance, Free};
use super::contacts::Contact;
use super::heights::Step;
use super::shape::{box_around, without_slivers};
use crate::span::algebra::{and_row, or, sub};
use crate::span::components::label;
use crate::span::{Rows, RowsBuilder};
use crate::support::{Part, SupportPlan};
use rayon::prelude::*;
use std::sync::Arc;

/// Layers whose clearances are worked out at a time.
const CHUNK: usize = 16;

/// The area of the columns on each layer; equal neighbours share theirs. Length = layers.
///
/// What falls is what fell from the layer above and what ends here, less the part. The columns are that less
/// the gaps, which do not fall: below a wall its gap is filled again.
pub fn fall(part: Part, layers: &[Step], contacts: &[Contact], plan: &SupportPlan) -> Vec<Arc<Rows>> {
    let clearance = Clearance::new(part, plan);
    let mut all = Vec::with_capacity(layers.len());
    let (mut falls, mut area) = (Arc::new(Rows::default()), Arc::new(Rows::default()));
    for (steps, ends) in layers.rchunks(CHUNK).zip(contacts.rchunks(CHUNK)) {
        let reached = ends.iter().fold((*falls).clone(), |all, end| or(&all, &end.area));
        let around = box_around(&reached, clearance.widest(), part.frame);
        let free: Vec<Option<Free>> = (0..steps.len())
            .into_par_iter()
            .map(|i| {
                let same = steps.get(i + 1).is_some_and(|above| clearance.same(steps[i], *above));
                (!same).then(|| clearance.of(steps[i], &around))
            })
            .collect();
        let mut last = &Free::default();
        for (free, end) in free.iter().zip(ends).rev() {
            let below = step(&falls, end, free.as_ref().unwrap_or(last));
            if free.is_some() || !Arc::ptr_eq(&below, &falls) {
                last = free.as_ref().unwrap_or(last);
                let own = without_slivers(&sub(&below, &last.with_gaps), plan.width, part.frame);
                area = shared(own, &area);
            }
            falls = below;
            all.push(Arc::clone(&area));
        }
    }
    all.reverse();
    all
}

/// What falls, from one layer to the next lower one.
fn step(above: &Arc<Rows>, end: &Contact, free: &Free) -> Arc<Rows> {
    let rest = shared(sub(above, &free.part), above);
    if end.area.is_empty() {
        return rest;
    }
    let new = touching(&sub(&end.area, &free.with_gaps), &[&end.hangs, &rest]);
    // With the gaps beside it, which are to be filled further down.
    let new = touching(&sub(&end.area, &free.part), &[&new]);
    shared(or(&rest, &new), above)
}

/// The old one, if it is equal.
fn shared(new: Rows, old: &Arc<Rows>) -> Arc<Rows> {
    if new == **old { Arc::clone(old) } else { Arc::new(new) }
}

/// The connected parts of an area that overlap one of the others: what was cut off by a wall is not.
fn touching(area: &Rows, others: &[&Rows]) -> Rows {
    if area.is_empty() {
        return Rows::default();
    }
    let part = label(area);
    let mut touched = vec![false; part.iter().max().map_or(0, |m| *m as usize + 1)];
    for k in area.first()..area.end() {
        let begin = area.range(k).start;
        for other in others {
            and_row(area.row(k), other.row(k), |_, i| touched[part[begin + i] as usize] = true);
        }
    }
    if touched.iter().all(|t| *t) {
        return area.clone();
    }
    let mut out = RowsBuilder::new(area.first());
    for k in area.first()..area.end() {
        for i in area.range(k).filter(|i| touched[part[*i] as usize]) {
            out.push(area.spans()[i].start, area.spans()[i].end);
        }
        out.end_row();
    }
    out.finish()
}

/// Leaves only what stands on the lowest layer.
pub fn keep_to_bed(areas: &mut [Arc<Rows>]) {
    let mut ended = Rows::default();
    for i in 1..areas.len() {
        if !Arc::ptr_eq(&areas[i - 1], &areas[i]) {
            ended = or(&ended, &sub(&areas[i], &areas[i - 1]));
        }
        if !ended.is_empty() {
            areas[i] = Arc::new(sub(&areas[i], &ended));
        }
    }
}
