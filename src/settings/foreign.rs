//! Settings PrusaSlicer has and this crate does not honour yet.

use super::assign::Warning;
use super::foreign_resin::FOREIGN_RESIN;
use super::types::PrinterTechnology;

/// A key that is known by name only.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Foreign {
    /// PrusaSlicer's name.
    pub name: &'static str,
    /// The values that ask for nothing; any other one would be missed in the print. `None`: never worth a warning.
    pub off: Option<&'static [&'static str]>,
}

/// The key of that name, among those of a technology.
pub fn find(name: &str, technology: PrinterTechnology) -> Option<&'static Foreign> {
    let table = of(technology);
    table.binary_search_by(|f| f.name.cmp(name)).ok().and_then(|i| table.get(i))
}

/// The keys of a technology, sorted by name.
pub fn of(technology: PrinterTechnology) -> &'static [Foreign] {
    match technology {
        PrinterTechnology::Fff => FOREIGN,
        PrinterTechnology::Sla => FOREIGN_RESIN,
    }
}

impl Foreign {
    /// A warning if `value` asks for something the print will lack.
    pub fn warning(&self, value: &str) -> Option<Warning> {
        let off = self.off?;
        // Lists per extruder ask for nothing if no entry does; `nil` leaves an override unset.
        let idle = |v: &str| v.is_empty() || v == "\"\"" || v == "nil" || off.iter().any(|o| same(o, v));
        let asks = !idle(value) && !value.split([',', ';']).all(|v| idle(v.trim()));
        asks.then(|| Warning::new(self.name, value, "not supported yet, so it has no effect"))
    }
}

/// Equal as texts or as numbers, so that `0.0` and `0%` are as good as `0`.
fn same(a: &str, b: &str) -> bool {
    let number = |t: &str| t.trim_end_matches('%').parse::<f64>().ok();
    let flag = |t: &str| match t {
        "true" => Some(1.0),
        "false" => Some(0.0),
        t => number(t),
    };
    a == b || flag(a).is_some_and(|a| Some(a) == flag(b))
}

pub(super) const fn quiet(name: &'static str) -> Foreign {
    Foreign { name, off: None }
}

pub(super) const fn seen(name: &'static str, off: &'static [&'static str]) -> Foreign {
    Foreign { name, off: Some(off) }
}

/// Sorted by name. The names are those of PrusaSlicer 2.5's option list and, as far as known, of later versions.
pub static FOREIGN: &[Foreign] = &[
    seen("arc_fitting", &["0", "disabled"]),
    seen("autoemit_temperature_commands", &["1"]),
    seen("automatic_infill_combination", &["0"]),
    quiet("automatic_infill_combination_max_layer_height"),
    quiet("avoid_crossing_curled_overhangs"),
    seen("avoid_crossing_perimeters", &["0"]),
    quiet("avoid_crossing_perimeters_max_detour"),
    quiet("bed_custom_model"),
    quiet("bed_custom_texture"),
    quiet("bed_temperature_extruder"),
    seen("between_objects_gcode", &[""]),
    seen("binary_gcode", &["0"]),
    quiet("bottom_solid_infill_flow_ratio"),
    quiet("bridge_acceleration"),
    quiet("chamber_minimal_temperature"),
    seen("chamber_temperature", &["0"]),
    quiet("clip_multipart_objects"),
    quiet("color_change_gcode"),
    seen("colorprint_heights", &[""]),
    quiet("compatible_printers"),
    quiet("compatible_printers_condition"),
    quiet("compatible_printers_condition_cummulative"),
    quiet("compatible_prints"),
    quiet("compatible_prints_condition"),
    quiet("compatible_prints_condition_cummulative"),
    seen("complete_objects", &["0"]),
    quiet("cooling_perimeter_transition_distance"),
    quiet("cooling_slowdown_logic"),
    quiet("cooling_tube_length"),
    quiet("cooling_tube_retraction"),
    quiet("default_acceleration"),
    quiet("default_filament_profile"),
    quiet("default_print_profile"),
    quiet("enable_dynamic_fan_speeds"),
    seen("enable_dynamic_overhang_speeds", &["0"]),
    seen("end_filament_gcode", &[r#""; Filament-specific end gcode \n;END gcode for filament\n""#]),
    quiet("external_perimeter_acceleration"),
    quiet("extra_loading_move"),
    seen("extra_perimeters_on_overhangs", &["0"]),
    quiet("extruder"),
    quiet("extruder_clearance_height"),
    quiet("extruder_clearance_radius"),
    quiet("extruder_colour"),
    seen("extruder_offset", &["0x0"]),
    seen("extrusion_axis", &["E"]),
    quiet("filament_abrasive"),
    quiet("filament_colour"),
    quiet("filament_cooling_final_speed"),
    quiet("filament_cooling_initial_speed"),
    quiet("filament_cooling_moves"),
    seen("filament_deretract_speed", &["nil"]),
    quiet("filament_infill_max_crossing_speed"),
    quiet("filament_infill_max_speed"),
    quiet("filament_load_time"),
    quiet("filament_loading_speed"),
    quiet("filament_loading_speed_start"),
    quiet("filament_minimal_purge_on_wipe_tower"),
    quiet("filament_multitool_ramming"),
    quiet("filament_multitool_ramming_flow"),
    quiet("filament_multitool_ramming_volume"),
    quiet("filament_notes"),
    quiet("filament_purge_multiplier"),
    quiet("filament_ramming_parameters"),
    seen("filament_retract_before_travel", &["nil"]),
    seen("filament_retract_before_wipe", &["nil"]),
    seen("filament_retract_layer_change", &["nil"]),
    seen("filament_retract_length", &["nil"]),
    seen("filament_retract_length_toolchange", &["nil"]),
    seen("filament_retract_lift", &["nil"]),
    seen("filament_retract_lift_above", &["nil"]),
    seen("filament_retract_lift_below", &["nil"]),
    seen("filament_retract_restart_extra", &["nil"]),
    seen("filament_retract_restart_extra_toolchange", &["nil"]),
    seen("filament_retract_speed", &["nil"]),
    quiet("filament_seam_gap_distance"),
    quiet("filament_settings_id"),
    seen("filament_shrinkage_compensation_xy", &["0%"]),
    seen("filament_shrinkage_compensation_z", &["0%"]),
    quiet("filament_soluble"),
    quiet("filament_spool_weight"),
    quiet("filament_stamping_distance"),
    quiet("filament_stamping_loading_speed"),
    quiet("filament_toolchange_delay"),
    seen("filament_travel_lift_before_obstacle", &["nil"]),
    seen("filament_travel_max_lift", &["nil"]),
    seen("filament_travel_ramping_lift", &["nil"]),
    seen("filament_travel_slope", &["nil"]),
    quiet("filament_unload_time"),
    quiet("filament_unloading_speed"),
    quiet("filament_unloading_speed_start"),
    quiet("filament_vendor"),
    seen("filament_wipe", &["nil"]),
    quiet("first_layer_acceleration"),
    quiet("first_layer_acceleration_over_raft"),
    quiet("first_layer_infill_speed"),
    seen("fuzzy_skin", &["none"]),
    quiet("fuzzy_skin_point_dist"),
    quiet("fuzzy_skin_thickness"),
    quiet("gcode_label_objects"),
    seen("gcode_substitutions", &[""]),
    quiet("high_current_on_filament_swap"),
    quiet("host_type"),
    quiet("idle_temperature"),
    quiet("infill_acceleration"),
    seen("infill_extruder", &["0", "1"]),
    seen("infill_only_where_needed", &["0"]),
    quiet("inherits"),
    quiet("inherits_group"),
    seen("interface_shells", &["0"]),
    seen("interlocking_beam", &["0"]),
    quiet("interlocking_beam_layer_count"),
    quiet("interlocking_beam_width"),
    quiet("interlocking_boundary_avoidance"),
    quiet("interlocking_depth"),
    quiet("interlocking_orientation"),
    seen("ironing", &["0"]),
    quiet("ironing_flowrate"),
    quiet("ironing_spacing"),
    quiet("ironing_speed"),
    quiet("ironing_type"),
    seen("machine_limits_usage", &["time_estimate_only", "ignore"]),
    quiet("machine_max_acceleration_e"),
    quiet("machine_max_acceleration_extruding"),
    quiet("machine_max_acceleration_retracting"),
    quiet("machine_max_acceleration_travel"),
    quiet("machine_max_acceleration_x"),
    quiet("machine_max_acceleration_y"),
    quiet("machine_max_acceleration_z"),
    quiet("machine_max_feedrate_e"),
    quiet("machine_max_feedrate_x"),
    quiet("machine_max_feedrate_y"),
    quiet("machine_max_feedrate_z"),
    quiet("machine_max_jerk_e"),
    quiet("machine_max_jerk_x"),
    quiet("machine_max_jerk_y"),
    quiet("machine_max_jerk_z"),
    quiet("machine_min_extruding_rate"),
    quiet("machine_min_travel_rate"),
    quiet("max_print_speed"),
    quiet("max_volumetric_extrusion_rate_slope_negative"),
    quiet("max_volumetric_extrusion_rate_slope_positive"),
    quiet("min_bead_width"),
    quiet("min_feature_size"),
    quiet("mmu_segmented_region_interlocking_depth"),
    quiet("mmu_segmented_region_max_width"),
    quiet("multimaterial_purging"),
    quiet("notes"),
    quiet("nozzle_high_flow"),
    seen("only_one_perimeter_first_layer", &["0"]),
    seen("only_retract_when_crossing_perimeters", &["0"]),
    seen("ooze_prevention", &["0"]),
    quiet("output_filename_format"),
    quiet("over_bridge_speed"),
    quiet("overhang_fan_speed_0"),
    quiet("overhang_fan_speed_1"),
    quiet("overhang_fan_speed_2"),
    quiet("overhang_fan_speed_3"),
    quiet("overhang_speed_0"),
    quiet("overhang_speed_1"),
    quiet("overhang_speed_2"),
    quiet("overhang_speed_3"),
    quiet("parking_pos_retraction"),
    quiet("pause_print_gcode"),
    quiet("perimeter_acceleration"),
    seen("perimeter_extruder", &["0", "1"]),
    seen("perimeter_generator", &["classic"]),
    quiet("physical_printer_settings_id"),
    seen("post_process", &[""]),
    quiet("prefer_clockwise_movements"),
    quiet("print_host"),
    quiet("print_settings_id"),
    quiet("printer_model"),
    quiet("printer_notes"),
    quiet("printer_settings_id"),
    quiet("printer_variant"),
    quiet("printer_vendor"),
    quiet("printhost_apikey"),
    quiet("printhost_cafile"),
    quiet("remaining_times"),
    quiet("retract_before_wipe"),
    quiet("retract_length_toolchange"),
    seen("retract_lift_above", &["0"]),
    seen("retract_lift_below", &["0"]),
    quiet("retract_restart_extra_toolchange"),
    quiet("scarf_seam_entire_loop"),
    quiet("scarf_seam_length"),
    quiet("scarf_seam_max_segment_length"),
    quiet("scarf_seam_on_inner_perimeters"),
    quiet("scarf_seam_only_on_smooth"),
    seen("scarf_seam_placement", &["nowhere"]),
    quiet("scarf_seam_start_height"),
    quiet("seam_gap_distance"),
    quiet("silent_mode"),
    seen("single_extruder_multi_material", &["0"]),
    quiet("single_extruder_multi_material_priming"),
    seen("slicing_mode", &["regular"]),
    quiet("solid_infill_acceleration"),
    seen("solid_infill_extruder", &["0", "1"]),
    quiet("solid_layers"),
    quiet("solid_min_thickness"),
    seen("spiral_vase", &["0"]),
    quiet("staggered_inner_seams"),
    quiet("standby_temperature_delta"),
    seen("start_filament_gcode", &[r#""; Filament gcode\n""#]),
    quiet("support_material_extruder"),
    quiet("support_material_interface_extruder"),
    quiet("template_custom_gcode"),
    quiet("threads"),
    quiet("thumbnails"),
    quiet("thumbnails_format"),
    seen("toolchange_gcode", &[""]),
    quiet("top_solid_infill_acceleration"),
    quiet("travel_acceleration"),
    quiet("travel_lift_before_obstacle"),
    quiet("travel_max_lift"),
    seen("travel_ramping_lift", &["0"]),
    quiet("travel_short_distance_acceleration"),
    quiet("travel_slope"),
    seen("use_volumetric_e", &["0"]),
    quiet("variable_layer_height"),
    quiet("wall_distribution_count"),
    quiet("wall_transition_angle"),
    quiet("wall_transition_filter_deviation"),
    quiet("wall_transition_length"),
    seen("wipe", &["0"]),
    seen("wipe_into_infill", &["0"]),
    seen("wipe_into_objects", &["0"]),
    seen("wipe_tower", &["0"]),
    quiet("wipe_tower_acceleration"),
    quiet("wipe_tower_bridging"),
    quiet("wipe_tower_brim_width"),
    quiet("wipe_tower_cone_angle"),
    quiet("wipe_tower_extra_flow"),
    quiet("wipe_tower_extra_spacing"),
    quiet("wipe_tower_extruder"),
    quiet("wipe_tower_no_sparse_layers"),
    quiet("wipe_tower_rotation_angle"),
    quiet("wipe_tower_width"),
    quiet("wipe_tower_x"),
    quiet("wipe_tower_y"),
    quiet("wiping_volumes_extruders"),
    quiet("wiping_volumes_matrix"),
];

#[cfg(test)]
mod tests {
    use super::super::keys;
    use super::*;

    #[test]
    fn the_tables_are_sorted_and_disjoint_from_the_registry() {
        for technology in [PrinterTechnology::Fff, PrinterTechnology::Sla] {
            assert!(of(technology).windows(2).all(|w| w[0].name < w[1].name));
            assert!(of(technology).iter().all(|f| keys::of(technology).all(|k| k.name != f.name)));
        }
    }

    #[test]
    fn only_values_that_ask_for_something_warn() {
        let warns = |key: &str, value: &str| {
            find(key, PrinterTechnology::Fff).and_then(|f| f.warning(value)).is_some()
        };
        for (key, value) in [("complete_objects", "1"), ("fuzzy_skin", "all"), ("wipe", "0,1")] {
            assert!(warns(key, value), "{key} = {value}");
        }
        for (key, value) in [
            ("complete_objects", "0"),
            ("fuzzy_skin", "none"),
            ("wipe", "0,0"),
            ("filament_retract_length", "nil,nil"),
            ("fuzzy_skin_thickness", "0.3"),
            ("thin_walls", "false"),
        ] {
            assert!(!warns(key, value), "{key} = {value}");
        }
    }
}
