//! Settings of what a part is made of: walls, skins, bridges, infill.

use super::types::FloatOrPercent::{self, Float, Percent};

/// Walls.
#[derive(Clone, Debug, PartialEq)]
pub struct PerimeterSettings {
    /// Number of walls.
    pub perimeters: u32,
    /// Print the outermost wall before the inner ones.
    pub external_perimeters_first: bool,
    /// Where loops start.
    pub seam_position: SeamPosition,
    /// Add walls where a slope would else show infill.
    pub extra_perimeters: bool,
    /// Print walls too thin for a loop as one line of varying width.
    pub thin_walls: bool,
    /// Fill what walls leave between them with lines of varying width.
    pub gap_fill_enabled: bool,
    /// Print walls over air as bridges.
    pub overhangs: bool,
    /// Where only one wall surrounds a top surface.
    pub top_one_perimeter_type: OnePerimeter,
}

impl Default for PerimeterSettings {
    fn default() -> Self {
        Self {
            perimeters: 3,
            external_perimeters_first: false,
            seam_position: SeamPosition::Aligned,
            extra_perimeters: true,
            thin_walls: true,
            gap_fill_enabled: true,
            overhangs: true,
            top_one_perimeter_type: OnePerimeter::None,
        }
    }
}

/// Which top surfaces have one wall only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OnePerimeter {
    /// None.
    #[default]
    None,
    /// All of them.
    Top,
    /// Those of the topmost layer.
    Topmost,
}

/// Where loops start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SeamPosition {
    /// A pseudo-random vertex, derived from the loop's content.
    Random,
    /// The best corner near the nozzle.
    Nearest,
    /// The best corner near the seam of the layer below.
    #[default]
    Aligned,
    /// The vertex furthest back (largest y).
    Rear,
}

/// Skins and infill.
#[derive(Clone, Debug, PartialEq)]
pub struct InfillSettings {
    /// Density of sparse infill \[%\], 0..=100.
    pub fill_density: f64,
    /// Pattern of sparse infill.
    pub fill_pattern: FillPattern,
    /// Pattern of top skins.
    pub top_fill_pattern: FillPattern,
    /// Pattern of bottom skins.
    pub bottom_fill_pattern: FillPattern,
    /// Angle of the first family of lines \[degrees\], counter-clockwise from +x.
    pub fill_angle: f64,
    /// How far infill reaches into the innermost wall \[mm\], or % of the wall's width.
    pub infill_overlap: FloatOrPercent,
    /// Solid layers under every top surface.
    pub top_solid_layers: u32,
    /// Solid layers over every bottom surface.
    pub bottom_solid_layers: u32,
    /// Least thickness of the top shell \[mm\].
    pub top_solid_min_thickness: f64,
    /// Least thickness of the bottom shell \[mm\].
    pub bottom_solid_min_thickness: f64,
    /// Sparse areas smaller than this become solid \[mm²\].
    pub solid_infill_below_area: f64,
    /// Every N-th layer is solid; 0 = never.
    pub solid_infill_every_layers: u32,
    /// Print infill before the walls.
    pub infill_first: bool,
    /// Length of an infill line's end along the wall \[mm\], or % of the line's width; 0 = none.
    pub infill_anchor: FloatOrPercent,
    /// Longest link along a wall between two infill lines \[mm\], or % of the line's width; 0 = none.
    pub infill_anchor_max: FloatOrPercent,
    /// Sparse infill is printed every N-th layer, N layers thick where the nozzle allows.
    pub infill_every_layers: u32,
    /// Add solid infill beside shallow slopes, so that the shell stays as thick as asked.
    pub ensure_vertical_shell_thickness: VerticalShell,
    /// How far top, bottom and bridge skins reach into the part beyond what is exposed \[mm\].
    pub external_infill_margin: f64,
    /// Direction of bridges \[degrees\]; 0 = the best one of each.
    pub bridge_angle: f64,
    /// Factor on the flow of bridges.
    pub bridge_flow_ratio: f64,
    /// Bridges are threads as thick as the nozzle's bore instead of lines of the layer's height.
    pub thick_bridges: bool,
}

/// How much is done to keep the shell's thickness on slopes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VerticalShell {
    /// Nothing.
    #[default]
    Disabled,
    /// Only under top and over bottom surfaces nearby.
    Partial,
    /// Everywhere.
    Enabled,
}

impl Default for InfillSettings {
    fn default() -> Self {
        Self {
            fill_density: 20.0,
            fill_pattern: FillPattern::Rectilinear,
            top_fill_pattern: FillPattern::Monotonic,
            bottom_fill_pattern: FillPattern::Monotonic,
            fill_angle: 45.0,
            infill_overlap: Percent(25.0),
            top_solid_layers: 3,
            bottom_solid_layers: 3,
            top_solid_min_thickness: 0.0,
            bottom_solid_min_thickness: 0.0,
            solid_infill_below_area: 70.0,
            solid_infill_every_layers: 0,
            infill_first: false,
            infill_anchor: Percent(600.0),
            infill_anchor_max: Float(50.0),
            infill_every_layers: 1,
            ensure_vertical_shell_thickness: VerticalShell::Disabled,
            external_infill_margin: 3.0,
            bridge_angle: 0.0,
            bridge_flow_ratio: 1.0,
            thick_bridges: true,
        }
    }
}

/// Infill patterns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FillPattern {
    /// Parallel lines, turned by 90 degrees from layer to layer.
    #[default]
    Rectilinear,
    /// Rectilinear, all lines of a region laid in one sweep direction.
    Monotonic,
    /// Monotonic without links between the lines.
    MonotonicLines,
    /// Rectilinear without the turn.
    AlignedRectilinear,
    /// Parallel lines without links, turned by 90 degrees from layer to layer.
    Line,
    /// Parallel lines, every one linked to the next along the wall.
    ZigZag,
    /// Two families of lines on every layer, crossing at right angles.
    Grid,
    /// Three families of lines on every layer, meeting in triangles.
    Triangles,
    /// Three families of lines on every layer, meeting in stars and hexagons.
    Stars,
    /// Cubes standing on a corner.
    Cubic,
    /// Hexagonal cells with double walls.
    Honeycomb,
}
