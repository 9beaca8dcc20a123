//! All layers: outlines on rows, areas by kind, lines.

use super::border::Border;
use super::rectilinear::{Style, lay};
use super::skin::{Areas, Level, divide};
use super::{FillKind, FillPath, FillPlan};
use crate::lattice::Point2;
use crate::region::Island;
use crate::span::algebra::and_row;
use crate::span::{RowFrame, Rows, RowsBuilder, Trace, scan, trace};
use rayon::prelude::*;
use std::ops::Range;
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

/// Fills all layers of an object, lowest first: layer → island → paths.
///
/// Paths of an island come kind by kind (sparse, solid, top), region by region, and in the order in
/// which they are to be laid; the lines of a solid region are laid in one sweep if that order and the
/// paths' directions are kept. Every path stays within 2 nm of the island's infill areas.
///
/// Rows lie at fixed places of the mesh frame, so a border parallel to them may be up to one spacing
/// away from the nearest line. The spacing counts the lines alone: the links between them come on top.
pub fn fill(layers: &[FillLayer], plan: &FillPlan) -> Vec<Vec<Vec<FillPath>>> {
    let frames = [false, true].map(|turned| plan.area_frame(turned));
    let levels: Vec<Level> =
        layers.iter().map(|l| Level { top: l.print_z, bottom: l.print_z - l.height }).collect();
    let outlines = outlines(layers, &frames, plan);
    let families = [0, 1].map(|f: usize| outlines.iter().map(|o| &o[f]).collect::<Vec<_>>());
    layers
        .par_iter()
        .enumerate()
        .map(|(i, layer)| {
            let rings = Rings::new(layer.islands);
            let mut out = vec![Vec::new(); layer.islands.len()];
            for turned in [false, true] {
                let kinds: Vec<_> = KINDS.into_iter().filter(|&k| plan.is_turned(k, i) == turned).collect();
                if kinds.is_empty() || rings.rings.is_empty() {
                    continue;
                }
                let frame = &frames[usize::from(turned)];
                let own = trace(rings.rings.iter().copied(), frame);
                let areas = divide(i, &own.rows, &families[usize::from(turned)], &levels, frame, plan);
                for kind in kinds {
                    rings.fill(kind, i, &areas, &own, frame, plan, &mut out);
                }
            }
            out
        })
        .collect()
}

/// Every layer's outlines on the rows of both families, as far as they are needed. A layer like the
/// one below shares its rows.
fn outlines(layers: &[FillLayer], frames: &[RowFrame; 2], plan: &FillPlan) -> Vec<Arc<[Rows; 2]>> {
    let needed =
        [false, true].map(|turned| (0..2).any(|i| KINDS.iter().any(|&k| plan.is_turned(k, i) == turned)));
    let same = |i: usize| {
        let (a, b) = (layers[i].islands, layers[i - 1].islands);
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.outline == b.outline)
    };
    let scanned: Vec<Option<Arc<[Rows; 2]>>> = layers
        .par_iter()
        .enumerate()
        .map(|(i, layer)| {
            if i > 0 && same(i) {
                return None;
            }
            Some(Arc::new([0, 1].map(|f| {
                if !needed[f] {
                    return Rows::default();
                }
                let rings = layer.islands.iter().flat_map(|i| i.outline.rings());
                scan(rings.map(|r| &r[..]), &frames[f])
            })))
        })
        .collect();
    let mut last = Arc::default();
    let mut shared = Vec::with_capacity(scanned.len());
    for rows in scanned {
        last = rows.unwrap_or(last);
        shared.push(Arc::clone(&last));
    }
    shared
}

const KINDS: [FillKind; 3] = [FillKind::Sparse, FillKind::Solid, FillKind::TopSolid];

/// The infill areas of a layer, flattened.
#[derive(Default)]
struct Rings<'a> {
    rings: Vec<&'a [Point2]>,
    /// Per region (one `ExPolygon`) its rings.
    regions: Vec<Range<usize>>,
    region_of_ring: Vec<u32>,
    island_of_region: Vec<usize>,
}

impl<'a> Rings<'a> {
    fn new(islands: &'a [Island]) -> Self {
        let mut all = Self::default();
        for (i, island) in islands.iter().enumerate() {
            for area in &island.infill {
                let begin = all.rings.len();
                all.rings.extend(area.rings().map(|r| &r[..]));
                all.region_of_ring.resize(all.rings.len(), all.regions.len() as u32);
                all.regions.push(begin..all.rings.len());
                all.island_of_region.push(i);
            }
        }
        all
    }

    /// Lays the lines of one kind on layer `i`.
    #[expect(clippy::too_many_arguments, reason = "the layer's state, shared by its kinds")]
    fn fill(
        &self,
        kind: FillKind,
        i: usize,
        areas: &Areas,
        own: &Trace,
        frame: &RowFrame,
        plan: &FillPlan,
        out: &mut [Vec<FillPath>],
    ) {
        let area = match kind {
            FillKind::Sparse if plan.density <= 0.0 => return,
            FillKind::Sparse => &areas.sparse,
            FillKind::Solid => &areas.solid,
            FillKind::TopSolid => &areas.top,
            FillKind::Bridge | FillKind::InternalBridge => return,
        };
        if area.is_empty() {
            return;
        }
        let lines = plan.line_frame(kind, i);
        let (traced, moved);
        let (trace, area) = if lines == *frame {
            (own, area)
        } else {
            traced = trace(self.rings.iter().copied(), &lines);
            moved = resample(&widen(area, &own.rows), frame, &traced.rows, &lines);
            (&traced, &moved)
        };
        let border = Border {
            rings: &self.rings,
            regions: &self.regions,
            region_of_ring: &self.region_of_ring,
            trace,
            frame: &lines,
        };
        let least = plan.pitch(FillKind::Solid, i);
        let style = Style { kind, pitch: plan.pitch(kind, i), least };
        lay(&border, area, style, |region, path| out[self.island_of_region[region]].push(path));
    }
}

/// Moves the ends of `area` that lie on the border of `own` outwards, half-way to the next span of
/// `own`: on another family of rows the border is elsewhere, and cuts there.
fn widen(area: &Rows, own: &Rows) -> Rows {
    let mut out = RowsBuilder::new(area.first());
    for (k, row) in area.iter() {
        let whole = own.row(k);
        let middle = |i: usize| {
            let (a, b) = (i64::from(whole[i].end), i64::from(whole[i + 1].start));
            ((a + b) / 2) as i32
        };
        and_row(whole, row, |piece, i| {
            let start = match i {
                _ if piece.start != whole[i].start => piece.start,
                0 => i32::MIN,
                _ => middle(i - 1),
            };
            let end = match i + 1 {
                _ if piece.end != whole[i].end => piece.end,
                n if n == whole.len() => i32::MAX,
                _ => middle(i),
            };
            out.push(start, end);
        });
        out.end_row();
    }
    out.finish()
}

/// `area` on the rows of another frame of the same direction: each takes over the nearest row of
/// `area`, cut to `own`.
fn resample(area: &Rows, frame: &RowFrame, own: &Rows, to: &RowFrame) -> Rows {
    let mut out = RowsBuilder::new(own.first());
    for (k, row) in own.iter() {
        and_row(row, area.row(frame.nearest_row(to.t(k))), |s, _| out.push(s.start, s.end));
        out.end_row();
    }
    out.finish()
}
