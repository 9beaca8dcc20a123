//! The registry: one row per setting, and everything else follows from it.

use super::assign::quote;
use super::keys_resin::RESIN_KEYS;
use super::kind::Kind::{
    self, Choice, Count, Flag, Integer, LengthOrPixels, Number, NumberOrPercent, Percent, Points, Text,
};
use super::kind::Stage;
use super::kind::Technology;
use super::types::{PrinterTechnology, Settings};
use super::value::{Problem, unescape};

/// One setting: its name and syntax, and the way to its field.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// PrusaSlicer's name, e.g. `layer_height`. No other setting has it, of whatever technology.
    pub name: &'static str,
    /// The jobs that have it.
    pub technology: Technology,
    /// The stage it belongs to.
    pub stage: Stage,
    /// Unit of a bare number; empty where there is none.
    pub unit: &'static str,
    /// Syntax and range.
    pub kind: Kind,
    /// PrusaSlicer keeps a value for each extruder (`0.4,0.4`); the first is used here.
    pub per_extruder: bool,
    /// What it does, in one line.
    pub help: &'static str,
    pub(super) read: fn(&mut Settings, &str) -> Result<(), Problem>,
    pub(super) write: fn(&Settings) -> String,
}

impl Key {
    /// The value of this key in `settings`, in PrusaSlicer's syntax.
    pub fn get(&self, settings: &Settings) -> String {
        let text = (self.write)(settings);
        match self.kind {
            // What was written can be read, so the fallback is never taken.
            Text if self.per_extruder => quote(&unescape(&text).unwrap_or(text)),
            _ => text,
        }
    }

    /// The default value for a technology, in PrusaSlicer's syntax.
    pub fn default_text(&self, technology: PrinterTechnology) -> String {
        self.get(&Settings::of(technology))
    }
}

/// The key of that name, of whatever technology.
pub fn find(name: &str) -> Option<&'static Key> {
    KEYS.iter().chain(RESIN_KEYS).find(|k| k.name == name)
}

/// The keys of a technology, in the order of the registry.
pub fn of(technology: PrinterTechnology) -> impl Iterator<Item = &'static Key> {
    KEYS.iter().chain(RESIN_KEYS).filter(move |k| k.technology.fits(technology))
}

/// The keys of a stage.
pub fn of_stage(technology: PrinterTechnology, stage: Stage) -> impl Iterator<Item = &'static Key> {
    of(technology).filter(move |k| k.stage == stage)
}

/// Rows `Stage stage.field: [@mark] Kind, "unit", "help";` - the field's name is the key's; `@each` marks a
/// value per extruder, `@both` a setting of all technologies.
macro_rules! registry {
    (
        $(#[$doc:meta])* $table:ident of $technology:ident:
        $($stage:ident $part:ident.$field:ident: $(@ $mark:ident)? $kind:expr, $unit:literal, $help:literal;)*
    ) => {
        $(#[$doc])*
        pub static $table: &[$crate::settings::keys::Key] = &[$($crate::settings::keys::Key {
            name: stringify!($field),
            technology: $crate::settings::keys::registry!(of $technology $($mark)?),
            stage: $crate::settings::kind::Stage::$stage,
            unit: $unit,
            kind: $kind,
            per_extruder: $crate::settings::keys::registry!(is_each $($mark)?),
            help: $help,
            read: |settings, text| {
                settings.$part.$field = $crate::settings::value::Value::read(text, &$kind)?;
                Ok(())
            },
            write: |settings| $crate::settings::value::Value::write(&settings.$part.$field, &$kind),
        },)*];
    };
    (is_each each) => { true };
    (is_each $($mark:ident)?) => { false };
    (of $technology:ident both) => { $crate::settings::kind::Technology::Both };
    (of $technology:ident $($mark:ident)?) => { $crate::settings::kind::Technology::$technology };
}
pub(super) use registry;

/// A line width: a length, or a percentage of the layer height; 0 means automatic.
const WIDTH: Kind = NumberOrPercent(0.0, 20.0, 2000.0);
/// A speed; 0 (automatic in PrusaSlicer) is refused by the cross-checks with a better message than a range.
const SPEED: Kind = Number(0.0, 10_000.0);
/// A speed or a percentage of another one.
const SPEED_OF: Kind = NumberOrPercent(0.0, 10_000.0, 1000.0);
const SKIN_PATTERNS: Kind = Choice(
    &["rectilinear", "monotonic", "monotoniclines", "alignedrectilinear"],
    &["concentric", "hilbertcurve", "archimedeanchords", "octagramspiral"],
);
const SPARSE_PATTERNS: Kind = Choice(
    &[
        "rectilinear",
        "alignedrectilinear",
        "monotonic",
        "line",
        "zigzag",
        "grid",
        "triangles",
        "stars",
        "cubic",
        "honeycomb",
    ],
    &[
        "concentric",
        "3dhoneycomb",
        "gyroid",
        "hilbertcurve",
        "archimedeanchords",
        "octagramspiral",
        "adaptivecubic",
        "supportcubic",
        "lightning",
    ],
);

registry! {
    /// The settings of filament printers, those that resin printers share included, grouped by stage.
    KEYS of Filament:
    Slicing slicing.layer_height: @both Number(0.01, 10.0), "mm", "Layer thickness";
    Slicing slicing.first_layer_height: NumberOrPercent(0.01, 10.0, 1000.0), "mm", "Thickness of the first layer; % of layer_height";
    Slicing slicing.adaptive_layer_height: Flag, "", "Layers as thick as the surface's slope allows, instead of layer_height";
    Slicing slicing.adaptive_cusp_height: Number(0.001, 10.0), "mm", "Greatest step that an adaptive layer leaves on a slope, across the surface";
    Slicing slicing.min_layer_height: @each Number(0.0, 10.0), "mm", "Least thickness of an adaptive layer; 0 = 0.01 mm";
    Slicing slicing.max_layer_height: @each Number(0.0, 10.0), "mm", "Greatest thickness of an adaptive layer; 0 = 75% of the nozzle's bore";
    Slicing slicing.resolution: Number(0.0, 10.0), "mm", "Tolerance of contour simplification; 0 keeps every point";
    Slicing slicing.slice_closing_radius: Number(0.0, 10.0), "mm", "Gaps in a contour up to twice this are closed";
    Slicing slicing.xy_size_compensation: Number(-10.0, 10.0), "mm", "Grows (+) or shrinks (-) every layer's outline in XY";
    Slicing slicing.elefant_foot_compensation: @both LengthOrPixels(0.0, 10.0, 500.0), "mm", "Shrinks the first layer's outline in XY";

    Widths widths.extrusion_width: WIDTH, "mm", "Line width where the widths below are 0; % of the layer height; 0 = automatic";
    Widths widths.first_layer_extrusion_width: WIDTH, "mm", "Line width of the whole first layer; % of its height; 0 = as on other layers";
    Widths widths.perimeter_extrusion_width: WIDTH, "mm", "Line width of inner walls; % of the layer height; 0 = automatic";
    Widths widths.external_perimeter_extrusion_width: WIDTH, "mm", "Line width of the outermost wall; % of the layer height; 0 = automatic";
    Widths widths.infill_extrusion_width: WIDTH, "mm", "Line width of sparse infill; % of the layer height; 0 = automatic";
    Widths widths.solid_infill_extrusion_width: WIDTH, "mm", "Line width of solid infill; % of the layer height; 0 = automatic";
    Widths widths.top_infill_extrusion_width: WIDTH, "mm", "Line width of topmost solid infill; % of the layer height; 0 = automatic";
    Widths widths.support_material_extrusion_width: WIDTH, "mm", "Line width of supports; % of the layer height; 0 = automatic";

    Perimeters perimeters.perimeters: Count(0, 1000), "", "Number of walls";
    Perimeters perimeters.external_perimeters_first: Flag, "", "Print the outermost wall before the inner ones";
    Perimeters perimeters.seam_position: Choice(&["random", "nearest", "aligned", "rear"], &[]), "", "Where loops start";
    Perimeters perimeters.extra_perimeters: Flag, "", "Add walls where a slope would else show infill";
    Perimeters perimeters.thin_walls: Flag, "", "Print walls too thin for a loop as one line of varying width";
    Perimeters perimeters.gap_fill_enabled: Flag, "", "Fill what walls leave between them with lines of varying width";
    Perimeters perimeters.overhangs: Flag, "", "Print walls over air as bridges";
    Perimeters perimeters.top_one_perimeter_type: Choice(&["none", "top", "topmost"], &[]), "", "Which top surfaces have one wall only";

    Infill infill.fill_density: Percent(0.0, 100.0), "%", "Density of sparse infill";
    Infill infill.fill_pattern: SPARSE_PATTERNS, "", "Pattern of sparse infill";
    Infill infill.top_fill_pattern: SKIN_PATTERNS, "", "Pattern of top skins";
    Infill infill.bottom_fill_pattern: SKIN_PATTERNS, "", "Pattern of bottom skins";
    Infill infill.fill_angle: Number(0.0, 360.0), "°", "Direction of the first family of infill lines, counter-clockwise from +x";
    Infill infill.infill_overlap: NumberOrPercent(0.0, 10.0, 100.0), "mm", "How far infill reaches into the innermost wall; % of that wall's width";
    Infill infill.top_solid_layers: Count(0, 100_000), "", "Solid layers under every top surface";
    Infill infill.bottom_solid_layers: Count(0, 100_000), "", "Solid layers over every bottom surface";
    Infill infill.top_solid_min_thickness: Number(0.0, 1000.0), "mm", "Least thickness of the top shell";
    Infill infill.bottom_solid_min_thickness: Number(0.0, 1000.0), "mm", "Least thickness of the bottom shell";
    Infill infill.solid_infill_below_area: Number(0.0, 1e6), "mm²", "Sparse areas smaller than this become solid";
    Infill infill.solid_infill_every_layers: Count(0, 100_000), "", "Every N-th layer is solid; 0 = never";
    Infill infill.infill_first: Flag, "", "Print infill before the walls";
    Infill infill.infill_anchor: NumberOrPercent(0.0, 1000.0, 100_000.0), "mm", "Length of a sparse line's end along the wall; % of the line's width; 0 = none";
    Infill infill.infill_anchor_max: NumberOrPercent(0.0, 1000.0, 100_000.0), "mm", "Longest link along a wall between two sparse lines; % of the line's width; 0 = none";
    Infill infill.infill_every_layers: Count(1, 100_000), "layers", "Print sparse infill every N-th layer, N layers thick as far as the nozzle allows";
    Infill infill.ensure_vertical_shell_thickness: Choice(&["disabled", "partial", "enabled"], &[]), "", "Add solid infill beside shallow slopes, so that the shell stays as thick as asked";
    Infill infill.external_infill_margin: Number(0.0, 100.0), "mm", "How far top, bottom and bridge skins reach into the part beyond what is exposed";
    Infill infill.bridge_angle: Number(0.0, 360.0), "°", "Direction of bridges; 0 = the best one of each";
    Infill infill.bridge_flow_ratio: Number(0.01, 2.0), "", "Factor on the flow of bridges";
    Infill infill.thick_bridges: Flag, "", "Bridges are threads as thick as the nozzle's bore instead of lines of the layer's height";

    Support support.support_material: Flag, "", "Make supports";
    Support support.support_material_auto: Flag, "", "Find overhangs by their slope; 0 = only enforcers are supported";
    Support support.support_material_threshold: Number(0.0, 90.0), "°", "Slopes flatter than this, measured from horizontal, are supported; 0 = what half a wall's width does not cover";
    Support support.support_material_enforce_layers: Count(0, 5000), "layers", "Support everything over air on the first N layers";
    Support support.support_material_buildplate_only: Flag, "", "Supports stand on the bed only, not on the part";
    Support support.dont_support_bridges: Flag, "", "Leave bridges without support";
    Support support.support_material_style: Choice(&["grid", "snug", "organic", "tree"], &[]), "", "Shape of supports: columns of whole cells, columns as large as the overhang, or branches (organic, tree)";
    Support support.support_material_pattern: Choice(&["rectilinear", "rectilinear-grid", "honeycomb"], &[]), "", "Pattern of the columns";
    Support support.support_material_spacing: Number(0.0, 100.0), "mm", "Clear distance between the lines of the columns";
    Support support.support_material_angle: Number(0.0, 359.0), "°", "Direction of the columns' lines, counter-clockwise from +x";
    Support support.support_material_with_sheath: Flag, "", "Put a line around each column";
    Support support.support_material_closing_radius: Number(0.0, 100.0), "mm", "Gaps between columns up to twice this are closed; style snug only";
    Support support.support_material_xy_spacing: NumberOrPercent(0.0, 10.0, 1000.0), "mm", "Clear distance to the part beside; % of an outer wall's width";
    Support support.support_material_contact_distance: Number(0.0, 10.0), "mm", "Clear distance to the part above; 0 = supports of soluble material touch it";
    Support support.support_material_bottom_contact_distance: Number(0.0, 10.0), "mm", "Clear distance to the part below; 0 = as above";
    Support support.support_material_synchronize_layers: Flag, "", "Layers of support are those of the part, instead of as few as fit";
    Support support.support_material_layer_height: Number(0.0, 10.0), "mm", "Greatest thickness of a layer of support; 0 = max_layer_height";
    Support support.support_material_interface_layers: Count(0, 1000), "layers", "Dense layers under the part";
    Support support.support_material_bottom_interface_layers: Integer(-1, 1000), "layers", "Dense layers on the part; -1 = as many as under it";
    Support support.support_material_interface_pattern: Choice(&["auto", "rectilinear", "concentric"], &[]), "", "Pattern of the dense layers; auto = concentric where the support touches the part";
    Support support.support_material_interface_spacing: Number(0.0, 100.0), "mm", "Clear distance between the lines of the dense layers; 0 = solid";
    Support support.support_material_interface_contact_loops: Flag, "", "Put loops around the topmost dense layer";
    Support support.support_material_flow_ratio: Number(0.1, 2.0), "", "Factor on the flow of columns and branches";
    Support support.support_material_interface_flow_ratio: Number(0.1, 2.0), "", "Factor on the flow of the dense layers";
    Support support.support_tree_angle: Number(0.0, 85.0), "°", "Greatest slope of a branch, measured from upright";
    Support support.support_tree_angle_slow: Number(0.0, 85.0), "°", "Slope of a branch where nothing is in its way";
    Support support.support_tree_branch_diameter: Number(0.1, 100.0), "mm", "Diameter of the thinnest branches but for their tips";
    Support support.support_tree_branch_diameter_angle: Number(0.0, 15.0), "°", "Branches grow thicker downwards by twice this angle";
    Support support.support_tree_branch_diameter_double_wall: Number(0.0, 100.0), "mm", "Branches at least as thick as a circle of this diameter have two walls; 0 = one wall always";
    Support support.support_tree_branch_distance: Number(0.1, 100.0), "mm", "Distance between branches where they touch the part";
    Support support.support_tree_tip_diameter: Number(0.1, 100.0), "mm", "Diameter of a branch's tip";
    Support support.support_tree_top_rate: Percent(5.0, 35.0), "%", "Share of a supported area that tips touch";

    Adhesion adhesion.skirts: Count(0, 1000), "", "Loops around the print; 0 = none";
    Adhesion adhesion.skirt_distance: Number(0.0, 1000.0), "mm", "Distance between skirt and print";
    Adhesion adhesion.skirt_height: Count(0, 100_000), "layers", "Layers the skirt stands high";
    Adhesion adhesion.min_skirt_length: Number(0.0, 1e6), "mm", "Least filament extruded in the first layer's skirt; 0 = no minimum";
    Adhesion adhesion.draft_shield: Choice(&["disabled", "limited", "enabled"], &[]), "", "The skirt stands as high as the print (enabled) or skirt_height (limited) and keeps draughts off";
    Adhesion adhesion.brim_width: Number(0.0, 200.0), "mm", "Width of the brim on the first layer; 0 = none";
    Adhesion adhesion.brim_type: Choice(&["no_brim", "outer_only", "inner_only", "outer_and_inner"], &[]), "", "Where the brim lies";
    Adhesion adhesion.brim_separation: Number(0.0, 10.0), "mm", "Distance between brim and part";
    Adhesion adhesion.brim_ears: Flag, "", "The brim is a disc of its width at each sharp corner only";
    Adhesion adhesion.brim_ears_max_angle: Number(0.0, 180.0), "°", "Corners up to this angle get an ear";
    Adhesion adhesion.raft_layers: Count(0, 1000), "layers", "Layers of raft under the part; 0 = none";
    Adhesion adhesion.raft_contact_distance: Number(0.0, 10.0), "mm", "Clear distance between raft and part";
    Adhesion adhesion.raft_expansion: Number(0.0, 100.0), "mm", "How far the raft reaches beyond the part";
    Adhesion adhesion.raft_first_layer_density: Percent(10.0, 100.0), "%", "Density of the first layer of raft and supports";
    Adhesion adhesion.raft_first_layer_expansion: Number(0.0, 100.0), "mm", "How much wider the first layer of raft and supports is";
    Adhesion adhesion.duplicate_distance: Number(0.0, 1000.0), "mm", "Distance between the boxes around copies of a part";

    Speed speed.perimeter_speed: SPEED, "mm/s", "Speed of inner walls";
    Speed speed.external_perimeter_speed: SPEED_OF, "mm/s", "Speed of the outermost wall; % of perimeter_speed";
    Speed speed.small_perimeter_speed: SPEED_OF, "mm/s", "Speed of walls of radius up to 6.5 mm; % of perimeter_speed";
    Speed speed.infill_speed: SPEED, "mm/s", "Speed of sparse infill";
    Speed speed.solid_infill_speed: SPEED_OF, "mm/s", "Speed of solid infill; % of infill_speed";
    Speed speed.top_solid_infill_speed: SPEED_OF, "mm/s", "Speed of topmost solid infill; % of solid_infill_speed";
    Speed speed.first_layer_speed: SPEED_OF, "mm/s", "Speed of the first layer; % of each line's own speed";
    Speed speed.bridge_speed: SPEED, "mm/s", "Speed of bridges and of walls over air";
    Speed speed.gap_fill_speed: SPEED, "mm/s", "Speed of gap fill";
    Speed speed.support_material_speed: SPEED, "mm/s", "Speed of supports";
    Speed speed.support_material_interface_speed: SPEED_OF, "mm/s", "Speed of the dense layers of supports; % of support_material_speed";
    Speed speed.first_layer_speed_over_raft: SPEED_OF, "mm/s", "Speed of the part's first layer on a raft; % of each line's own speed";
    Speed speed.travel_speed: SPEED, "mm/s", "Speed of moves without extrusion";
    Speed speed.travel_speed_z: SPEED, "mm/s", "Speed of vertical moves; 0 = travel_speed";
    Speed speed.max_volumetric_speed: Number(0.0, 10_000.0), "mm³/s", "Limit of volumetric flow; 0 = none";

    Retraction retraction.retract_length: @each Number(0.0, 1000.0), "mm", "Filament pulled back; 0 = never retract";
    Retraction retraction.retract_speed: @each Number(0.0, 10_000.0), "mm/s", "Speed of the pull";
    Retraction retraction.deretract_speed: @each Number(0.0, 10_000.0), "mm/s", "Speed of the push; 0 = retract_speed";
    Retraction retraction.retract_restart_extra: @each Number(-100.0, 100.0), "mm", "Extra filament pushed after a retraction";
    Retraction retraction.retract_before_travel: @each Number(0.0, 10_000.0), "mm", "Travels shorter than this do not retract";
    Retraction retraction.retract_lift: @each Number(0.0, 100.0), "mm", "Nozzle lift during retracted travel";
    Retraction retraction.retract_layer_change: @each Flag, "", "Retract at every layer change";

    Cooling cooling.cooling: @each Flag, "", "Slow short layers down and drive the fan by layer time";
    Cooling cooling.fan_always_on: @each Flag, "", "Keep the fan at min_fan_speed at least";
    Cooling cooling.min_fan_speed: @each Number(0.0, 100.0), "%", "Least fan speed";
    Cooling cooling.max_fan_speed: @each Number(0.0, 100.0), "%", "Fan speed of the shortest layers";
    Cooling cooling.bridge_fan_speed: @each Number(0.0, 100.0), "%", "Fan speed of bridges and of walls over air";
    Cooling cooling.disable_fan_first_layers: @each Count(0, 100_000), "layers", "The fan stays off for this many layers";
    Cooling cooling.full_fan_speed_layer: @each Count(0, 100_000), "", "The fan ramps up to full speed at this layer; 0 = no ramp";
    Cooling cooling.fan_below_layer_time: @each Number(0.0, 1e5), "s", "Layers shorter than this turn the fan on";
    Cooling cooling.slowdown_below_layer_time: @each Number(0.0, 1e5), "s", "Layers shorter than this are slowed down";
    Cooling cooling.min_print_speed: @each Number(0.0, 10_000.0), "mm/s", "The slow-down stops at this speed";

    Filament filament.filament_diameter: @each Number(0.1, 20.0), "mm", "Diameter of the filament";
    Filament filament.filament_density: @each Number(0.0, 100.0), "g/cm³", "Density of the filament; 0 = unknown";
    Filament filament.filament_cost: @each Number(0.0, 1e9), "money/kg", "Price of the filament; 0 = unknown";
    Filament filament.filament_type: @each Text, "", "Material, e.g. PLA";
    Filament filament.extrusion_multiplier: @each Number(0.01, 10.0), "", "Factor on all flow";
    Filament filament.filament_max_volumetric_speed: @each Number(0.0, 10_000.0), "mm³/s", "Limit of the filament's volumetric flow; 0 = none";
    Filament filament.temperature: @each Count(0, 600), "°C", "Nozzle temperature; 0 leaves it alone";
    Filament filament.first_layer_temperature: @each Count(0, 600), "°C", "Nozzle temperature of the first layer; 0 leaves it alone";
    Filament filament.bed_temperature: @each Count(0, 300), "°C", "Bed temperature; 0 leaves it alone";
    Filament filament.first_layer_bed_temperature: @each Count(0, 300), "°C", "Bed temperature of the first layer; 0 leaves it alone";

    Printer printer.printer_technology: @both Choice(&["FFF", "SLA"], &[]), "", "How the machine builds: of filament or of resin; given by the command, so that a file for the other kind is refused";
    Printer printer.bed_shape: Points(-10_000.0, 10_000.0), "mm", "Outline of the bed";
    Printer printer.max_print_height: @both Number(0.0, 10_000.0), "mm", "Height of the build volume; 0 = unlimited";
    Printer printer.nozzle_diameter: @each Number(0.05, 10.0), "mm", "Bore of the nozzle";
    Printer printer.gcode_flavor: Choice(&["reprap", "reprapfirmware", "marlin", "marlin2", "klipper"], &[]), "", "Dialect of the firmware";
    Printer printer.z_offset: Number(-100.0, 100.0), "mm", "Added to every Z";
    Printer printer.use_relative_e_distances: Flag, "", "E counts per move (M83) instead of from the start (M82)";
    Printer printer.use_firmware_retraction: Flag, "", "Retract by G10 / G11";

    Output output.start_gcode: Text, "", "Template written before the print";
    Output output.end_gcode: Text, "", "Template written after the print";
    Output output.before_layer_gcode: Text, "", "Template written before each layer's Z move";
    Output output.layer_gcode: Text, "", "Template written after each layer's Z move";
    Output output.gcode_comments: Flag, "", "Say what each line does";
    Output output.gcode_resolution: Number(0.0, 10.0), "mm", "Tolerance of path simplification";
}
