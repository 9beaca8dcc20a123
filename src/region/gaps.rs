//! Thin walls and gap fill: which narrow places get a bead, and how wide it is.
//!
//! Both follow the medial axis of the area within the last wall that was laid, or of the outline itself.
//! A disc of radius r on it is a channel 2 r wide. The walls on both sides of a gap cover half their
//! spacing of it, so 2 r less the spacing is left; the bead that fills it has exactly that
//! cross-section, as spacings add up where beads lie side by side. A thin wall has no neighbours: its
//! bead is as wide as the wall, so that no edge lies outside.

use super::beads::{self, Shape};
use super::medial;
use super::near::Edges;
use super::perimeters::WallPlan;
use super::{Bead, BeadKind};
use crate::contour::{ExPolygon, Ring};
use crate::lattice;
use crate::settings::Settings;
use std::f64::consts::PI;

/// Which lines of varying width are wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BeadPlan {
    /// Where the outline is too narrow for a loop.
    pub thin_walls: bool,
    /// Between walls, and between walls and infill.
    pub gap_fill: bool,
    /// By how much a bead is wider than the spacing that it fills \[nm\].
    pub rounding: i64,
}

impl BeadPlan {
    /// The plan for a layer of `height_mm` \[mm\].
    pub fn new(settings: &Settings, height_mm: f64) -> Self {
        Self {
            thin_walls: settings.perimeters.thin_walls,
            gap_fill: settings.perimeters.gap_fill_enabled,
            rounding: lattice::nm(height_mm * (1.0 - PI / 4.0)),
        }
    }
}

/// The narrowest thin wall, as a share of the external wall's width. The widest is where a loop fits.
pub const THINNEST: f64 = 0.5;

/// The same without `thin_walls`: walls as wide as a line are no thin walls yet, and are printed.
const WHOLE: f64 = 0.99;

/// The narrowest gap that is filled, as a share of the spacing of walls.
pub const NARROWEST_GAP: f64 = 0.1;

/// The widest gap that is filled, as a share of the spacing of walls: one in which no loop fits any more.
pub const WIDEST_GAP: f64 = 1.6;

/// Beads shorter than this share of the width, or spacing, of walls are left out.
const SHORTEST: f64 = 1.0;

/// A bead ends this share of its width short of the walls ahead of it.
const END: f64 = 0.25;

/// The beads beside the walls at `depth`, whose centre lines are the rings `inner`, in the area within the
/// walls before them; or in the outline. Discs from `most` \[nm\] of radius have room for a loop.
pub(super) fn beside_wall<'a>(
    area: &ExPolygon,
    inner: impl IntoIterator<Item = &'a Ring>,
    depth: u32,
    most: i64,
    plan: &WallPlan,
) -> Vec<Bead> {
    let width = plan.external_width as f64;
    match depth.checked_sub(1) {
        None => {
            let least = if plan.beads.thin_walls { THINNEST } else { WHOLE };
            let radii = (0.5 * least * width, most as f64);
            let shape =
                Shape { kind: BeadKind::ThinWall, add: 0.0, slack: 4_000.0, shortest: SHORTEST * width };
            Place { taken: 0.0, radii, reach: 0.5 * width }.fill(area, || inner, &shape)
        }
        Some(outer) if plan.beads.gap_fill => {
            let reach = 0.5 * plan.spacing_at(depth) as f64;
            gap_fill(area, || inner, plan.spacing_at(outer), reach, most, plan)
        }
        _ => Vec::new(),
    }
}

/// The thin walls of an area that has no room for a loop of lines `width` \[nm\] wide.
pub fn thin_walls(area: &ExPolygon, width: f64) -> Vec<Bead> {
    let shape = Shape { kind: BeadKind::ThinWall, add: 0.0, slack: 4_000.0, shortest: SHORTEST * width };
    let radii = (0.5 * THINNEST * width, width);
    Place { taken: 0.0, radii, reach: 0.5 * width }.fill(area, std::iter::empty::<&Ring>, &shape)
}

/// The beads beside infill, in the area within the innermost walls. Discs from `room` \[nm\] of radius
/// have infill in them; `inner`, asked for only when
/// need be, is where those discs' centres lie.
pub(super) fn beside_infill<'a>(
    area: &ExPolygon,
    inner: impl FnOnce() -> &'a [ExPolygon],
    room: i64,
    plan: &WallPlan,
) -> Vec<Bead> {
    let spacing = plan.spacing_at(plan.count.saturating_sub(1));
    let inner = || inner().iter().flat_map(ExPolygon::rings);
    gap_fill(area, inner, spacing, (room - spacing / 2) as f64, room, plan)
}

/// The beads that fill what is left between walls `spacing` \[nm\] apart, whose centre lines bound the
/// area, and what reaches `reach` \[nm\] outwards from `inner`.
fn gap_fill<'a, R: IntoIterator<Item = &'a Ring>>(
    area: &ExPolygon,
    inner: impl FnOnce() -> R,
    spacing: i64,
    reach: f64,
    most: i64,
    plan: &WallPlan,
) -> Vec<Bead> {
    let spacing = spacing as f64;
    let radii = (0.5 * (1.0 + NARROWEST_GAP) * spacing, most as f64);
    let add = plan.beads.rounding as f64 - spacing;
    let shape = Shape { kind: BeadKind::GapFill, add, slack: 50_000.0, shortest: SHORTEST * spacing };
    Place { taken: 0.5 * spacing, radii, reach }.fill(area, inner, &shape)
}

/// Where beads go \[nm\].
struct Place {
    /// How much of a disc's radius walls cover.
    taken: f64,
    /// Radii of the discs whose channel is to be filled.
    radii: (f64, f64),
    /// How far what lies inside reaches out from its line.
    reach: f64,
}

impl Place {
    fn fill<'a, R: IntoIterator<Item = &'a Ring>>(
        &self,
        area: &ExPolygon,
        inner: impl FnOnce() -> R,
        shape: &Shape,
    ) -> Vec<Bead> {
        let Some(&origin) = area.contour.first() else { return Vec::new() };
        let edges = Edges::new(area.rings(), origin);
        // Sorted only when it is asked for: most areas have no narrow places.
        let (mut inner, mut inside) = (Some(inner), Edges::default());
        let mut near = Vec::new();
        let pieces = medial::axis(&edges, self.radii.0..=self.radii.1, shape.slack, |node| {
            if let Some(inner) = inner.take() {
                inside = Edges::new(inner().into_iter(), origin);
            }
            let clearance = self.reach + END * 2.0 * (node.r - self.taken);
            inside.clear_of(node.x, node.y, clearance, &mut near)
        });
        if pieces.is_empty() { Vec::new() } else { beads::beads(pieces, &edges, shape, origin) }
    }
}

#[cfg(test)]
#[allow(clippy::panic, clippy::unwrap_used)]
#[path = "gaps_tests.rs"]
mod tests;
