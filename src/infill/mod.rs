//! Skins and infill patterns.

pub(crate) mod anchor;
pub(crate) mod border;
mod bridge;
mod combine;
mod layer;
mod onto;
pub(crate) mod patterns;
pub mod plan;
pub(crate) mod rectilinear;
pub(crate) mod regions;
mod skin;

pub use bridge::Bridge;
pub use layer::{FillLayer, Filled, fill};
pub use plan::FillPlan;
pub use skin::Level;

use crate::lattice::Point2;

/// What an infill line is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum FillKind {
    /// Sparse infill.
    Sparse,
    /// Solid infill below a top or above a bottom surface.
    Solid,
    /// The topmost solid layer.
    TopSolid,
    /// Solid infill over air, from one anchor to another.
    Bridge,
    /// Solid infill over sparse infill.
    InternalBridge,
}

impl FillKind {
    /// Number of kinds.
    pub const COUNT: usize = 5;
}

/// An open polyline to be extruded \[nm\]; at least two points.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FillPath {
    /// Centre line.
    pub points: Vec<Point2>,
    /// What it is for.
    pub kind: FillKind,
    /// Number of layers it is thick: 1, or more where sparse infill is combined.
    pub layers: u32,
}

#[cfg(test)]
mod tests;
