//! Areas and lines → ordered moves.
//!
//! [`plan`] decides in which order and direction the walls and fills of every layer are printed,
//! where loops start, where the filament is pulled back, how fast every line goes and how fast the
//! fan turns. It is serial and cheap; its result depends on nothing but its arguments.

mod bead;
mod cooling;
mod loops;
mod nearest;
mod order;
pub mod role;
pub mod seam;
mod sheet;
mod simplify;
pub mod speed;
#[cfg(test)]
mod support_tests;
#[cfg(test)]
pub(crate) mod testing;

pub use order::Planner;
pub use role::Role;

use crate::contour::Ring;
use crate::infill::FillPath;
use crate::lattice::Point2;
use crate::region::{Bead, Wall};
use crate::settings::Settings;
use crate::slice::planes::LayerZ;
use crate::support::Strand;
use std::ops::Range;

/// What one layer prints, not yet in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrintLayer {
    /// Heights. A layer of nothing but supports has `slice_z` 0.
    pub z: LayerZ,
    /// The connected areas.
    pub islands: Vec<PrintIsland>,
    /// Loops around the print, in printing order.
    pub skirt: Vec<Ring>,
    /// Thickness of these \[nm\], which is more than the layer's where it hangs above a raft; 0 without any.
    pub skirt_height: i32,
    /// The brim, in printing order.
    pub brim: Vec<Strand>,
    /// Supports or raft whose upper side is the layer's, in printing order.
    pub supports: Vec<Strand>,
    /// Thickness of these \[nm\], which may differ from the part's; 0 without any.
    pub support_height: i32,
    /// It is the part's first layer, and lies on a raft.
    pub on_raft: bool,
}

impl PrintLayer {
    /// It is a layer of nothing but supports or raft, none of the part's.
    pub fn is_beside(&self) -> bool {
        self.z.slice_z == 0 && self.islands.is_empty() && !self.supports.is_empty()
    }
}

/// What one connected area of a layer prints.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PrintIsland {
    /// Centre lines of the walls.
    pub walls: Vec<Wall>,
    /// Thin walls and gap fill.
    pub beads: Vec<Bead>,
    /// Infill lines.
    pub fills: Vec<FillPath>,
}

/// One layer in printing order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LayerPlan {
    /// Height of the nozzle above the bed \[nm\].
    pub print_z: i32,
    /// Thickness \[nm\].
    pub height: i32,
    /// Extrusions in printing order; between them the nozzle travels in a straight line.
    pub extrusions: Vec<Extrusion>,
    /// The points of all extrusions \[nm\], in the mesh's frame.
    pub points: Vec<Point2>,
    /// Fan speed \[%\].
    pub fan: f64,
    /// Duration of all travel at full speed, without acceleration \[s\].
    pub travel_seconds: f64,
}

impl LayerPlan {
    /// Duration of the layer without acceleration and retractions: a lower bound \[s\].
    pub fn seconds(&self) -> f64 {
        self.travel_seconds + self.extrusions.iter().map(|e| e.length / e.speed).sum::<f64>()
    }

    /// The centre line of an extrusion of this layer.
    pub fn path(&self, extrusion: &Extrusion) -> &[Point2] {
        let Range { start, end } = extrusion.points;
        self.points.get(start as usize..end as usize).unwrap_or_default()
    }
}

/// One line to be extruded without a break; loops have been cut open at their seams.
#[derive(Clone, Debug, PartialEq)]
pub struct Extrusion {
    /// What it is for.
    pub role: Role,
    /// Its points in [`LayerPlan::points`]; at least two.
    pub points: Range<u32>,
    /// Width of the bead \[mm\].
    pub width: f64,
    /// Height of the bead \[mm\]: the layer's, but for threads over air and infill of several layers.
    pub height: f64,
    /// Cross-section \[mm²\], before `extrusion_multiplier`.
    pub mm3_per_mm: f64,
    /// Feed rate \[mm/s\].
    pub speed: f64,
    /// Length \[mm\].
    pub length: f64,
    /// Pull the filament back on the way to its first point.
    pub retract: bool,
    /// Fan speed while it is printed \[%\]; `None` = the layer's.
    pub fan: Option<f64>,
}

/// Plans all layers; `start` is where the nozzle stands at first \[nm, the mesh's frame\].
///
/// A caller that wants to write each layer as soon as it is planned uses a [`Planner`] instead.
pub fn plan<'a>(
    layers: impl IntoIterator<Item = &'a PrintLayer>,
    start: Point2,
    settings: &Settings,
) -> Vec<LayerPlan> {
    let mut planner = Planner::new(start, settings);
    let plan_one = |layer| {
        let mut out = LayerPlan::default();
        planner.layer(layer, &mut out);
        out
    };
    layers.into_iter().map(plan_one).collect()
}
