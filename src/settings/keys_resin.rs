//! The registry's rows of resin printers.

use super::keys::registry;
use super::kind::Kind::{self, Choice, Count, Flag, LengthOrPixels, Number, Text};
use super::types_resin::CONTAINERS;

/// A speed of the plate; 0 is refused by the cross-checks where the plate moves.
const SPEED: Kind = Number(0.0, 10_000.0);
const LIFT: Kind = Number(0.0, 300.0);
const TIME: Kind = Number(0.0, 3600.0);
const LIGHT: Kind = Count(0, 255);
const LAYERS: Kind = Count(0, 100_000);
const FACTOR: Kind = Number(0.5, 2.0);
registry! {
    /// The settings of resin printers alone, grouped by stage.
    RESIN_KEYS of Resin:
    Slicing exposure.initial_layer_height: Number(0.0, 10.0), "mm", "Thickness of the first layer; 0 = layer_height";

    Exposure exposure.exposure_time: TIME, "s", "Exposure of normal layers";
    Exposure exposure.initial_exposure_time: TIME, "s", "Exposure of bottom layers";
    Exposure exposure.bottom_layers: LAYERS, "layers", "Layers with the full initial_exposure_time";
    Exposure exposure.transition_layers: LAYERS, "layers", "Layers behind the bottom layers whose exposure falls linearly to exposure_time";
    Exposure exposure.faded_layers: LAYERS, "layers", "PrusaSlicer's way: three bottom layers and so many transition layers, in the place of bottom_layers and transition_layers; 0 = they rule";
    Exposure exposure.light: LIGHT, "", "Light of normal layers; 255 = full";
    Exposure exposure.bottom_light: LIGHT, "", "Light of bottom layers; 255 = full";

    Lift lift.lift_height: LIFT, "mm", "First stage of the lift behind a normal layer";
    Lift lift.lift_speed: SPEED, "mm/min", "Speed of that stage";
    Lift lift.lift_height2: LIFT, "mm", "Second stage of the lift, on top of the first; 0 = none";
    Lift lift.lift_speed2: SPEED, "mm/min", "Speed of that stage";
    Lift lift.lift_retract_speed: SPEED, "mm/min", "Speed of the way back, or of its first stage";
    Lift lift.lift_retract_height2: LIFT, "mm", "Length of the last stage of the way back, a part of the whole lift; 0 = none";
    Lift lift.lift_retract_speed2: SPEED, "mm/min", "Speed of that stage";
    Lift lift.bottom_lift_height: LIFT, "mm", "As lift_height, behind bottom layers";
    Lift lift.bottom_lift_speed: SPEED, "mm/min", "As lift_speed, behind bottom layers";
    Lift lift.bottom_lift_height2: LIFT, "mm", "As lift_height2, behind bottom layers";
    Lift lift.bottom_lift_speed2: SPEED, "mm/min", "As lift_speed2, behind bottom layers";
    Lift lift.bottom_lift_retract_speed: SPEED, "mm/min", "As lift_retract_speed, behind bottom layers";
    Lift lift.bottom_lift_retract_height2: LIFT, "mm", "As lift_retract_height2, behind bottom layers";
    Lift lift.bottom_lift_retract_speed2: SPEED, "mm/min", "As lift_retract_speed2, behind bottom layers";
    Lift lift.rest_before_lift: TIME, "s", "Rest between exposure and lift";
    Lift lift.rest_after_lift: TIME, "s", "Rest at the top of the lift";
    Lift lift.rest_after_retract: TIME, "s", "Rest between the way back and the exposure";
    Lift lift.bottom_rest_before_lift: TIME, "s", "As rest_before_lift, of bottom layers";
    Lift lift.bottom_rest_after_lift: TIME, "s", "As rest_after_lift, of bottom layers";
    Lift lift.bottom_rest_after_retract: TIME, "s", "As rest_after_retract, of bottom layers";
    Lift lift.tilt: Flag, "", "The vat tilts instead of the plate lifting, as in a Prusa SL1; lifts and their speeds then have no effect";
    Lift lift.fast_tilt_time: TIME, "s", "Time of a tilt behind a small layer; for the print time only";
    Lift lift.slow_tilt_time: TIME, "s", "Time of a tilt behind a large layer; for the print time only";
    Lift lift.area_fill: Number(0.0, 100.0), "%", "A layer that lights more than this share of the panel is large";

    Image image.anti_aliasing: Choice(&["1", "2", "4", "8", "16"], &[]), "", "Sub-rows of a pixel row; 1 = no greys";
    Image image.minimum_grey: Count(0, 255), "", "Darker greys, but not black, are raised to this";
    Image image.gamma_correction: Number(0.0, 1.0), "", "Exponent of the grey curve; 1 = linear, 0 = no greys";
    Image image.absolute_correction: LengthOrPixels(-10.0, 10.0, 500.0), "mm", "Grows (+) or shrinks (-) every layer's outline in XY";
    Image image.relative_correction_x: FACTOR, "", "Factor on the model's x";
    Image image.relative_correction_y: FACTOR, "", "Factor on the model's y";
    Image image.relative_correction_z: FACTOR, "", "Factor on the model's z";
    Image image.elefant_foot_compensation_layers: LAYERS, "layers", "Layers over which that shrinking falls linearly to nothing";

    Display display.display_width: Number(0.0, 2000.0), "mm", "Length of the lit area along display_pixels_x; 0 = unknown";
    Display display.display_height: Number(0.0, 2000.0), "mm", "Length of the lit area along display_pixels_y; 0 = unknown";
    Display display.display_pixels_x: Count(0, 65_535), "px", "Pixels of the panel along the plate's x; 0 = unknown";
    Display display.display_pixels_y: Count(0, 65_535), "px", "Pixels of the panel along the plate's y; 0 = unknown";
    Display display.display_orientation: Choice(&["landscape", "portrait"], &[]), "", "Rows of the stored image run along the plate's x (landscape) or its y (portrait)";
    Display display.display_mirror_x: Flag, "", "The panel shows the image mirrored left to right";
    Display display.display_mirror_y: Flag, "", "The panel shows the image mirrored top to bottom";

    Material material.sla_material_settings_id: Text, "", "Name of the resin's profile";
    Material material.material_type: Text, "", "Kind of resin, e.g. Tough";
    Material material.material_density: Number(0.0, 100.0), "g/ml", "Density of the resin; 0 = unknown";
    Material material.bottle_cost: Number(0.0, 1e9), "money", "Price of a bottle; 0 = unknown";
    Material material.bottle_volume: Number(0.0, 1e6), "ml", "Content of a bottle";

    Printer machine.machine_name: Text, "", "Full name of the machine, as some compare it with the file's";
    Printer machine.printer_model: Text, "", "Code of the machine, such as SL1S, which a Prusa compares with the file's";
    Printer machine.container: Choice(CONTAINERS, &[]), "", "The files that the machine reads; where the output's name has an extension, that decides";
    Printer machine.ctb_version: Choice(&["3", "4"], &[]), "", "Version of a .ctb file; 4 knows two-stage lifts and rests";
    Printer machine.sla_archive_format: Text, "", "PrusaSlicer's name of the container; kept for the settings within an .sl1";
}
