//! The texts of a G-code file that come from the user and from the job: templates, date, settings.

use super::filament::FilamentJob;
use crate::gcode::LayerText;
use crate::gcode::template::{TemplateError, expand};
use crate::lattice::{Point2, mm};
use crate::path::PrintLayer;
use crate::resin::date::civil;
use crate::settings::Settings;
use crate::settings::flow::{Flow, FlowRole};

/// Templates with their placeholders filled in, and what is needed to fill in those of the layers.
#[derive(Debug)]
pub(super) struct GcodeText<'a> {
    /// `YYYY-MM-DD at HH:MM:SS UTC`.
    pub date: String,
    /// G-code before the print.
    pub start: String,
    /// G-code after the print.
    pub end: String,
    /// All settings.
    pub config: Vec<(String, String)>,
    job: &'a FilamentJob<'a>,
    values: Vec<(&'static str, String)>,
}

impl<'a> GcodeText<'a> {
    /// Fills in the start and end G-code and tries the templates of the layers once, so that a mistake in
    /// them is found before anything is written.
    pub fn new(
        layers: &[PrintLayer],
        origin: [i64; 3],
        job: &'a FilamentJob<'a>,
    ) -> Result<Self, TemplateError> {
        let config = job.settings.entries().map(|(key, value)| (key.to_owned(), value)).collect();
        let values = values(layers, origin, job);
        let mut text =
            Self { date: date(job.date), start: String::new(), end: String::new(), config, job, values };
        let output = &job.settings.output;
        text.start = text.expand("start_gcode", &output.start_gcode, None)?;
        let last = layers.last().map(|l| text.layer_text(layers.len() - 1, l));
        text.end = text.expand("end_gcode", &output.end_gcode, last)?;
        let first = layers.first().map(|l| text.layer_text(0, l));
        text.expand("before_layer_gcode", &output.before_layer_gcode, first)?;
        text.expand("layer_gcode", &output.layer_gcode, first)?;
        Ok(text)
    }

    /// The G-code of a layer. Whether a template can be filled in does not depend on the layer, and
    /// [`Self::new`] has tried it, so there is nothing left to fail.
    pub fn layer(&self, name: &str, template: &str, layer: LayerText) -> String {
        self.expand(name, template, Some(layer)).unwrap_or_default()
    }

    fn layer_text(&self, index: usize, layer: &PrintLayer) -> LayerText {
        let z = mm(layer.z.print_z) + self.job.settings.printer.z_offset;
        LayerText { index, z, height: mm(layer.z.height) }
    }

    fn expand(&self, name: &str, text: &str, layer: Option<LayerText>) -> Result<String, TemplateError> {
        if text.is_empty() {
            return Ok(String::new());
        }
        expand(name, text, &|wanted| {
            let of_layer = layer.and_then(|l| match wanted {
                "layer_num" => Some(l.index.to_string()),
                "layer_z" => Some(number(l.z)),
                _ => None,
            });
            let own = || self.values.iter().find(|(key, _)| *key == wanted).map(|(_, value)| value.clone());
            of_layer.or_else(own).or_else(|| self.job.settings.template_value(wanted))
        })
    }
}

/// Values of this print, under PrusaSlicer's names.
fn values(layers: &[PrintLayer], origin: [i64; 3], job: &FilamentJob<'_>) -> Vec<(&'static str, String)> {
    let printer = &job.settings.printer;
    let bed = bounds(printer.bed_shape.iter().copied());
    let first = layers.first().map_or([[0.0; 2]; 2], |layer| extents(layer, origin, job.settings));
    let top = layers.last().map_or(0.0, |l| mm(l.z.print_z)) + printer.z_offset;
    let mut values = vec![
        ("input_filename_base", job.stem.clone()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("timestamp", date(job.date)),
        ("total_layer_count", layers.len().to_string()),
        ("max_layer_z", number(top)),
        ("current_extruder", "0".to_owned()),
        ("initial_extruder", "0".to_owned()),
        ("initial_tool", "0".to_owned()),
        ("total_toolchanges", "0".to_owned()),
        ("num_objects", "1".to_owned()),
        ("num_instances", "1".to_owned()),
        ("layer_num", "0".to_owned()),
        ("layer_z", "0".to_owned()),
    ];
    for ([min, max, size], [lo, hi]) in [
        (["first_layer_print_min", "first_layer_print_max", "first_layer_print_size"], first),
        (["print_bed_min", "print_bed_max", "print_bed_size"], bed),
    ] {
        let extent = [hi[0] - lo[0], hi[1] - lo[1]];
        for (name, value) in [(min, lo), (max, hi), (size, extent)] {
            values.push((name, format!("{},{}", number(value[0]), number(value[1]))));
            let [x, y] = indexed(name);
            values.push((x, number(value[0])));
            values.push((y, number(value[1])));
        }
    }
    values
}

fn indexed(name: &str) -> [&'static str; 2] {
    match name {
        "first_layer_print_min" => ["first_layer_print_min[0]", "first_layer_print_min[1]"],
        "first_layer_print_max" => ["first_layer_print_max[0]", "first_layer_print_max[1]"],
        "first_layer_print_size" => ["first_layer_print_size[0]", "first_layer_print_size[1]"],
        "print_bed_min" => ["print_bed_min[0]", "print_bed_min[1]"],
        "print_bed_max" => ["print_bed_max[0]", "print_bed_max[1]"],
        _ => ["print_bed_size[0]", "print_bed_size[1]"],
    }
}

/// The corners of the box around all beads of the first layer \[mm\], those of skirt, brim, supports and raft
/// among them.
fn extents(layer: &PrintLayer, origin: [i64; 3], settings: &Settings) -> [[f64; 2]; 2] {
    let flow = |role| Flow::new(role, mm(layer.z.height), true, settings);
    let place = |p: &Point2| [mm(i64::from(p.x) + origin[0]), mm(i64::from(p.y) + origin[1])];
    let grown = |reach: f64| move |p: [f64; 2]| [[p[0] - reach, p[1] - reach], [p[0] + reach, p[1] + reach]];
    let wall = 0.5 * flow(FlowRole::ExternalPerimeter).width;
    let walls = layer.islands.iter().flat_map(|i| &i.walls).flat_map(|w| &w.ring);
    // Neighbouring beads share what is between a spacing and a width.
    let beside = 0.5 * flow(FlowRole::Skirt).spacing();
    let strands = layer.brim.iter().chain(&layer.supports).flat_map(|s| &s.points);
    let others = layer.skirt.iter().flatten().chain(strands);
    bounds(walls.map(place).flat_map(grown(wall)).chain(others.map(place).flat_map(grown(beside))))
}

fn bounds(points: impl Iterator<Item = [f64; 2]>) -> [[f64; 2]; 2] {
    points
        .fold(None, |found: Option<[[f64; 2]; 2]>, p| {
            let [lo, hi] = found.unwrap_or([p, p]);
            Some([[lo[0].min(p[0]), lo[1].min(p[1])], [hi[0].max(p[0]), hi[1].max(p[1])]])
        })
        .unwrap_or_default()
}

/// Millimetres with at most three decimals.
fn number(value: f64) -> String {
    let text = format!("{value:.3}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

/// Seconds since 1970-01-01 UTC as `YYYY-MM-DD at HH:MM:SS UTC`.
fn date(seconds: i64) -> String {
    let [year, month, day, h, m, s] = civil(seconds);
    format!("{year:04}-{month:02}-{day:02} at {h:02}:{m:02}:{s:02} UTC")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::PrintIsland;
    use crate::region::Wall;
    use crate::slice::planes::LayerZ;
    use crate::support::{Strand, StrandKind};

    #[test]
    fn dates_are_the_calendars() {
        assert_eq!(date(0), "1970-01-01 at 00:00:00 UTC");
        assert_eq!(date(951_827_696), "2000-02-29 at 12:34:56 UTC");
        assert_eq!(date(4_107_542_399), "2100-02-28 at 23:59:59 UTC");
        assert_eq!(date(-1), "1969-12-31 at 23:59:59 UTC");
    }

    #[test]
    fn the_first_layer_reaches_to_the_edges_of_its_beads() {
        let ring =
            |half: i32| [(-1, -1), (1, -1), (1, 1), (-1, 1)].map(|(x, y)| Point2::new(half * x, half * y));
        let wall = Wall { ring: ring(4_000_000).to_vec(), ..Wall::default() };
        let islands = vec![PrintIsland { walls: vec![wall], ..PrintIsland::default() }];
        let z = LayerZ { slice_z: 1, print_z: 200_000, height: 200_000 };
        let mut layer = PrintLayer { z, islands, ..PrintLayer::default() };
        let (settings, origin) = (Settings::default(), [10_000_000, 20_000_000, 0]);
        let flow = |role| Flow::new(role, 0.2, true, &settings);
        let half = 4.0 + 0.5 * flow(FlowRole::ExternalPerimeter).width;
        let near = |a: [[f64; 2]; 2], half: f64| {
            let wanted = [10.0 - half, 20.0 - half, 10.0 + half, 20.0 + half];
            a.as_flattened().iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-9)
        };
        assert!(near(extents(&layer, origin, &settings), half));
        // A raft has no walls, and a skirt lies further out.
        let strand = |half: i32| Strand { points: ring(half).to_vec(), closed: true, kind: StrandKind::Base };
        let beside = 0.5 * flow(FlowRole::Skirt).spacing();
        layer.islands.clear();
        layer.supports.push(strand(5_000_000));
        assert!(near(extents(&layer, origin, &settings), 5.0 + beside));
        layer.brim.push(strand(6_000_000));
        assert!(near(extents(&layer, origin, &settings), 6.0 + beside));
        layer.skirt.push(ring(9_000_000).to_vec());
        assert!(near(extents(&layer, origin, &settings), 9.0 + beside));
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([0.2, -0.0001, 100.0, 0.12345].map(number), ["0.2", "0", "100", "0.123"]);
    }
}
