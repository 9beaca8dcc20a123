//! Settings of resin printers that PrusaSlicer has and this crate does not honour yet.

use super::foreign::{Foreign, quiet, seen};

/// Sorted by name. The names are those of PrusaSlicer 2.5's option list and, as far as known, of later versions.
pub static FOREIGN_RESIN: &[Foreign] = &[
    quiet("bed_custom_model"),
    quiet("bed_custom_texture"),
    quiet("bed_shape"),
    quiet("bottle_weight"),
    quiet("branchingsupport_base_diameter"),
    quiet("branchingsupport_base_height"),
    quiet("branchingsupport_base_safety_distance"),
    quiet("branchingsupport_buildplate_only"),
    quiet("branchingsupport_critical_angle"),
    quiet("branchingsupport_head_front_diameter"),
    quiet("branchingsupport_head_penetration"),
    quiet("branchingsupport_head_width"),
    quiet("branchingsupport_max_bridge_length"),
    quiet("branchingsupport_max_bridges_on_pillar"),
    quiet("branchingsupport_max_pillar_link_distance"),
    quiet("branchingsupport_max_weight_on_model"),
    quiet("branchingsupport_object_elevation"),
    quiet("branchingsupport_pillar_connection_mode"),
    quiet("branchingsupport_pillar_diameter"),
    quiet("branchingsupport_pillar_widening_factor"),
    quiet("branchingsupport_small_pillar_diameter_percent"),
    quiet("compatible_printers"),
    quiet("compatible_printers_condition"),
    quiet("compatible_printers_condition_cummulative"),
    quiet("compatible_prints"),
    quiet("compatible_prints_condition"),
    quiet("compatible_prints_condition_cummulative"),
    quiet("default_sla_material_profile"),
    quiet("default_sla_print_profile"),
    quiet("delay_after_exposure"),
    quiet("delay_before_exposure"),
    quiet("elefant_foot_min_width"),
    quiet("high_viscosity_tilt_time"),
    quiet("hollowing_closing_distance"),
    seen("hollowing_enable", &["0"]),
    quiet("hollowing_min_thickness"),
    quiet("hollowing_quality"),
    quiet("host_type"),
    quiet("inherits"),
    quiet("inherits_group"),
    quiet("material_colour"),
    seen("material_correction", &["1"]),
    seen("material_correction_x", &["1"]),
    seen("material_correction_y", &["1"]),
    seen("material_correction_z", &["1"]),
    quiet("material_notes"),
    seen("material_ow_absolute_correction", &["nil"]),
    seen("material_ow_elefant_foot_compensation", &["nil"]),
    seen("material_ow_relative_correction_x", &["nil"]),
    seen("material_ow_relative_correction_y", &["nil"]),
    seen("material_ow_relative_correction_z", &["nil"]),
    quiet("material_print_speed"),
    quiet("material_vendor"),
    quiet("max_exposure_time"),
    quiet("max_initial_exposure_time"),
    quiet("min_exposure_time"),
    quiet("min_initial_exposure_time"),
    quiet("output_filename_format"),
    quiet("pad_around_object"),
    quiet("pad_around_object_everywhere"),
    quiet("pad_brim_size"),
    seen("pad_enable", &["0"]),
    quiet("pad_max_merge_distance"),
    quiet("pad_object_connector_penetration"),
    quiet("pad_object_connector_stride"),
    quiet("pad_object_connector_width"),
    quiet("pad_object_gap"),
    quiet("pad_wall_height"),
    quiet("pad_wall_slope"),
    quiet("pad_wall_thickness"),
    quiet("physical_printer_settings_id"),
    quiet("print_host"),
    quiet("printer_notes"),
    quiet("printer_settings_id"),
    quiet("printer_variant"),
    quiet("printer_vendor"),
    quiet("printhost_apikey"),
    quiet("printhost_cafile"),
    seen("relative_correction", &["1"]),
    quiet("sla_output_precision"),
    quiet("sla_print_settings_id"),
    quiet("slice_closing_radius"),
    quiet("slicing_mode"),
    quiet("support_base_diameter"),
    quiet("support_base_height"),
    quiet("support_base_safety_distance"),
    quiet("support_buildplate_only"),
    quiet("support_critical_angle"),
    seen("support_enforcers_only", &["0"]),
    quiet("support_head_front_diameter"),
    quiet("support_head_penetration"),
    quiet("support_head_width"),
    quiet("support_max_bridge_length"),
    quiet("support_max_bridges_on_pillar"),
    quiet("support_max_pillar_link_distance"),
    quiet("support_max_weight_on_model"),
    quiet("support_object_elevation"),
    quiet("support_pillar_connection_mode"),
    quiet("support_pillar_diameter"),
    quiet("support_pillar_widening_factor"),
    quiet("support_points_density_relative"),
    quiet("support_points_minimal_distance"),
    quiet("support_small_pillar_diameter_percent"),
    quiet("support_tree_type"),
    seen("supports_enable", &["0"]),
    quiet("thumbnails"),
    quiet("thumbnails_format"),
    quiet("tower_hop_height"),
    quiet("tower_speed"),
    quiet("use_tilt"),
    seen("zcorrection_layers", &["0"]),
];

#[cfg(test)]
mod tests {
    use super::super::{foreign, keys};
    use crate::settings::PrinterTechnology::Sla;

    /// The keys of a configuration for SLA that PrusaSlicer 2.5.0 saves.
    const SAVED: &str = "
        absolute_correction area_fill bed_shape bottle_cost bottle_volume bottle_weight
        display_height display_mirror_x display_mirror_y display_orientation display_pixels_x
        display_pixels_y display_width elefant_foot_compensation elefant_foot_min_width
        exposure_time faded_layers fast_tilt_time gamma_correction high_viscosity_tilt_time
        hollowing_closing_distance hollowing_enable hollowing_min_thickness hollowing_quality
        initial_exposure_time initial_layer_height layer_height material_correction
        material_correction_x material_correction_y material_correction_z material_density
        material_print_speed max_exposure_time max_initial_exposure_time max_print_height
        min_exposure_time min_initial_exposure_time output_filename_format pad_around_object
        pad_around_object_everywhere pad_brim_size pad_enable pad_max_merge_distance
        pad_object_connector_penetration pad_object_connector_stride pad_object_connector_width
        pad_object_gap pad_wall_height pad_wall_slope pad_wall_thickness printer_technology
        relative_correction relative_correction_x relative_correction_y relative_correction_z
        slice_closing_radius slicing_mode slow_tilt_time support_base_diameter
        support_base_height support_base_safety_distance support_buildplate_only
        support_critical_angle support_head_front_diameter support_head_penetration
        support_head_width support_max_bridge_length support_max_bridges_on_pillar
        support_max_pillar_link_distance support_object_elevation
        support_pillar_connection_mode support_pillar_diameter support_pillar_widening_factor
        support_points_density_relative support_points_minimal_distance
        support_small_pillar_diameter_percent supports_enable
    ";

    #[test]
    fn every_key_that_prusaslicer_saves_is_known() {
        let honoured = |name: &str| keys::of(Sla).any(|k| k.name == name);
        let mut count = 0;
        for name in SAVED.split_whitespace() {
            assert!(honoured(name) || foreign::find(name, Sla).is_some(), "{name}");
            count += u32::from(honoured(name));
        }
        assert_eq!(count, 26);
    }
}
