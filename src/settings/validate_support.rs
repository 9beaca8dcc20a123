//! Checks of what is printed beside the part: supports, raft, skirt and brim.

use super::assign::Warning;
use super::flow::{Flow, FlowRole};
use super::load::SettingsError;
use super::types::{FloatOrPercent, Settings};
use super::types_support::{BrimType, DraftShield, SupportStyle};
use super::validate::MAX_WIDTH_IN_NOZZLES;

/// Clear distances to the part beside above this support little \[mm\].
const FAR_BESIDE: f64 = 3.0;
/// The part sags where it is more than this many layers above its supports.
const FAR_ABOVE: f64 = 2.5;

impl Settings {
    /// Thickness and width of supports against the nozzle, and their speeds; nothing of it matters where none
    /// are printed.
    pub(super) fn check_supports(&self) -> Result<(), SettingsError> {
        if !self.has_supports() {
            return Ok(());
        }
        self.check_support_layers()?;
        self.check_support_widths()?;
        let s = &self.speed;
        let speeds = [
            ("support_material_speed", s.support_material_speed),
            (
                "support_material_interface_speed",
                s.support_material_interface_speed.of(s.support_material_speed),
            ),
        ];
        match speeds.iter().find(|(_, v)| !(*v > 0.0 && v.is_finite())) {
            Some((key, _)) => {
                Err(self.invalid(key, "supports would stand still", "give a speed above 0 mm/s"))
            }
            None => Ok(()),
        }
    }

    fn check_support_layers(&self) -> Result<(), SettingsError> {
        let (key, nozzle) = ("support_material_layer_height", self.printer.nozzle_diameter);
        let height = self.support.support_material_layer_height;
        if height > nozzle {
            let problem = format!("thicker than the nozzle's bore ({nozzle} mm), so layers would not bond");
            return Err(self.invalid(key, problem, format!("at most {nozzle}, or 0 for max_layer_height")));
        }
        let [least, _] = self.adaptive_heights();
        let least = least.min(self.slicing.layer_height);
        if height > 0.0 && height < least {
            let problem = format!("thinner than the thinnest layer there is ({least} mm)");
            return Err(self.invalid(key, problem, format!("at least {least}, or 0 for max_layer_height")));
        }
        Ok(())
    }

    /// Thickness of the thickest layers of support or raft \[mm\].
    fn thickest_support(&self) -> f64 {
        let s = &self.support;
        let columns = s.support_material || s.support_material_enforce_layers > 0;
        let [_, most] = self.adaptive_heights();
        let most = if s.support_material_layer_height > 0.0 { s.support_material_layer_height } else { most };
        let own = if columns && !s.support_material_synchronize_layers { most } else { 0.0 };
        let raft = if self.adhesion.raft_layers > 1 { self.raft_layer_height() } else { 0.0 };
        let most = own.max(raft).max(self.slicing.layer_height).min(self.printer.nozzle_diameter);
        // Three quarters of a bore have digits that nobody wrote.
        (most * 1e6).round() / 1e6
    }

    fn check_support_widths(&self) -> Result<(), SettingsError> {
        let most = MAX_WIDTH_IN_NOZZLES * self.printer.nozzle_diameter;
        for (first, height) in [(true, self.first_height()), (false, self.thickest_support())] {
            let flow = Flow::new(FlowRole::Support, height, first, self);
            let key = self.support_width_key(height, first);
            if !(flow.width >= height && flow.spacing() > 0.0) {
                let problem = format!(
                    "gives supports lines {:.3} mm wide, narrower than their layers of up to {height} mm",
                    flow.width
                );
                let remedy = format!(
                    "at least {height}, 0 for automatic, or thinner layers by support_material_layer_height"
                );
                return Err(self.invalid(key, problem, remedy));
            }
            if flow.width > most {
                let nozzle = self.printer.nozzle_diameter;
                let problem =
                    format!("gives supports lines {:.3} mm wide from a nozzle of {nozzle} mm", flow.width);
                return Err(self.invalid(key, problem, format!("at most {most:.3}, or 0 for automatic")));
            }
        }
        Ok(())
    }

    /// The key that decides the width of supports: the order of [`Flow::new`].
    fn support_width_key(&self, height: f64, first: bool) -> &'static str {
        let (w, own) = (&self.widths, "support_material_extrusion_width");
        let given = |v: FloatOrPercent| v.of(height) > 0.0;
        if first && given(w.first_layer_extrusion_width) {
            "first_layer_extrusion_width"
        } else if given(w.support_material_extrusion_width) || !given(w.extrusion_width) {
            own
        } else {
            "extrusion_width"
        }
    }

    /// What of supports is allowed and probably not meant.
    pub(super) fn support_oddities(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if !self.has_supports() {
            return warnings;
        }
        let mut warn = |key: &str, message: &str| {
            warnings.push(Warning::new(key, &self.get(key).unwrap_or_default(), message));
        };
        let (s, layer) = (&self.support, self.slicing.layer_height);
        let columns = s.support_material || s.support_material_enforce_layers > 0;
        let wall = Flow::new(FlowRole::ExternalPerimeter, layer, false, self).width;
        let line = Flow::new(FlowRole::Support, layer, false, self).width;
        if columns {
            let beside = s.support_material_xy_spacing.of(wall);
            if beside > FAR_BESIDE {
                let text = format!(
                    "keeps supports {beside:.2} mm away from walls; what hangs there is printed in air"
                );
                warn("support_material_xy_spacing", &text);
            }
            if s.support_material_contact_distance > FAR_ABOVE * layer {
                let text = format!("more than {FAR_ABOVE} layers of {layer} mm; what is supported will sag");
                warn("support_material_contact_distance", &text);
            }
            if s.support_material_threshold >= 89.0 {
                warn(
                    "support_material_threshold",
                    "supports all walls that are not upright; 30 to 60 is common",
                );
            }
        }
        if columns && s.support_material_style == SupportStyle::Organic {
            if s.support_tree_branch_diameter < line {
                let text = format!("thinner than a line of {line:.2} mm; branches cannot be printed");
                warn("support_tree_branch_diameter", &text);
            }
            if s.support_tree_angle <= 0.0 {
                warn("support_tree_angle", "branches grow straight up and cannot meet");
            }
        } else if columns && s.support_material_spacing > 10.0 {
            warn("support_material_spacing", "lines this far apart hold little and fall over");
        }
        warnings
    }

    /// What of raft, skirt and brim is allowed and probably not meant.
    pub(super) fn adhesion_oddities(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        let mut warn = |key: &str, message: &str| {
            warnings.push(Warning::new(key, &self.get(key).unwrap_or_default(), message));
        };
        let (a, layer) = (&self.adhesion, self.slicing.layer_height);
        let flow = Flow::new(FlowRole::Skirt, self.first_height(), true, self);
        let brim = a.brim_width > 0.0 && a.brim_type != BrimType::NoBrim;
        if brim && a.raft_layers > 0 {
            warn("brim_width", "has no effect on a raft");
        } else if brim && a.brim_width < flow.spacing() && !a.brim_ears {
            let text = format!("narrower than a line of {:.2} mm, so there is no brim", flow.width);
            warn("brim_width", &text);
        } else if brim && a.brim_width > 0.5 * self.bed_size() {
            warn("brim_width", "reaches across the whole bed");
        }
        if brim && a.raft_layers == 0 && a.brim_separation > 1.0 {
            warn("brim_separation", "so far from the part a brim does not hold it");
        }
        if a.brim_ears && !brim {
            warn("brim_ears", "has no effect without brim_width and brim_type");
        }
        if a.draft_shield != DraftShield::Disabled && a.skirts == 0 {
            warn("draft_shield", "has no effect while skirts is 0");
        }
        if a.raft_layers > 0 {
            if a.raft_contact_distance > FAR_ABOVE * layer && !self.has_soluble_supports() {
                let text =
                    format!("more than {FAR_ABOVE} layers of {layer} mm; the part may come off its raft");
                warn("raft_contact_distance", &text);
            }
            if f64::from(a.raft_layers) * self.raft_layer_height() > 10.0 {
                warn("raft_layers", "makes a raft more than 10 mm high");
            }
        }
        warnings
    }

    /// The bed's shorter side \[mm\].
    fn bed_size(&self) -> f64 {
        let extent = |axis: usize| {
            let of = |p: &[f64; 2]| p.get(axis).copied().unwrap_or_default();
            let points = self.printer.bed_shape.iter().map(of);
            let (low, high) = points.fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
            high - low
        };
        extent(0).min(extent(1))
    }
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

    /// With supports.
    fn supported(values: &[(&str, &str)]) -> Result<Vec<Warning>, String> {
        with(&[&[("support_material", "1")], values].concat())
    }

    #[test]
    fn contradictions_name_the_setting_to_change() {
        let cases: &[(&[(&str, &str)], &str)] = &[
            (
                &[("support_material_layer_height", "0.5")],
                "support_material_layer_height = 0.5: thicker than the nozzle's bore (0.4 mm)",
            ),
            (
                &[("support_material_layer_height", "0.005")],
                "support_material_layer_height = 0.005: thinner than the thinnest layer there is (0.07 mm)",
            ),
            (
                &[("support_material_extrusion_width", "0.25")],
                "support_material_extrusion_width = 0.25: gives supports lines 0.250 mm wide, narrower than their layers of up to 0.3",
            ),
            (
                &[("support_material_extrusion_width", "1.3")],
                "support_material_extrusion_width = 1.3: gives supports lines 1.300 mm wide from a nozzle of 0.4 mm; at most 1.200",
            ),
            (&[("support_material_speed", "0")], "support_material_speed = 0: supports would stand still"),
            (
                &[("support_material_interface_speed", "0%")],
                "support_material_interface_speed = 0%: supports would stand still",
            ),
        ];
        for (values, message) in cases {
            let error = supported(values).expect_err(message);
            assert!(error.starts_with(message), "{error}");
            assert!(error.contains("; ") && error.lines().count() == 1, "{error}");
            // What is not printed cannot be wrong.
            assert_eq!(with(values), Ok(Vec::new()), "{values:?}");
            assert!(with(&[&[("raft_layers", "2")], *values].concat()).is_err());
        }
    }

    #[test]
    fn their_neighbours_are_allowed() {
        let cases: &[&[(&str, &str)]] = &[
            &[],
            &[("support_material_layer_height", "0.4")],
            &[("support_material_extrusion_width", "0.3")],
            &[
                ("support_material_extrusion_width", "0.25"),
                ("support_material_layer_height", "0.2"),
                ("layer_height", "0.2"),
            ],
            &[("support_material_extrusion_width", "0.4"), ("support_material_synchronize_layers", "1")],
            &[("support_material_contact_distance", "0")],
            &[("support_material_style", "organic"), ("support_material_pattern", "honeycomb")],
            &[("brim_width", "5"), ("brim_ears", "1"), ("skirts", "2"), ("draft_shield", "enabled")],
            &[("raft_layers", "3"), ("raft_contact_distance", "0.2")],
        ];
        for values in cases {
            assert_eq!(supported(values), Ok(Vec::new()), "{values:?}");
        }
    }

    #[test]
    fn oddities_are_only_warned_of() {
        let keys = |values: &[(&str, &str)]| {
            supported(values).unwrap().into_iter().map(|w| w.key).collect::<Vec<_>>()
        };
        assert_eq!(keys(&[("support_material_xy_spacing", "900%")]), ["support_material_xy_spacing"]);
        assert_eq!(
            keys(&[("support_material_contact_distance", "1")]),
            ["support_material_contact_distance"]
        );
        assert_eq!(keys(&[("support_material_threshold", "90")]), ["support_material_threshold"]);
        assert_eq!(keys(&[("support_material_spacing", "50")]), ["support_material_spacing"]);
        let organic = ("support_material_style", "organic");
        assert_eq!(keys(&[organic, ("support_material_spacing", "50")]), [""; 0]);
        assert_eq!(
            keys(&[organic, ("support_tree_branch_diameter", "0.2")]),
            ["support_tree_branch_diameter"]
        );
        assert_eq!(keys(&[organic, ("support_tree_angle", "0")]), ["support_tree_angle"]);
        assert_eq!(keys(&[("brim_width", "5"), ("raft_layers", "3")]), ["brim_width"]);
        assert_eq!(keys(&[("brim_width", "0.2")]), ["brim_width"]);
        assert_eq!(keys(&[("brim_width", "200")]), ["brim_width"]);
        assert_eq!(keys(&[("brim_width", "5"), ("brim_separation", "2")]), ["brim_separation"]);
        assert_eq!(keys(&[("brim_ears", "1")]), ["brim_ears"]);
        assert_eq!(keys(&[("brim_ears", "1"), ("brim_width", "5"), ("brim_type", "no_brim")]), ["brim_ears"]);
        assert_eq!(keys(&[("draft_shield", "limited"), ("skirts", "0")]), ["draft_shield"]);
        assert_eq!(keys(&[("raft_layers", "3"), ("raft_contact_distance", "1")]), ["raft_contact_distance"]);
        assert_eq!(keys(&[("raft_layers", "99")]), ["raft_layers"]);
    }
}
