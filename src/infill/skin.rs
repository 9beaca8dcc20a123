//! Which parts of a layer are solid: comparison with the layers above and below, on rows.

use super::{FillKind, FillPlan};
use crate::settings::VerticalShell;
use crate::span::algebra::{and, and_row, close_rows, dilate, or, sub};
use crate::span::morph::dilate_disc;
use crate::span::{RowFrame, Rows, RowsBuilder, components};
use std::borrow::Cow;
use std::sync::Arc;

/// Exposed patches lose this at either end of a row before they are grown \[nm\]: shorter ones vanish.
/// Across the rows a patch must be two rows wide, or one row beside a wall.
const SHRINK: f64 = 50_000.0;
/// The inner layers of a shell are widened by this many spacings of solid lines, as strips beside walls
/// would hold no line otherwise;
const WIDEN: f64 = 3.3;
/// by this many where such strips are made wide enough anyway.
const WIDEN_LESS: f64 = 1.05;
/// Solid strips beside walls are at least this many spacings wide,
const NARROW: f64 = 1.5;
/// and reach this many spacings over what they are for.
const OVERLAP: f64 = 0.3;

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

/// All layers of an object on the rows of one frame, lowest first.
#[derive(Clone, Copy, Debug)]
pub struct Stack<'a> {
    /// Outlines; neighbours that are equal share theirs.
    pub outlines: &'a [Arc<Rows>],
    /// Infill areas; neighbours that are equal share theirs.
    pub own: &'a [Arc<Rows>],
    /// Heights.
    pub levels: &'a [Level],
    /// The rows.
    pub frame: &'a RowFrame,
    /// Settings.
    pub plan: &'a FillPlan,
}

/// Sparse areas narrower than this many solid lines, between a skin and a wall, are solid.
const SLIVER: f64 = 1.5;

/// The skins of a layer that air touches, disjoint parts of its infill area.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Skins {
    /// Exposed above.
    pub top: Rows,
    /// Exposed below.
    pub bottom: Rows,
}

impl Stack<'_> {
    /// The parts of layer `i` with nothing over or under them, without crumbs, grown into the part by the
    /// plan's margin. What is exposed both above and below belongs to the bottom.
    pub fn skins(&self, i: usize) -> Skins {
        let own = &*self.own[i];
        let exposed = |j: Option<usize>, count: u32| match j.and_then(|j| self.outlines.get(j)) {
            _ if count == 0 => Rows::default(),
            Some(other) if Arc::ptr_eq(other, &self.outlines[i]) => Rows::default(),
            Some(other) => self.tidy(own, &and(own, other)),
            None => own.clone(),
        };
        let plan = self.plan;
        // The first layer lies on the bed.
        let under = if i == 0 { Rows::default() } else { exposed(i.checked_sub(1), plan.bottom_layers) };
        let on_bed = i == 0 && plan.bottom_layers > 0;
        let over = if on_bed { Rows::default() } else { sub(&exposed(Some(i + 1), plan.top_layers), &under) };
        let top = sub(&self.grow(own, &over, SHRINK + plan.margin), &under);
        let bottom = sub(&self.grow(own, &under, SHRINK + plan.margin), &top);
        Skins { top, bottom }
    }

    /// Divides the infill area of layer `i`; `skins` are those of all layers.
    pub fn divide(&self, i: usize, skins: &[Skins]) -> Areas {
        let (own, plan) = (&*self.own[i], self.plan);
        let Skins { top, bottom } = skins[i].clone();
        let every = u64::from(plan.solid_every);
        let mut solid = if plan.density >= 1.0 || every > 0 && (i as u64).is_multiple_of(every) {
            own.clone()
        } else {
            self.shell(i, skins)
        };
        let mut sparse = sub(own, &solid);
        if !solid.is_empty() && !sparse.is_empty() {
            // Slivers between a skin and a wall have no room for sparse lines.
            let reach = self.frame.units(SLIVER * plan.pitch(FillKind::Solid, i));
            let grown = |area: &Rows| dilate_disc(area, reach, |k| self.frame.t(k));
            sparse = and(&sparse, &grown(&sub(&sparse, &grown(&solid))));
            solid = sub(own, &sparse);
        }
        if plan.density > 0.0 && plan.solid_below_area > 0.0 && !sparse.is_empty() {
            let least = (plan.solid_below_area / self.frame.mm2_per_unit()).min(1e18) as i64;
            let small = components::smaller_than(&sparse, least);
            if !small.is_empty() {
                solid = or(&solid, &small);
                sparse = sub(&sparse, &small);
            }
        }
        Areas { sparse, solid: sub(&sub(&solid, &top), &bottom), top, bottom }
    }

    /// The solid part of layer `i`: its skins, and what belongs to the shells of layers above and below.
    fn shell(&self, i: usize, skins: &[Skins]) -> Rows {
        let own = &*self.own[i];
        let Some(covered) = self.covered(i) else { return own.clone() };
        let spacing = self.plan.pitch(FillKind::Solid, i);
        let is_wide = self.plan.vertical_shell != VerticalShell::Disabled;
        let widen = if is_wide { WIDEN_LESS } else { WIDEN };
        let mut solid = self.grow(own, &self.tidy(own, &covered), SHRINK + widen * spacing);
        let mut add = |part: &Rows| {
            if !part.is_empty() {
                solid = or(&solid, &and(own, part));
            }
        };
        add(&skins[i].top);
        add(&skins[i].bottom);
        skins[i + 1..].iter().take(self.above(i).saturating_sub(1)).for_each(|s| add(&s.top));
        skins[..i].iter().rev().take(self.below(i).saturating_sub(1)).for_each(|s| add(&s.bottom));
        match self.plan.vertical_shell {
            VerticalShell::Disabled => return solid,
            VerticalShell::Partial if solid.is_empty() => return solid,
            _ => {}
        }
        let strips = self.beside_walls(i, spacing);
        let all = or(&solid, &strips);
        if self.plan.vertical_shell == VerticalShell::Partial { connected(&all, &solid) } else { all }
    }

    /// The part of layer `i` that lies under and over enough layers; `None` where one is missing.
    fn covered(&self, i: usize) -> Option<Cow<'_, Rows>> {
        let mut covered = Cow::Borrowed(&*self.own[i]);
        for (count, up) in [(self.above(i), true), (self.below(i), false)] {
            let at = |m: usize| if up { Some(i + m) } else { i.checked_sub(m) };
            let mut last = i;
            for m in 1..=count {
                let j = at(m)?;
                let outline = self.outlines.get(j)?;
                // Prismatic parts: the same again changes nothing.
                if !Arc::ptr_eq(outline, &self.outlines[last]) {
                    covered = Cow::Owned(and(&covered, outline));
                }
                last = j;
            }
        }
        Some(covered)
    }

    /// The part of layer `i` with walls over or under it, so that slopes are as thick as they are wide;
    /// strips that are too narrow for a line are left out.
    fn beside_walls(&self, i: usize, spacing: f64) -> Rows {
        let own = &*self.own[i];
        let mut inside = Cow::Borrowed(own);
        for (count, up) in [(self.above(i), true), (self.below(i), false)] {
            let mut last = i;
            // The layer behind the shell is only to be there.
            for m in 1..count {
                let at = if up { Some(i + m) } else { i.checked_sub(m) };
                let Some((j, other)) = at.and_then(|j| Some((j, self.own.get(j)?))) else { break };
                if !Arc::ptr_eq(other, &self.own[last]) {
                    inside = Cow::Owned(and(&inside, other));
                }
                last = j;
            }
        }
        if inside.length() == own.length() {
            return Rows::default();
        }
        let shrink = NARROW * spacing;
        let wide = sub(own, &dilate_disc(&inside, self.frame.units(shrink), |k| self.frame.t(k)));
        self.grow(own, &wide, shrink + OVERLAP * spacing)
    }

    /// Number of layers over layer `i` that must be there for it to be sparse.
    fn above(&self, i: usize) -> usize {
        let plan = self.plan;
        let levels = &self.levels[i..];
        // Layer i + m - 1 is a top surface where layer i + m is missing.
        let shallow = |m: &usize| {
            let depth = levels.get(m - 1).map(|l| l.top - levels[0].top);
            depth.is_some_and(|d| *m as u64 <= u64::from(plan.top_layers) || d < plan.top_thickness)
        };
        if plan.top_layers == 0 { 0 } else { (1..).take_while(shallow).count() }
    }

    /// The same under it.
    fn below(&self, i: usize) -> usize {
        let plan = self.plan;
        let levels = &self.levels[..=i];
        let shallow = |m: &usize| {
            let depth = (i + 1).checked_sub(*m).map(|q| levels[i].bottom - levels[q].bottom);
            depth.is_some_and(|d| *m as u64 <= u64::from(plan.bottom_layers) || d < plan.bottom_thickness)
        };
        if plan.bottom_layers == 0 { 0 } else { (1..).take_while(shallow).count() }
    }

    /// The part of `own` outside `covered` without crumbs.
    ///
    /// What lies outside `own` counts as exposed while shrinking, so that a patch keeps its full width
    /// beside a wall: to shrink the patch is to grow the covered part of `own`. It stays shrunk.
    fn tidy(&self, own: &Rows, covered: &Rows) -> Rows {
        if covered.length() == own.length() {
            return Rows::default();
        }
        let shrink = length(self.frame.units(SHRINK));
        let grown = dilate(covered, 0, shrink);
        sub(own, &close_rows(&grown))
    }

    /// `core` grown by `radius` \[nm\] as far as it is connected in `own`.
    fn grow(&self, own: &Rows, core: &Rows, radius: f64) -> Rows {
        if core.is_empty() {
            return Rows::default();
        }
        let radius = self.frame.units(radius);
        connected(&and(own, &dilate_disc(core, radius, |k| self.frame.t(k))), core)
    }
}

/// The connected parts of `area` that hold some of `seed`, a part of it.
fn connected(area: &Rows, seed: &Rows) -> Rows {
    let label = components::label(area);
    let mut keep = vec![false; label.len()];
    for (k, row) in seed.iter() {
        let first = area.range(k).start;
        and_row(area.row(k), row, |_, i| keep[label[first + i] as usize] = true);
    }
    if label.iter().all(|&l| keep[l as usize]) {
        return area.clone();
    }
    let mut out = RowsBuilder::new(area.first());
    for k in area.first()..area.end() {
        for i in area.range(k) {
            if keep[label[i] as usize] {
                out.push(area.spans()[i].start, area.spans()[i].end);
            }
        }
        out.end_row();
    }
    out.finish()
}

fn length(units: i64) -> i32 {
    units.clamp(0, i32::MAX.into()) as i32
}
