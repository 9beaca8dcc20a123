//! Settings → the machine as masks and containers see it.

use super::schedule::Schedule;
use super::{Preview, Print};
use crate::lattice::nm;
use crate::mask::Panel;
use crate::settings::{DisplayOrientation, Settings};
use std::sync::Arc;

/// The panel of settings that passed [`Settings::validate_resin`].
///
/// The settings describe it in landscape. In portrait pixels are stored along the plate's y, so that
/// width and height change places; that exchange mirrors the image by itself, hence the turned mirror
/// (PrusaSlicer's convention). The pitch is rounded to whole nanometres here and nowhere else.
pub fn panel(settings: &Settings) -> Panel {
    let d = &settings.display;
    let pitch = |length: f64, pixels: u32| nm(length / f64::from(pixels.max(1))).max(1);
    let (x, y) = (pitch(d.display_width, d.display_pixels_x), pitch(d.display_height, d.display_pixels_y));
    let portrait = d.display_orientation == DisplayOrientation::Portrait;
    let mirror_y = d.display_mirror_y;
    if portrait {
        Panel {
            width: d.display_pixels_y,
            height: d.display_pixels_x,
            pitch_x: y,
            pitch_y: x,
            mirror_x: !d.display_mirror_x,
            mirror_y,
            portrait,
        }
    } else {
        Panel {
            width: d.display_pixels_x,
            height: d.display_pixels_y,
            pitch_x: x,
            pitch_y: y,
            mirror_x: d.display_mirror_x,
            mirror_y,
            portrait,
        }
    }
}

/// How far a layer's outline is moved outwards along the plate's x and y \[nm\]; inwards if negative.
///
/// `absolute_correction`, less the elephant foot's share: full on the first layer, falling linearly to
/// nothing over `elefant_foot_compensation_layers`.
pub fn outline_offset(settings: &Settings, panel: &Panel, index: u32) -> [i64; 2] {
    let i = &settings.image;
    let count = i64::from(i.elefant_foot_compensation_layers);
    let left = (count - i64::from(index)).max(0);
    let pitches =
        if panel.portrait { [panel.pitch_y, panel.pitch_x] } else { [panel.pitch_x, panel.pitch_y] };
    pitches.map(|pitch| {
        let foot =
            if count > 0 { settings.slicing.elefant_foot_compensation.nm(pitch) * left / count } else { 0 };
        i.absolute_correction.nm(pitch) - foot
    })
}

/// What holds for a print by these settings. `name`, `date` and `preview` are empty, for the caller to
/// fill in.
pub fn print(settings: &Settings, panel: &Panel, layers: u32) -> Print {
    let (schedule, m) = (Schedule::new(settings, panel), &settings.material);
    let named = [&m.sla_material_settings_id, &m.material_type];
    let cost = if m.bottle_volume > 0.0 { m.bottle_cost / m.bottle_volume * 1000.0 } else { 0.0 };
    Print {
        name: String::new(),
        date: 0,
        machine: settings.machine.machine_name.clone(),
        printer_model: settings.machine.printer_model.clone(),
        material: named.into_iter().find(|n| !n.is_empty()).cloned().unwrap_or_default(),
        panel: *panel,
        build_height: settings.printer.max_print_height,
        layers,
        layer_height: settings.slicing.layer_height,
        first_layer_height: settings.initial_height(),
        exposure: schedule.exposure,
        bottom_exposure: schedule.bottom_exposure,
        bottom_layers: schedule.bottom_layers,
        transition_layers: schedule.transition_layers,
        motion: schedule.motion,
        bottom_motion: schedule.bottom_motion,
        light: schedule.light,
        bottom_light: schedule.bottom_light,
        anti_aliasing: settings.image.anti_aliasing,
        density: m.material_density,
        cost,
        config: settings.entries().map(|(key, value)| format!("{key} = {value}\n")).collect(),
        preview: Arc::new(Preview { width: 0, height: 0, rgb: Vec::new() }),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::settings::printers;

    fn settings(printer: &str, values: &[(&str, &str)]) -> Settings {
        let mut s = printers::find(printer).unwrap().settings().unwrap();
        for (key, value) in values {
            s.set(key, value).unwrap();
        }
        s
    }

    #[test]
    fn a_landscape_panel_is_as_described() {
        let p = panel(&settings("elegoo-saturn-3-ultra", &[]));
        let expected = Panel {
            width: 11_520,
            height: 5120,
            pitch_x: 19_000,
            pitch_y: 24_000,
            mirror_x: true,
            mirror_y: false,
            portrait: false,
        };
        assert_eq!(p, expected);
        assert_eq!(p.plate(), [218_880_000, 122_880_000]);
    }

    #[test]
    fn a_portrait_panel_is_stored_on_its_side() {
        let p = panel(&settings("prusa-sl1", &[("display_height", "68.4")]));
        let expected = Panel {
            width: 1440,
            height: 2560,
            pitch_x: 47_500,
            pitch_y: 47_250,
            mirror_x: false,
            mirror_y: false,
            portrait: true,
        };
        assert_eq!(p, expected);
        assert_eq!(p.plate(), [120_960_000, 68_400_000]);
        assert!(
            panel(&settings("prusa-sl1", &[("display_mirror_x", "0"), ("display_mirror_y", "1")])).mirror_x
        );
    }

    #[test]
    fn the_pitch_of_every_preset_covers_its_display() {
        for preset in printers::all() {
            let s = preset.settings().unwrap();
            let (p, d) = (panel(&s), &s.display);
            let [x, y] = p.plate();
            assert_eq!([x, y], [nm(d.display_width), nm(d.display_height)], "{}", preset.slug);
            assert_eq!(u64::from(p.pixels()), u64::from(d.display_pixels_x) * u64::from(d.display_pixels_y));
        }
    }

    #[test]
    fn outlines_move_by_correction_and_foot() {
        let values = [
            ("absolute_correction", "2px"),
            ("elefant_foot_compensation", "0.08"),
            ("elefant_foot_compensation_layers", "4"),
        ];
        let s = settings("elegoo-saturn-3-ultra", &values);
        let offset = |s: &Settings, i| outline_offset(s, &panel(s), i);
        assert_eq!(offset(&s, 0), [38_000 - 80_000, 48_000 - 80_000]);
        assert_eq!(offset(&s, 3), [38_000 - 20_000, 48_000 - 20_000]);
        assert_eq!([offset(&s, 4), offset(&s, u32::MAX)], [[38_000, 48_000]; 2]);
        let none = settings("elegoo-saturn-3-ultra", &[]);
        assert_eq!(offset(&none, 0), [0, 0]);
        let off = settings("elegoo-saturn-3-ultra", &[values[1], ("elefant_foot_compensation_layers", "0")]);
        assert_eq!(offset(&off, 0), [0, 0]);
        // In portrait the pitch along the plate's x is that of the rows.
        let portrait = settings("prusa-sl1", &[("display_height", "68.4"), ("absolute_correction", "-1px")]);
        assert_eq!(offset(&portrait, 0), [-47_250, -47_500]);
    }

    #[test]
    fn a_print_says_what_the_settings_say() {
        let values = [
            ("material_type", "Tough"),
            ("bottle_cost", "30"),
            ("bottle_volume", "500"),
            ("material_density", "1.1"),
            ("faded_layers", "8"),
            ("bottom_layers", "0"),
        ];
        let s = settings("elegoo-saturn-3-ultra", &values);
        let p = print(&s, &panel(&s), 960);
        assert_eq!((p.machine.as_str(), p.material.as_str()), ("ELEGOO Saturn 3 Ultra", "Tough"));
        assert_eq!((p.layers, p.build_height, p.density, p.cost), (960, 260.0, 1.1, 60.0));
        assert_eq!((p.bottom_layers, p.transition_layers), (3, 8));
        assert!(p.config.starts_with("absolute_correction = 0\nanti_aliasing = 1\n"));
        assert!(p.config.contains("\nprinter_technology = SLA\n") && !p.config.contains("perimeters"));
        assert!(p.config.lines().is_sorted_by_key(|l| l.split(" = ").next().map(str::to_owned)));
    }
}
