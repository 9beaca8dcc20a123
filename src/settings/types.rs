//! The settings themselves: one struct per stage, in PrusaSlicer's units and with its defaults.

/// A value given in its unit or as a percentage of something else (`0.45` or `50%`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FloatOrPercent {
    /// An absolute value in the setting's own unit.
    Float(f64),
    /// A percentage of the setting's base; 50 means 50 %.
    Percent(f64),
}

impl FloatOrPercent {
    /// The absolute value for a given base.
    pub fn of(self, base: f64) -> f64 {
        match self {
            Self::Float(v) => v,
            Self::Percent(p) => base * p / 100.0,
        }
    }
}

use super::types_part::{InfillSettings, PerimeterSettings};
use super::types_resin::{
    DisplaySettings, ExposureSettings, ImageSettings, LengthOrPixels, LiftSettings, MachineSettings,
    MaterialSettings,
};
use super::types_support::{AdhesionSettings, SupportSettings};
use FloatOrPercent::{Float, Percent};

/// Everything a job needs to know, one part per stage. A filament job reads those down to `output`, a
/// resin job `slicing.layer_height`, a few of `printer` and those behind `output`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Settings {
    /// Planes and contours.
    pub slicing: SlicingSettings,
    /// Line widths.
    pub widths: WidthSettings,
    /// Walls.
    pub perimeters: PerimeterSettings,
    /// Skins and infill.
    pub infill: InfillSettings,
    /// Supports.
    pub support: SupportSettings,
    /// Skirt, brim and raft.
    pub adhesion: AdhesionSettings,
    /// Feed rates.
    pub speed: SpeedSettings,
    /// Retraction and travel.
    pub retraction: RetractionSettings,
    /// Fan and slow-down.
    pub cooling: CoolingSettings,
    /// The filament loaded.
    pub filament: FilamentSettings,
    /// The machine.
    pub printer: PrinterSettings,
    /// G-code text.
    pub output: OutputSettings,
    /// How long and how brightly layers are lit.
    pub exposure: ExposureSettings,
    /// How the plate parts a layer from the film.
    pub lift: LiftSettings,
    /// How sections become pixels.
    pub image: ImageSettings,
    /// The panel.
    pub display: DisplaySettings,
    /// The resin.
    pub material: MaterialSettings,
    /// The resin printer's name and its files.
    pub machine: MachineSettings,
}

/// Planes and contours.
#[derive(Clone, Debug, PartialEq)]
pub struct SlicingSettings {
    /// Layer thickness \[mm\].
    pub layer_height: f64,
    /// Thickness of the first layer \[mm\], or % of `layer_height`.
    pub first_layer_height: FloatOrPercent,
    /// Layers as thick as the surface's slope allows instead of `layer_height`.
    pub adaptive_layer_height: bool,
    /// Greatest step that an adaptive layer may leave on a slope, measured across the surface \[mm\].
    pub adaptive_cusp_height: f64,
    /// Least thickness of an adaptive layer \[mm\]; 0 = 0.01 mm.
    pub min_layer_height: f64,
    /// Greatest thickness of an adaptive layer \[mm\]; 0 = 75 % of the nozzle's bore.
    pub max_layer_height: f64,
    /// Tolerance of contour simplification \[mm\]; 0 keeps every point.
    pub resolution: f64,
    /// Gaps in a contour up to twice this are closed \[mm\].
    pub slice_closing_radius: f64,
    /// Grows (+) or shrinks (-) every layer's outline in XY \[mm\].
    pub xy_size_compensation: f64,
    /// Shrinks the first layer's outline in XY, which the bed squashes or the light bleeds outwards \[mm\];
    /// pixels on resin printers only.
    pub elefant_foot_compensation: LengthOrPixels,
}

impl Default for SlicingSettings {
    fn default() -> Self {
        Self {
            layer_height: 0.3,
            first_layer_height: Float(0.35),
            adaptive_layer_height: false,
            adaptive_cusp_height: 0.1,
            min_layer_height: 0.07,
            max_layer_height: 0.0,
            resolution: 0.0,
            slice_closing_radius: 0.049,
            xy_size_compensation: 0.0,
            elefant_foot_compensation: LengthOrPixels::Length(0.0),
        }
    }
}

/// Line widths \[mm\], or % of the layer height; 0 means automatic.
#[derive(Clone, Debug, PartialEq)]
pub struct WidthSettings {
    /// Default for the widths below that are 0.
    pub extrusion_width: FloatOrPercent,
    /// All lines of the first layer; 0 leaves the widths below in force.
    pub first_layer_extrusion_width: FloatOrPercent,
    /// Inner walls.
    pub perimeter_extrusion_width: FloatOrPercent,
    /// Outermost wall.
    pub external_perimeter_extrusion_width: FloatOrPercent,
    /// Sparse infill.
    pub infill_extrusion_width: FloatOrPercent,
    /// Solid infill.
    pub solid_infill_extrusion_width: FloatOrPercent,
    /// Topmost solid infill.
    pub top_infill_extrusion_width: FloatOrPercent,
    /// Supports, skirt-like loops excepted.
    pub support_material_extrusion_width: FloatOrPercent,
}

impl Default for WidthSettings {
    fn default() -> Self {
        let auto = Float(0.0);
        Self {
            extrusion_width: auto,
            first_layer_extrusion_width: Percent(200.0),
            perimeter_extrusion_width: auto,
            external_perimeter_extrusion_width: auto,
            infill_extrusion_width: auto,
            solid_infill_extrusion_width: auto,
            top_infill_extrusion_width: auto,
            support_material_extrusion_width: auto,
        }
    }
}

/// Feed rates \[mm/s\].
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedSettings {
    /// Inner walls.
    pub perimeter_speed: f64,
    /// Outermost wall; % of `perimeter_speed`.
    pub external_perimeter_speed: FloatOrPercent,
    /// Walls of radius up to 6.5 mm; % of `perimeter_speed`.
    pub small_perimeter_speed: FloatOrPercent,
    /// Sparse infill.
    pub infill_speed: f64,
    /// Solid infill; % of `infill_speed`.
    pub solid_infill_speed: FloatOrPercent,
    /// Topmost solid infill; % of `solid_infill_speed`.
    pub top_solid_infill_speed: FloatOrPercent,
    /// First layer: an absolute speed, or % of each line's own.
    pub first_layer_speed: FloatOrPercent,
    /// Bridges and walls over air.
    pub bridge_speed: f64,
    /// Gap fill.
    pub gap_fill_speed: f64,
    /// Support.
    pub support_material_speed: f64,
    /// Dense layers of support; % of `support_material_speed`.
    pub support_material_interface_speed: FloatOrPercent,
    /// The part's first layer on a raft: an absolute speed, or % of each line's own.
    pub first_layer_speed_over_raft: FloatOrPercent,
    /// Moves without extrusion.
    pub travel_speed: f64,
    /// Vertical moves; 0 = `travel_speed`.
    pub travel_speed_z: f64,
    /// Limit of volumetric flow \[mm³/s\]; 0 = none.
    pub max_volumetric_speed: f64,
}

impl Default for SpeedSettings {
    fn default() -> Self {
        Self {
            perimeter_speed: 60.0,
            external_perimeter_speed: Percent(50.0),
            small_perimeter_speed: Float(15.0),
            infill_speed: 80.0,
            solid_infill_speed: Float(20.0),
            top_solid_infill_speed: Float(15.0),
            first_layer_speed: Float(30.0),
            bridge_speed: 60.0,
            gap_fill_speed: 20.0,
            support_material_speed: 60.0,
            support_material_interface_speed: Percent(100.0),
            first_layer_speed_over_raft: Float(30.0),
            travel_speed: 130.0,
            travel_speed_z: 0.0,
            max_volumetric_speed: 0.0,
        }
    }
}

/// Retraction and travel.
#[derive(Clone, Debug, PartialEq)]
pub struct RetractionSettings {
    /// Filament pulled back \[mm\]; 0 = never retract.
    pub retract_length: f64,
    /// Speed of the pull \[mm/s\].
    pub retract_speed: f64,
    /// Speed of the push \[mm/s\]; 0 = `retract_speed`.
    pub deretract_speed: f64,
    /// Extra filament pushed after a retraction \[mm\].
    pub retract_restart_extra: f64,
    /// Travels shorter than this do not retract \[mm\].
    pub retract_before_travel: f64,
    /// Nozzle lift during retracted travel \[mm\].
    pub retract_lift: f64,
    /// Retract at every layer change.
    pub retract_layer_change: bool,
}

impl Default for RetractionSettings {
    fn default() -> Self {
        Self {
            retract_length: 2.0,
            retract_speed: 40.0,
            deretract_speed: 0.0,
            retract_restart_extra: 0.0,
            retract_before_travel: 2.0,
            retract_lift: 0.0,
            retract_layer_change: false,
        }
    }
}

/// Fan and slow-down.
#[derive(Clone, Debug, PartialEq)]
pub struct CoolingSettings {
    /// Slow short layers down and drive the fan by layer time.
    pub cooling: bool,
    /// Keep the fan at `min_fan_speed` at least.
    pub fan_always_on: bool,
    /// Least fan speed \[%\].
    pub min_fan_speed: f64,
    /// Fan speed of the shortest layers \[%\].
    pub max_fan_speed: f64,
    /// Fan speed of bridges and walls over air \[%\].
    pub bridge_fan_speed: f64,
    /// The fan stays off for this many layers.
    pub disable_fan_first_layers: u32,
    /// The fan ramps up to full speed at this layer; 0 = no ramp.
    pub full_fan_speed_layer: u32,
    /// Layers shorter than this turn the fan on \[s\].
    pub fan_below_layer_time: f64,
    /// Layers shorter than this are slowed down \[s\].
    pub slowdown_below_layer_time: f64,
    /// The slow-down stops at this speed \[mm/s\].
    pub min_print_speed: f64,
}

impl Default for CoolingSettings {
    fn default() -> Self {
        Self {
            cooling: true,
            fan_always_on: false,
            min_fan_speed: 35.0,
            max_fan_speed: 100.0,
            bridge_fan_speed: 100.0,
            disable_fan_first_layers: 3,
            full_fan_speed_layer: 0,
            fan_below_layer_time: 60.0,
            slowdown_below_layer_time: 5.0,
            min_print_speed: 10.0,
        }
    }
}

/// The filament loaded.
#[derive(Clone, Debug, PartialEq)]
pub struct FilamentSettings {
    /// Diameter \[mm\].
    pub filament_diameter: f64,
    /// Density \[g/cm³\]; 0 = unknown.
    pub filament_density: f64,
    /// Price \[money/kg\]; 0 = unknown.
    pub filament_cost: f64,
    /// Material name, e.g. `PLA`.
    pub filament_type: String,
    /// Factor on all flow.
    pub extrusion_multiplier: f64,
    /// Limit of volumetric flow \[mm³/s\]; 0 = none.
    pub filament_max_volumetric_speed: f64,
    /// Nozzle temperature \[°C\]; 0 leaves it alone.
    pub temperature: u32,
    /// Nozzle temperature of the first layer \[°C\].
    pub first_layer_temperature: u32,
    /// Bed temperature \[°C\]; 0 leaves it alone.
    pub bed_temperature: u32,
    /// Bed temperature of the first layer \[°C\].
    pub first_layer_bed_temperature: u32,
}

impl Default for FilamentSettings {
    fn default() -> Self {
        Self {
            filament_diameter: 1.75,
            filament_density: 0.0,
            filament_cost: 0.0,
            filament_type: "PLA".to_owned(),
            extrusion_multiplier: 1.0,
            filament_max_volumetric_speed: 0.0,
            temperature: 200,
            first_layer_temperature: 200,
            bed_temperature: 0,
            first_layer_bed_temperature: 0,
        }
    }
}

/// The machine.
#[derive(Clone, Debug, PartialEq)]
pub struct PrinterSettings {
    /// How the machine builds, and which settings count.
    pub printer_technology: PrinterTechnology,
    /// Outline of the bed \[mm\].
    pub bed_shape: Vec<[f64; 2]>,
    /// Height of the build volume \[mm\]; 0 = unlimited.
    pub max_print_height: f64,
    /// Nozzle bore \[mm\].
    pub nozzle_diameter: f64,
    /// Dialect of the firmware.
    pub gcode_flavor: GcodeFlavor,
    /// Added to every Z \[mm\].
    pub z_offset: f64,
    /// E counts per move (M83) instead of from the start (M82).
    pub use_relative_e_distances: bool,
    /// Retract by G10 / G11.
    pub use_firmware_retraction: bool,
}

impl Default for PrinterSettings {
    fn default() -> Self {
        Self {
            printer_technology: PrinterTechnology::Fff,
            bed_shape: vec![[0.0, 0.0], [200.0, 0.0], [200.0, 200.0], [0.0, 200.0]],
            max_print_height: 200.0,
            nozzle_diameter: 0.4,
            gcode_flavor: GcodeFlavor::Reprap,
            z_offset: 0.0,
            use_relative_e_distances: false,
            use_firmware_retraction: false,
        }
    }
}

/// How a machine builds a part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PrinterTechnology {
    /// Fused filament fabrication: molten plastic, layer by layer.
    #[default]
    Fff,
    /// Stereolithography by a masked panel: resin hardened layer by layer.
    Sla,
}

impl PrinterTechnology {
    /// PrusaSlicer's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fff => "FFF",
            Self::Sla => "SLA",
        }
    }

    /// The other one.
    pub const fn other(self) -> Self {
        match self {
            Self::Fff => Self::Sla,
            Self::Sla => Self::Fff,
        }
    }
}

/// Dialect of the firmware.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GcodeFlavor {
    /// RepRap / Sprinter.
    #[default]
    Reprap,
    /// RepRapFirmware.
    Reprapfirmware,
    /// Marlin 1.
    Marlin,
    /// Marlin 2.
    Marlin2,
    /// Klipper.
    Klipper,
}

/// G-code text.
#[derive(Clone, Debug, PartialEq)]
pub struct OutputSettings {
    /// Template written before the print.
    pub start_gcode: String,
    /// Template written after the print.
    pub end_gcode: String,
    /// Template written before each layer's Z move.
    pub before_layer_gcode: String,
    /// Template written after each layer's Z move.
    pub layer_gcode: String,
    /// Say what each line does.
    pub gcode_comments: bool,
    /// Tolerance of path simplification \[mm\].
    pub gcode_resolution: f64,
}

impl Default for OutputSettings {
    fn default() -> Self {
        Self {
            start_gcode: "G28 ; home all axes\nG1 Z5 F5000 ; lift nozzle\n".to_owned(),
            end_gcode: "M104 S0 ; turn off temperature\nG28 X0  ; home X axis\nM84     ; disable motors\n"
                .to_owned(),
            before_layer_gcode: String::new(),
            layer_gcode: String::new(),
            gcode_comments: false,
            gcode_resolution: 0.0125,
        }
    }
}
