//! What hangs → what holds it.

use super::draw::apart_from;
use super::seeds::{Ribs, ribs};
use super::{Held, Overhang, Part, SupportPlan, per_layer, span};
use crate::span::algebra::{and, or, sub};
use crate::span::components::smaller_than;
use crate::span::morph::{dilate_disc, erode_disc};
use crate::span::{RowFrame, Rows, RowsBuilder};
use rayon::prelude::*;
use std::sync::Arc;

/// What is narrower than twice this needs no roof \[nm\].
const NARROW: f64 = 600_000.0;
/// Smaller areas need no roof \[mm²\].
const LEAST_ROOF: f64 = 3.0;
/// What hangs without needing support is supported, because the user asks for it, from this size on \[mm²\].
const LEAST_ASKED: f64 = 0.2;

/// Support that a layer of the part wants.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The part's layer.
    pub of: usize,
    /// How high the support may reach \[nm above the bed\].
    pub top: i32,
    /// The support's layer that reaches as high.
    pub layer: usize,
}

/// The layers of the part that need support, lowest first.
pub fn wanted(part: Part, overhangs: &[Overhang], plan: &SupportPlan) -> Vec<Wanted> {
    let hangs = |i: &usize| overhangs.get(*i).is_some_and(|o| !o.area.is_empty());
    let top = |i: usize| i32::try_from(part.levels[i].bottom).unwrap_or(i32::MAX) - plan.top_gap;
    (1..part.outlines.len()).filter(hangs).map(|of| Wanted { of, top: top(of), layer: 0 }).collect()
}

/// How far layer `i` holds itself over the one below \[nm\].
pub fn reach(part: Part, i: usize, plan: &SupportPlan) -> f64 {
    let (own, below) = (part.levels[i], part.levels[i - 1]);
    let rise = 0.5 * (own.top + own.bottom - below.top - below.bottom) as f64;
    let by_slope = plan.threshold.map_or(0.0, |degrees| rise / libm::tan(degrees.to_radians()));
    by_slope.max(plan.half_wall)
}

/// What holds the part, per layer of supports.
pub fn held(
    part: Part,
    overhangs: &[Overhang],
    wanted: &[Wanted],
    keep_out: &[Arc<Rows>],
    plan: &SupportPlan,
) -> Vec<Held> {
    let areas: Vec<[Rows; 2]> = wanted
        .par_iter()
        .map(|w| contact(part, &overhangs[w.of].area, w, &keep_out[w.layer], plan))
        .collect();
    let dense = plan.top_interface.max(1) as usize;
    let mut held = per_layer(keep_out.len(), |j| {
        // Contacts ascend, and so do their layers.
        let from = wanted.partition_point(|w| w.layer < j);
        let mut own = Held::default();
        for (w, [roof, strip]) in wanted.iter().zip(&areas).skip(from) {
            if w.layer >= j + dense {
                break;
            }
            own.interface = or(&own.interface, roof);
            if w.layer == j {
                own.contact = or(&own.contact, roof);
                own.strips = or(&own.strips, strip);
            }
        }
        own.interface = sub(&own.interface, &keep_out[j]);
        own.contact = and(&own.contact, &own.interface);
        own.strips = sub(&own.strips, &own.interface);
        own.all = or(&own.interface, &own.strips);
        own
    });
    let frame = &plan.frame;
    let holds_itself = frame.units(plan.half_wall);
    let carried = per_layer(held.len(), |j| match held.get(j + 1) {
        Some(above) if !above.all.is_empty() => {
            let lies = dilate_disc(&held[j].all, holds_itself, |k| frame.t(k));
            sub(&sub(&above.all, &lies), &keep_out[j])
        }
        _ => Rows::default(),
    });
    let tip = frame.units(plan.tree.tip_radius);
    let ribs = per_layer(held.len(), |j| {
        let Some(above) = held.get(j + 1).filter(|_| !carried[j].is_empty()) else { return Ribs::default() };
        let t = |k| frame.t(k);
        let roof = and(&carried[j], &above.interface);
        let wide = and(&roof, &dilate_disc(&erode_disc(&roof, tip, t), tip, t));
        ribs(&wide, 2.0 * tip as f64, span(plan), frame)
    });
    for ((held, carried), ribs) in held.iter_mut().zip(carried).zip(ribs) {
        (held.carried, held.ribs) = (carried, ribs);
    }
    held
}

/// The roof and the strips that hold what hangs: every point of `area` that does not hold itself is at most its
/// reach from one of them, or support is not allowed there.
fn contact(part: Part, area: &Rows, wanted: &Wanted, keep_out: &Rows, plan: &SupportPlan) -> [Rows; 2] {
    let frame = part.frame;
    let t = |k| frame.t(k);
    let reach = frame.units(reach(part, wanted.of, plan));
    let tip = frame.units(plan.tree.tip_radius);
    let mut need = sub(area, &dilate_disc(&part.outlines[wanted.of - 1], reach, t));
    need = or(&need, &without(area, &need, frame));
    let narrow = frame.units(NARROW);
    let wide = dilate_disc(&erode_disc(&need, narrow, t), narrow + reach + frame.pitch(), t);
    let wide = large(&and(area, &wide), frame);
    let roof = match plan.top_interface {
        0 => Rows::default(),
        _ => sub(&wide, keep_out),
    };
    let ribs = match plan.top_interface {
        0 => sub(&and(&stripes(&wide, 2 * tip, 2 * tip + 2 * reach - frame.pitch(), frame), &wide), keep_out),
        _ => Rows::default(),
    };
    let rest = sub(&sub(&need, &dilate_disc(&roof, reach, t)), &dilate_disc(&ribs, reach, t));
    let strips = sub(&dilate_disc(&rest, tip, t), keep_out);
    [roof, or(&ribs, &strips)]
}

/// Stripes `width` wide and about `pitch` apart \[units\] along the rows over the extent of an area.
pub fn stripes(area: &Rows, width: i64, pitch: i64, frame: &RowFrame) -> Rows {
    let every = (pitch / frame.pitch()).max(1) as i32;
    let wide = ((width / frame.pitch()) as i32).clamp(1, every);
    let mut out = RowsBuilder::new(area.first());
    for (k, row) in area.iter() {
        if k.rem_euclid(every) < wide {
            row.iter().for_each(|s| out.push(s.start, s.end));
        }
        out.end_row();
    }
    out.finish()
}

/// The larger connected parts of `area` in which nothing is needed.
fn without(area: &Rows, need: &Rows, frame: &RowFrame) -> Rows {
    let least = (LEAST_ASKED / frame.mm2_per_unit()) as i64;
    let idle = apart_from(area, need);
    if idle.is_empty() { idle } else { sub(&idle, &smaller_than(&idle, least)) }
}

/// The connected parts that are large enough for a roof.
fn large(area: &Rows, frame: &RowFrame) -> Rows {
    if area.is_empty() {
        return Rows::default();
    }
    sub(area, &smaller_than(area, (LEAST_ROOF / frame.mm2_per_unit()) as i64))
}
