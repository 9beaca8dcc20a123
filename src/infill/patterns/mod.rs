//! Sparse infill: the patterns.
//!
//! A pattern says where its lines lie, and by that how long they are per area: its density law. The
//! laws count lines alone; what links and anchors add along the walls comes on top, as in PrusaSlicer.

mod aligned_rectilinear;
pub(crate) mod clip;
mod crossing;
mod cubic;
mod grid;
pub(crate) mod honeycomb;
pub(crate) mod join;
mod line;
mod monotonic;
mod monotonic_lines;
mod open;
mod rectilinear;
mod stars;
mod straight;
mod triangles;
mod zigzag;

use super::anchor::Anchors;
use super::regions::Compared;
use super::{FillKind, FillPath, FillPlan};
use crate::lattice::Point2;
use crate::settings::FillPattern;
use crate::span::Rows;
use open::SparseOnly;

/// The sparse infill of a layer.
#[derive(Clone, Copy, Debug)]
pub struct Sparse<'a> {
    /// The layer's infill regions and the rows of areas.
    pub compared: Compared<'a>,
    /// What is to be filled, on the rows of areas; not empty.
    pub area: &'a Rows,
    /// Density above 0, pattern, angle, spacing.
    pub plan: &'a FillPlan,
    /// Index of the layer, counted in layers as thick as the lines.
    pub layer: usize,
    /// Height of its upper side \[nm\].
    pub print_z: i64,
    /// Number of layers that the lines are thick: the value of [`FillPath::layers`].
    pub layers: u32,
}

/// Lays the sparse infill of one layer: reports each path with the index of its region, region by
/// region, in the order in which they are to be laid.
pub fn lay(sparse: &Sparse, found: impl FnMut(usize, FillPath)) {
    match sparse.plan.pattern {
        FillPattern::Rectilinear => rectilinear::lay(sparse, found),
        FillPattern::Monotonic => monotonic::lay(sparse, found),
        FillPattern::MonotonicLines => monotonic_lines::lay(sparse, found),
        FillPattern::AlignedRectilinear => aligned_rectilinear::lay(sparse, found),
        FillPattern::Line => line::lay(sparse, found),
        FillPattern::ZigZag => zigzag::lay(sparse, found),
        FillPattern::Grid => grid::lay(sparse, found),
        FillPattern::Triangles => triangles::lay(sparse, found),
        FillPattern::Stars => stars::lay(sparse, found),
        FillPattern::Cubic => cubic::lay(sparse, found),
        FillPattern::Honeycomb => honeycomb::lay(sparse, found),
    }
}

/// What the geometry of a pattern depends on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spec {
    /// Direction of the first family of lines \[degrees\], counter-clockwise from +x.
    pub angle: f64,
    /// Distance between lines at full density \[nm\].
    pub spacing: f64,
    /// Share of the volume that lines fill, above 0.
    pub density: f64,
    /// Index of the layer, counted in layers as thick as the lines.
    pub layer: usize,
    /// Height of its upper side \[nm\].
    pub z: f64,
}

impl Spec {
    /// Distance between the lines of each of `families` families that share the density \[nm\].
    fn pitch(&self, families: f64) -> f64 {
        families * self.spacing / self.density
    }

    /// The angle, turned by 90 degrees on odd layers.
    fn turned(&self) -> f64 {
        self.angle + if self.layer.is_multiple_of(2) { 0.0 } else { 90.0 }
    }
}

impl<'a> Sparse<'a> {
    fn spec(&self) -> Spec {
        Spec {
            angle: self.plan.angle,
            spacing: self.plan.sparse_spacing(self.layer, self.layers),
            density: self.plan.density,
            layer: self.layer,
            z: self.print_z as f64,
        }
    }

    /// Lines shorter than this are left out \[nm\].
    fn least(&self) -> f64 {
        self.plan.pitch(FillKind::Solid, self.layer)
    }

    fn anchors(&self) -> Anchors {
        let link = self.plan.anchor_max;
        Anchors { link, anchor: self.plan.anchor.min(link), gap: self.least() }
    }

    /// The walls of the sparse part of the regions.
    fn open(&self) -> SparseOnly<'a> {
        let is_whole = self.area.length() == self.compared.own.length();
        SparseOnly { area: (!is_whole).then_some(self.area), frame: self.compared.frame }
    }

    /// The border of the area inside the regions as directed edges \[nm\]; `None` where all is sparse.
    fn outline(&self) -> Option<Vec<[Point2; 2]>> {
        let is_whole = self.area.length() == self.compared.own.length();
        (!is_whole).then(|| self.compared.outline(self.area))
    }

    /// Takes chains of points and reports them as paths.
    fn paths(&self, mut found: impl FnMut(usize, FillPath)) -> impl FnMut(usize, Vec<Point2>) {
        let layers = self.layers;
        move |region, points| found(region, FillPath { points, kind: FillKind::Sparse, layers })
    }
}
