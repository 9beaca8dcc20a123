//! Width, flow and feed rate of every role on one layer.

use super::role::Role;
use crate::settings::flow::{Flow, FlowRole, Section};
use crate::settings::{FloatOrPercent, Settings};
use std::f64::consts::PI;

/// How lines of one role are printed on one layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// Width of the bead \[mm\].
    pub width: f64,
    /// Height of the bead \[mm\].
    pub height: f64,
    /// Cross-section \[mm²\], before `extrusion_multiplier`.
    pub mm3_per_mm: f64,
    /// Feed rate \[mm/s\].
    pub speed: f64,
}

/// Loops of up to this length are small perimeters \[mm\]: circles of radius 6.5 mm, as in PrusaSlicer.
pub const SMALL_PERIMETER: f64 = 2.0 * PI * 6.5;

/// Nothing moves slower than this \[mm/s\].
const SLOWEST: f64 = 0.1;

/// The lines of one layer.
#[derive(Clone, Copy, Debug)]
pub struct Lines<'a> {
    by_role: [Line; Role::COUNT],
    settings: &'a Settings,
    /// Thickness of the layer \[mm\].
    height: f64,
    first: bool,
    /// Speed of the layer's lines, of each line's own; 0 = its own.
    slow: FloatOrPercent,
    /// Most volume in a second \[mm³/s\].
    most: f64,
}

impl<'a> Lines<'a> {
    /// The lines of a layer of `height` \[mm\]; `first` is true on the first layer.
    pub fn new(height: f64, first: bool, settings: &'a Settings) -> Self {
        let slow = if first { settings.speed.first_layer_speed } else { FloatOrPercent::Float(0.0) };
        Self::slowed(height, first, slow, settings)
    }

    /// Those of the part's first layer on a raft.
    pub fn on_raft(height: f64, settings: &'a Settings) -> Self {
        Self::slowed(height, false, settings.speed.first_layer_speed_over_raft, settings)
    }

    fn slowed(height: f64, first: bool, slow: FloatOrPercent, settings: &'a Settings) -> Self {
        let most = [settings.speed.max_volumetric_speed, settings.filament.filament_max_volumetric_speed]
            .into_iter()
            .filter(|flow| *flow > 0.0)
            .fold(f64::INFINITY, f64::min);
        let none = Line { width: 0.0, height, mm3_per_mm: 0.0, speed: SLOWEST };
        let mut lines = Self { by_role: [none; Role::COUNT], settings, height, first, slow, most };
        lines.by_role = Role::ALL.map(|role| {
            let flow = if role.is_bridge() { Flow::bridging } else { Flow::new };
            lines.of_flow(role, flow(role.flow(), height, first, settings))
        });
        lines
    }

    /// The line of a role.
    #[inline]
    pub fn of(&self, role: Role) -> &Line {
        &self.by_role[role.index()]
    }

    /// Sparse infill that fills a `height` of several layers \[mm\] at once, as wide as that of one.
    pub fn combined(&self, height: f64) -> Line {
        let own = Flow::new(FlowRole::Infill, self.height, self.first, self.settings);
        self.of_flow(Role::InternalInfill, Flow { height, ..own })
    }

    /// A line of the role's speed and another width \[mm\] and section \[mm²\].
    pub fn varied(&self, role: Role, width: f64, mm3_per_mm: f64) -> Line {
        let speed = self.speed(role.speed(&self.settings.speed), mm3_per_mm);
        Line { width, height: self.height, mm3_per_mm, speed }
    }

    /// Feed rate of small perimeters of a section \[mm²\], whatever their roles \[mm/s\].
    pub fn small_speed(&self, mm3_per_mm: f64) -> f64 {
        let speeds = &self.settings.speed;
        self.speed(speeds.small_perimeter_speed.of(speeds.perimeter_speed), mm3_per_mm)
    }

    /// The section of a pressed bead `width` mm wide on this layer \[mm²\].
    ///
    /// The flanks of one much narrower than the layer is thick would meet; it is a round thread then.
    pub fn section(&self, width: f64) -> f64 {
        let pressed = Flow { width, height: self.height, section: Section::Rounded };
        pressed.mm3_per_mm().max(PI / 4.0 * width * width.min(self.height))
    }

    fn of_flow(&self, role: Role, flow: Flow) -> Line {
        Line { height: flow.height, ..self.varied(role, flow.width, flow.mm3_per_mm()) }
    }

    /// A role's `own` speed, on this layer and under the limits of volume \[mm/s\].
    fn speed(&self, own: f64, section: f64) -> f64 {
        let speed = match self.slow.of(own) {
            slow if slow > 0.0 => slow,
            _ => own,
        };
        let most = if section > 0.0 { self.most / section } else { f64::INFINITY };
        speed.min(most).max(SLOWEST)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::FloatOrPercent::{Float, Percent};

    #[test]
    fn the_first_layer_and_the_flow_limits_slow_lines_down() {
        let mut s = Settings::default();
        s.speed.first_layer_speed = Percent(50.0);
        let line = |s: &Settings, first| *Lines::new(0.2, first, s).of(Role::Perimeter);
        assert_eq!(line(&s, false).speed, 60.0);
        assert_eq!(line(&s, true).speed, 30.0);
        assert_eq!(Lines::new(0.2, true, &s).small_speed(0.08), 7.5);
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

    #[test]
    fn the_layer_on_a_raft_has_a_speed_of_its_own() {
        let mut s = Settings::default();
        let speed = |s: &Settings| Lines::on_raft(0.2, s).of(Role::Perimeter).speed;
        for (over_raft, wanted) in [(Float(17.0), 17.0), (Percent(50.0), 30.0), (Float(0.0), 60.0)] {
            s.speed.first_layer_speed_over_raft = over_raft;
            assert_eq!(speed(&s), wanted);
        }
        // It is not wider, as the first layer on the bed is.
        s.widths.first_layer_extrusion_width = Float(0.6);
        let width = |lines: Lines| lines.of(Role::Perimeter).width;
        assert_eq!(width(Lines::on_raft(0.2, &s)), width(Lines::new(0.2, false, &s)));
        assert_eq!(width(Lines::new(0.2, true, &s)), 0.6);
    }

    #[test]
    fn every_line_is_limited_by_its_own_section() {
        let mut s = Settings::default();
        s.speed.max_volumetric_speed = 2.0;
        let lines = Lines::new(0.2, false, &s);
        let thick = lines.combined(0.4);
        assert_eq!((thick.width, thick.height), (lines.of(Role::InternalInfill).width, 0.4));
        assert!((thick.mm3_per_mm - 0.4 * (0.45 - 0.4 * (1.0 - PI / 4.0))).abs() < 1e-12);
        let wide = lines.varied(Role::GapFill, 1.2, lines.section(1.2));
        for line in [thick, wide] {
            assert!((line.speed * line.mm3_per_mm - 2.0).abs() < 1e-12);
        }
        // A narrow one has the speed of its role.
        assert_eq!(lines.varied(Role::GapFill, 0.2, lines.section(0.2)).speed, 20.0);
    }

    #[test]
    fn bridges_and_overhangs_have_flow_and_speed_of_their_own() {
        let mut s = Settings::default();
        (s.speed.bridge_speed, s.infill.bridge_flow_ratio) = (47.0, 0.81);
        let lines = Lines::new(0.2, false, &s);
        for role in [Role::BridgeInfill, Role::OverhangPerimeter] {
            let line = lines.of(role);
            assert!((line.width - 0.36).abs() < 1e-12 && line.height == line.width);
            assert_eq!(line.speed, 47.0);
        }
        s.infill.thick_bridges = false;
        let lines = Lines::new(0.2, false, &s);
        let (over, wall) = (lines.of(Role::OverhangPerimeter), lines.of(Role::ExternalPerimeter));
        assert_eq!((over.width, over.height), (wall.width, 0.2));
        assert!((over.mm3_per_mm - 0.81 * wall.mm3_per_mm).abs() < 1e-12);
    }

    #[test]
    fn sections_grow_with_the_width() {
        let s = Settings::default();
        let lines = Lines::new(0.2, false, &s);
        let sections: Vec<_> = (1..200).map(|i| lines.section(f64::from(i) * 0.01)).collect();
        assert!(sections[0] > 0.0 && sections.is_sorted());
        assert!((sections[44] - lines.of(Role::Perimeter).mm3_per_mm).abs() < 1e-12);
    }
}
