//! Settings and flows → what the infill stage needs, in nanometres.

use super::FillKind;
use super::bridge::{BridgePlan, across};
use crate::lattice::{mm, nm};
use crate::settings::flow::{Flow, FlowRole};
use crate::settings::{FillPattern, FloatOrPercent, Settings, VerticalShell};
use crate::span::RowFrame;

/// How to fill the layers of one object.
#[derive(Clone, Debug, PartialEq)]
pub struct FillPlan {
    /// Share of the volume filled by sparse infill, 0..=1.
    pub density: f64,
    /// Pattern of sparse infill.
    pub pattern: FillPattern,
    /// Direction of the lines on even layers \[degrees\]; odd layers are turned by 90.
    pub angle: f64,
    /// Per [`FillKind`]: the lines turn from layer to layer. Bridges have directions of their own.
    pub turned: [bool; FillKind::COUNT],
    /// Per [`FillKind`]: lines are linked to the next. The sparse ones' pattern says that instead.
    pub linked: [bool; FillKind::COUNT],
    /// Line spacing per [`FillKind`] on the first layer \[nm\], the sparse one at full density.
    pub first_spacing: [f64; FillKind::COUNT],
    /// The same on all other layers \[nm\].
    pub spacing: [f64; FillKind::COUNT],
    /// The same per layer \[nm\] where layers differ in thickness; empty where all but the first have one.
    /// Sparse lines keep theirs, so that they lie upon each other.
    pub layer_spacing: Vec<[f64; FillKind::COUNT]>,
    /// Spacing of sparse lines that are 2, 3, ... layers thick \[nm\], as far as the nozzle allows.
    pub thick_spacing: Vec<f64>,
    /// Length of a sparse line's end along the wall \[nm\]; 0 = none.
    pub anchor: f64,
    /// Longest link along a wall between two sparse lines \[nm\]; 0 = neither links nor anchors.
    pub anchor_max: f64,
    /// Solid layers under a top surface.
    pub top_layers: u32,
    /// Solid layers over a bottom surface.
    pub bottom_layers: u32,
    /// Least thickness of the top shell \[nm\].
    pub top_thickness: i64,
    /// Least thickness of the bottom shell \[nm\].
    pub bottom_thickness: i64,
    /// Sparse areas smaller than this become solid \[mm²\].
    pub solid_below_area: f64,
    /// Every N-th layer is solid; 0 = never.
    pub solid_every: u32,
    /// How to bridge; without it skins over air are laid like any others, as on supports.
    pub bridges: Option<BridgePlan>,
    /// What is done to keep the shell's thickness on slopes.
    pub vertical_shell: VerticalShell,
    /// Sparse areas that as many layers have in common are printed on the topmost of them; 1 = none.
    pub combine: u32,
    /// Thickest line \[nm\]: the nozzle's bore.
    pub thickest: i64,
    /// How far skins that are exposed to air reach into the part \[nm\].
    pub margin: f64,
}

impl FillPlan {
    /// The plan of a filament job.
    ///
    /// In solid infill `Monotonic` is laid like `Rectilinear`: all solid lines of a region are laid in one sweep
    /// whatever the pattern. The pattern of solid infill inside follows `bottom_fill_pattern`.
    pub fn new(settings: &Settings) -> Self {
        let i = &settings.infill;
        let spacing = |first: bool| {
            let layer = settings.slicing.layer_height;
            spacings(
                if first { settings.slicing.first_layer_height.of(layer) } else { layer },
                first,
                settings,
            )
        };
        let width = Flow::new(FlowRole::Infill, settings.slicing.layer_height, false, settings).width;
        let along = |length: FloatOrPercent| nm(length.of(width)) as f64;
        let turns = |p: FillPattern| p != FillPattern::AlignedRectilinear;
        let links = |p: FillPattern| p != FillPattern::MonotonicLines;
        let [sparse, solid, top] = [i.fill_pattern, i.bottom_fill_pattern, i.top_fill_pattern].map(turns);
        Self {
            density: (i.fill_density / 100.0).clamp(0.0, 1.0),
            pattern: i.fill_pattern,
            angle: i.fill_angle,
            turned: [sparse, solid, top, false, false],
            linked: [true, links(i.bottom_fill_pattern), links(i.top_fill_pattern), true, true],
            first_spacing: spacing(true),
            spacing: spacing(false),
            layer_spacing: Vec::new(),
            thick_spacing: thick_spacings(settings),
            anchor: along(i.infill_anchor),
            anchor_max: along(i.infill_anchor_max),
            top_layers: i.top_solid_layers,
            bottom_layers: i.bottom_solid_layers,
            top_thickness: nm(i.top_solid_min_thickness),
            bottom_thickness: nm(i.bottom_solid_min_thickness),
            solid_below_area: i.solid_infill_below_area,
            solid_every: i.solid_infill_every_layers,
            bridges: Some(BridgePlan::new(settings)),
            vertical_shell: i.ensure_vertical_shell_thickness,
            combine: i.infill_every_layers.max(1),
            thickest: nm(settings.printer.nozzle_diameter),
            margin: nm(i.external_infill_margin) as f64,
        }
    }

    /// The plan for layers of different `heights` \[nm\], lowest layer first: solid lines lie as close as
    /// beads of their own layer's thickness need, sparse ones as `layer_height` says.
    pub fn for_heights(settings: &Settings, heights: impl Iterator<Item = i32>) -> Self {
        let own = |(i, height): (usize, i32)| spacings(mm(height), i == 0, settings);
        Self { layer_spacing: heights.enumerate().map(own).collect(), ..Self::new(settings) }
    }

    /// True when a kind's lines are turned by 90 degrees on layer `i`.
    fn is_turned(&self, kind: FillKind, i: usize) -> bool {
        i % 2 == 1 && self.turned[kind as usize]
    }

    /// The rows on which areas are compared: the solid lines' own, the same on all layers.
    pub fn area_frame(&self) -> RowFrame {
        RowFrame::new(self.angle, 0.0, self.spacing[FillKind::Solid as usize])
    }

    /// The rows on which the lines of a kind lie on layer `i`.
    pub(super) fn line_frame(&self, kind: FillKind, i: usize) -> RowFrame {
        RowFrame::new(self.degrees(kind, i), 0.0, self.pitch(kind, i))
    }

    /// Direction of the lines of a kind on layer `i` \[degrees\].
    pub(super) fn degrees(&self, kind: FillKind, i: usize) -> f64 {
        self.angle + if self.is_turned(kind, i) { 90.0 } else { 0.0 }
    }

    /// The direction \[degrees\] that crosses the sparse lines of layer `i` best.
    pub(super) fn across_sparse(&self, i: usize) -> f64 {
        let i = i / self.combine.max(1) as usize;
        let own = self.degrees(FillKind::Sparse, i);
        match self.pattern {
            FillPattern::Grid => across(&[0.0, 90.0].map(|d| self.angle + d), own),
            FillPattern::Triangles | FillPattern::Stars | FillPattern::Cubic => {
                across(&[0.0, 60.0, 120.0].map(|d| self.angle + d), own + 90.0)
            }
            // Across the strands.
            FillPattern::Honeycomb => across(&[self.angle + 60.0 * (i % 3) as f64], own + 90.0),
            _ => across(&[own], own + 90.0),
        }
    }

    /// The rows on which the lines of a bridge lie on layer `i`.
    pub(super) fn bridge_frame(&self, degrees: f64, kind: FillKind, i: usize) -> RowFrame {
        RowFrame::new(degrees, 0.0, self.pitch(kind, i))
    }

    /// Distance between sparse lines at full density on layer `i` \[nm\] where they are `layers` thick.
    pub(super) fn sparse_spacing(&self, i: usize, layers: u32) -> f64 {
        let thick = layers.checked_sub(2).and_then(|n| self.thick_spacing.get(n as usize)).copied();
        let own = if i == 0 { self.first_spacing } else { self.spacing }[FillKind::Sparse as usize];
        thick.filter(|s| *s > 0.0).unwrap_or(own)
    }

    /// Distance between the lines of a kind on layer `i` \[nm\].
    pub(super) fn pitch(&self, kind: FillKind, i: usize) -> f64 {
        let spacing = if i == 0 { self.first_spacing } else { self.spacing }[kind as usize];
        match kind {
            FillKind::Sparse => spacing / self.density,
            _ => self.layer_spacing.get(i).map_or(spacing, |own| own[kind as usize]),
        }
    }
}

/// Spacing of sparse lines that are 2, 3, ... layers thick \[nm\]: a thicker line of one width is rounder,
/// so that lines of full density lie closer.
fn thick_spacings(settings: &Settings) -> Vec<f64> {
    let layer = settings.slicing.layer_height;
    let most = (settings.printer.nozzle_diameter / layer + 1e-6).min(1000.0) as u32;
    (2..=most.min(settings.infill.infill_every_layers))
        .map(|n| Flow::new(FlowRole::Infill, f64::from(n) * layer, false, settings).spacing_nm() as f64)
        .collect()
}

/// Line spacing per kind on a layer of `height` \[mm\], in nanometres.
fn spacings(height: f64, first: bool, settings: &Settings) -> [f64; FillKind::COUNT] {
    let [sparse, solid, top] = [FlowRole::Infill, FlowRole::SolidInfill, FlowRole::TopSolidInfill]
        .map(|role| Flow::new(role, height, first, settings).spacing_nm() as f64);
    let bridge = Flow::bridging(FlowRole::SolidInfill, height, first, settings).spacing_nm() as f64;
    [sparse, solid, top, bridge, bridge]
}
