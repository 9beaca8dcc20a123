//! Settings of supports and of what holds a print to the bed.

use super::types::FloatOrPercent::{self, Percent};
use super::types::Settings;

/// Supports.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportSettings {
    /// Make supports.
    pub support_material: bool,
    /// Find overhangs by their slope; without it only enforcers are supported.
    pub support_material_auto: bool,
    /// Slopes flatter than this are supported \[degrees from horizontal\]; 0 = what half a wall's width does
    /// not cover.
    pub support_material_threshold: f64,
    /// Everything over air on this many layers from the first is supported, whatever the other settings.
    pub support_material_enforce_layers: u32,
    /// Supports stand on the bed only, not on the part.
    pub support_material_buildplate_only: bool,
    /// Leave bridges without support.
    pub dont_support_bridges: bool,
    /// Shape of the columns.
    pub support_material_style: SupportStyle,
    /// Pattern of the columns.
    pub support_material_pattern: SupportPattern,
    /// Clear distance between the lines of the columns \[mm\].
    pub support_material_spacing: f64,
    /// Direction of the columns' lines \[degrees\], counter-clockwise from +x.
    pub support_material_angle: f64,
    /// A line around each column.
    pub support_material_with_sheath: bool,
    /// Gaps between columns up to twice this are closed, in style `snug` \[mm\].
    pub support_material_closing_radius: f64,
    /// Clear distance to the part beside it \[mm\], or % of an outer wall's width.
    pub support_material_xy_spacing: FloatOrPercent,
    /// Clear distance to the part above \[mm\]; 0 = supports of a soluble material touch it.
    pub support_material_contact_distance: f64,
    /// Clear distance to the part below \[mm\]; 0 = as above.
    pub support_material_bottom_contact_distance: f64,
    /// Layers of support are those of the part, instead of as few as fit.
    pub support_material_synchronize_layers: bool,
    /// Greatest thickness of a layer of support \[mm\]; 0 = `max_layer_height`.
    pub support_material_layer_height: f64,
    /// Dense layers under the part.
    pub support_material_interface_layers: u32,
    /// Dense layers on the part; -1 = as many as under it.
    pub support_material_bottom_interface_layers: i32,
    /// Pattern of the dense layers.
    pub support_material_interface_pattern: InterfacePattern,
    /// Clear distance between the lines of the dense layers \[mm\]; 0 = solid.
    pub support_material_interface_spacing: f64,
    /// Loops around the topmost dense layer.
    pub support_material_interface_contact_loops: bool,
    /// Factor on the flow of columns.
    pub support_material_flow_ratio: f64,
    /// Factor on the flow of the dense layers.
    pub support_material_interface_flow_ratio: f64,
    /// Greatest slope of a branch \[degrees from upright\].
    pub support_tree_angle: f64,
    /// Slope of a branch where nothing is in its way \[degrees from upright\].
    pub support_tree_angle_slow: f64,
    /// Diameter of the thinnest branches but for their tips \[mm\].
    pub support_tree_branch_diameter: f64,
    /// Branches grow thicker downwards: half the angle of their cone \[degrees\].
    pub support_tree_branch_diameter_angle: f64,
    /// Branches at least as thick as a circle of this diameter have two walls \[mm\]; 0 = one wall always.
    pub support_tree_branch_diameter_double_wall: f64,
    /// Distance between branches where they touch the part \[mm\].
    pub support_tree_branch_distance: f64,
    /// Diameter of a branch's tip \[mm\].
    pub support_tree_tip_diameter: f64,
    /// Share of a supported area that tips touch \[%\].
    pub support_tree_top_rate: f64,
}

impl Default for SupportSettings {
    fn default() -> Self {
        Self {
            support_material: false,
            support_material_auto: true,
            support_material_threshold: 0.0,
            support_material_enforce_layers: 0,
            support_material_buildplate_only: false,
            dont_support_bridges: true,
            support_material_style: SupportStyle::Grid,
            support_material_pattern: SupportPattern::Rectilinear,
            support_material_spacing: 2.5,
            support_material_angle: 0.0,
            support_material_with_sheath: true,
            support_material_closing_radius: 2.0,
            support_material_xy_spacing: Percent(50.0),
            support_material_contact_distance: 0.2,
            support_material_bottom_contact_distance: 0.0,
            support_material_synchronize_layers: false,
            support_material_layer_height: 0.0,
            support_material_interface_layers: 3,
            support_material_bottom_interface_layers: -1,
            support_material_interface_pattern: InterfacePattern::Rectilinear,
            support_material_interface_spacing: 0.0,
            support_material_interface_contact_loops: false,
            support_material_flow_ratio: 1.0,
            support_material_interface_flow_ratio: 1.0,
            support_tree_angle: 40.0,
            support_tree_angle_slow: 25.0,
            support_tree_branch_diameter: 2.0,
            support_tree_branch_diameter_angle: 5.0,
            support_tree_branch_diameter_double_wall: 3.0,
            support_tree_branch_distance: 1.0,
            support_tree_tip_diameter: 0.8,
            support_tree_top_rate: 15.0,
        }
    }
}

/// Shape of supports.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SupportStyle {
    /// Columns of whole cells of a grid, which are few, stable and easy to break off.
    #[default]
    Grid,
    /// Columns as large as what they hold.
    Snug,
    /// Branches that grow together on their way down.
    Organic,
}

/// Pattern of columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SupportPattern {
    /// Parallel lines, the same on all layers.
    #[default]
    Rectilinear,
    /// Parallel lines, turned by 90 degrees from layer to layer.
    RectilinearGrid,
    /// Hexagonal cells.
    Honeycomb,
}

/// Pattern of the dense layers between columns and part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InterfacePattern {
    /// As suits the distance: concentric where the support touches the part, else rectilinear.
    Auto,
    /// Parallel lines.
    #[default]
    Rectilinear,
    /// Loops, each inside the one before.
    Concentric,
}

/// Skirt, brim and raft.
#[derive(Clone, Debug, PartialEq)]
pub struct AdhesionSettings {
    /// Loops around the print; 0 = none.
    pub skirts: u32,
    /// Distance between skirt and print \[mm\].
    pub skirt_distance: f64,
    /// Layers the skirt stands high.
    pub skirt_height: u32,
    /// Least filament extruded in the first layer's skirt \[mm\]; 0 = no minimum.
    pub min_skirt_length: f64,
    /// The skirt stands as high as the print and keeps draughts off.
    pub draft_shield: DraftShield,
    /// Width of the brim \[mm\]; 0 = none.
    pub brim_width: f64,
    /// Where the brim lies.
    pub brim_type: BrimType,
    /// Distance between brim and part \[mm\].
    pub brim_separation: f64,
    /// The brim is a disc at each sharp corner only.
    pub brim_ears: bool,
    /// Corners up to this angle get an ear \[degrees\].
    pub brim_ears_max_angle: f64,
    /// Layers of raft under the part; 0 = none.
    pub raft_layers: u32,
    /// Clear distance between raft and part \[mm\].
    pub raft_contact_distance: f64,
    /// How far the raft reaches beyond the part \[mm\].
    pub raft_expansion: f64,
    /// Density of the first layer of raft and supports \[%\].
    pub raft_first_layer_density: f64,
    /// How much wider the first layer of raft and supports is \[mm\].
    pub raft_first_layer_expansion: f64,
    /// Distance between the boxes around copies of a part \[mm\].
    pub duplicate_distance: f64,
}

impl Default for AdhesionSettings {
    fn default() -> Self {
        Self {
            skirts: 1,
            skirt_distance: 6.0,
            skirt_height: 1,
            min_skirt_length: 0.0,
            draft_shield: DraftShield::Disabled,
            brim_width: 0.0,
            brim_type: BrimType::OuterOnly,
            brim_separation: 0.0,
            brim_ears: false,
            brim_ears_max_angle: 125.0,
            raft_layers: 0,
            raft_contact_distance: 0.1,
            raft_expansion: 1.5,
            raft_first_layer_density: 90.0,
            raft_first_layer_expansion: 3.0,
            duplicate_distance: 6.0,
        }
    }
}

/// How high the skirt stands.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum DraftShield {
    /// `skirt_height` layers.
    #[default]
    Disabled,
    /// As many, whatever the print's height.
    Limited,
    /// As high as the print.
    Enabled,
}

/// Where the brim lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BrimType {
    /// Nowhere.
    NoBrim,
    /// Around the part.
    #[default]
    OuterOnly,
    /// In its holes.
    InnerOnly,
    /// Both.
    OuterAndInner,
}

/// Layers of a raft above its first are this thick, in bores of the nozzle (PrusaSlicer's).
const RAFT_LAYER: f64 = 0.75;

impl Settings {
    /// Whether anything is printed with the lines of supports: supports or a raft.
    pub fn has_supports(&self) -> bool {
        let s = &self.support;
        s.support_material || s.support_material_enforce_layers > 0 || self.adhesion.raft_layers > 0
    }

    /// Whether the part lies on its supports without a gap, so that nothing hangs: they are of a material that
    /// can be washed out. PrusaSlicer then prints no bridges and no overhanging walls, and neither do we.
    pub fn has_soluble_supports(&self) -> bool {
        self.support.support_material && self.support.support_material_contact_distance <= 0.0
    }

    /// Thickness of a raft's layers above its first \[mm\]: three quarters of the nozzle's bore, but not less
    /// than `layer_height` nor more than `support_material_layer_height`.
    pub fn raft_layer_height(&self) -> f64 {
        let thick = self.slicing.layer_height.max(RAFT_LAYER * self.printer.nozzle_diameter);
        match self.support.support_material_layer_height {
            most if most > 0.0 => thick.min(most),
            _ => thick,
        }
    }
}
