//! Width, flow and feed rate of every role on one layer.

use super::role::Role;
use crate::settings::Settings;
use crate::settings::flow::Flow;
use std::f64::consts::PI;

/// How lines of one role are printed on one layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Width of the bead \[mm\].
    pub width: f64,
    /// Cross-section \[mm²\], before `extrusion_multiplier`.
    pub mm3_per_mm: f64,
    /// Feed rate \[mm/s\].
    pub speed: f64,
    /// Feed rate of small perimeters \[mm/s\].
    pub small_speed: f64,
}

/// Loops of up to this length are small perimeters \[mm\]: circles of radius 6.5 mm, as in PrusaSlicer.
pub const SMALL_PERIMETER: f64 = 2.0 * PI * 6.5;

/// Nothing moves slower than this \[mm/s\].
const SLOWEST: f64 = 0.1;

/// The lines of all roles on a layer of `height` \[mm\], by [`Role::index`].
pub fn lines(height: f64, first: bool, settings: &Settings) -> [Line; Role::COUNT] {
    Role::ALL.map(|role| {
        let flow = Flow::new(role.flow(), height, first, settings);
        let (speeds, section) = (&settings.speed, flow.mm3_per_mm());
        let limited = |own: f64| {
            let speed = match speeds.first_layer_speed.of(own) {
                slow if first && slow > 0.0 => slow,
                _ => own,
            };
            [speeds.max_volumetric_speed, settings.filament.filament_max_volumetric_speed]
                .into_iter()
                .filter(|flow| *flow > 0.0 && section > 0.0)
                .fold(speed, |speed, flow| speed.min(flow / section))
                .max(SLOWEST)
        };
        Line {
            width: flow.width,
            mm3_per_mm: section,
            speed: limited(role.speed(speeds)),
            small_speed: limited(speeds.small_perimeter_speed.of(speeds.perimeter_speed)),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::FloatOrPercent::{Float, Percent};

    #[test]
    fn the_first_layer_and_the_flow_limits_slow_lines_down() {
        let mut s = Settings::default();
        s.speed.first_layer_speed = Percent(50.0);
        let line = |s: &Settings, first| lines(0.2, first, s)[Role::Perimeter.index()];
        assert_eq!(line(&s, false).speed, 60.0);
        assert_eq!(line(&s, true).speed, 30.0);
        assert_eq!(line(&s, true).small_speed, 7.5);
        s.speed.first_layer_speed = Float(20.0);
        assert_eq!(line(&s, true).speed, 20.0);
        s.speed.first_layer_speed = Float(0.0);
        assert_eq!(line(&s, true).speed, 60.0);
        s.filament.filament_max_volumetric_speed = 3.0;
        let slow = line(&s, false);
        assert!((slow.speed * slow.mm3_per_mm - 3.0).abs() < 1e-12);
        s.speed.max_volumetric_speed = 1.0;
        let slow = line(&s, false);
        assert!((slow.speed * slow.mm3_per_mm - 1.0).abs() < 1e-12);
    }
}
