//! Walls: how many, where, and what they leave for infill.

use super::boolean;
use super::extra::extra_walls;
use super::gaps::{self, BeadPlan};
use super::inside::Cover;
use super::near::Edges;
use super::offset::{self, Join};
use super::one_wall::{self, Top};
use super::overhang::Support;
use super::{Bead, Island, Wall, wavefront};
use crate::contour::{ExPolygon, Ring};
use crate::lattice;
use crate::settings::flow::{Flow, FlowRole};
use crate::settings::{OnePerimeter, Settings};
use std::cell::{Cell, OnceCell};

/// Where the walls of a layer lie, all in \[nm\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WallPlan {
    /// Number of walls.
    pub count: u32,
    /// Width of the external wall.
    pub external_width: i64,
    /// Spacing of the external wall to one like it.
    pub external_spacing: i64,
    /// Spacing of inner walls.
    pub perimeter_spacing: i64,
    /// Spacing of solid infill lines.
    pub solid_spacing: i64,
    /// Width of solid infill lines.
    pub solid_width: i64,
    /// How far infill reaches into the innermost wall.
    pub infill_overlap: i64,
    /// Whether walls are added on slopes.
    pub extra: bool,
    /// How far the centre line of a wall may lie outside the layer below before it hangs in air; 0 to
    /// leave overhangs unmarked.
    pub reach: i64,
    /// Where a single wall surrounds top surfaces.
    pub one_wall: OnePerimeter,
    /// Lines of varying width beside the walls.
    pub beads: BeadPlan,
}

/// Two walls overlap by no more than this share of their spacing; where they would, the inner one is
/// left out.
const OVERLAP_TOLERANCE: f64 = 0.4;

/// The same for external walls without `thin_walls`: a loop narrower than this share is a single line.
const LEAST_ROOM: f64 = 0.05;

/// Infill lines end this share of their spacing short of the overlap, since the links between them run
/// along that border and are as wide as they are.
const END_ALLOWANCE: f64 = 0.5;

impl WallPlan {
    /// The plan for a layer of `height_mm` \[mm\].
    pub fn new(settings: &Settings, height_mm: f64, first_layer: bool) -> Self {
        let flow = |role| Flow::new(role, height_mm, first_layer, settings);
        let external = flow(FlowRole::ExternalPerimeter);
        let (inner, solid) = (flow(FlowRole::Perimeter), flow(FlowRole::SolidInfill));
        let count = settings.perimeters.perimeters;
        let bore = settings.printer.nozzle_diameter;
        let innermost = if count == 1 { external } else { inner };
        let base = 0.5 * (innermost.spacing() + solid.spacing());
        Self {
            count,
            external_width: external.width_nm(),
            external_spacing: external.spacing_nm(),
            perimeter_spacing: inner.spacing_nm(),
            solid_spacing: solid.spacing_nm(),
            solid_width: solid.width_nm(),
            infill_overlap: lattice::nm(settings.infill.infill_overlap.of(base)),
            // Without infill nothing shows between walls, and they carry each other.
            extra: settings.perimeters.extra_perimeters && settings.infill.fill_density > 0.0,
            // What lies on supports does not hang.
            reach: match settings.perimeters.overhangs && !settings.has_soluble_supports() {
                true => lattice::nm(0.5 * bore),
                false => 0,
            },
            one_wall: settings.perimeters.top_one_perimeter_type,
            beads: BeadPlan::new(settings, height_mm),
        }
    }

    /// How deep the walls reach into the area, to the inner edge of the innermost one.
    pub fn walls_depth(&self) -> i64 {
        match self.count {
            0 => 0,
            n => {
                (self.external_width + self.external_spacing) / 2 + i64::from(n - 1) * self.perimeter_spacing
            }
        }
    }

    /// How far the centre line of the wall at `depth` lies inside that of the wall before it, or inside
    /// the outline for the first; and the spacing that it needs to the wall across the room.
    fn step(&self, depth: u32) -> (i64, i64) {
        match depth {
            0 => (self.external_width / 2, self.external_spacing),
            1 => ((self.external_spacing + self.perimeter_spacing) / 2, self.perimeter_spacing),
            _ => (self.perimeter_spacing, self.perimeter_spacing),
        }
    }

    /// How far infill lines end inside the centre line of the innermost wall, or inside the outline when
    /// there are no walls. Negative when the overlap is more than half a wall.
    pub fn infill_inset(&self) -> i64 {
        if self.count == 0 {
            return self.solid_width / 2;
        }
        let half = self.spacing_at(self.count - 1) / 2;
        half - self.infill_overlap + (END_ALLOWANCE * self.solid_spacing as f64) as i64
    }

    /// Spacing of the walls at a depth to others like them.
    pub(super) fn spacing_at(&self, depth: u32) -> i64 {
        if depth == 0 { self.external_spacing } else { self.perimeter_spacing }
    }

    /// Radius of the smallest disc between the centre lines of innermost walls that has infill in it;
    /// narrower places are filled as gaps. Where gaps are not filled, [`Self::infill_inset`].
    fn infill_room(&self) -> i64 {
        match self.count.checked_sub(1) {
            Some(innermost) if self.beads.gap_fill => {
                (0.5 * (1.0 + gaps::WIDEST_GAP) * self.spacing_at(innermost) as f64) as i64
            }
            _ => self.infill_inset(),
        }
    }
}

/// The layers that touch a layer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Neighbours<'a> {
    /// Areas of the layer below; `None` on the first layer, which lies on the bed.
    pub below: Option<&'a [ExPolygon]>,
    /// Areas of the layer above; `None` on the last.
    pub above: Option<&'a [ExPolygon]>,
}

/// Walls and infill border of a layer's areas, as PrusaSlicer spaces them. One island per area, in the
/// same order, whose outline is the area.
///
/// The external wall's centre line runs half its width inside the outline, the others a spacing further
/// in each. A wall is left out where it would come nearer than 0.6 spacings to itself. An area that
/// falls apart on the way inwards stays one island.
///
/// The layer above decides on additional walls and single ones, the layer below on what overhangs.
pub fn walls(areas: Vec<ExPolygon>, neighbours: &Neighbours, plan: &WallPlan) -> Vec<Island> {
    let extra = match neighbours.above {
        Some(above) if plan.extra => extra_walls(&areas, above, plan),
        _ => Vec::new(),
    };
    let support = match neighbours.below {
        Some(below) if plan.reach > 0 => Some(Support::new(below, plan.reach)),
        _ => None,
    };
    // Without anything above, everything is a top surface.
    let single = match plan.one_wall {
        OnePerimeter::None => false,
        OnePerimeter::Top => neighbours.above.is_none_or(<[ExPolygon]>::is_empty),
        OnePerimeter::Topmost => neighbours.above.is_none(),
    };
    let cover = neighbours.above.filter(|_| plan.one_wall == OnePerimeter::Top).map(Cover::new);
    let build = |(i, outline)| {
        let count = plan.count + extra.get(i).copied().unwrap_or(0);
        let count = if single { count.min(1) } else { count };
        let mut island = island(outline, cover.as_ref(), &WallPlan { count, ..*plan });
        if let Some(support) = &support {
            support.flag(&mut island);
        }
        island
    };
    areas.into_iter().enumerate().map(build).collect()
}

fn island(outline: ExPolygon, above: Option<&Cover>, plan: &WallPlan) -> Island {
    let (mut walls, mut beads) = (Vec::new(), Vec::new());
    let (mut tops, mut second) = (Vec::new(), Vec::new());
    let mut lines = vec![Line { polygon: outline.clone(), inner: Inner::Untried }];
    for depth in 0..plan.count {
        let (distance, spacing) = plan.step(depth);
        // Without thin walls, loops that overlap are better than nothing.
        let crowded = depth == 0 && !plan.beads.thin_walls;
        let fits = if crowded { LEAST_ROOM } else { 1.0 - OVERLAP_TOLERANCE };
        let radius = (0.5 * fits * spacing as f64) as i64;
        let next = if depth + 1 < plan.count { plan.step(depth + 1).0 } else { plan.infill_room() };
        lines = lines
            .into_iter()
            .flat_map(|line| {
                let (polygon, next, filled) = centre_lines(line, distance, radius, next);
                if !filled {
                    let inner = next.iter().flat_map(|line| line.polygon.rings());
                    beads.extend(gaps::beside_wall(&polygon, inner, depth, distance + radius, plan));
                }
                next
            })
            .collect();
        for Line { polygon, .. } in &lines {
            let wall = |hole: bool| {
                move |ring: &Ring| Wall { ring: ring.clone(), depth, hole, overhang: Vec::new() }
            };
            walls.push(wall(false)(&polygon.contour));
            walls.extend(polygon.holes.iter().map(wall(true)));
        }
        match depth {
            0 if plan.count > 1 => lines = covered(lines, above, plan, &mut tops),
            1 if !tops.is_empty() => second = lines.iter().map(|line| line.polygon.clone()).collect(),
            _ => {}
        }
    }
    let mut infill: Vec<ExPolygon> =
        lines.into_iter().flat_map(|line| infill(line, plan, &mut beads)).collect();
    if !tops.is_empty() {
        infill.extend(one_wall::infill(&tops, &second, plan));
    }
    Island { outline, walls, beads, infill }
}

/// Where walls go on inside the external one; areas that the layer above leaves open are added to `tops`.
fn covered(lines: Vec<Line>, above: Option<&Cover>, plan: &WallPlan, tops: &mut Vec<Top>) -> Vec<Line> {
    let Some(above) = above else { return lines };
    let mut left = Vec::with_capacity(lines.len());
    for line in lines {
        match one_wall::split(&line.polygon, above, plan) {
            None => left.push(line),
            Some(mut top) => {
                let covered = std::mem::take(&mut top.covered).into_iter();
                left.extend(covered.map(|polygon| Line { polygon, inner: Inner::Untried }));
                tops.push(top);
            }
        }
    }
    left
}

/// What is left for infill within an innermost wall, or within an outline without walls, and the beads
/// that fill gaps beside it.
fn infill(line: Line, plan: &WallPlan, beads: &mut Vec<Bead>) -> Vec<ExPolygon> {
    let Line { polygon, inner } = line;
    let (border, room) = (plan.infill_inset(), plan.infill_room());
    let fill_gaps = plan.beads.gap_fill && plan.count > 0 && room > border;
    let inner = match inner {
        Inner::Untried => Inner::of(&polygon, if fill_gaps { room } else { border }),
        inner => inner,
    };
    if !fill_gaps {
        return inner.or_raw(&polygon, border);
    }
    let plain = || offset::inset(std::slice::from_ref(&polygon), border);
    if inner.whole(&polygon).is_some() && !inner.gapes() {
        return plain();
    }
    let (inner, core) = (Cell::new(Some(inner)), OnceCell::new());
    let core = || core.get_or_init(|| inner.take().map_or_else(Vec::new, |i| i.or_raw(&polygon, room)));
    let found = gaps::beside_infill(&polygon, || core().as_slice(), room, plan);
    if found.is_empty() {
        return plain();
    }
    beads.extend(found);
    opened(core(), room - border, &polygon, border, plain)
}

/// An area bounded by centre lines of walls, and what is known of the next step inwards.
struct Line {
    polygon: ExPolygon,
    inner: Inner,
}

enum Inner {
    Untried,
    Unproven,
    /// The areas, and whether the inset is known to leave gaps.
    Proven(Vec<ExPolygon>, bool),
}

impl Inner {
    fn of(polygon: &ExPolygon, distance: i64) -> Self {
        match wavefront::inset_and_gaping(polygon, distance) {
            Some((polygons, gapes)) => Self::Proven(polygons, gapes),
            None => Self::Unproven,
        }
    }

    fn gapes(&self) -> bool {
        !matches!(self, Self::Proven(_, false))
    }

    /// The inset of `polygon` by the same distance, by way of the polygon library if need be.
    fn or_raw(self, polygon: &ExPolygon, distance: i64) -> Vec<ExPolygon> {
        match self {
            Self::Proven(polygons, _) => polygons,
            _ => offset::raw_inset(polygon, distance as f64),
        }
    }

    /// The inset if it is one area with as many holes as `polygon` has: then `polygon` is nowhere
    /// narrower than twice the inset's distance.
    fn whole(&self, polygon: &ExPolygon) -> Option<&ExPolygon> {
        match self {
            Self::Proven(inset, _) => match inset.as_slice() {
                [one] if one.holes.len() == polygon.holes.len() => Some(one),
                _ => None,
            },
            _ => None,
        }
    }
}

/// The centre lines `distance` inside a line, without those parts where they would be nearer than twice
/// `radius` to each other; with the area within the line, and whether no gaps are left in it.
///
/// That is an opening, which takes three runs of the polygon library. Mostly the area is wide enough
/// and nothing would be opened; the step inwards that comes `next` proves it and is needed anyway.
fn centre_lines(line: Line, distance: i64, radius: i64, next: i64) -> (ExPolygon, Vec<Line>, bool) {
    let Line { polygon, inner } = line;
    let plain = if matches!(inner, Inner::Untried) { Inner::of(&polygon, distance) } else { inner };
    if let Some(centre) = plain.whole(&polygon) {
        let inner = if next > 0 { Inner::of(centre, next) } else { Inner::Untried };
        let wide = next >= radius && inner.whole(centre).is_some();
        if wide || Inner::of(&polygon, distance + radius).whole(&polygon).is_some() {
            let lines = vec![Line { polygon: centre.clone(), inner }];
            let filled = !plain.gapes();
            return (polygon, lines, filled);
        }
    }
    if matches!(&plain, Inner::Proven(polygons, _) if polygons.is_empty()) {
        return (polygon, Vec::new(), false);
    }
    let core = offset::inset(std::slice::from_ref(&polygon), distance + radius);
    let lines = opened(&core, radius, &polygon, distance, || plain.or_raw(&polygon, distance));
    let lines = lines.into_iter().map(|polygon| Line { polygon, inner: Inner::Untried }).collect();
    (polygon, lines, false)
}

/// A core inside `polygon` grown by `radius`, but not beyond the `plain` inset by `distance`.
fn opened(
    core: &[ExPolygon],
    radius: i64,
    polygon: &ExPolygon,
    distance: i64,
    plain: impl FnOnce() -> Vec<ExPolygon>,
) -> Vec<ExPolygon> {
    if core.is_empty() {
        return Vec::new();
    }
    let grown = offset::outset(core, radius, Join::Miter);
    // Mitred corners may grow past the plain inset, which is the nearest a line may come.
    if keeps_clear(&grown, polygon, distance) { grown } else { boolean::intersection(&grown, &plain()) }
}

/// Whether no corner of `lines` comes nearer to the border of `polygon` than `distance` \[nm\], within
/// the tolerance of simplification.
fn keeps_clear(lines: &[ExPolygon], polygon: &ExPolygon, distance: i64) -> bool {
    let Some(&origin) = polygon.contour.first() else { return true };
    let edges = Edges::new(polygon.rings(), origin);
    let least = distance as f64 - 1.5 * offset::SIMPLIFY;
    let mut near = Vec::new();
    lines.iter().flat_map(ExPolygon::rings).flatten().all(|p| {
        let (x, y) = p.minus(origin);
        edges.clear_of(x as f64, y as f64, least, &mut near)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Point2;

    fn rectangle(x0: i32, y0: i32, x1: i32, y1: i32) -> Ring {
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(x, y)).to_vec()
    }

    fn plan(count: u32) -> WallPlan {
        WallPlan {
            count,
            external_width: 450_000,
            external_spacing: 400_000,
            perimeter_spacing: 420_000,
            solid_spacing: 400_000,
            solid_width: 440_000,
            infill_overlap: 100_000,
            extra: false,
            reach: 0,
            one_wall: OnePerimeter::None,
            beads: BeadPlan { thin_walls: true, ..BeadPlan::default() },
        }
    }

    #[test]
    fn the_walls_of_a_square_lie_where_the_plan_says() {
        let square = ExPolygon { contour: rectangle(0, 0, 10_000_000, 10_000_000), holes: vec![] };
        let islands = walls(vec![square], &Neighbours::default(), &plan(3));
        assert_eq!(islands.len(), 1);
        let at = |d: i32| rectangle(d, d, 10_000_000 - d, 10_000_000 - d);
        for (wall, (depth, d)) in islands[0].walls.iter().zip([(0, 225_000), (1, 635_000), (2, 1_055_000)]) {
            assert_eq!(*wall, Wall { ring: at(d), depth, ..Wall::default() });
        }
        // Half a spacing less the overlap, plus half of an infill line's spacing.
        assert_eq!(islands[0].infill[0].contour, at(1_055_000 + 210_000 - 100_000 + 200_000));
    }

    #[test]
    fn a_wall_needs_six_tenths_of_its_spacing() {
        let strip = |w: i32| vec![ExPolygon { contour: rectangle(0, 0, 10_000_000, w), holes: vec![] }];
        // External: width 0.45 + 0.6 * 0.4 for the two centre lines to be 0.24 apart.
        assert_eq!(walls(strip(680_000), &Neighbours::default(), &plan(2))[0].walls.len(), 0);
        assert_eq!(walls(strip(700_000), &Neighbours::default(), &plan(2))[0].walls.len(), 1);
        // Second: another 2 * 0.41 for the way and 0.6 * 0.42 for the room, less what the first needs.
        assert_eq!(walls(strip(1_500_000), &Neighbours::default(), &plan(2))[0].walls.len(), 1);
        assert_eq!(walls(strip(1_540_000), &Neighbours::default(), &plan(2))[0].walls.len(), 2);
    }
}
