//! Settings and flows → what the support stage needs, in nanometres.

use super::raft;
use crate::lattice::{mm, nm};
use crate::settings::flow::{Flow, FlowRole};
use crate::settings::{InterfacePattern, Settings, SupportPattern, SupportStyle};
use crate::span::RowFrame;

/// Rows of areas lie about as far apart \[mm\]: finer than what hangs from one layer to the next.
const ROW: f64 = 0.1;

/// How to support.
#[derive(Clone, Debug, PartialEq)]
pub struct SupportPlan {
    /// The rows of all areas; they run as the columns' lines do, and a cell of the grid is `cell_rows` high.
    pub frame: RowFrame,
    /// Side of a cell of the grid \[nm\]: the distance of the columns' lines.
    pub cell: f64,
    /// Number of rows in a cell.
    pub cell_rows: u32,
    /// Find overhangs by their slope; never where supports are off.
    pub auto: bool,
    /// Slopes flatter than this are supported \[degrees from horizontal\]; `None` = what `half_wall` does not cover.
    pub threshold: Option<f64>,
    /// Half the width of an outer wall \[nm\].
    pub half_wall: f64,
    /// Everything over air on as many layers is supported.
    pub enforce_layers: u32,
    /// Supports stand on the bed only.
    pub on_bed_only: bool,
    /// Leave bridges alone.
    pub spare_bridges: bool,
    /// Shape.
    pub style: SupportStyle,
    /// Pattern of the columns.
    pub pattern: SupportPattern,
    /// Direction of the columns' lines \[degrees\].
    pub angle: f64,
    /// A line around each column.
    pub sheath: bool,
    /// Gaps up to twice this are closed, in style snug \[nm\].
    pub closing: f64,
    /// Clear distance to the part beside \[nm\].
    pub xy_gap: f64,
    /// Clear distance to the part above \[nm\].
    pub top_gap: i32,
    /// Clear distance to the part below \[nm\].
    pub bottom_gap: i32,
    /// How far the threads of bridges hang below the underside of their layer \[nm\].
    pub thread_drop: i32,
    /// Layers are the part's.
    pub synchronized: bool,
    /// Thickness of support layers, least and greatest \[nm\].
    pub heights: [i32; 2],
    /// Thickness of the first layer \[nm\].
    pub first_height: i32,
    /// Dense layers under the part.
    pub top_interface: u32,
    /// Dense layers on the part.
    pub bottom_interface: u32,
    /// Pattern of the dense layers.
    pub interface_pattern: InterfacePattern,
    /// Distance between the lines of dense layers, from middle to middle \[nm\].
    pub interface_pitch: f64,
    /// Loops around the topmost dense layer.
    pub contact_loops: bool,
    /// Width of a column's line \[nm\].
    pub width: f64,
    /// Distance of lines that touch, at `layer_height` \[nm\].
    pub spacing: f64,
    /// The same on the first layer \[nm\].
    pub first_spacing: f64,
    /// Share of the first layer that is filled, 0..=1.
    pub first_density: f64,
    /// How much wider the first layer is \[nm\].
    pub first_expansion: f64,
    /// How much the part's first layer has been shrunk \[nm\].
    pub first_shrink: f64,
    /// Height of the raft's upper side, 0 without one \[nm\]: what supports stand on.
    pub base_z: i32,
    /// Branches.
    pub tree: TreePlan,
}

/// How branches grow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreePlan {
    /// Greatest slope \[degrees from upright\].
    pub angle: f64,
    /// Slope where nothing is in the way \[degrees from upright\].
    pub angle_slow: f64,
    /// Radius behind the tip \[nm\].
    pub radius: f64,
    /// Growth of the radius by height \[nm per nm\].
    pub taper: f64,
    /// Branches at least as thick as a circle of this diameter have two walls \[mm\]; 0 = never.
    pub double_wall: f64,
    /// Distance of tips \[nm\].
    pub distance: f64,
    /// Radius of a tip \[nm\].
    pub tip_radius: f64,
    /// Share of an area that tips touch, 0..=1.
    pub top_rate: f64,
}

impl SupportPlan {
    /// The plan of a filament job.
    pub fn new(settings: &Settings) -> Self {
        let (s, a) = (&settings.support, &settings.adhesion);
        let layer = settings.slicing.layer_height;
        let first = settings.slicing.first_layer_height.of(layer);
        let flow = Flow::new(FlowRole::Support, layer, false, settings);
        let dense = Flow::new(FlowRole::SupportInterface, layer, false, settings);
        let wall = Flow::new(FlowRole::ExternalPerimeter, layer, false, settings).width;
        let cell = nm(s.support_material_spacing + flow.spacing()).max(1000) as f64;
        let cell_rows = (mm(cell as i64) / ROW).round().clamp(1.0, 1000.0);
        let frame = RowFrame::new(s.support_material_angle, 0.0, cell / cell_rows);
        let [least, most] = settings.adaptive_heights();
        let most = if s.support_material_layer_height > 0.0 { s.support_material_layer_height } else { most };
        let height = |mm: f64| nm(mm).clamp(1, 1 << 30) as i32;
        let gap = |mm: f64| nm(mm).clamp(0, 1 << 30) as i32;
        let top_gap = gap(s.support_material_contact_distance);
        let bottom_gap = match gap(s.support_material_bottom_contact_distance) {
            0 => top_gap,
            own => own,
        };
        let top_interface = s.support_material_interface_layers;
        Self {
            frame,
            cell,
            cell_rows: cell_rows as u32,
            auto: s.support_material && s.support_material_auto,
            threshold: Some(s.support_material_threshold).filter(|t| *t > 0.0),
            half_wall: 0.5 * nm(wall) as f64,
            enforce_layers: s.support_material_enforce_layers,
            on_bed_only: s.support_material_buildplate_only,
            spare_bridges: s.dont_support_bridges,
            style: s.support_material_style,
            pattern: s.support_material_pattern,
            angle: s.support_material_angle,
            sheath: s.support_material_with_sheath,
            closing: nm(s.support_material_closing_radius) as f64,
            xy_gap: nm(s.support_material_xy_spacing.of(wall)) as f64,
            top_gap,
            bottom_gap,
            thread_drop: gap(Flow::bridging(FlowRole::SolidInfill, layer, false, settings).height - layer),
            synchronized: s.support_material_synchronize_layers,
            heights: [height(least.min(layer)), height(most.min(settings.printer.nozzle_diameter))],
            first_height: height(first),
            top_interface,
            bottom_interface: u32::try_from(s.support_material_bottom_interface_layers)
                .unwrap_or(top_interface),
            interface_pattern: s.support_material_interface_pattern,
            interface_pitch: nm(s.support_material_interface_spacing + dense.spacing()) as f64,
            contact_loops: s.support_material_interface_contact_loops,
            width: flow.width_nm() as f64,
            spacing: flow.spacing_nm() as f64,
            first_spacing: Flow::new(FlowRole::Support, first, true, settings).spacing_nm() as f64,
            first_density: (a.raft_first_layer_density / 100.0).clamp(0.0, 1.0),
            first_expansion: nm(a.raft_first_layer_expansion) as f64,
            first_shrink: match a.raft_layers {
                0 => settings.slicing.elefant_foot_compensation.nm(0) as f64,
                _ => 0.0,
            },
            base_z: raft::Heights::new(settings).top(),
            tree: TreePlan {
                angle: s.support_tree_angle,
                angle_slow: s.support_tree_angle_slow.min(s.support_tree_angle),
                radius: 0.5 * nm(s.support_tree_branch_diameter) as f64,
                taper: libm::tan(s.support_tree_branch_diameter_angle.to_radians()),
                double_wall: s.support_tree_branch_diameter_double_wall,
                distance: nm(s.support_tree_branch_distance) as f64,
                tip_radius: 0.5 * nm(s.support_tree_tip_diameter.min(s.support_tree_branch_diameter)) as f64,
                top_rate: s.support_tree_top_rate / 100.0,
            },
        }
    }
}
