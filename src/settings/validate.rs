//! Checks of settings against each other, after all values have been read.

use super::assign::Warning;
use super::flow::{Flow, FlowRole};
use super::load::SettingsError;
use super::types::{FloatOrPercent, GcodeFlavor, Settings};
use super::types_part::FillPattern;
use super::types_resin::LengthOrPixels;

/// A value that cannot work together with others.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key} = {value}: {problem}; {remedy}")]
pub struct Invalid {
    /// The setting to change.
    pub key: &'static str,
    /// Its value.
    pub value: String,
    /// What is wrong.
    pub problem: String,
    /// What to do.
    pub remedy: String,
}

/// A nozzle cannot press a line wider than this many bores (PrusaSlicer's limit).
pub(super) const MAX_WIDTH_IN_NOZZLES: f64 = 3.0;
/// Patterns whose lines are those of solid infill.
const STRAIGHT: [FillPattern; 4] = [
    FillPattern::Rectilinear,
    FillPattern::Monotonic,
    FillPattern::MonotonicLines,
    FillPattern::AlignedRectilinear,
];
/// The lattice reaches 2^30 nm to either side of the bed's centre.
const MAX_BED: f64 = 2000.0;

impl Settings {
    /// Checks what no range of a single value can: layers against the nozzle, widths against layers, speeds, bed.
    ///
    /// # Errors
    /// [`SettingsError::Invalid`] with the first contradiction.
    pub fn validate(&self) -> Result<Vec<Warning>, SettingsError> {
        self.check_layers()?;
        self.check_widths()?;
        self.check_overlap()?;
        self.check_speeds()?;
        self.check_bed()?;
        self.check_extrusion()?;
        self.check_supports()?;
        let mut warnings = self.oddities();
        warnings.extend(self.support_oddities());
        warnings.extend(self.adhesion_oddities());
        Ok(warnings)
    }

    pub(super) fn invalid(
        &self,
        key: &'static str,
        problem: impl Into<String>,
        remedy: impl Into<String>,
    ) -> SettingsError {
        let (problem, remedy) = (problem.into(), remedy.into());
        SettingsError::Invalid(Invalid { key, value: self.get(key).unwrap_or_default(), problem, remedy })
    }

    /// Thickness of the first layer \[mm\].
    pub(super) fn first_height(&self) -> f64 {
        self.slicing.first_layer_height.of(self.slicing.layer_height)
    }

    /// Least and greatest thickness of adaptive layers \[mm\], 0 replaced by its meaning.
    pub fn adaptive_heights(&self) -> [f64; 2] {
        let [min, max] = [self.slicing.min_layer_height, self.slicing.max_layer_height];
        [
            if min > 0.0 { min } else { 0.01 },
            if max > 0.0 { max } else { 0.75 * self.printer.nozzle_diameter },
        ]
    }

    fn check_layers(&self) -> Result<(), SettingsError> {
        let nozzle = self.printer.nozzle_diameter;
        let mut heights =
            vec![("layer_height", self.slicing.layer_height), ("first_layer_height", self.first_height())];
        if self.slicing.adaptive_layer_height {
            let [min, max] = self.adaptive_heights();
            if min > max {
                let problem = format!("above the greatest thickness of an adaptive layer ({max} mm)");
                let remedy = format!("at most {max}, or set max_layer_height");
                return Err(self.invalid("min_layer_height", problem, remedy));
            }
            heights.push(("max_layer_height", max));
        }
        for (key, height) in heights {
            // `is_nan` and the like are covered: a comparison with them is false.
            if !(height > 0.0 && height.is_finite()) {
                return Err(self.invalid(key, "the layer has no thickness", "give a height above 0"));
            }
            if height > nozzle {
                let problem =
                    format!("thicker than the nozzle's bore ({nozzle} mm), so layers would not bond");
                return Err(self.invalid(key, problem, format!("at most {nozzle}, or set nozzle_diameter")));
            }
        }
        Ok(())
    }

    fn check_widths(&self) -> Result<(), SettingsError> {
        let nozzle = self.printer.nozzle_diameter;
        let roles = [
            (FlowRole::ExternalPerimeter, "external_perimeter_extrusion_width"),
            (FlowRole::Perimeter, "perimeter_extrusion_width"),
            (FlowRole::Infill, "infill_extrusion_width"),
            (FlowRole::SolidInfill, "solid_infill_extrusion_width"),
            (FlowRole::TopSolidInfill, "top_infill_extrusion_width"),
        ];
        let mut layers = vec![(true, self.first_height()), (false, self.slicing.layer_height)];
        if self.slicing.adaptive_layer_height {
            layers.extend(self.adaptive_heights().map(|height| (false, height)));
        }
        for (first, height) in layers {
            for (role, own) in roles {
                let flow = Flow::new(role, height, first, self);
                let key = self.width_key(own, height, first);
                let layer = if first { "first layer" } else { "layers" };
                if !(flow.width >= height && flow.spacing() > 0.0) {
                    let problem = format!(
                        "gives lines {:.3} mm wide, narrower than the {layer} of {height} mm",
                        flow.width
                    );
                    return Err(self.invalid(key, problem, format!("at least {height}, or 0 for automatic")));
                }
                if flow.width > MAX_WIDTH_IN_NOZZLES * nozzle {
                    let problem =
                        format!("gives lines {:.3} mm wide from a nozzle of {nozzle} mm", flow.width);
                    let most = MAX_WIDTH_IN_NOZZLES * nozzle;
                    return Err(self.invalid(key, problem, format!("at most {most:.3}, or 0 for automatic")));
                }
            }
        }
        Ok(())
    }

    /// Infill that reaches through the innermost wall would show, or even stick out of the part.
    fn check_overlap(&self) -> Result<(), SettingsError> {
        let flow = |role| Flow::new(role, self.slicing.layer_height, false, self);
        let (external, inner) = (flow(FlowRole::ExternalPerimeter), flow(FlowRole::Perimeter));
        let (wall, most) = match self.perimeters.perimeters {
            0 => return Ok(()),
            // Up to the middle of the only wall.
            1 => (external, 0.5 * external.spacing()),
            _ => (inner, inner.spacing()),
        };
        let overlap =
            self.infill.infill_overlap.of(0.5 * (wall.spacing() + flow(FlowRole::SolidInfill).spacing()));
        if overlap > most * (1.0 + 1e-9) {
            let problem =
                format!("infill would reach {overlap:.3} mm into a wall, through to the other side");
            return Err(self.invalid("infill_overlap", problem, format!("at most {most:.3}")));
        }
        Ok(())
    }

    /// The key that decides a role's width: the order of [`Flow::new`].
    fn width_key(&self, own: &'static str, height: f64, first: bool) -> &'static str {
        let given = |v: FloatOrPercent| v.of(height) > 0.0;
        let w = &self.widths;
        let own_width = match own {
            "external_perimeter_extrusion_width" => w.external_perimeter_extrusion_width,
            "perimeter_extrusion_width" => w.perimeter_extrusion_width,
            "infill_extrusion_width" => w.infill_extrusion_width,
            "solid_infill_extrusion_width" => w.solid_infill_extrusion_width,
            _ => w.top_infill_extrusion_width,
        };
        if first && given(w.first_layer_extrusion_width) {
            "first_layer_extrusion_width"
        } else if given(own_width) || !given(w.extrusion_width) {
            own
        } else {
            "extrusion_width"
        }
    }

    fn check_speeds(&self) -> Result<(), SettingsError> {
        let s = &self.speed;
        let solid = s.solid_infill_speed.of(s.infill_speed);
        let speeds = [
            ("perimeter_speed", s.perimeter_speed),
            ("external_perimeter_speed", s.external_perimeter_speed.of(s.perimeter_speed)),
            ("small_perimeter_speed", s.small_perimeter_speed.of(s.perimeter_speed)),
            ("infill_speed", s.infill_speed),
            ("solid_infill_speed", solid),
            ("top_solid_infill_speed", s.top_solid_infill_speed.of(solid)),
            ("first_layer_speed", s.first_layer_speed.of(s.perimeter_speed)),
            ("bridge_speed", s.bridge_speed),
            ("travel_speed", s.travel_speed),
        ];
        if self.perimeters.gap_fill_enabled && !(s.gap_fill_speed > 0.0 && s.gap_fill_speed.is_finite()) {
            let remedy = "give a speed above 0 mm/s or set gap_fill_enabled = 0";
            return Err(self.invalid("gap_fill_speed", "stands still", remedy));
        }
        match speeds.iter().find(|(_, v)| !(*v > 0.0 && v.is_finite())) {
            Some((key, _)) => {
                let problem = "stands still (automatic speed is not supported yet)";
                Err(self.invalid(key, problem, "give a speed above 0 mm/s"))
            }
            None => Ok(()),
        }
    }

    fn check_bed(&self) -> Result<(), SettingsError> {
        let points = &self.printer.bed_shape;
        if points.len() < 3 {
            return Err(self.invalid(
                "bed_shape",
                "fewer than 3 points",
                "give the corners: 0x0,200x0,200x200,0x200",
            ));
        }
        let size = |axis: usize| {
            let of = |p: &[f64; 2]| p.get(axis).copied().unwrap_or_default();
            let (min, max) =
                points.iter().map(of).fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            max - min
        };
        if size(0) > MAX_BED || size(1) > MAX_BED {
            let problem = format!("larger than {MAX_BED} mm");
            return Err(self.invalid("bed_shape", problem, "is the unit millimetres?"));
        }
        // Shoelace formula, twice the area.
        let next = points.iter().cycle().skip(1);
        let area: f64 = points.iter().zip(next).map(|(a, b)| a[0] * b[1] - b[0] * a[1]).sum();
        if area.abs() < 2.0 {
            return Err(self.invalid(
                "bed_shape",
                "encloses less than 1 mm²",
                "give the corners in order around the bed",
            ));
        }
        Ok(())
    }

    fn check_extrusion(&self) -> Result<(), SettingsError> {
        if let LengthOrPixels::Pixels(_) = self.slicing.elefant_foot_compensation {
            let problem = "a filament printer has no pixels";
            return Err(self.invalid("elefant_foot_compensation", problem, "give millimetres"));
        }
        let i = &self.infill;
        let skins = i.top_solid_layers > 0 || i.bottom_solid_layers > 0 || i.solid_infill_every_layers > 0;
        let min_skins = i.top_solid_min_thickness > 0.0 || i.bottom_solid_min_thickness > 0.0;
        if self.perimeters.perimeters == 0 && i.fill_density <= 0.0 && !skins && !min_skins {
            let problem = "with fill_density = 0% and no solid layers nothing would be printed";
            return Err(self.invalid("perimeters", problem, "at least 1, or fill_density above 0"));
        }
        let r = &self.retraction;
        if r.retract_length > 0.0 && r.retract_speed <= 0.0 && !self.printer.use_firmware_retraction {
            return Err(self.invalid(
                "retract_speed",
                "retraction stands still",
                "give a speed above 0 mm/s",
            ));
        }
        if self.printer.use_firmware_retraction && self.printer.gcode_flavor == GcodeFlavor::Reprap {
            let remedy = "set gcode_flavor to your firmware's, or use_firmware_retraction = 0";
            return Err(self.invalid(
                "use_firmware_retraction",
                "the reprap flavor has no G10 and G11",
                remedy,
            ));
        }
        let c = &self.cooling;
        if c.min_fan_speed > c.max_fan_speed {
            let problem = format!("above max_fan_speed = {}", c.max_fan_speed);
            return Err(self.invalid("min_fan_speed", problem, "swap the two or make them equal"));
        }
        for (key, template) in [
            ("before_layer_gcode", &self.output.before_layer_gcode),
            ("layer_gcode", &self.output.layer_gcode),
        ] {
            if !self.printer.use_relative_e_distances && resets_e(template) {
                let problem = "G92 E0 at each layer contradicts absolute E distances";
                return Err(self.invalid(key, problem, "remove it or set use_relative_e_distances = 1"));
            }
        }
        Ok(())
    }

    /// What is allowed and probably not meant.
    fn oddities(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |key: &str, message: &str| {
            warnings.push(Warning::new(key, &self.get(key).unwrap_or_default(), message));
        };
        let (f, o) = (&self.filament, &self.output);
        if f.first_layer_temperature == 0 && !code_in(&o.start_gcode, &["M104", "M109"]) {
            warn("first_layer_temperature", "the nozzle will not be heated; give the filament's temperature");
        } else if f.temperature == 0 && f.first_layer_temperature > 0 {
            warn("temperature", "the nozzle stays at first_layer_temperature after the first layer");
        }
        if self.perimeters.perimeters == 0 {
            warn("perimeters", "the print has no walls");
        }
        if self.printer.use_firmware_retraction && self.retraction.retract_length <= 0.0 {
            warn(
                "use_firmware_retraction",
                "has no effect while retract_length is 0; the firmware sets the length",
            );
        }
        let (i, nozzle, layer) = (&self.infill, self.printer.nozzle_diameter, self.slicing.layer_height);
        if f64::from(i.infill_every_layers) * layer > nozzle * (1.0 + 1e-9) && i.fill_density < 100.0 {
            let most = (nozzle / layer * (1.0 + 1e-9)).floor();
            let text = format!(
                "more than the nozzle of {nozzle} mm can print at once; infill goes {most} layers thick"
            );
            warn("infill_every_layers", &text);
        }
        let thread = nozzle * i.bridge_flow_ratio.sqrt();
        if i.thick_bridges && thread < layer {
            let text =
                format!("bridges are threads {thread:.3} mm thick, thinner than a layer, and may tear");
            warn("bridge_flow_ratio", &text);
        } else if !(0.5..=1.5).contains(&i.bridge_flow_ratio) {
            warn("bridge_flow_ratio", "far from 1; bridges may tear or sag");
        }
        if i.fill_density >= 100.0 && !STRAIGHT.contains(&i.fill_pattern) {
            warn("fill_pattern", "has no effect at fill_density = 100%, where everything is solid infill");
        }
        if i.infill_anchor.of(1.0) > 0.0 && i.infill_anchor_max.of(1.0) <= 0.0 {
            warn("infill_anchor", "has no effect while infill_anchor_max is 0");
        }
        let xy = self.slicing.xy_size_compensation;
        let wall = Flow::new(FlowRole::ExternalPerimeter, layer, false, self).width;
        if xy < -wall {
            warn("xy_size_compensation", "takes more than a wall's width off every side; thin parts vanish");
        }
        let foot = self.slicing.elefant_foot_compensation.nm(0) as f64 / crate::lattice::NM_PER_MM;
        if foot > wall {
            warn(
                "elefant_foot_compensation",
                "takes more than a wall's width off the first layer; thin parts lose it",
            );
        }
        if self.slicing.layer_height > 0.8 * self.printer.nozzle_diameter {
            warn("layer_height", "above 80% of the nozzle's bore; layers may bond badly");
        }
        warnings
    }
}

/// Whether a line of the template resets the extruder: `G92 E0`, comments aside.
fn resets_e(template: &str) -> bool {
    template.lines().any(|line| {
        let mut words = line.split(';').next().unwrap_or_default().split_ascii_whitespace();
        words.next().is_some_and(|w| w.eq_ignore_ascii_case("G92"))
            && words.any(|w| matches!(w.strip_prefix(['E', 'e']).map(str::parse::<f64>), Some(Ok(0.0))))
    })
}

/// Whether a line of the template starts with one of the codes.
fn code_in(template: &str, codes: &[&str]) -> bool {
    template.lines().filter_map(|l| l.split_ascii_whitespace().next()).any(|w| codes.contains(&w))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used)]
mod tests {
    use super::*;

    fn with(values: &[(&str, &str)]) -> Result<Vec<Warning>, String> {
        let mut s = Settings::default();
        for (key, value) in values {
            s.set(key, value).unwrap();
        }
        s.validate().map_err(|e| e.to_string())
    }

    #[test]
    fn the_defaults_are_sound() {
        assert_eq!(with(&[]), Ok(Vec::new()));
    }

    #[test]
    fn contradictions_name_the_setting_to_change() {
        let cases: &[(&[(&str, &str)], &str)] = &[
            (&[("layer_height", "0.5")], "layer_height = 0.5: thicker than the nozzle's bore (0.4 mm)"),
            (&[("first_layer_height", "200%")], "first_layer_height = 200%: thicker than"),
            (
                &[("extrusion_width", "0.2"), ("first_layer_extrusion_width", "0")],
                "extrusion_width = 0.2: gives lines 0.200 mm wide, narrower than the first layer",
            ),
            (
                &[("first_layer_extrusion_width", "50%")],
                "first_layer_extrusion_width = 50%: gives lines 0.175 mm",
            ),
            (&[("infill_extrusion_width", "0.25")], "infill_extrusion_width = 0.25: gives lines"),
            (
                &[("top_infill_extrusion_width", "1000%")],
                "top_infill_extrusion_width = 1000%: gives lines 3.000 mm wide from a nozzle of 0.4 mm; at most 1.200",
            ),
            (&[("perimeter_speed", "0")], "perimeter_speed = 0: stands still"),
            (&[("external_perimeter_speed", "0%")], "external_perimeter_speed = 0%: stands still"),
            (&[("travel_speed", "0")], "travel_speed = 0: stands still"),
            (&[("bridge_speed", "0")], "bridge_speed = 0: stands still"),
            (
                &[("gap_fill_speed", "0")],
                "gap_fill_speed = 0: stands still; give a speed above 0 mm/s or set",
            ),
            (&[("infill_overlap", "0.5")], "infill_overlap = 0.5: infill would reach 0.500 mm into a wall"),
            (
                &[("infill_overlap", "60%"), ("perimeters", "1")],
                "infill_overlap = 60%: infill would reach 0.2",
            ),
            (
                &[("elefant_foot_compensation", "2px")],
                "elefant_foot_compensation = 2px: a filament printer has no",
            ),
            (&[("bed_shape", "0x0,10x10")], "bed_shape = 0x0,10x10: fewer than 3 points"),
            (&[("bed_shape", "0x0,10x10,20x20")], "bed_shape = 0x0,10x10,20x20: encloses less than 1 mm²"),
            (&[("bed_shape", "0x0,9000x0,0x9000")], "bed_shape = 0x0,9000x0,0x9000: larger than 2000 mm"),
            (
                &[
                    ("perimeters", "0"),
                    ("fill_density", "0"),
                    ("top_solid_layers", "0"),
                    ("bottom_solid_layers", "0"),
                ],
                "perimeters = 0: with fill_density = 0% and no solid layers nothing",
            ),
            (&[("retract_speed", "0")], "retract_speed = 0: retraction stands still"),
            (
                &[("use_firmware_retraction", "1")],
                "use_firmware_retraction = 1: the reprap flavor has no G10",
            ),
            (
                &[("min_fan_speed", "90"), ("max_fan_speed", "50")],
                "min_fan_speed = 90: above max_fan_speed = 50",
            ),
            (&[("layer_gcode", "; x\\n g92 X1 e0.0 ; reset")], "layer_gcode = ; x"),
        ];
        for (values, message) in cases {
            let error = with(values).expect_err(message);
            assert!(error.starts_with(message), "{error}");
            assert!(error.contains("; ") && error.lines().count() == 1, "{error}");
        }
    }

    #[test]
    fn their_neighbours_are_allowed() {
        let cases: &[&[(&str, &str)]] = &[
            &[("layer_height", "0.3"), ("nozzle_diameter", "0.4")],
            &[("first_layer_height", "100%")],
            &[("retract_speed", "0"), ("retract_length", "0")],
            &[("use_firmware_retraction", "1"), ("gcode_flavor", "marlin2")],
            &[("layer_gcode", "G92 E0"), ("use_relative_e_distances", "1")],
            &[("layer_gcode", "; G92 E0\\nG92 E1\\nG92 X0")],
            &[("fill_density", "0"), ("travel_speed_z", "0"), ("max_print_height", "0")],
            &[("bed_shape", "0x0,0x200,200x200,200x0")],
            &[("gap_fill_speed", "0"), ("gap_fill_enabled", "0")],
            &[("infill_overlap", "100%")],
            &[("infill_every_layers", "1"), ("layer_height", "0.2")],
            &[("infill_every_layers", "2"), ("layer_height", "0.2")],
            &[("fill_density", "100%"), ("infill_every_layers", "9")],
            &[("fill_density", "100%"), ("fill_pattern", "monotonic")],
            &[("infill_anchor", "0"), ("infill_anchor_max", "0")],
            &[("bridge_flow_ratio", "0.6"), ("thick_bridges", "1")],
            &[("xy_size_compensation", "-0.3"), ("elefant_foot_compensation", "0.3")],
        ];
        for values in cases {
            assert_eq!(with(values), Ok(Vec::new()), "{values:?}");
        }
    }

    #[test]
    fn oddities_are_only_warned_of() {
        let keys = |values| with(values).unwrap().into_iter().map(|w| w.key).collect::<Vec<_>>();
        assert_eq!(keys(&[("first_layer_temperature", "0")]), ["first_layer_temperature"]);
        assert_eq!(keys(&[("first_layer_temperature", "0"), ("start_gcode", "G28\\nM109 S200")]), [""; 0]);
        assert_eq!(keys(&[("temperature", "0")]), ["temperature"]);
        assert_eq!(keys(&[("perimeters", "0")]), ["perimeters"]);
        assert_eq!(keys(&[("layer_height", "0.35")]), ["layer_height"]);
        assert_eq!(keys(&[("infill_every_layers", "3"), ("layer_height", "0.2")]), ["infill_every_layers"]);
        assert_eq!(keys(&[("bridge_flow_ratio", "0.3")]), ["bridge_flow_ratio"]);
        assert_eq!(keys(&[("bridge_flow_ratio", "1.6")]), ["bridge_flow_ratio"]);
        assert_eq!(keys(&[("bridge_flow_ratio", "0.01"), ("thick_bridges", "0")]), ["bridge_flow_ratio"]);
        assert_eq!(keys(&[("fill_density", "100%"), ("fill_pattern", "honeycomb")]), ["fill_pattern"]);
        assert_eq!(keys(&[("infill_anchor_max", "0")]), ["infill_anchor"]);
        assert_eq!(keys(&[("xy_size_compensation", "-2")]), ["xy_size_compensation"]);
        assert_eq!(keys(&[("elefant_foot_compensation", "2")]), ["elefant_foot_compensation"]);
    }
}
