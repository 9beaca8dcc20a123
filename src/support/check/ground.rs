//! What a layer may lie on.

use super::{LEVEL, Print, Rule, area, supports_under};
use crate::lattice::Point2;
use crate::span::algebra::{and, dilate, or, sub};
use crate::span::morph::dilate_disc;
use crate::span::{RowFrame, Rows, RowsBuilder};
use crate::support::SupportLayer;
use std::ops::Range;
use std::sync::Arc;

/// Where a layer is held from below, as far as areas tell: bridges are not in it.
#[derive(Clone, Debug)]
pub struct Ground {
    frame: RowFrame,
    /// `None`: everywhere.
    rows: Option<Rows>,
}

impl Ground {
    /// That of layer `i` of the part.
    pub fn of_part(print: &Print, i: usize, rule: &Rule) -> Self {
        let below = Below::part(print, i, rule);
        Self { frame: *print.part.frame, rows: below.map(|b| b.all(print.part.frame)) }
    }

    /// That of layer `j` of the supports.
    pub fn of_support(print: &Print, j: usize, rule: &Rule) -> Self {
        let below = Below::support(print, j, rule);
        Self { frame: *print.part.frame, rows: below.map(|b| b.all(print.part.frame)) }
    }

    /// Takes an area in.
    pub fn add(&mut self, area: &Rows) {
        self.rows = self.rows.take().map(|rows| or(&rows, area));
    }

    /// Whether a point lies on it.
    pub fn holds(&self, p: Point2) -> bool {
        let Some(rows) = &self.rows else { return true };
        let (s, t) = self.frame.st(p);
        let row = rows.row(self.frame.nearest_row(t.into()));
        let i = row.partition_point(|span| span.end <= s);
        row.get(i).is_some_and(|span| span.start <= s)
    }

    /// Lines are looked at in steps of this \[nm\].
    pub(super) fn step(&self) -> f64 {
        0.5 * self.frame.pitch() as f64 / self.frame.scale()
    }
}

/// What layer `i` of the part has in air, bridges left out.
pub(super) fn part_in_air(print: &Print, i: usize, rule: &Rule) -> Rows {
    let Some(own) = print.part.outlines.get(i) else { return Rows::default() };
    let below = i.checked_sub(1).and_then(|b| print.part.outlines.get(b));
    if below.is_some_and(|below| Arc::ptr_eq(own, below)) {
        return Rows::default();
    }
    let Some(below) = Below::part(print, i, rule) else { return Rows::default() };
    let bridged = print.overhangs.get(i).map(|o| &o.bridged).filter(|b| !b.is_empty());
    let left = below.beyond(own, print.part.frame);
    match bridged {
        // The bridge's own edge is within reach of the bridge.
        Some(bridged) if !left.is_empty() => far(&left, bridged, below.reach, print.part.frame),
        _ => left,
    }
}

/// What layer `j` of the supports has in air.
pub(super) fn support_in_air(print: &Print, j: usize, rule: &Rule) -> Rows {
    let Some(own) = print.supports.get(j) else { return Rows::default() };
    if i64::from(own.bottom_z()) <= LEVEL {
        return Rows::default();
    }
    // Nearly all support stands on support: the part need not be looked at.
    let frame = print.part.frame;
    let left = far(&area(own), &carrying(print, own), support_reach(own, rule, frame), frame);
    match Below::support(print, j, rule).filter(|_| !left.is_empty()) {
        Some(below) => below.beyond(&left, frame),
        None => Rows::default(),
    }
}

/// Supports that carry a layer of supports. What ends between its sides carries it too, where layers are not
/// the same everywhere.
fn carrying(print: &Print, own: &SupportLayer) -> Rows {
    ending(print, i64::from(own.bottom_z()) - LEVEL..i64::from(own.print_z) - LEVEL)
}

/// How far a layer of supports may reach over supports \[units\].
fn support_reach(own: &SupportLayer, rule: &Rule, frame: &RowFrame) -> i64 {
    frame.units(rule.support_reach + rule.support_slope * f64::from(own.height)) + frame.pitch()
}

/// What lies under a layer. Lengths in units of the frame.
struct Below {
    part: Rows,
    supports: Rows,
    /// How far a layer may reach over the part, over support, and where it lies between both.
    reach: i64,
    support_reach: i64,
    between: i64,
}

impl Below {
    /// Under layer `i` of the part; `None` where the plate holds everything.
    fn part(print: &Print, i: usize, rule: &Rule) -> Option<Self> {
        let (part, frame) = (print.part, print.part.frame);
        let z = part.levels.get(i).map_or(0, |l| l.bottom);
        if z <= LEVEL {
            return None;
        }
        let reach = rule.reach(part, i);
        let below = i.checked_sub(1).filter(|&b| part.levels.get(b).is_some_and(|l| l.top >= z - LEVEL));
        let below = below.and_then(|b| part.outlines.get(b));
        let slack = frame.pitch();
        Some(Self {
            part: below.map_or_else(Rows::default, |b| Rows::clone(b)),
            supports: supports_under(print, i, rule),
            reach: frame.units(reach) + slack,
            support_reach: frame.units(reach) + slack,
            between: frame.units(reach + rule.xy_gap) + slack,
        })
    }

    /// Under layer `j` of the supports; `None` as above.
    fn support(print: &Print, j: usize, rule: &Rule) -> Option<Self> {
        let (part, frame) = (print.part, print.part.frame);
        let own = print.supports.get(j)?;
        let (bottom, top) = (i64::from(own.bottom_z()), i64::from(own.print_z));
        if bottom <= LEVEL {
            return None;
        }
        let feet = bottom - rule.foot - LEVEL..top - LEVEL;
        let first = part.levels.partition_point(|l| l.top < feet.start);
        let last = part.levels.partition_point(|l| l.top < feet.end);
        // Of layers that follow each other the lower ones show only where the part narrows.
        let mut on_part = Rows::default();
        let mut previous: Option<&Arc<Rows>> = None;
        for outline in part.outlines.get(first..last).unwrap_or_default() {
            if previous.is_none_or(|p| !Arc::ptr_eq(p, outline)) {
                on_part = or(&on_part, outline);
            }
            previous = Some(outline);
        }
        let support_reach = support_reach(own, rule, frame);
        let reach = support_reach + frame.units(rule.xy_gap);
        let supports = carrying(print, own);
        Some(Self { part: on_part, supports, reach, support_reach, between: reach })
    }

    /// The part of `own` that nothing holds.
    fn beyond(&self, own: &Rows, frame: &RowFrame) -> Rows {
        let left = far(own, &self.part, self.reach, frame);
        if left.is_empty() {
            return left;
        }
        let left = far(&left, &self.supports, self.support_reach, frame);
        if left.is_empty() || self.between <= self.reach {
            return left;
        }
        let from_part = far(&left, &self.part, self.between, frame);
        let near_part = sub(&left, &from_part);
        or(&from_part, &far(&near_part, &self.supports, self.between, frame))
    }

    /// Everywhere that something is held.
    fn all(&self, frame: &RowFrame) -> Rows {
        let grown = |rows: &Rows, by: i64| dilate_disc(rows, by, |k| frame.t(k));
        let on = or(&grown(&self.part, self.reach), &grown(&self.supports, self.support_reach));
        if self.supports.is_empty() || self.between <= self.reach {
            return on;
        }
        or(&on, &and(&grown(&self.part, self.between), &grown(&self.supports, self.between)))
    }
}

/// The part of `area`, of layer `i` of the part, that no support can hold: the place below it is nearer to
/// the part than the gap beside, or the part or the bed lies below and leaves no room between the gaps.
pub(super) fn cramped(print: &Print, i: usize, rule: &Rule, area: &Rows) -> Rows {
    let (part, frame) = (print.part, print.part.frame);
    let Some(level) = part.levels.get(i).filter(|_| !area.is_empty()) else { return Rows::default() };
    if level.bottom < rule.room_on_bed {
        return area.clone();
    }
    let reach = frame.units(rule.reach(part, i)) + frame.pitch();
    let beside = reach + frame.units(rule.xy_gap) + frame.pitch();
    let first = part.levels.partition_point(|l| l.top < level.bottom - rule.room - LEVEL);
    // Those that a support at the greatest distance, as thick as they come, would stand beside.
    let beside_from = level.bottom - rule.contact - rule.thickest - LEVEL;
    let next = part.levels.partition_point(|l| l.top < beside_from).max(first);
    let mut left = area.clone();
    for (range, radius) in [(first..next, reach), (next..i, beside)] {
        for outline in part.outlines.get(range).unwrap_or_default() {
            left = far(&left, outline, radius, frame);
        }
    }
    sub(area, &left)
}

/// All supports whose upper side lies in a range of heights.
pub(super) fn ending(print: &Print, z: Range<i64>) -> Rows {
    let first = print.supports.partition_point(|l| i64::from(l.print_z) < z.start);
    let layers = print.supports.get(first..).unwrap_or_default();
    let mut within = layers.iter().take_while(|l| i64::from(l.print_z) < z.end);
    let first = within.next().map(area).unwrap_or_default();
    within.fold(first, |all, layer| or(&all, &area(layer)))
}

/// The part of `area` that is more than `radius` \[units\] from `ground`.
///
/// Most of what reaches over the ground does so along the rows, by less than the radius: that costs no
/// more than a pass over both. Discs are drawn around the rows next to what is left.
pub(super) fn far(area: &Rows, ground: &Rows, radius: i64, frame: &RowFrame) -> Rows {
    if area.is_empty() || ground.is_empty() {
        return area.clone();
    }
    let along = i32::try_from(radius).unwrap_or(i32::MAX);
    let left = sub(area, &dilate(ground, 0, along));
    if left.is_empty() {
        return left;
    }
    sub(&left, &dilate_disc(&around(ground, &left, radius, frame), radius, |k| frame.t(k)))
}

/// Those rows of `area` that are at most `radius` \[units\] from a row of `place` that is not empty.
pub(super) fn around(area: &Rows, place: &Rows, radius: i64, frame: &RowFrame) -> Rows {
    let reach = (radius / frame.pitch().max(1)) as i32 + 1;
    let mut out = RowsBuilder::new(area.first());
    // The last row that is wanted, and the next one of `place` to be looked at.
    let (mut until, mut next) = (i32::MIN, place.first());
    for (k, row) in area.iter() {
        next = next.max(k - reach);
        while next < place.end() && next <= k + reach {
            if !place.row(next).is_empty() {
                until = next + reach;
            }
            next += 1;
        }
        if k <= until {
            row.iter().for_each(|s| out.push(s.start, s.end));
        }
        out.end_row();
    }
    out.finish()
}
