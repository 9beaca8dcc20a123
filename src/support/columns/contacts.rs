//! What hangs → the areas in which columns end.

use super::heights::Step;
use super::{cells, shape};
use crate::lattice::NM_PER_MM;
use crate::settings::SupportStyle;
use crate::span::Rows;
use crate::span::algebra::{and, or, sub};
use crate::span::morph::dilate_disc;
use crate::support::overhang::Overhang;
use crate::support::{Level, Part, SupportPlan};
use rayon::prelude::*;

/// What hangs above one height.
#[derive(Clone, Debug)]
pub struct Hanging {
    /// Where supports under it end \[nm above the bed\].
    pub top: i32,
    /// What hangs.
    pub area: Rows,
    /// Where it lies further out than it may without support.
    pub far: Rows,
    /// Where it hangs so far out that a line would lie in air with most of its width.
    pub deep: Rows,
}

/// Lines that lie in air with more than this share of their width want dense layers under them, in style
/// grid.
const IN_AIR: f64 = 0.75;

/// The end of the columns at one layer of support.
#[derive(Clone, Debug, Default)]
pub struct Contact {
    /// What hangs above.
    pub hangs: Rows,
    /// The columns under it, before anything is cut off for the part's sake.
    pub area: Rows,
    /// The dense part of those.
    pub dense: Rows,
}

/// What hangs, by the height at which supports end under it, ascending.
pub fn hanging(part: Part, overhangs: &[Overhang], plan: &SupportPlan) -> Vec<Hanging> {
    let layers = overhangs.len().min(part.outlines.len());
    let mut all: Vec<Hanging> =
        (1..layers).into_par_iter().flat_map_iter(|i| of_layer(part, i, &overhangs[i], plan)).collect();
    all.sort_by_key(|h| h.top);
    all
}

fn of_layer(part: Part, i: usize, overhang: &Overhang, plan: &SupportPlan) -> Vec<Hanging> {
    if overhang.area.is_empty() {
        return Vec::new();
    }
    let (frame, area) = (part.frame, overhang.area.clone());
    let t = |k| frame.t(k);
    let top = (part.levels[i].bottom as i32).saturating_sub(plan.top_gap);
    let wall = frame.units(2.0 * plan.half_wall);
    let below = and(&part.outlines[i - 1], &shape::box_around(&area, wall, frame));
    let reach = reach(part.levels, i - 1, plan);
    let far = sub(&area, &dilate_disc(&below, frame.units(reach.max(plan.half_wall)), t));
    let beyond = |distance: i64| match far.is_empty() {
        true => Rows::default(),
        false => sub(&far, &dilate_disc(&below, distance, t)),
    };
    let deep = match plan.style {
        SupportStyle::Grid => beyond(frame.units(2.0 * IN_AIR * plan.half_wall)),
        _ => Rows::default(),
    };
    let threads = if plan.thread_drop > 0 { beyond(wall) } else { Rows::default() };
    if threads.is_empty() {
        return vec![Hanging { top, area, far, deep }];
    }
    // The line beside those in air hangs no lower than they do, yet a layer of its own is not worth while.
    let low = and(&area, &dilate_disc(&threads, wall + 2 * frame.pitch(), t));
    let high = sub(&area, &low);
    let lower = top.saturating_sub(plan.thread_drop);
    let part_of = |all: &Rows| [and(all, &low), and(all, &high)];
    let ([far_low, far_high], [deep_low, deep_high]) = (part_of(&far), part_of(&deep));
    let mut both = vec![Hanging { top: lower, far: far_low, deep: deep_low, area: low }];
    if !high.is_empty() {
        both.push(Hanging { top, area: high, far: far_high, deep: deep_high });
    }
    both
}

/// How far the layer above layer `i` may hang over it \[nm\]: as its slope allows.
pub fn reach(levels: &[Level], i: usize, plan: &SupportPlan) -> f64 {
    let own = levels[i];
    let above = levels.get(i + 1).unwrap_or(&own);
    // From one cutting plane to the next.
    let rise = 0.5 * (above.top + above.bottom - own.top - own.bottom) as f64;
    let by_slope = plan.threshold.map_or(plan.half_wall, |degrees| rise / libm::tan(degrees.to_radians()));
    by_slope.clamp(0.0, NM_PER_MM * 100.0)
}

/// The contacts of each layer of support: what hangs ends columns at the highest layer that is no higher
/// than it allows. Length = layers.
pub fn contacts(part: Part, hanging: Vec<Hanging>, layers: &[Step], plan: &SupportPlan) -> Vec<Contact> {
    let mut merged = vec![[Rows::default(), Rows::default(), Rows::default()]; layers.len()];
    for h in hanging {
        if let Some(i) = layers.partition_point(|l| l.top <= h.top).checked_sub(1) {
            for (all, own) in merged[i].iter_mut().zip([h.area, h.far, h.deep]) {
                *all = or(all, &own);
            }
        }
    }
    merged.into_par_iter().map(|of_layer| contact(part, of_layer, plan)).collect()
}

fn contact(part: Part, [hangs, far, deep]: [Rows; 3], plan: &SupportPlan) -> Contact {
    if hangs.is_empty() {
        return Contact::default();
    }
    if plan.style == SupportStyle::Grid {
        // Lines that the layer below holds by half need no more than the columns' own ones under them.
        let (area, dense) = (cells::covering(&hangs, plan), cells::covering(&deep, plan));
        return Contact { hangs, area, dense };
    }
    let frame = part.frame;
    let area = shape::widened(&shape::closed(&hangs, plan.closing, frame), &far, plan.width, frame);
    Contact { hangs, dense: area.clone(), area }
}
