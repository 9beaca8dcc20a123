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
    /// Skirt and brim.
    Skirt,
    /// Columns and branches of support, and rafts.
    Support,
    /// The dense layers of support.
    SupportInterface,
}

/// Width and height of a bead \[mm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flow {
    /// Full width of the bead \[mm\].
    pub width: f64,
    /// Thickness of the layer, or diameter of a round thread \[mm\].
    pub height: f64,
    /// What lies on top of each other: see [`Flow::bridging`].
    pub section: Section,
}

/// Cross-section of a bead.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Section {
    /// Pressed flat between layers.
    Rounded,
    /// The same with its volume multiplied by this.
    Scaled(f64),
    /// A thread that hangs in air.
    Round,
}

/// Threads in air lie this much further apart than they are thick \[mm\], as in PrusaSlicer, since they
/// cannot be pressed into each other.
const THREAD_GAP: f64 = 0.05;

/// Share of its height by which the rounded flanks of a bead narrow it: 1 - pi/4.
const ROUNDING: f64 = 1.0 - PI / 4.0;

impl Flow {
    /// The flow of a role on a layer of `height` \[mm\]; `first` is true on the first layer.
    ///
    /// A width of 0 falls back to `extrusion_width` and then to a multiple of the nozzle's bore
    /// (external 1.05, top and support 1.0, others 1.125), percentages are of the layer height: PrusaSlicer's rules.
    pub fn new(role: FlowRole, height: f64, first: bool, settings: &Settings) -> Self {
        let (w, nozzle) = (&settings.widths, settings.printer.nozzle_diameter);
        let own = match role {
            FlowRole::ExternalPerimeter => w.external_perimeter_extrusion_width,
            FlowRole::Perimeter | FlowRole::Skirt => w.perimeter_extrusion_width,
            FlowRole::Infill => w.infill_extrusion_width,
            FlowRole::SolidInfill => w.solid_infill_extrusion_width,
            FlowRole::TopSolidInfill => w.top_infill_extrusion_width,
            FlowRole::Support | FlowRole::SupportInterface => w.support_material_extrusion_width,
        };
        let given = |v: FloatOrPercent| Some(v.of(height)).filter(|w| *w > 0.0);
        let auto = match role {
            FlowRole::ExternalPerimeter => 1.05 * nozzle,
            FlowRole::TopSolidInfill | FlowRole::Support | FlowRole::SupportInterface => nozzle,
            _ => 1.125 * nozzle,
        };
        let first_width = if first { given(w.first_layer_extrusion_width) } else { None };
        let width = first_width.or_else(|| given(own)).or_else(|| given(w.extrusion_width)).unwrap_or(auto);
        let section = match role {
            FlowRole::Support => scaled(settings.support.support_material_flow_ratio),
            FlowRole::SupportInterface => scaled(settings.support.support_material_interface_flow_ratio),
            _ => Section::Rounded,
        };
        Self { width, height, section }
    }

    /// The flow of a role where it bridges air: with `thick_bridges` a round thread whose section is the
    /// nozzle's times `bridge_flow_ratio`, else the role's own line with its volume times that ratio.
    pub fn bridging(role: FlowRole, height: f64, first: bool, settings: &Settings) -> Self {
        let ratio = settings.infill.bridge_flow_ratio;
        if settings.infill.thick_bridges {
            let diameter = settings.printer.nozzle_diameter * ratio.sqrt();
            return Self { width: diameter, height: diameter, section: Section::Round };
        }
        Self { section: Section::Scaled(ratio), ..Self::new(role, height, first, settings) }
    }

    /// Distance between the centre lines of neighbouring beads \[mm\].
    pub fn spacing(self) -> f64 {
        match self.section {
            Section::Round => self.width + THREAD_GAP,
            _ => self.width - self.height * ROUNDING,
        }
    }

    /// Cross-section \[mm²\], which is mm³ of plastic per mm of line.
    pub fn mm3_per_mm(self) -> f64 {
        match self.section {
            Section::Rounded => self.height * self.spacing(),
            Section::Scaled(ratio) => ratio * self.height * self.spacing(),
            Section::Round => PI / 4.0 * self.width * self.width,
        }
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

fn scaled(ratio: f64) -> Section {
    if ratio == 1.0 { Section::Rounded } else { Section::Scaled(ratio) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rounded_rectangle_is_the_textbooks() {
        let f = Flow { width: 0.45, height: 0.2, section: Section::Rounded };
        // A rectangle of (w - h) x h between two half discs of diameter h.
        let area = (0.45 - 0.2) * 0.2 + PI * 0.1 * 0.1;
        assert!((f.mm3_per_mm() - area).abs() < 1e-12);
        assert!((f.spacing() - 0.407_079_632_679_489_7).abs() < 1e-12);
    }

    #[test]
    fn bridges_are_threads_of_the_nozzles_bore() {
        let mut s = Settings::default();
        s.infill.bridge_flow_ratio = 0.81;
        let f = Flow::bridging(FlowRole::SolidInfill, 0.2, false, &s);
        assert!((f.width - 0.36).abs() < 1e-12 && (f.spacing() - 0.41).abs() < 1e-12);
        assert!((f.mm3_per_mm() - PI * 0.18 * 0.18).abs() < 1e-12);
        s.infill.thick_bridges = false;
        let (thin, own) = (
            Flow::bridging(FlowRole::SolidInfill, 0.2, false, &s),
            Flow::new(FlowRole::SolidInfill, 0.2, false, &s),
        );
        assert_eq!(thin.width, own.width);
        assert!((thin.mm3_per_mm() - 0.81 * own.mm3_per_mm()).abs() < 1e-12);
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
