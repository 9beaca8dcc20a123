//! All layers: regions on rows, areas by kind, lines.

use super::anchor::Everywhere;
use super::bridge::{Bridge, Grid, by_direction, over_air, over_sparse, union};
use super::combine::{Thick, combine};
use super::patterns::{self, Sparse};
use super::rectilinear::{Chain, Links, chains};
use super::regions::{Compared, Regions};
use super::skin::{Areas, Level, Skins, Stack};
use super::{FillKind, FillPath, FillPlan};
use crate::contour::Ring;
use crate::region::Island;
use crate::span::algebra::{or, sub};
use crate::span::{RowFrame, Rows, Trace, scan_layers};
use rayon::prelude::*;
use std::sync::Arc;

/// One layer as the infill stage sees it.
#[derive(Clone, Copy, Debug)]
pub struct FillLayer<'a> {
    /// Its islands.
    pub islands: &'a [Island],
    /// Height of its upper side \[nm\].
    pub print_z: i64,
    /// Its thickness \[nm\].
    pub height: i64,
}

/// The infill of an object.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Filled {
    /// Layer, lowest first → island → paths.
    pub paths: Vec<Vec<Vec<FillPath>>>,
    /// Per layer its bridges over air, on the rows of `FillPlan::area_frame`.
    pub bridges: Vec<Vec<Bridge>>,
}

/// Fills all layers of an object, lowest first.
///
/// Paths of an island come kind by kind (sparse, bridges, solid, top), region by region, and in the order
/// in which they are to be laid; the lines of a solid region are laid in one sweep if that order and the
/// paths' directions are kept. Every path stays within 2 nm of the island's infill areas.
///
/// Areas are compared on one family of rows, those of `FillPlan::area_frame`; lines of other directions
/// or distances carry them over to their own rows.
///
/// Rows lie at fixed places of the mesh frame, so a border parallel to them may be up to one spacing
/// away from the nearest line. The spacing counts the lines alone: the links between them come on top.
pub fn fill(layers: &[FillLayer], plan: &FillPlan) -> Filled {
    let frame = plan.area_frame();
    let levels: Vec<Level> =
        layers.iter().map(|l| Level { top: l.print_z, bottom: l.print_z - l.height }).collect();
    let outlines = on_rows(layers, &frame, |i| i.outline.rings());
    let own = on_rows(layers, &frame, |i| i.infill.iter().flat_map(|e| e.rings()));
    let stack = Stack { outlines: &outlines, own: &own, levels: &levels, frame: &frame, plan };
    let skins: Vec<Skins> = (0..layers.len()).into_par_iter().map(|i| stack.skins(i)).collect();
    let mut areas: Vec<Areas> = (0..layers.len()).into_par_iter().map(|i| stack.divide(i, &skins)).collect();
    let bridges = bridges(&mut areas, &own, &outlines, &frame, plan);
    let sparse = combine(&mut areas, &levels, &frame, plan);
    let paths = layers
        .par_iter()
        .enumerate()
        .map(|(i, layer)| {
            let regions = Regions::new(layer.islands);
            let mut filling = Filling {
                compared: Compared { regions: &regions, own: &own[i], frame: &frame },
                plan,
                layer: i,
                traces: Vec::new(),
                out: vec![Vec::new(); layer.islands.len()],
            };
            filling.sparse(&sparse[i], layer.print_z);
            for (bridges, kind) in bridges[i].iter().zip([FillKind::InternalBridge, FillKind::Bridge]) {
                for bridge in bridges {
                    filling.straight(&bridge.rows, kind, &plan.bridge_frame(bridge.degrees, kind, i));
                }
            }
            filling.straight(&areas[i].solid, FillKind::Solid, &plan.line_frame(FillKind::Solid, i));
            filling.straight(&areas[i].top, FillKind::TopSolid, &plan.line_frame(FillKind::TopSolid, i));
            filling.out
        })
        .collect();
    Filled { paths, bridges: bridges.into_iter().map(|[_, over_air]| over_air).collect() }
}

/// Some rings of every layer on the rows of `frame`. A layer like the one below shares its rows.
fn on_rows<'a, R: Iterator<Item = &'a Ring>>(
    layers: &[FillLayer<'a>],
    frame: &RowFrame,
    rings: impl Fn(&'a Island) -> R + Sync,
) -> Vec<Arc<Rows>> {
    scan_layers(layers.len(), |i| layers[i].islands.iter().flat_map(&rings).map(|r| &r[..]), frame)
}

/// Takes the bridges out of every layer's areas, those over sparse infill and those over air; what is
/// left of the skins over air becomes solid.
fn bridges(
    areas: &mut [Areas],
    own: &[Arc<Rows>],
    outlines: &[Arc<Rows>],
    frame: &RowFrame,
    plan: &FillPlan,
) -> Vec<[Vec<Bridge>; 2]> {
    let grid = Grid { frame, degrees: plan.angle };
    let internal: Vec<Option<Bridge>> = (0..areas.len())
        .into_par_iter()
        .map(|i| {
            let below = i.checked_sub(1)?;
            let rules = plan.bridges.filter(|_| plan.density > 0.0)?;
            let (solid, sparse) = (&areas[i].solid, &areas[below].sparse);
            if solid.is_empty() || sparse.is_empty() {
                return None;
            }
            over_sparse(solid, sparse, grid, plan.across_sparse(below), &rules)
        })
        .collect();
    areas
        .par_iter_mut()
        .zip(internal)
        .enumerate()
        .map(|(i, (areas, internal))| {
            let mut internal = Vec::from_iter(internal);
            for bridge in &internal {
                areas.solid = sub(&areas.solid, &bridge.rows);
            }
            let bottom = std::mem::take(&mut areas.bottom);
            if bottom.is_empty() {
                return [internal, Vec::new()];
            }
            let below = i.checked_sub(1).and_then(|b| outlines.get(b));
            let rules = plan.bridges.filter(|rules| rules.over_air);
            let found = below.zip(rules).map_or_else(Vec::new, |(below, rules)| {
                by_direction(over_air(
                    &own[i],
                    &bottom,
                    below,
                    grid,
                    plan.degrees(FillKind::Solid, i),
                    &rules,
                ))
            });
            areas.solid = or(&areas.solid, &bottom);
            if !found.is_empty() {
                // Anchors are taken from whatever is there.
                let taken = union(&found);
                for area in [&mut areas.sparse, &mut areas.solid, &mut areas.top] {
                    *area = sub(area, &taken);
                }
                internal.iter_mut().for_each(|b| b.rows = sub(&b.rows, &taken));
            }
            [internal, found]
        })
        .collect()
}

/// The lines of one layer in the making.
struct Filling<'a> {
    compared: Compared<'a>,
    plan: &'a FillPlan,
    layer: usize,
    /// The regions on the lines used so far.
    traces: Vec<(RowFrame, Trace)>,
    /// Island → paths.
    out: Vec<Vec<FillPath>>,
}

impl Filling<'_> {
    /// Lays the sparse infill.
    fn sparse(&mut self, parts: &[Thick], print_z: i64) {
        if self.plan.density <= 0.0 {
            return;
        }
        let (compared, plan, layer) = (self.compared, self.plan, self.layer);
        for part in parts {
            // Counted in layers of this thickness: lines turn from one to the next.
            let layer = layer / part.layers as usize;
            let sparse = Sparse { compared, area: &part.rows, plan, layer, print_z, layers: part.layers };
            let islands = &compared.regions.island_of_region;
            patterns::lay(&sparse, |region, path| self.out[islands[region]].push(path));
        }
    }

    /// Fills an area with solid lines on the rows of `lines`.
    fn straight(&mut self, area: &Rows, kind: FillKind, lines: &RowFrame) {
        if area.is_empty() {
            return;
        }
        let known = self.traces.iter().position(|t| t.0 == *lines).unwrap_or_else(|| {
            self.traces.push((*lines, self.compared.regions.trace(lines)));
            self.traces.len() - 1
        });
        let trace = &self.traces[known].1;
        let area = self.compared.onto(area, trace, lines);
        let border = self.compared.regions.border(trace, lines);
        let least = self.plan.pitch(FillKind::Solid, self.layer);
        let (pitch, islands) = (self.plan.pitch(kind, self.layer), &self.compared.regions.island_of_region);
        let mut links = Links::near(pitch, &Everywhere);
        if !self.plan.linked[kind as usize] {
            (links.border, links.straight) = (0.0, 0.0);
        }
        chains(&border, &area, least, links, |Chain { region, points, .. }| {
            self.out[islands[region]].push(FillPath { points, kind, layers: 1 });
        });
    }
}
