//! Overhangs, supports and adhesion.
//!
//! Areas are rows: what of a layer hangs, what stands under it, what must be kept clear of it. All of them lie
//! on the rows of one frame, [`SupportPlan::frame`]; outlines become polygons again only where lines are laid.

pub mod brim;
pub mod check;
pub mod columns;
pub mod overhang;
pub mod paths;
mod plan;
pub mod raft;
pub mod report;
pub mod skirt;
pub mod tree;

pub use crate::infill::Level;
pub use plan::SupportPlan;

use crate::lattice::Point2;
use crate::settings::SupportStyle;
use crate::span::{RowFrame, Rows};
use overhang::Overhang;
use std::sync::Arc;

/// The part as the support stage sees it: its layers, lowest first, on the rows of one frame.
#[derive(Clone, Copy, Debug)]
pub struct Part<'a> {
    /// Outlines; neighbours that are equal share theirs.
    pub outlines: &'a [Arc<Rows>],
    /// Heights above the bed; on a raft the lowest layer begins above 0. Length = layers.
    pub levels: &'a [Level],
    /// The rows.
    pub frame: &'a RowFrame,
}

/// One layer of supports or raft.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SupportLayer {
    /// Height of its upper side above the bed \[nm\].
    pub print_z: i32,
    /// Its thickness \[nm\].
    pub height: i32,
    /// What kind of layer it is.
    pub kind: LayerKind,
    /// Columns or branches, or the raft's loose layers. The areas do not overlap.
    pub base: Rows,
    /// The part of `base` that has two walls, in branches.
    pub thick: Rows,
    /// Dense, under the part.
    pub interface: Rows,
    /// The part of `interface` that the part lies upon.
    pub contact: Rows,
    /// Dense, on the part.
    pub bottom_interface: Rows,
}

impl SupportLayer {
    /// Height of its lower side above the bed \[nm\].
    pub fn bottom_z(&self) -> i32 {
        self.print_z - self.height
    }

    /// Nothing is printed.
    pub fn is_empty(&self) -> bool {
        self.base.is_empty() && self.interface.is_empty() && self.bottom_interface.is_empty()
    }
}

/// What a layer of supports belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum LayerKind {
    /// Columns: `base` is filled with the support's pattern.
    #[default]
    Columns,
    /// Branches: `base` has walls and nothing within.
    Branches,
    /// The raft's first layer.
    RaftFirst,
    /// The raft's loose layers.
    RaftBase,
    /// The raft's dense layers, which are `interface`.
    RaftInterface,
}

/// A line of supports, raft or brim.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Strand {
    /// Centre line \[nm\]; at least two points.
    pub points: Vec<Point2>,
    /// It runs on from its last point to its first.
    pub closed: bool,
    /// What it is.
    pub kind: StrandKind,
}

/// What a strand is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum StrandKind {
    /// Of a column, a branch, or a loose layer of raft.
    Base,
    /// Of a dense layer.
    Interface,
    /// Of the brim.
    Brim,
}

/// The supports of a part that stands at `plan.base_z`, lowest layer first: columns or branches by
/// `plan.style`.
pub fn supports(part: Part, overhangs: &[Overhang], plan: &SupportPlan) -> Vec<SupportLayer> {
    if overhangs.iter().all(|o| o.area.is_empty()) {
        return Vec::new();
    }
    match plan.style {
        SupportStyle::Grid | SupportStyle::Snug => columns::columns(part, overhangs, plan),
        SupportStyle::Organic => tree::tree(part, overhangs, plan),
    }
}
