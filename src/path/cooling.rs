//! Fan and slow-down of short layers.

use super::{Extrusion, LayerPlan};
use crate::settings::CoolingSettings;

/// Slows the layer's lines down to `slowdown_below_layer_time` and sets its fan.
///
/// Only extruding moves are slowed, all in proportion, none below `min_print_speed`; what hangs in air
/// keeps its speed, as in PrusaSlicer. `index` counts layers from 0. The fan follows PrusaSlicer's rules:
/// off for the first layers, then a ramp; full below the slow-down's layer time, `min_fan_speed` at
/// `fan_below_layer_time`, linear between, and off or (`fan_always_on`) at the minimum above; faster over
/// air if `bridge_fan_speed` is, whatever `cooling` says.
pub(super) fn cool(layer: &mut LayerPlan, index: usize, settings: &CoolingSettings) {
    if settings.cooling {
        slow_down(layer, settings);
    }
    layer.fan = fan(layer.seconds(), index, settings);
    let over_air = ramped(settings.bridge_fan_speed, index, settings);
    if over_air > layer.fan {
        for e in layer.extrusions.iter_mut().filter(|e| e.role.is_bridge()) {
            e.fan = Some(over_air);
        }
    }
}

fn slow_down(layer: &mut LayerPlan, settings: &CoolingSettings) {
    let wanted = settings.slowdown_below_layer_time - layer.travel_seconds;
    let slowest = settings.min_print_speed;
    // Lines that reach the slowest speed leave the rest to the others, which can make more of them
    // reach it: every round ends or freezes at least one speed, and a layer has few.
    for _ in 0..8 {
        let (mut fixed, mut free) = (0.0, 0.0);
        for e in &layer.extrusions {
            let seconds = e.length / e.speed;
            if may_slow(e, slowest) { free += seconds } else { fixed += seconds }
        }
        let factor = (wanted - fixed) / free;
        if !(factor > 1.0 + 1e-9 && factor.is_finite()) {
            break;
        }
        for e in layer.extrusions.iter_mut().filter(|e| may_slow(e, slowest)) {
            e.speed = (e.speed / factor).max(slowest);
        }
    }
}

/// True for a line that can be slowed down to `slowest`.
fn may_slow(e: &Extrusion, slowest: f64) -> bool {
    e.speed > slowest && !e.role.is_bridge()
}

/// The layer's fan speed by its duration.
fn fan(seconds: f64, index: usize, settings: &CoolingSettings) -> f64 {
    let (low, high) = (settings.min_fan_speed, settings.max_fan_speed);
    let (short, long) = (settings.slowdown_below_layer_time, settings.fan_below_layer_time);
    let mut fan = if settings.fan_always_on { low } else { 0.0 };
    if settings.cooling {
        if seconds < short {
            fan = high;
        } else if seconds < long {
            let t = (seconds - short) / (long - short);
            fan = (low * t + high * (1.0 - t) + 0.5).floor();
        }
    }
    ramped(fan, index, settings)
}

/// A fan speed on a layer of the first ones, where the fan is off or not yet up.
fn ramped(mut fan: f64, index: usize, settings: &CoolingSettings) -> f64 {
    let full = settings.full_fan_speed_layer as usize;
    let mut disabled = settings.disable_fan_first_layers as usize;
    if disabled == 0 && full > 0 {
        disabled = 1;
    }
    if index < disabled {
        return 0.0;
    }
    if full > disabled && index < full {
        let ramp = (index + 1 - disabled) as f64 / (full - disabled) as f64;
        fan = (fan * ramp.min(1.0)).floor();
    }
    fan.clamp(0.0, 100.0)
}

#[cfg(test)]
mod tests {
    use super::super::Role;
    use super::*;

    fn layer(speeds: &[(f64, f64)], travel_seconds: f64) -> LayerPlan {
        let line = |&(length, speed): &(f64, f64)| Extrusion {
            role: Role::Perimeter,
            points: 0..0,
            width: 0.45,
            mm3_per_mm: 0.08,
            speed,
            length,
            retract: false,
            height: 0.2,
            fan: None,
        };
        LayerPlan { extrusions: speeds.iter().map(line).collect(), travel_seconds, ..LayerPlan::default() }
    }

    #[test]
    fn short_layers_are_slowed_to_the_wanted_time() {
        let settings = CoolingSettings::default();
        let mut short = layer(&[(60.0, 60.0), (20.0, 20.0)], 1.0);
        cool(&mut short, 9, &settings);
        assert!((short.seconds() - 5.0).abs() < 1e-9);
        assert!((short.extrusions[0].speed - 30.0).abs() < 1e-9);
        // One line at its limit leaves the rest to the other.
        let mut uneven = layer(&[(60.0, 60.0), (12.0, 12.0)], 0.0);
        cool(&mut uneven, 9, &settings);
        assert_eq!(uneven.extrusions[1].speed, 10.0);
        assert!((uneven.seconds() - 5.0).abs() < 1e-9);
        // A tiny layer ends at the slowest speed; a line slower than that already is left alone.
        let mut tiny = layer(&[(1.0, 60.0), (1.0, 5.0)], 0.0);
        cool(&mut tiny, 9, &settings);
        assert_eq!((tiny.extrusions[0].speed, tiny.extrusions[1].speed), (10.0, 5.0));
        let mut long = layer(&[(600.0, 60.0)], 0.0);
        cool(&mut long, 9, &settings);
        assert_eq!(long.extrusions[0].speed, 60.0);
        let mut off = layer(&[(60.0, 60.0)], 0.0);
        cool(&mut off, 9, &CoolingSettings { cooling: false, ..settings });
        assert_eq!(off.extrusions[0].speed, 60.0);
        cool(&mut LayerPlan::default(), 0, &CoolingSettings::default());
    }

    #[test]
    fn what_hangs_in_air_keeps_its_speed_and_has_a_fan_of_its_own() {
        let settings = CoolingSettings { bridge_fan_speed: 80.0, ..CoolingSettings::default() };
        let with_bridge = || {
            let mut layer = layer(&[(60.0, 60.0), (60.0, 60.0)], 0.0);
            layer.extrusions[1].role = Role::BridgeInfill;
            layer
        };
        let mut short = with_bridge();
        cool(&mut short, 9, &settings);
        assert_eq!(short.extrusions[1].speed, 60.0);
        assert!((short.seconds() - 5.0).abs() < 1e-9);
        // The layer's fan is faster than the bridges', which do not slow it down.
        assert_eq!((short.fan, short.extrusions[1].fan), (100.0, None));
        let mut long = with_bridge();
        long.travel_seconds = 100.0;
        cool(&mut long, 9, &settings);
        assert_eq!([long.extrusions[0].fan, long.extrusions[1].fan], [None, Some(80.0)]);
        let mut low = with_bridge();
        low.travel_seconds = 100.0;
        cool(&mut low, 2, &settings);
        assert!(low.extrusions.iter().all(|e| e.fan.is_none()));
        // Without slow-down too.
        let mut long = with_bridge();
        cool(&mut long, 9, &CoolingSettings { cooling: false, ..settings });
        assert_eq!((long.fan, long.extrusions[1].fan), (0.0, Some(80.0)));
    }

    #[test]
    fn the_fan_follows_layer_time_and_height() {
        let s = CoolingSettings::default();
        assert_eq!(fan(3.0, 2, &s), 0.0);
        assert_eq!(fan(3.0, 3, &s), 100.0);
        assert_eq!(fan(32.5, 3, &s), 68.0);
        assert_eq!(fan(60.0, 3, &s), 0.0);
        assert_eq!(fan(60.0, 3, &CoolingSettings { fan_always_on: true, ..s.clone() }), 35.0);
        let off = CoolingSettings { cooling: false, ..s.clone() };
        assert_eq!(fan(3.0, 3, &off), 0.0);
        assert_eq!(fan(3.0, 3, &CoolingSettings { fan_always_on: true, ..off }), 35.0);
        let ramp = CoolingSettings { disable_fan_first_layers: 1, full_fan_speed_layer: 5, ..s };
        assert_eq!([0, 1, 2, 4, 5].map(|i| fan(3.0, i, &ramp)), [0.0, 25.0, 50.0, 100.0, 100.0]);
    }
}
