//! Skirt and brim: what they go around, and on which layers.

use super::supports::Supports;
use crate::contour::{ExPolygon, Ring};
use crate::lattice::{self, NM_PER_MM, Point2};
use crate::path::PrintLayer;
use crate::region::Island;
use crate::region::inside::bounds;
use crate::region::offset::{Join, inset, outset};
use crate::settings::flow::{Flow, FlowRole};
use crate::settings::{BrimType, DraftShield, Settings};
use crate::slice::planes::LayerZ;
use crate::support::skirt::{self, convex_hull, hull_of_lines};
use crate::support::{Strand, brim};
use rayon::prelude::*;

/// Whether there is a brim; a raft has none.
pub fn has_brim(settings: &Settings) -> bool {
    let a = &settings.adhesion;
    a.brim_width > 0.0 && a.brim_type != BrimType::NoBrim && a.raft_layers == 0
}

/// The flow of skirt and brim on the first layer.
pub fn flow(settings: &Settings) -> Flow {
    let height = settings.slicing.first_layer_height.of(settings.slicing.layer_height);
    Flow::new(FlowRole::Skirt, height, true, settings)
}

/// The outlines of a part's first layer.
pub fn footprint(islands: &[Vec<Island>]) -> Vec<ExPolygon> {
    islands.first().into_iter().flatten().map(|i| i.outline.clone()).collect()
}

/// The loops of the skirt, and the brim.
///
/// The skirt goes around everything on the layers that it is on: part, supports and raft, and the brim. Only a
/// draft shield stands `skirt_distance` from the part whatever the brim, which is then cut where the shield
/// stands (PrusaSlicer's rules). A brim goes around the part, not around its supports.
pub fn skirt_and_brim(
    islands: &[Vec<Island>],
    z: &[LayerZ],
    beside: &Supports,
    settings: &Settings,
) -> (Vec<Ring>, Vec<Strand>) {
    let a = &settings.adhesion;
    let flow = flow(settings);
    let brim = |others: &[ExPolygon]| match has_brim(settings) {
        true => brim::brim(&footprint(islands), others, flow, a),
        false => Vec::new(),
    };
    if !skirt::is_wanted(a) {
        return (Vec::new(), brim(&[]));
    }
    let filament = &settings.filament;
    let section = std::f64::consts::PI / 4.0 * filament.filament_diameter * filament.filament_diameter;
    let per_mm = flow.mm3_per_mm() * filament.extrusion_multiplier / section;
    let mut inside = hulls(islands, z, beside, flow, settings);
    if a.draft_shield != DraftShield::Disabled {
        let skirt = skirt::skirt(&inside, flow, per_mm, a);
        let brim = brim(&taken(&skirt, flow));
        return (skirt, brim);
    }
    let brim = brim(&[]);
    inside.extend(hull_of_lines(brim.iter().map(|s| &s.points[..]), flow.spacing()));
    (skirt::skirt(&inside, flow, per_mm, a), brim)
}

/// The hull of each layer's outlines and supports, up to the skirt's height.
fn hulls(
    islands: &[Vec<Island>],
    z: &[LayerZ],
    beside: &Supports,
    flow: Flow,
    settings: &Settings,
) -> Vec<Ring> {
    let raft = settings.adhesion.raft_layers as usize;
    let carriers = beside.layers.iter().take(raft).map(|l| l.print_z).chain(z.iter().map(|l| l.print_z));
    let top = match settings.adhesion.draft_shield {
        DraftShield::Enabled => i32::MAX,
        _ => carriers.take(settings.adhesion.skirt_height as usize).last().unwrap_or(0),
    };
    let of_part =
        islands.par_iter().zip(z).filter(|(_, z)| z.print_z <= top).map(|(islands, _)| {
            convex_hull(islands.iter().flat_map(|i| &i.outline.contour).copied().collect())
        });
    let beside = beside.layers.par_iter().zip(&beside.strands).filter(|(layer, _)| layer.print_z <= top);
    let of_beside = beside
        .filter_map(|(_, strands)| hull_of_lines(strands.iter().map(|s| &s.points[..]), flow.spacing()));
    of_part.chain(of_beside).filter(|hull| !hull.is_empty()).collect()
}

/// The area that a skirt's loops cover.
fn taken(skirt: &[Ring], flow: Flow) -> Vec<ExPolygon> {
    let (Some(outer), Some(inner)) = (skirt.first(), skirt.last()) else { return Vec::new() };
    let half = lattice::nm(0.5 * flow.spacing());
    let whole = |ring: &Ring| ExPolygon { contour: ring.clone(), holes: Vec::new() };
    let room = inset(&[whole(inner)], half);
    let mut taken = outset(&[whole(outer)], half, Join::Miter);
    if let Some(outer) = taken.first_mut() {
        // A hole runs the other way round.
        outer.holes.extend(room.into_iter().map(|p| p.contour.into_iter().rev().collect::<Ring>()));
    }
    taken
}

/// Gives the layers their skirt: the first `skirt_height` of raft and part, or all for a draft shield.
///
/// Layers of nothing but columns lie between two of the part's and carry none, as in PrusaSlicer: the skirt's
/// beads on the part's layers are as thick as those, and lie upon each other. On the part's first layer on a
/// raft they are thicker than it by the gap beneath it.
pub fn lay_skirt(layers: &mut [PrintLayer], skirt: &[Ring], raft_top: i32, settings: &Settings) {
    let high = match settings.adhesion.draft_shield {
        DraftShield::Enabled => usize::MAX,
        _ => settings.adhesion.skirt_height as usize,
    };
    if skirt.is_empty() {
        return;
    }
    let mut below = 0;
    let carries = |l: &&mut PrintLayer| l.z.print_z <= raft_top || l.z.slice_z != 0 || !l.islands.is_empty();
    for layer in layers.iter_mut().filter(carries).take(high) {
        layer.skirt = skirt.to_vec();
        layer.skirt_height = layer.z.print_z - below;
        below = layer.z.print_z;
    }
}

/// Says what of the lines beside the part reaches furthest beyond the bed, and how far; `None` where all of them
/// are on it. `origin`: world position of the lattice's zero \[nm\].
///
/// Nobody else would: the part itself is on the bed, and many nozzles can go a little further.
pub fn beyond_bed(
    skirt: &[Ring],
    beside: &Supports,
    origin: [i64; 3],
    settings: &Settings,
) -> Option<String> {
    let raft = (settings.adhesion.raft_layers as usize).min(beside.strands.len());
    let (raft, supports) = beside.strands.split_at(raft);
    let bed = &settings.printer.bed_shape;
    let far_strands = |strands: &mut dyn Iterator<Item = &Strand>| {
        let lines: Vec<&[Point2]> = strands.map(|s| &s.points[..]).collect();
        beyond(&lines, origin, bed)
    };
    let skirt: Vec<&[Point2]> = skirt.iter().map(|r| &r[..]).collect();
    let all = [
        ("the skirt reaches", "skirt_distance or skirts", beyond(&skirt, origin, bed)),
        ("the brim reaches", "brim_width", far_strands(&mut beside.brim.iter())),
        ("the raft reaches", "raft_expansion", far_strands(&mut raft.iter().flatten())),
        ("supports reach", "raft_first_layer_expansion", far_strands(&mut supports.iter().flatten())),
    ];
    let (what, keys, mm) = all.into_iter().max_by(|a, b| a.2.total_cmp(&b.2))?;
    let mm = mm + 0.5 * flow(settings).width;
    (mm > SLACK).then(|| {
        format!("{what} {mm:.2} mm beyond the bed; move, turn or scale the part, or set a smaller {keys}")
    })
}

/// How far lines \[nm\] reach beyond a convex bed with these corners \[mm\]; 0 or less inside.
fn beyond(lines: &[&[Point2]], origin: [i64; 3], bed: &[[f64; 2]]) -> f64 {
    let edges = || bed.iter().zip(bed.iter().cycle().skip(1)).filter(|(a, b)| a != b);
    let twice_area: f64 = edges().map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
    let outside = |p: Point2| {
        let p = [i64::from(p.x) + origin[0], i64::from(p.y) + origin[1]].map(|c| c as f64 / NM_PER_MM);
        let right_of = |(a, b): (&[f64; 2], &[f64; 2])| {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            (dy * (p[0] - a[0]) - dx * (p[1] - a[1])) / (dx * dx + dy * dy).sqrt() * twice_area.signum()
        };
        edges().map(right_of).fold(f64::NEG_INFINITY, f64::max)
    };
    let points = || lines.iter().copied().flatten().copied();
    // Mostly the box around all of them lies on the bed.
    let (low, high) = bounds(points());
    let corners = [low, high, Point2::new(low.x, high.y), Point2::new(high.x, low.y)];
    let farthest =
        |points: &mut dyn Iterator<Item = Point2>| points.map(outside).fold(f64::NEG_INFINITY, f64::max);
    if points().next().is_none() {
        return f64::NEG_INFINITY;
    }
    let of_box = farthest(&mut corners.into_iter());
    if of_box < -MARGIN { of_box } else { farthest(&mut points()) }
}

/// Lines are thinner than twice this \[mm\].
const MARGIN: f64 = 2.0;

/// So far over the edge does not count \[mm\].
const SLACK: f64 = 0.01;

#[cfg(test)]
#[path = "adhesion_tests.rs"]
mod tests;
