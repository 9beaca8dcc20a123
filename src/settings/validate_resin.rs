//! Checks of a resin printer's settings against each other, after all values have been read.

use super::assign::Warning;
use super::load::SettingsError;
use super::types::Settings;
use super::types_resin::ExposureSettings;

/// Light does not cure deeper than this \[mm\], whatever the resin.
const MAX_LAYER: f64 = 0.5;
/// Pixels of panels in use are 14 to 100 µm apart; beyond these bounds a unit is wrong \[mm\].
const PITCH: [f64; 2] = [0.005, 0.5];

impl Settings {
    /// Checks what no range of a single value can: the panel, layers, exposures, lifts.
    ///
    /// # Errors
    /// [`SettingsError::Invalid`] with the first contradiction.
    pub fn validate_resin(&self) -> Result<Vec<Warning>, SettingsError> {
        self.check_panel()?;
        self.check_resin_layers()?;
        self.check_exposure()?;
        if !self.lift.tilt {
            self.check_lifts()?;
        }
        Ok(self.resin_oddities())
    }

    /// The extension (no dot) of an output: the one that its name has, or else that of the printer's files.
    ///
    /// # Errors
    /// [`SettingsError::Invalid`] where that asks for the printer's own files and they cannot be written.
    pub fn output_extension<'a>(&self, given: Option<&'a str>) -> Result<&'a str, SettingsError> {
        let container = self.machine.container;
        let own = given.is_none_or(|e| e.eq_ignore_ascii_case(container.extension()));
        if own && !container.is_written() {
            let remedy = "name an output ending in .goo or .zip and convert it with the vendor's program or UVtools, \
                          or set container to another kind of files that the machine takes";
            let kind = if container.extension() == container.name() { "" } else { "encrypted " };
            let problem =
                format!("the printer reads {kind}.{} files, which cannot be written", container.extension());
            return Err(self.invalid("container", problem, remedy));
        }
        Ok(given.unwrap_or(container.extension()))
    }

    fn check_panel(&self) -> Result<(), SettingsError> {
        let d = &self.display;
        let sides = [
            ("display_pixels_x", d.display_pixels_x, "display_width", d.display_width),
            ("display_pixels_y", d.display_pixels_y, "display_height", d.display_height),
        ];
        let remedy = "name a printer with --printer (`microtome printers` lists them), or give all of display_pixels_x, \
                      display_pixels_y, display_width and display_height";
        for (pixels_key, pixels, length_key, length) in sides {
            if pixels == 0 {
                return Err(self.invalid(pixels_key, "the panel is unknown", remedy));
            }
            if !positive(length) {
                return Err(self.invalid(length_key, "the panel's size is unknown", remedy));
            }
            let pitch = length / f64::from(pixels);
            if !(PITCH[0]..=PITCH[1]).contains(&pitch) {
                let problem =
                    format!("puts {pixels} pixels {:.3} um apart, which no panel does", 1000.0 * pitch);
                let remedy = format!(
                    "lengths are in mm; correct it or {pixels_key}, so that pixels are 5 to 500 um apart"
                );
                return Err(self.invalid(length_key, problem, remedy));
            }
        }
        if u64::from(d.display_pixels_x) * u64::from(d.display_pixels_y) > u64::from(u32::MAX) {
            let problem = format!("with display_pixels_y = {} 2^32 pixels or more", d.display_pixels_y);
            return Err(self.invalid("display_pixels_x", problem, "give the pixels of one panel"));
        }
        Ok(())
    }

    fn check_resin_layers(&self) -> Result<(), SettingsError> {
        let heights =
            [("layer_height", self.slicing.layer_height), ("initial_layer_height", self.initial_height())];
        for (key, height) in heights {
            if !positive(height) {
                return Err(self.invalid(
                    key,
                    "the layer has no thickness",
                    "give a height above 0, such as 0.05",
                ));
            }
            if height > MAX_LAYER {
                let problem = "thicker than light cures through resin";
                return Err(self.invalid(key, problem, format!("at most {MAX_LAYER}; 0.05 is common")));
            }
        }
        Ok(())
    }

    fn check_exposure(&self) -> Result<(), SettingsError> {
        let e = &self.exposure;
        let bottom = e.bottom_and_transition().0 > 0;
        for (key, time, counts) in [
            ("exposure_time", e.exposure_time, true),
            ("initial_exposure_time", e.initial_exposure_time, bottom),
        ] {
            if counts && !positive(time) {
                return Err(self.invalid(
                    key,
                    "without light nothing hardens",
                    "give the resin maker's exposure in s",
                ));
            }
        }
        for (key, light, counts) in [("light", e.light, true), ("bottom_light", e.bottom_light, bottom)] {
            if counts && light == 0 {
                return Err(self.invalid(
                    key,
                    "without light nothing hardens",
                    "give 1 to 255; 255 is full light",
                ));
            }
        }
        Ok(())
    }

    fn check_lifts(&self) -> Result<(), SettingsError> {
        let l = &self.lift;
        let normal = [
            ("lift_speed", l.lift_height, l.lift_speed),
            ("lift_speed2", l.lift_height2, l.lift_speed2),
            (
                "lift_retract_speed",
                l.lift_height + l.lift_height2 - l.lift_retract_height2,
                l.lift_retract_speed,
            ),
            ("lift_retract_speed2", l.lift_retract_height2, l.lift_retract_speed2),
        ];
        let whole = l.bottom_lift_height + l.bottom_lift_height2;
        let bottom = [
            ("bottom_lift_speed", l.bottom_lift_height, l.bottom_lift_speed),
            ("bottom_lift_speed2", l.bottom_lift_height2, l.bottom_lift_speed2),
            ("bottom_lift_retract_speed", whole - l.bottom_lift_retract_height2, l.bottom_lift_retract_speed),
            ("bottom_lift_retract_speed2", l.bottom_lift_retract_height2, l.bottom_lift_retract_speed2),
        ];
        for (key, retract2, whole) in [
            ("lift_retract_height2", l.lift_retract_height2, l.lift_height + l.lift_height2),
            ("bottom_lift_retract_height2", l.bottom_lift_retract_height2, whole),
        ] {
            if retract2 > whole {
                let problem = format!("goes further back than the plate was lifted ({whole} mm)");
                return Err(self.invalid(key, problem, format!("at most {whole}")));
            }
        }
        for (key, distance, speed) in normal.into_iter().chain(bottom) {
            if distance > 0.0 && !positive(speed) {
                let problem = format!("the plate stands still with {distance} mm to go");
                return Err(self.invalid(key, problem, "give a speed above 0 mm/min"));
            }
        }
        Ok(())
    }

    /// What is allowed and probably not meant.
    fn resin_oddities(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |key: &str, message: &str| {
            warnings.push(Warning::new(key, &self.get(key).unwrap_or_default(), message));
        };
        let (e, l, i) = (&self.exposure, &self.lift, &self.image);
        if self.slicing.layer_height > 0.2 {
            warn("layer_height", "above 0.2 mm; few resins harden that deep");
        }
        if e.faded_layers > 0 {
            let unset = ExposureSettings::default();
            for (key, layers, unset) in [
                ("bottom_layers", e.bottom_layers, unset.bottom_layers),
                ("transition_layers", e.transition_layers, unset.transition_layers),
            ] {
                if layers > 0 && layers != unset {
                    warn(key, "has no effect while faded_layers is above 0; set one of them to 0");
                }
            }
        }
        if e.bottom_and_transition().0 > 0 && e.initial_exposure_time < e.exposure_time {
            warn(
                "initial_exposure_time",
                "shorter than exposure_time; bottom layers may not stick to the plate",
            );
        }
        if !l.tilt {
            for (key, lift) in [
                ("lift_height", l.lift_height + l.lift_height2),
                ("bottom_lift_height", l.bottom_lift_height + l.bottom_lift_height2),
            ] {
                if !positive(lift) {
                    warn(key, "the plate never lifts, so the layer is not parted from the film");
                }
            }
        }
        if i.anti_aliasing == 1 && i.minimum_grey > 0 {
            warn("minimum_grey", "has no effect without anti_aliasing");
        }
        if i.anti_aliasing > 1 && i.gamma_correction <= 0.0 {
            warn("gamma_correction", "leaves no greys of anti_aliasing");
        }
        warnings
    }
}

/// False for NaN too.
fn positive(value: f64) -> bool {
    value > 0.0
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used)]
mod tests {
    use super::*;

    fn saturn(values: &[(&str, &str)]) -> Settings {
        let mut s = Settings::resin();
        super::super::printers::find("elegoo-saturn-3-ultra").unwrap().apply(&mut s).unwrap();
        for (key, value) in values {
            s.set(key, value).unwrap();
        }
        s
    }

    fn with(values: &[(&str, &str)]) -> Result<Vec<Warning>, String> {
        saturn(values).validate_resin().map_err(|e| e.to_string())
    }

    #[test]
    fn a_preset_is_sound_and_the_bare_defaults_lack_a_panel() {
        assert_eq!(with(&[]), Ok(Vec::new()));
        let error = Settings::resin().validate_resin().unwrap_err().to_string();
        assert!(error.starts_with("display_pixels_x = 0: the panel is unknown; name a printer"), "{error}");
    }

    #[test]
    fn contradictions_name_the_setting_to_change() {
        let cases: &[(&[(&str, &str)], &str)] = &[
            (&[("display_pixels_y", "0")], "display_pixels_y = 0: the panel is unknown"),
            (&[("display_height", "0")], "display_height = 0: the panel's size is unknown"),
            (&[("display_width", "21.888")], "display_width = 21.888: puts 11520 pixels 1.900 um apart"),
            (&[("display_pixels_y", "200")], "display_height = 122.88: puts 200 pixels 614.400 um apart"),
            (&[("layer_height", "0.6")], "layer_height = 0.6: thicker than light"),
            (&[("initial_layer_height", "5")], "initial_layer_height = 5: thicker than light"),
            (&[("exposure_time", "0")], "exposure_time = 0: without light"),
            (&[("initial_exposure_time", "0")], "initial_exposure_time = 0: without light"),
            (&[("light", "0")], "light = 0: without light"),
            (&[("bottom_light", "0")], "bottom_light = 0: without light"),
            (&[("lift_speed", "0")], "lift_speed = 0: the plate stands still with 6 mm to go"),
            (&[("lift_height2", "3")], "lift_speed2 = 0: the plate stands still with 3 mm"),
            (&[("lift_retract_speed", "0")], "lift_retract_speed = 0: the plate stands still with 6 mm"),
            (&[("lift_retract_height2", "2")], "lift_retract_speed2 = 0: the plate stands still with 2 mm"),
            (&[("lift_retract_height2", "7")], "lift_retract_height2 = 7: goes further back"),
            (&[("bottom_lift_retract_height2", "7")], "bottom_lift_retract_height2 = 7: goes further back"),
            (&[("bottom_lift_speed", "0")], "bottom_lift_speed = 0: the plate stands still"),
        ];
        for (values, message) in cases {
            let error = with(values).expect_err(message);
            assert!(error.starts_with(message), "{error}");
            assert!(error.contains("; ") && error.lines().count() == 1, "{error}");
        }
        // No value of a key reaches 2^32 pixels; fields do.
        let mut s = saturn(&[("display_width", "2000"), ("display_height", "1000")]);
        (s.display.display_pixels_x, s.display.display_pixels_y) = (65_535, 65_535);
        assert_eq!(s.validate_resin().map_err(|e| e.to_string()), Ok(Vec::new()));
        (s.display.display_pixels_x, s.display.display_pixels_y) = (65_536, 65_536);
        let error = s.validate_resin().unwrap_err().to_string();
        assert!(
            error.starts_with("display_pixels_x = 65536: with display_pixels_y = 65536 2^32 pixels"),
            "{error}"
        );
    }

    #[test]
    fn their_neighbours_are_allowed() {
        let cases: &[&[(&str, &str)]] = &[
            &[("layer_height", "0.2"), ("initial_layer_height", "0.5")],
            &[("bottom_layers", "0"), ("initial_exposure_time", "0"), ("bottom_light", "0")],
            &[("lift_retract_height2", "6"), ("lift_retract_speed2", "40"), ("lift_retract_speed", "0")],
            &[("lift_height2", "3"), ("lift_speed2", "180")],
            &[("tilt", "1"), ("lift_speed", "0"), ("lift_height", "0")],
            &[("anti_aliasing", "8"), ("minimum_grey", "60"), ("gamma_correction", "0.5")],
            &[("faded_layers", "10"), ("bottom_layers", "0")],
        ];
        for values in cases {
            assert_eq!(with(values), Ok(Vec::new()), "{values:?}");
        }
    }

    #[test]
    fn oddities_are_only_warned_of() {
        let keys = |values| with(values).unwrap().into_iter().map(|w| w.key).collect::<Vec<_>>();
        assert_eq!(keys(&[("layer_height", "0.25")]), ["layer_height"]);
        assert_eq!(keys(&[("faded_layers", "10"), ("transition_layers", "2")]), ["transition_layers"]);
        assert_eq!(keys(&[("initial_exposure_time", "1")]), ["initial_exposure_time"]);
        assert_eq!(
            keys(&[("lift_height", "0"), ("bottom_lift_height", "0")]),
            ["lift_height", "bottom_lift_height"]
        );
        assert_eq!(keys(&[("minimum_grey", "9")]), ["minimum_grey"]);
        assert_eq!(keys(&[("anti_aliasing", "2"), ("gamma_correction", "0")]), ["gamma_correction"]);
    }

    #[test]
    fn an_output_has_the_printers_extension_or_its_own() {
        let s = saturn(&[]);
        assert_eq!(s.output_extension(None).unwrap(), "goo");
        assert_eq!(s.output_extension(Some("CTB")).unwrap(), "CTB");
        for (container, files) in [("encrypted-ctb", "encrypted .ctb files"), ("pm5s", "reads .pm5s files")] {
            let locked = saturn(&[("container", container)]);
            let own = locked.machine.container.extension();
            for extension in [None, Some(own), Some(own.to_ascii_uppercase().as_str())] {
                let error = locked.output_extension(extension).unwrap_err().to_string();
                assert!(
                    error.starts_with(&format!("container = {container}: the printer reads ")),
                    "{error}"
                );
                assert!(error.contains(files) && error.contains(".goo or .zip"), "{error}");
                assert_eq!(error.lines().count(), 1, "{error}");
            }
            assert_eq!(locked.output_extension(Some("goo")).unwrap(), "goo");
        }
    }
}
