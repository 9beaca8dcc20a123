//! Which parts of a layer are solid: comparison with the layers above and below, on rows.

use super::FillPlan;
use crate::span::algebra::{and, close_rows, dilate, or, sub};
use crate::span::{RowFrame, Rows, components};

/// Solid patches lose this at either end of a row before they are grown \[nm\]: shorter ones vanish.
/// Across the rows a patch must be two rows wide, or one row beside a wall.
const SHRINK: f64 = 250_000.0;
/// What is left grows by this more than it shrank, in rows and, along the rows, in spacings. It
/// anchors a skin in its surroundings.
const ANCHOR: u32 = 1;

/// An infill area divided by kind; the parts are disjoint and together the whole.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Areas {
    /// Filled at the chosen density.
    pub sparse: Rows,
    /// Solid, not exposed to air above.
    pub solid: Rows,
    /// Solid and exposed to air above.
    pub top: Rows,
    /// Solid and exposed to air below; on the first layer there is none.
    pub bottom: Rows,
}

/// Height of a layer's upper side and its thickness \[nm\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level {
    /// Upper side.
    pub top: i64,
    /// Lower side.
    pub bottom: i64,
}

/// Divides the infill area `own` of layer `i`; `outlines` holds every layer's outline on `frame`.
pub fn divide(
    i: usize,
    own: &Rows,
    outlines: &[&Rows],
    levels: &[Level],
    frame: &RowFrame,
    plan: &FillPlan,
) -> Areas {
    let top = if plan.top_layers == 0 {
        Rows::default()
    } else {
        open(own, outlines.get(i + 1).map(|above| and(own, above)), frame)
    };
    let bottom = match i.checked_sub(1).and_then(|b| outlines.get(b)) {
        Some(below) if plan.bottom_layers > 0 => open(own, Some(and(own, below)), frame),
        _ => Rows::default(),
    };
    let top = sub(&top, &bottom);
    let all_solid =
        plan.density >= 1.0 || plan.solid_every > 0 && (i as u64).is_multiple_of(u64::from(plan.solid_every));
    let mut solid =
        if all_solid { own.clone() } else { open(own, covered(i, own, outlines, levels, plan), frame) };
    let mut sparse = sub(own, &solid);
    if plan.density > 0.0 && plan.solid_below_area > 0.0 && !sparse.is_empty() {
        let least = (plan.solid_below_area / frame.mm2_per_unit()).min(1e18) as i64;
        let small = components::smaller_than(&sparse, least);
        if !small.is_empty() {
            solid = or(&solid, &small);
            sparse = sub(&sparse, &small);
        }
    }
    let solid = sub(&sub(&solid, &top), &bottom);
    Areas { sparse, solid, top, bottom }
}

/// The part of `own` that lies under and over enough layers; `None` where a layer is missing.
fn covered(i: usize, own: &Rows, outlines: &[&Rows], levels: &[Level], plan: &FillPlan) -> Option<Rows> {
    let mut covered = own.clone();
    let mut step = |j: Option<usize>, last: &mut Option<usize>| -> Option<()> {
        let rows: &Rows = outlines.get(j?)?;
        // Prismatic parts: the same outline again changes nothing.
        if last.is_none_or(|l| !std::ptr::eq(outlines[l], rows)) {
            covered = and(&covered, rows);
        }
        *last = j;
        Some(())
    };
    let here = levels.get(i)?;
    let mut last = None;
    for m in 1.. {
        // Layer i + m - 1 is a top surface where layer i + m is missing.
        let depth = levels.get(i + m - 1).map_or(0, |l| l.top - here.top);
        let enough = m as u64 > u64::from(plan.top_layers) && depth >= plan.top_thickness;
        if plan.top_layers == 0 || enough {
            break;
        }
        step(Some(i + m), &mut last)?;
    }
    last = None;
    for m in 1.. {
        let depth = (i + 1).checked_sub(m).and_then(|q| levels.get(q)).map_or(0, |l| here.bottom - l.bottom);
        let enough = m as u64 > u64::from(plan.bottom_layers) && depth >= plan.bottom_thickness;
        if plan.bottom_layers == 0 || enough {
            break;
        }
        step(i.checked_sub(m), &mut last)?;
    }
    Some(covered)
}

/// The part of `own` outside `covered`, opened to remove crumbs and grown to anchor it. `None`
/// stands for nothing covered.
///
/// What lies outside `own` counts as exposed while shrinking, so that a patch keeps its full width
/// beside a wall: to shrink the patch is to grow the covered part of `own`.
fn open(own: &Rows, covered: Option<Rows>, frame: &RowFrame) -> Rows {
    let Some(covered) = covered else { return own.clone() };
    if covered == *own {
        return Rows::default();
    }
    let shrink = frame.units(SHRINK);
    let grow = shrink + i64::from(ANCHOR) * frame.pitch();
    let core = sub(own, &close_rows(&dilate(&covered, 0, length(shrink))));
    and(own, &dilate(&core, ANCHOR, length(grow)))
}

fn length(units: i64) -> i32 {
    units.clamp(0, i32::MAX.into()) as i32
}
