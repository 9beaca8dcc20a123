//! Supports, raft and brim of a part whose layers are ready.

use crate::contour::ExPolygon;
use crate::infill::Bridge;
use crate::lattice;
use crate::region::Island;
use crate::settings::Settings;
use crate::settings::flow::{Flow, FlowRole};
use crate::slice::planes::LayerZ;
use crate::span::algebra::or;
use crate::span::{RowFrame, Rows, scan};
use crate::support::overhang::{Bridges, Modifiers, Overhang, overhangs};
use crate::support::raft::{self, Heights};
use crate::support::{self, Level, Part, Strand, SupportLayer, SupportPlan, brim, paths};
use rayon::prelude::*;
use std::sync::Arc;

/// What is printed beside the part.
#[derive(Clone, Debug, Default)]
pub struct Supports {
    /// Raft and supports, lowest layer first.
    pub layers: Vec<SupportLayer>,
    /// Their lines. Length = layers.
    pub strands: Vec<Vec<Strand>>,
    /// The brim.
    pub brim: Vec<Strand>,
    /// What hangs, per layer of the part; empty where nobody asked.
    pub overhangs: Vec<Overhang>,
    /// The part as the support stage saw it; `None` where nobody asked.
    pub rows: Option<OnRows>,
}

/// The part on the rows of supports.
#[derive(Clone, Debug)]
pub struct OnRows {
    /// Its outlines, layer by layer.
    pub outlines: Vec<Arc<Rows>>,
    /// Heights.
    pub levels: Vec<Level>,
    /// The rows.
    pub frame: RowFrame,
}

impl OnRows {
    /// The layers of a part; `z` are their heights above the bed.
    pub fn new(islands: &[Vec<Island>], z: &[LayerZ], frame: RowFrame) -> Self {
        let of = |i: usize| islands[i].iter().flat_map(|i| i.outline.rings());
        let scanned: Vec<Option<Arc<Rows>>> = (0..islands.len())
            .into_par_iter()
            .map(|i| {
                let is_same = i > 0 && of(i).eq(of(i - 1));
                (!is_same).then(|| Arc::new(scan(of(i).map(|r| &r[..]), &frame)))
            })
            .collect();
        let mut last = Arc::default();
        let mut outlines = Vec::with_capacity(scanned.len());
        for rows in scanned {
            last = rows.unwrap_or(last);
            outlines.push(Arc::clone(&last));
        }
        let level = |l: &LayerZ| Level { top: l.print_z.into(), bottom: (l.print_z - l.height).into() };
        Self { outlines, levels: z.iter().map(level).collect(), frame }
    }

    /// As the support stage takes it.
    pub fn part(&self) -> Part<'_> {
        Part { outlines: &self.outlines, levels: &self.levels, frame: &self.frame }
    }
}

/// Whether anything but a part and its skirt is asked for.
pub fn is_wanted(settings: &Settings) -> bool {
    let (s, a) = (&settings.support, &settings.adhesion);
    s.support_material || s.support_material_enforce_layers > 0 || a.raft_layers > 0
}

/// Supports, raft and brim; `z` are the heights of the part's layers above the bed.
pub fn supports(
    islands: &[Vec<Island>],
    z: &[LayerZ],
    bridges: (&[Vec<Bridge>], &RowFrame),
    modifiers: Modifiers,
    settings: &Settings,
) -> Supports {
    let mut all = Supports::default();
    if is_wanted(settings) {
        let (plan, heights) = (SupportPlan::new(settings), Heights::new(settings));
        let rows = OnRows::new(islands, z, plan.frame);
        let bridges = Bridges { of_layer: bridges.0, frame: bridges.1 };
        all.overhangs = overhangs(rows.part(), modifiers, bridges, &plan);
        let columns = support::supports(rows.part(), &all.overhangs, &plan);
        let empty = Rows::default();
        if let Some(first) = rows.outlines.first().filter(|_| !heights.layers.is_empty()) {
            let stands = columns.first().filter(|l| l.bottom_z() <= heights.top());
            let feet = stands.map_or(empty.clone(), |l| or(&or(&l.base, &l.interface), &l.bottom_interface));
            all.layers = raft::raft(first, &feet, &heights, &plan);
        }
        all.layers.extend(columns);
        all.strands = paths::strands(&all.layers, &plan);
        all.rows = Some(rows);
    }
    if settings.adhesion.brim_width > 0.0 && settings.adhesion.raft_layers == 0 {
        let first = z.first().map_or(0, |l| l.height);
        let flow = Flow::new(FlowRole::Skirt, lattice::mm(first), true, settings);
        let outlines: Vec<ExPolygon> =
            islands.first().into_iter().flatten().map(|i| i.outline.clone()).collect();
        all.brim = brim::brim(&outlines, &[], flow, &settings.adhesion);
    }
    all
}
