//! Loops → areas: booleans, offsets, perimeters.

pub mod areas;
mod beads;
pub mod boolean;
mod extra;
pub mod foot;
pub mod inside;
pub mod gaps;
pub mod layers;
mod medial;
mod near;
pub mod offset;
mod one_wall;
mod overhang;
pub mod perimeters;
mod shadow;
mod wavefront;

#[cfg(test)]
mod tests;
#[cfg(test)]
mod wall_tests;

use crate::contour::{ExPolygon, Ring};
use crate::lattice::Point2;

/// One connected area of a layer with what is printed in it, inside its outline.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Island {
    /// The area itself, as sliced.
    pub outline: ExPolygon,
    /// Centre lines of the walls, from the outermost inwards.
    pub walls: Vec<Wall>,
    /// Open lines of varying width: thin walls, and fill of gaps between the walls.
    pub beads: Vec<Bead>,
    /// What is left for infill: lines end on its border, so overlap with the walls is already in it.
    pub infill: Vec<ExPolygon>,
}

/// The centre line of one closed wall.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wall {
    /// The loop \[nm\]; counter-clockwise around material, clockwise around a hole.
    pub ring: Ring,
    /// 0 for the external wall, 1 for the next one inwards, and so on.
    pub depth: u32,
    /// True when the loop runs around a hole.
    pub hole: bool,
    /// Per edge, `ring[i]` to `ring[i + 1]`, true where it runs over air; empty where no edge does. The
    /// ring has corners where that changes.
    pub overhang: Vec<bool>,
}

/// The centre line of a bead whose width varies.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Bead {
    /// The line \[nm\]; at least two points. A closed one repeats its first point at the end.
    pub points: Vec<Point2>,
    /// Width of the bead at each point \[nm\]; between points it changes evenly.
    pub widths: Vec<i32>,
    /// What it is.
    pub kind: BeadKind,
}

/// What a line of varying width is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BeadKind {
    /// A wall too thin for a loop; it shows, like an external wall.
    #[default]
    ThinWall,
    /// Between two walls, or between walls and nothing.
    GapFill,
}
