//! Loops on the first layer that hold the print to the bed.

mod clip;
mod ears;
mod nest;
#[cfg(test)]
mod tests;

use super::{Strand, StrandKind};
use crate::contour::{ExPolygon, Ring};
use crate::lattice::nm;
use crate::region::boolean::{self, Winding};
use crate::region::offset::{Join, inset, outset};
use crate::settings::flow::Flow;
use crate::settings::{AdhesionSettings, BrimType};
use rayon::prelude::*;

/// Two lines of brim that face each other lie at least this share of their spacing apart; where they would
/// not, as in a narrow gap between two parts, both are left out.
const LEAST_ROOM: f64 = 0.6;

/// Ears have no more loops than this.
const MOST_LOOPS: usize = 2000;

/// The brim around `first`, the outlines of the part's first layer, in printing order: every loop before those
/// inside it. Lines are cut where they would run into `others`.
///
/// The i-th line lies at `brim_separation` + (i + 1/2) x spacing from the outline, corners are round, and there
/// are as many lines as fit into `brim_width` (PrusaSlicer's rules). What can be reached from outside is the
/// outer brim's; what an outline encloses, outlines of parts in holes among it, is the inner brim's.
pub fn brim(
    first: &[ExPolygon],
    others: &[ExPolygon],
    flow: Flow,
    settings: &AdhesionSettings,
) -> Vec<Strand> {
    let free = Free::new(first, settings);
    let spacing = flow.spacing();
    let mut rings = Vec::new();
    if settings.brim_ears {
        rings.extend(nest::outside_in(&within(
            &ears::ears(first, &free, settings),
            0.0,
            spacing,
            MOST_LOOPS,
        )));
    } else {
        let count = lines(flow, settings);
        rings.extend(nest::outside_in(&around(&free.solid, settings.brim_separation, spacing, count)));
        rings.extend(nest::outside_in(&within(&free.holes, settings.brim_separation, spacing, count)));
    }
    clip::clear_of(rings, others, nm(0.5 * flow.width), nm(spacing))
}

/// The area that the brim of [`brim`] covers \[nm\], which supports leave free, as in PrusaSlicer.
pub fn cover(first: &[ExPolygon], flow: Flow, settings: &AdhesionSettings) -> Vec<ExPolygon> {
    let free = Free::new(first, settings);
    if settings.brim_ears {
        return ears::ears(first, &free, settings);
    }
    let width = nm(settings.brim_separation + lines(flow, settings) as f64 * flow.spacing());
    let mut area = boolean::difference(&outset(&free.solid, width, Join::Round), &free.solid);
    area.extend(boolean::difference(&free.holes, &inset(&free.holes, width)));
    area
}

/// Number of lines side by side.
fn lines(flow: Flow, settings: &AdhesionSettings) -> usize {
    // A width of so many lines gives so many, whatever the last digit.
    (settings.brim_width / flow.spacing() * (1.0 + 1e-9)) as usize
}

/// Where a brim is wanted.
struct Free {
    /// It lies around these: outlines without their holes; empty without outer brim.
    solid: Vec<ExPolygon>,
    /// It lies in these: what outlines enclose; empty without inner brim.
    holes: Vec<ExPolygon>,
}

impl Free {
    fn new(first: &[ExPolygon], settings: &AdhesionSettings) -> Self {
        let (outer, inner) = match settings.brim_type {
            BrimType::NoBrim => (false, false),
            BrimType::OuterOnly => (true, false),
            BrimType::InnerOnly => (false, true),
            BrimType::OuterAndInner => (true, true),
        };
        if settings.brim_width <= 0.0 || !(outer || inner) {
            return Self { solid: Vec::new(), holes: Vec::new() };
        }
        let solid = boolean::union(first.iter().map(|p| &p.contour), Winding::NonZero);
        let holes = if inner { boolean::difference(&solid, first) } else { Vec::new() };
        Self { solid: if outer { solid } else { Vec::new() }, holes }
    }
}

/// The lines around areas, the outermost first; `separation` and `spacing` in \[mm\].
fn around(solid: &[ExPolygon], separation: f64, spacing: f64, count: usize) -> Vec<Vec<ExPolygon>> {
    if solid.is_empty() {
        return Vec::new();
    }
    let room = nm(0.5 * LEAST_ROOM * spacing);
    (0..count)
        .into_par_iter()
        .rev()
        .map(|i| {
            let distance = nm(separation + (i as f64 + 0.5) * spacing);
            inset(&outset(solid, distance + room, Join::Round), room)
        })
        .collect()
}

/// The lines within areas, the outermost first: at most `count`, and as many as there is room for.
fn within(free: &[ExPolygon], separation: f64, spacing: f64, count: usize) -> Vec<Vec<ExPolygon>> {
    let room = nm(0.5 * LEAST_ROOM * spacing);
    let mut lines = Vec::new();
    if free.is_empty() {
        return lines;
    }
    for i in 0..count {
        let core = inset(free, nm(separation + (i as f64 + 0.5) * spacing) + room);
        if core.is_empty() {
            break;
        }
        lines.push(outset(&core, room, Join::Round));
    }
    lines
}

fn closed(points: Ring) -> Strand {
    Strand { points, closed: true, kind: StrandKind::Brim }
}
