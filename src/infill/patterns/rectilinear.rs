//! Parallel lines, linked where the border is short.
//!
//! Length of lines per area = density / spacing.

use super::Sparse;
use crate::infill::rectilinear::{self, Style};
use crate::infill::{FillKind, FillPath};

/// Lays parallel lines in the plan's direction for the layer.
pub fn lay(sparse: &Sparse, mut found: impl FnMut(usize, FillPath)) {
    let (plan, i) = (sparse.plan, sparse.layer);
    let lines = plan.line_frame(FillKind::Sparse, i);
    let trace = sparse.compared.regions.trace(&lines);
    let area = sparse.compared.onto(sparse.area, &trace, &lines);
    let border = sparse.compared.regions.border(&trace, &lines);
    let kind = FillKind::Sparse;
    let style = Style { kind, pitch: plan.pitch(kind, i), least: plan.pitch(FillKind::Solid, i) };
    rectilinear::lay(&border, &area, style, |region, path| {
        found(region, FillPath { layers: sparse.layers, ..path })
    });
}
