//! The cross-section of a printed line: its width, spacing and volume.
//!
//! A bead between flat layers is a rectangle with rounded ends: of width `w` and height `h` it has
//! the area `h (w - h (1 - pi/4))`. Neighbouring beads are laid `w - h (1 - pi/4)` apart, so that the
//! material of one fills the hollow between two round flanks. This is Slic3r's model of 2013 (Ranellucci),
//! documented in its manual under "Flow Math"; PrusaSlicer and its descendants use it too.

use super::{FloatOrPercent, Settings};
use crate::lattice;
use std::f64::consts::PI;

/// What a line belongs to, as far as its width goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlowRole {
    /// The outermost wall.
    ExternalPerimeter,
    /// An inner wall.
    Perimeter,
    /// Sparse infill.
    Infill,
    /// Solid infill.
    SolidInfill,
    /// Topmost solid infill.
    TopSolidInfill,
    /// Skirt.
    Skirt,
}

/// Width and height of a bead \[mm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Full width of the bead \[mm\].
    pub width: f64,
    /// Thickness of the layer \[mm\].
    pub height: f64,
}

/// Share of its height by which the rounded flanks of a bead narrow it: 1 - pi/4.
const ROUNDING: f64 = 1.0 - PI / 4.0;

impl Flow {
    /// The flow of a role on a layer of `height` \[mm\]; `first` is true on the first layer.
    ///
    /// A width of 0 falls back to `extrusion_width` and then to a multiple of the nozzle's bore
    /// (external 1.05, top 1.0, others 1.125), percentages are of the layer height: PrusaSlicer's rules.
    pub fn new(role: FlowRole, height: f64, first: bool, settings: &Settings) -> Self {
        let (w, nozzle) = (&settings.widths, settings.printer.nozzle_diameter);
        let own = match role {
            FlowRole::ExternalPerimeter => w.external_perimeter_extrusion_width,
            FlowRole::Perimeter | FlowRole::Skirt => w.perimeter_extrusion_width,
            FlowRole::Infill => w.infill_extrusion_width,
            FlowRole::SolidInfill => w.solid_infill_extrusion_width,
            FlowRole::TopSolidInfill => w.top_infill_extrusion_width,
        };
        let given = |v: FloatOrPercent| Some(v.of(height)).filter(|w| *w > 0.0);
        let auto = match role {
            FlowRole::ExternalPerimeter => 1.05 * nozzle,
            FlowRole::TopSolidInfill => nozzle,
            _ => 1.125 * nozzle,
        };
        let first_width = if first { given(w.first_layer_extrusion_width) } else { None };
        let width = first_width.or_else(|| given(own)).or_else(|| given(w.extrusion_width)).unwrap_or(auto);
        Self { width, height }
    }

    /// Distance between the centre lines of neighbouring beads \[mm\].
    pub fn spacing(self) -> f64 {
        self.width - self.height * ROUNDING
    }

    /// Cross-section \[mm²\], which is mm³ of plastic per mm of line.
    pub fn mm3_per_mm(self) -> f64 {
        self.height * self.spacing()
    }

    /// Width on the lattice \[nm\].
    pub fn width_nm(self) -> i64 {
        lattice::nm(self.width)
    }

    /// Spacing on the lattice \[nm\].
    pub fn spacing_nm(self) -> i64 {
        lattice::nm(self.spacing())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rounded_rectangle_is_the_textbooks() {
        let f = Flow { width: 0.45, height: 0.2 };
        // A rectangle of (w - h) x h between two half discs of diameter h.
        let area = (0.45 - 0.2) * 0.2 + PI * 0.1 * 0.1;
        assert!((f.mm3_per_mm() - area).abs() < 1e-12);
        assert!((f.spacing() - 0.407_079_632_679_489_7).abs() < 1e-12);
    }

    #[test]
    fn widths_fall_back_as_in_prusaslicer() {
        let mut s = Settings::default();
        assert_eq!(Flow::new(FlowRole::ExternalPerimeter, 0.2, false, &s).width, 1.05 * 0.4);
        assert_eq!(Flow::new(FlowRole::Infill, 0.2, true, &s).width, 0.4);
        s.widths.extrusion_width = FloatOrPercent::Float(0.5);
        assert_eq!(Flow::new(FlowRole::Perimeter, 0.2, false, &s).width, 0.5);
        s.widths.perimeter_extrusion_width = FloatOrPercent::Percent(300.0);
        assert!((Flow::new(FlowRole::Perimeter, 0.2, false, &s).width - 0.6).abs() < 1e-12);
    }
}
