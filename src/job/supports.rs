//! Supports, raft and brim of a part whose layers are ready.

use super::adhesion;
use crate::contour::ExPolygon;
use crate::infill::Bridge;
use crate::region::Island;
use crate::settings::Settings;
use crate::slice::planes::LayerZ;
use crate::span::algebra::{or, sub};
use crate::span::{RowFrame, Rows, scan, scan_layers};
use crate::support::overhang::{Bridges, Modifiers, Overhang, overhangs};
use crate::support::raft::{self, Heights};
use crate::support::{self, Level, Part, Strand, SupportLayer, SupportPlan, brim, paths};
use std::sync::Arc;

/// What is printed beside the part.
#[derive(Clone, Debug, Default)]
pub struct Supports {
    /// Raft and supports, lowest layer first.
    pub layers: Vec<SupportLayer>,
    /// Their lines. Length = layers.
    pub strands: Vec<Vec<Strand>>,
    /// The brim, which [`adhesion::skirt_and_brim`] makes.
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
        let rings = |i: usize| islands[i].iter().flat_map(|i| i.outline.rings()).map(|r| &r[..]);
        let outlines = scan_layers(islands.len(), rings, &frame);
        let level = |l: &LayerZ| Level { top: l.print_z.into(), bottom: (l.print_z - l.height).into() };
        Self { outlines, levels: z.iter().map(level).collect(), frame }
    }

    /// As the support stage takes it.
    pub fn part(&self) -> Part<'_> {
        Part { outlines: &self.outlines, levels: &self.levels, frame: &self.frame }
    }
}

/// Whether anything but a part, its skirt and its brim is asked for.
pub fn is_wanted(settings: &Settings) -> bool {
    settings.has_supports()
}

/// Supports and raft; `z` are the heights of the part's layers above the bed.
///
/// On the bed the lines of supports leave the brim's area free, as in PrusaSlicer: what they would print there
/// the brim does.
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
        if let Some(first) = rows.outlines.first().filter(|_| !heights.layers.is_empty()) {
            let stands = columns.first().filter(|l| l.bottom_z() <= heights.top());
            let feet =
                stands.map_or_else(Rows::default, |l| or(&or(&l.base, &l.interface), &l.bottom_interface));
            all.layers = raft::raft(first, &feet, &heights, &plan);
        }
        all.layers.extend(columns);
        let under_brim = all.layers.first_mut().filter(|l| l.bottom_z() <= 0 && adhesion::has_brim(settings));
        let whole = under_brim.map(|first| leave_brim(first, islands, &plan, settings));
        all.strands = paths::strands(&all.layers, &plan);
        // The layer above stands on the brim as it would on this one.
        all.layers.iter_mut().zip(whole).for_each(|(first, whole)| *first = whole);
        all.rows = Some(rows);
    }
    all
}

/// Takes the brim's area out of a layer on the bed; returns the layer as it was.
fn leave_brim(
    layer: &mut SupportLayer,
    islands: &[Vec<Island>],
    plan: &SupportPlan,
    settings: &Settings,
) -> SupportLayer {
    let area = brim::cover(&adhesion::footprint(islands), adhesion::flow(settings), &settings.adhesion);
    let area = scan(area.iter().flat_map(ExPolygon::rings).map(|r| &r[..]), &plan.frame);
    let whole = layer.clone();
    let SupportLayer { base, thick, interface, contact, bottom_interface, .. } = layer;
    for of_support in [base, thick, interface, contact, bottom_interface] {
        *of_support = sub(of_support, &area);
    }
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Point2;
    use crate::span::algebra::and;

    fn rectangle(low: [i32; 2], high: [i32; 2]) -> ExPolygon {
        let corners = [[low[0], low[1]], [high[0], low[1]], high, [low[0], high[1]]];
        let contour = corners.map(|[x, y]| Point2::new(x * 1_000_000, y * 1_000_000)).to_vec();
        ExPolygon { contour, holes: Vec::new() }
    }

    #[test]
    fn lines_on_the_bed_leave_the_brims_area_to_it() {
        let mut settings = Settings::default();
        settings.adhesion.brim_width = 4.0;
        let plan = SupportPlan::new(&settings);
        let rows = |area: &ExPolygon| scan(area.rings().map(|r| &r[..]), &plan.frame);
        let outline = rectangle([0, 0], [20, 10]);
        let islands = vec![vec![Island { outline, ..Island::default() }]];
        let whole = SupportLayer {
            base: rows(&rectangle([22, 0], [40, 10])),
            interface: rows(&rectangle([0, -9], [20, -1])),
            ..SupportLayer::default()
        };
        let mut left = whole.clone();
        assert_eq!(leave_brim(&mut left, &islands, &plan, &settings), whole);
        let brim = rows(&rectangle([20, 0], [23, 10]));
        assert!(!and(&whole.base, &brim).is_empty() && and(&left.base, &brim).is_empty());
        // Beyond it nothing is lost.
        let beyond = [rows(&rectangle([25, 0], [40, 10])), rows(&rectangle([0, -9], [20, -5]))];
        assert!(sub(&beyond[0], &left.base).is_empty() && sub(&beyond[1], &left.interface).is_empty());
    }
}
