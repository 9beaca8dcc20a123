//! Segments → closed loops, nesting, simplification.

pub mod nest;
pub mod cap;
pub mod chains;
mod edge;
mod finish;
mod front;
mod layered;
mod mate;
pub mod ring;
#[cfg(test)]
mod same_bytes;
pub mod simplify;
mod spans;
mod surface;
pub mod trace;
pub mod walk;

pub use trace::{LayerContours, Prepared, TraceError, TraceOptions, Walked, trace};
pub use walk::{contours_of, count_cycles};

use crate::lattice::Point2;

/// A closed polygon \[nm\]; the last point joins the first and is not repeated. Solid on the left:
/// outlines run counter-clockwise, holes clockwise.
pub type Ring = Vec<Point2>;

/// An area with holes, PrusaSlicer's ExPolygon.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExPolygon {
    /// Outer ring, counter-clockwise \[nm\].
    pub contour: Ring,
    /// Holes, clockwise \[nm\].
    pub holes: Vec<Ring>,
}

impl ExPolygon {
    /// The outer ring, then the holes.
    pub fn rings(&self) -> impl Iterator<Item = &Ring> {
        std::iter::once(&self.contour).chain(&self.holes)
    }

    /// Area \[mm²\].
    pub fn area_mm2(&self) -> f64 {
        let twice: i128 = self.rings().map(|r| crate::lattice::area2(r)).sum();
        twice as f64 * 0.5e-12
    }
}
