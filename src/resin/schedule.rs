//! Settings → when each layer is lit, and how the plate moves behind it.
//!
//! Layer i of `bottom_layers` has the full first exposure; over the `transition_layers` behind them it
//! falls linearly: of T layers the k-th, counted from 1, has `initial - (initial - normal) k / (T + 1)`.
//! PrusaSlicer's `faded_layers = F` means 3 bottom layers and F transition layers: the way in which it
//! estimates the print time of an SL1, whose firmware lights the first three layers alike as well. Motion
//! and light change behind the bottom layers.

use super::{LayerInfo, Motion};
use crate::lattice::mm;
use crate::mask::Panel;
use crate::settings::{FloatOrPercent, LiftSettings, Settings, SlicingSettings};
use crate::slice::planes::{self, LayerZ, PlaneError};

/// What depends on a layer's number, and the time that it takes.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule {
    /// Exposure of normal layers \[s\].
    pub exposure: f64,
    /// Exposure of bottom layers \[s\].
    pub bottom_exposure: f64,
    /// Number of bottom layers.
    pub bottom_layers: u32,
    /// Number of transition layers behind them.
    pub transition_layers: u32,
    /// Motion behind normal layers; none where the vat tilts.
    pub motion: Motion,
    /// Motion behind bottom layers; none where the vat tilts.
    pub bottom_motion: Motion,
    /// Light of normal layers.
    pub light: u8,
    /// Light of bottom layers.
    pub bottom_light: u8,
    /// The tilt in the place of a lift.
    tilt: Option<Tilt>,
}

/// Time that the plate of a machine with a tilting vat takes to move \[s/mm\]: PrusaSlicer's figure, as
/// the print times that version 2.5.0 writes show.
const PLATE_S_PER_MM: f64 = 5.0;

/// A vat that tilts: faster behind small layers. Times \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Tilt {
    fast: f64,
    slow: f64,
    /// A layer with more than this is large \[mm²\].
    large_mm2: f64,
}

impl Schedule {
    /// The schedule of settings that passed [`Settings::validate_resin`]; `panel` is theirs.
    pub fn new(settings: &Settings, panel: &Panel) -> Self {
        let (e, l) = (&settings.exposure, &settings.lift);
        let (bottom_layers, transition_layers) = e.bottom_and_transition();
        let panel_mm2 = f64::from(panel.pixels()) * panel.pixel_mm2();
        let light = |v: u32| u8::try_from(v).unwrap_or(u8::MAX);
        let rests = |motion: Motion| Motion {
            rest_before_lift: motion.rest_before_lift,
            rest_after_lift: motion.rest_after_lift,
            rest_after_retract: motion.rest_after_retract,
            ..Motion::default()
        };
        let in_force = |motion| if l.tilt { rests(motion) } else { motion };
        Self {
            exposure: e.exposure_time,
            bottom_exposure: e.initial_exposure_time,
            bottom_layers,
            transition_layers,
            motion: in_force(normal_motion(l)),
            bottom_motion: in_force(bottom_motion(l)),
            light: light(e.light),
            bottom_light: light(e.bottom_light),
            tilt: l.tilt.then_some(Tilt {
                fast: l.fast_tilt_time,
                slow: l.slow_tilt_time,
                large_mm2: panel_mm2 * l.area_fill / 100.0,
            }),
        }
    }

    /// Exposure of layer `index`, counted from 0 \[s\], rounded to milliseconds.
    pub fn exposure_of(&self, index: u32) -> f64 {
        if index < self.bottom_layers {
            return self.bottom_exposure;
        }
        let step = u64::from(index - self.bottom_layers) + 1;
        if step > u64::from(self.transition_layers) {
            return self.exposure;
        }
        let share = step as f64 / (f64::from(self.transition_layers) + 1.0);
        let exposure = self.bottom_exposure + (self.exposure - self.bottom_exposure) * share;
        (exposure * 1000.0).round() / 1000.0
    }

    /// What is known of layer `index` before its mask: `lit` and `area_mm2` are 0.
    pub fn layer(&self, index: u32, layer: &LayerZ) -> LayerInfo {
        let bottom = index < self.bottom_layers;
        LayerInfo {
            index,
            z: mm(layer.print_z),
            height: mm(layer.height),
            exposure: self.exposure_of(index),
            motion: if bottom { self.bottom_motion } else { self.motion },
            light: if bottom { self.bottom_light } else { self.light },
            lit: 0,
            area_mm2: 0.0,
        }
    }

    /// Time from the beginning of a layer's exposure to that of the next \[s\]; reads its `height`,
    /// `exposure`, `motion` and `area_mm2`. Accelerations are unknown, so it is a lower bound, as vendors' own
    /// figures are.
    pub fn time(&self, layer: &LayerInfo) -> f64 {
        let m = &layer.motion;
        let rests = m.rest_before_lift + m.rest_after_lift + m.rest_after_retract;
        let parting = match self.tilt {
            Some(tilt) => {
                let large = layer.area_mm2 > tilt.large_mm2;
                PLATE_S_PER_MM * layer.height + if large { tilt.slow } else { tilt.fast }
            }
            None => {
                let stages = [
                    (m.lift, m.lift_speed),
                    (m.lift2, m.lift2_speed),
                    (m.retract(), m.retract_speed),
                    (m.retract2, m.retract2_speed),
                ];
                // A stage without a length takes no time, whatever its speed.
                stages.iter().filter(|(d, v)| *d > 0.0 && *v > 0.0).map(|(d, v)| 60.0 * d / v).sum()
            }
        };
        layer.exposure + rests + parting
    }
}

/// The layers of a part that reaches from `z_min` to `z_max` \[nm\] above the plate: the first
/// `initial_layer_height` thick and the others `layer_height`, each cut at its middle; see
/// [`planes::layers`].
///
/// # Errors
/// [`PlaneError`]: no layer, too many, or beyond the lattice.
pub fn layers(z_min: i64, z_max: i64, settings: &Settings) -> Result<Vec<LayerZ>, PlaneError> {
    let heights = SlicingSettings {
        layer_height: settings.slicing.layer_height,
        first_layer_height: FloatOrPercent::Float(settings.initial_height()),
        ..SlicingSettings::default()
    };
    planes::layers(z_min, z_max, &heights).map_err(|e| match e {
        PlaneError::Height { key: "first_layer_height", height_mm } => {
            PlaneError::Height { key: "initial_layer_height", height_mm }
        }
        other => other,
    })
}

fn normal_motion(l: &LiftSettings) -> Motion {
    Motion {
        lift: l.lift_height,
        lift_speed: l.lift_speed,
        lift2: l.lift_height2,
        lift2_speed: l.lift_speed2,
        retract_speed: l.lift_retract_speed,
        retract2: l.lift_retract_height2,
        retract2_speed: l.lift_retract_speed2,
        rest_before_lift: l.rest_before_lift,
        rest_after_lift: l.rest_after_lift,
        rest_after_retract: l.rest_after_retract,
    }
}

fn bottom_motion(l: &LiftSettings) -> Motion {
    Motion {
        lift: l.bottom_lift_height,
        lift_speed: l.bottom_lift_speed,
        lift2: l.bottom_lift_height2,
        lift2_speed: l.bottom_lift_speed2,
        retract_speed: l.bottom_lift_retract_speed,
        retract2: l.bottom_lift_retract_height2,
        retract2_speed: l.bottom_lift_retract_speed2,
        rest_before_lift: l.bottom_rest_before_lift,
        rest_after_lift: l.bottom_rest_after_lift,
        rest_after_retract: l.bottom_rest_after_retract,
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::super::machine;
    use super::*;
    use crate::settings::printers;

    fn schedule(printer: &str, values: &[(&str, &str)]) -> Schedule {
        let mut s = printers::find(printer).unwrap().settings().unwrap();
        for (key, value) in values {
            s.set(key, value).unwrap();
        }
        s.validate_resin().unwrap();
        Schedule::new(&s, &machine::panel(&s))
    }

    const LAYER: LayerZ = LayerZ { slice_z: 75_000, print_z: 100_000, height: 50_000 };

    #[test]
    fn bottom_layers_then_a_linear_fall() {
        let values = [
            ("exposure_time", "2"),
            ("initial_exposure_time", "30"),
            ("bottom_layers", "2"),
            ("transition_layers", "3"),
            ("bottom_light", "200"),
        ];
        let s = schedule("elegoo-saturn-3-ultra", &values);
        let exposures: Vec<f64> = (0..7).map(|i| s.exposure_of(i)).collect();
        assert_eq!(exposures, [30.0, 30.0, 23.0, 16.0, 9.0, 2.0, 2.0]);
        assert_eq!(s.exposure_of(u32::MAX), 2.0);
        let lights: Vec<u8> = (0..4).map(|i| s.layer(i, &LAYER).light).collect();
        assert_eq!(lights, [200, 200, 255, 255]);
    }

    #[test]
    fn faded_layers_are_prusaslicers() {
        let s = schedule("prusa-sl1", &[("faded_layers", "8"), ("initial_exposure_time", "35")]);
        let exposures: Vec<f64> = (0..13).map(|i| s.exposure_of(i)).collect();
        assert_eq!(exposures, [35.0, 35.0, 35.0, 32.0, 29.0, 26.0, 23.0, 20.0, 17.0, 14.0, 11.0, 8.0, 8.0]);
        let none = schedule("prusa-sl1", &[("faded_layers", "0")]);
        assert_eq!(none.exposure_of(0), 8.0);
    }

    #[test]
    fn a_layer_says_what_the_settings_say() {
        let s = schedule("elegoo-mars-4", &[("bottom_lift_height", "8"), ("rest_after_lift", "0.5")]);
        let (bottom, normal) = (s.layer(4, &LAYER), s.layer(5, &LAYER));
        assert_eq!((bottom.index, bottom.z, bottom.height, bottom.exposure), (4, 0.1, 0.05, 30.0));
        assert_eq!((bottom.motion.lift, bottom.motion.rest_after_lift), (8.0, 0.0));
        assert_eq!((normal.motion.lift, normal.motion.rest_after_lift, normal.exposure), (6.0, 0.5, 2.5));
        assert_eq!((normal.lit, normal.area_mm2), (0, 0.0));
    }

    #[test]
    fn every_key_of_a_motion_reaches_its_field() {
        let keys = [
            "lift_height",
            "lift_speed",
            "lift_height2",
            "lift_speed2",
            "lift_retract_speed",
            "lift_retract_height2",
            "lift_retract_speed2",
            "rest_before_lift",
            "rest_after_lift",
            "rest_after_retract",
        ];
        for (prefix, base, layer) in [("", 10.0, 9), ("bottom_", 50.0, 0)] {
            let texts: Vec<(String, String)> = keys
                .iter()
                .enumerate()
                .map(|(i, k)| (format!("{prefix}{k}"), (base + i as f64).to_string()))
                .collect();
            let values: Vec<(&str, &str)> = texts.iter().map(|(k, v)| (k.as_str(), v.as_str())).collect();
            let m = schedule("elegoo-mars-4", &values).layer(layer, &LAYER).motion;
            let fields = [
                m.lift,
                m.lift_speed,
                m.lift2,
                m.lift2_speed,
                m.retract_speed,
                m.retract2,
                m.retract2_speed,
                m.rest_before_lift,
                m.rest_after_lift,
                m.rest_after_retract,
            ];
            assert_eq!(fields, std::array::from_fn(|i| base + i as f64), "{prefix}");
        }
    }

    #[test]
    fn time_is_exposure_motion_and_rests() {
        let plain = schedule("elegoo-mars-4", &[]);
        let layer = plain.layer(9, &LAYER);
        assert!((plain.time(&layer) - (2.5 + 360.0 / 65.0 + 360.0 / 150.0)).abs() < 1e-12);
        let values = [
            ("lift_height", "3"),
            ("lift_speed", "60"),
            ("lift_height2", "4"),
            ("lift_speed2", "240"),
            ("lift_retract_speed", "200"),
            ("lift_retract_height2", "2"),
            ("lift_retract_speed2", "40"),
            ("rest_before_lift", "0.25"),
            ("rest_after_lift", "0.5"),
            ("rest_after_retract", "1"),
        ];
        let two = schedule("elegoo-mars-4", &values);
        // 3 mm at 60, 4 at 240, back 5 at 200 and 2 at 40 mm/min.
        let seconds = 2.5 + 3.0 + 1.0 + 1.5 + 3.0 + 1.75;
        assert!((two.time(&two.layer(9, &LAYER)) - seconds).abs() < 1e-12);
    }

    #[test]
    fn a_tilting_vat_is_slow_behind_large_layers() {
        let s = schedule("prusa-sl1", &[("rest_after_lift", "0.5")]);
        let panel_mm2 = 120.96 * 68.04;
        let mut layer = s.layer(20, &LAYER);
        assert_eq!(layer.motion, Motion { rest_after_lift: 0.5, ..Motion::default() });
        layer.area_mm2 = panel_mm2 * 0.499;
        assert!((s.time(&layer) - (8.0 + 0.5 + 5.0 + 0.25)).abs() < 1e-12);
        layer.area_mm2 = panel_mm2 * 0.501;
        assert!((s.time(&layer) - (8.0 + 0.5 + 8.0 + 0.25)).abs() < 1e-12);
    }

    #[test]
    fn the_print_time_of_an_sl1_is_prusaslicers() {
        // What PrusaSlicer 2.5.0 writes for a cube of 4 x 4 x 2 mm.
        for (faded, initial, fast, height, seconds) in [
            ("8", "35", "5", "0.05", 719.0),
            ("8", "35", "0", "0.05", 519.0),
            ("3", "35", "0", "0.05", 451.5),
            ("8", "8", "5", "0.05", 530.0),
            ("8", "35", "5", "0.1", 458.75),
        ] {
            let values = [
                ("faded_layers", faded),
                ("initial_exposure_time", initial),
                ("fast_tilt_time", fast),
                ("layer_height", height),
            ];
            let s = schedule("prusa-sl1", &values);
            let mut settings = Settings::resin();
            settings.set("layer_height", height).unwrap();
            settings.set("initial_layer_height", "0.05").unwrap();
            let list = layers(0, 2_000_000, &settings).unwrap();
            let sum: f64 = (0..).zip(&list).map(|(i, l)| s.time(&s.layer(i, l))).sum();
            assert!((sum - seconds).abs() < 1e-9, "{sum} for {values:?}");
        }
    }

    #[test]
    fn layers_are_cut_at_their_middles() {
        let mut s = Settings::resin();
        s.set("initial_layer_height", "0.1").unwrap();
        let list = layers(0, 200_000, &s).unwrap();
        let planes: Vec<_> = list.iter().map(|l| (l.slice_z, l.print_z, l.height)).collect();
        assert_eq!(
            planes,
            [(50_000, 100_000, 100_000), (125_000, 150_000, 50_000), (175_000, 200_000, 50_000)]
        );
        s.exposure.initial_layer_height = -1.0;
        let error = layers(0, 200_000, &s).unwrap_err().to_string();
        assert!(error.starts_with("initial_layer_height is -1 mm"), "{error}");
    }
}
