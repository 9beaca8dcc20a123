//! What the part keeps free of supports.

use super::contacts::reach;
use super::heights::Step;
use crate::span::Rows;
use crate::span::algebra::{and, or};
use crate::span::morph::dilate_disc;
use crate::support::{Part, SupportPlan};
use std::ops::Range;
use std::sync::Arc;

/// The part with the gaps around it.
pub struct Clearance<'a> {
    part: Part<'a>,
    plan: &'a SupportPlan,
}

/// What a layer of support must keep clear of.
#[derive(Clone, Debug, Default)]
pub struct Free {
    /// The part beside it and near below it.
    pub part: Rows,
    /// That and what is near above it, with the gaps beside them.
    pub with_gaps: Rows,
}

impl<'a> Clearance<'a> {
    /// That of a part.
    pub fn new(part: Part<'a>, plan: &'a SupportPlan) -> Self {
        Self { part, plan }
    }

    /// The widest gap beside the part \[units\].
    pub fn widest(&self) -> i64 {
        self.part.frame.units(self.plan.xy_gap)
    }

    /// What must stay free in a layer of support, exact within `around`.
    ///
    /// `around` reaches further than the widest gap beyond everything that is of interest.
    pub fn of(&self, step: Step, around: &Rows) -> Free {
        let part = self.union(self.beside(step), around);
        let above = self.above(step);
        if above.clone().all(|i| self.gap(i) == self.plan.xy_gap) {
            let with_gaps = self.grown(&or(&part, &self.union(above, around)), self.plan.xy_gap);
            return Free { part, with_gaps };
        }
        let beside = self.grown(&part, self.plan.xy_gap);
        let with_gaps =
            above.fold(beside, |all, i| or(&all, &self.grown(&self.union(i..i + 1, around), self.gap(i))));
        Free { part, with_gaps }
    }

    /// Whether the same outlines are in the way of both.
    pub fn same(&self, a: Step, b: Step) -> bool {
        let outlines = |step| {
            let (beside, above) = (self.beside(step), self.above(step));
            let near = |i: usize| (Arc::as_ptr(&self.part.outlines[i]), self.gap(i).to_bits());
            (beside.map(|i| near(i).0).collect::<Vec<_>>(), above.map(near).collect::<Vec<_>>())
        };
        let distinct = |(mut beside, mut above): (Vec<_>, Vec<_>)| {
            beside.dedup();
            above.dedup();
            (beside, above)
        };
        distinct(outlines(a)) == distinct(outlines(b))
    }

    /// The gap beside layer `i` of the part where support ends below it \[nm\]: no wider than what the next
    /// layer may hang over it.
    fn gap(&self, i: usize) -> f64 {
        self.plan.xy_gap.min(reach(self.part.levels, i, self.plan))
    }

    /// The layers of the part beside a layer of support or so near below that it may not stand there.
    fn beside(&self, step: Step) -> Range<usize> {
        let low = i64::from(step.bottom) - i64::from(self.plan.bottom_gap);
        self.overlapping(low, step.top.into())
    }

    /// Those in the gap above it.
    fn above(&self, step: Step) -> Range<usize> {
        let top = i64::from(step.top);
        let above = self.overlapping(top, top + i64::from(self.plan.top_gap));
        above.start.max(self.beside(step).end).min(above.end)..above.end
    }

    fn overlapping(&self, low: i64, high: i64) -> Range<usize> {
        let levels = self.part.levels;
        let end = levels.partition_point(|l| l.bottom < high);
        levels.partition_point(|l| l.top <= low).min(end)..end
    }

    /// The outlines of layers.
    fn union(&self, layers: Range<usize>, around: &Rows) -> Rows {
        let mut all = Rows::default();
        let mut last: Option<&Arc<Rows>> = None;
        for outline in &self.part.outlines[layers] {
            if !last.is_some_and(|last| Arc::ptr_eq(last, outline)) {
                all = or(&all, &and(outline, around));
            }
            last = Some(outline);
        }
        all
    }

    /// An area, grown \[nm\].
    fn grown(&self, area: &Rows, by: f64) -> Rows {
        dilate_disc(area, self.part.frame.units(by), |k| self.part.frame.t(k))
    }
}
