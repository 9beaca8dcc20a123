//! Loops → areas: booleans, offsets, perimeters.

pub mod areas;
pub mod boolean;
pub mod offset;
pub mod perimeters;
mod wavefront;

#[cfg(test)]
mod tests;

use crate::contour::{ExPolygon, Ring};

/// One connected area of a layer with what is printed in it, inside its outline.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Island {
    /// The area itself, as sliced.
    pub outline: ExPolygon,
    /// Centre lines of the walls, from the outermost inwards.
    pub walls: Vec<Wall>,
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
}
