//! `microtome printers`.

use super::exit::CliError;
use super::report;
use crate::settings::printers::{self, Preset, PrinterError};
use crate::settings::{DisplayOrientation, Settings, SettingsError};
use clap::Args;
use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write as _;

/// Arguments of `printers`.
#[derive(Debug, Args)]
pub struct PrintersArgs {
    /// A printer's name, to see its settings; saved and edited they can be given to --printer
    #[arg(value_name = "NAME")]
    name: Option<String>,
    /// Print machine-readable JSON
    #[arg(long)]
    json: bool,
}

/// One printer, as `--json` prints it.
#[derive(Debug, Serialize)]
struct Printer {
    slug: &'static str,
    name: String,
    /// Along the plate's x and y.
    pixels: [u32; 2],
    pitch_um: [f64; 2],
    volume_mm: [f64; 3],
    orientation: &'static str,
    mirror: [bool; 2],
    container: &'static str,
    /// Whether its own files can be written.
    written: bool,
}

/// One printer and all its settings.
#[derive(Debug, Serialize)]
struct Details {
    #[serde(flatten)]
    printer: Printer,
    settings: BTreeMap<&'static str, String>,
}

/// Lists the presets, or describes one.
///
/// # Errors
/// When no preset has the name, or stdout cannot be written.
pub fn run(args: &PrintersArgs) -> Result<(), CliError> {
    let text = match &args.name {
        Some(name) => {
            let preset = printers::find(name)?;
            if args.json {
                let settings = preset.settings().map_err(PrinterError::from)?;
                let printer = Printer::new(preset, &settings);
                return Ok(report::json(&Details { printer, settings: settings.entries().collect() })?);
            }
            preset.toml.to_owned()
        }
        None => {
            let all: Result<Vec<Printer>, SettingsError> =
                printers::all().iter().map(|p| Ok(Printer::new(p, &p.settings()?))).collect();
            let all = all.map_err(PrinterError::from)?;
            if args.json {
                return Ok(report::json(&all)?);
            }
            table(&all)
        }
    };
    std::io::stdout().lock().write_all(text.as_bytes())?;
    Ok(())
}

impl Printer {
    fn new(preset: &Preset, settings: &Settings) -> Self {
        let (d, m) = (&settings.display, &settings.machine);
        let pixels = [d.display_pixels_x, d.display_pixels_y];
        let size = [d.display_width, d.display_height];
        // Whole nanometres, as the panel has them.
        let pitch = |i: usize| (1e6 * size[i] / f64::from(pixels[i].max(1))).round() / 1e3;
        Self {
            slug: preset.slug,
            name: m.machine_name.clone(),
            pixels,
            pitch_um: [pitch(0), pitch(1)],
            volume_mm: [size[0], size[1], settings.printer.max_print_height],
            orientation: match d.display_orientation {
                DisplayOrientation::Landscape => "landscape",
                DisplayOrientation::Portrait => "portrait",
            },
            mirror: [d.display_mirror_x, d.display_mirror_y],
            container: m.container.name(),
            written: m.container.is_written(),
        }
    }

    fn row(&self) -> [String; 6] {
        let ([px, py], [x, y], [w, d, h]) = (self.pixels, self.pitch_um, self.volume_mm);
        let mark = if self.written { "" } else { " *" };
        [
            self.slug.to_owned(),
            self.name.clone(),
            format!("{px} x {py}"),
            if x == y { format!("{x}") } else { format!("{x} x {y}") },
            format!("{w} x {d} x {h}"),
            format!("{}{mark}", self.container),
        ]
    }
}

/// The printers as a table with a line on what is not written.
fn table(all: &[Printer]) -> String {
    let head = ["name", "machine", "pixels", "pitch/um", "volume/mm", "container"].map(str::to_owned);
    let rows: Vec<[String; 6]> = [head].into_iter().chain(all.iter().map(Printer::row)).collect();
    let widths: [usize; 6] =
        std::array::from_fn(|i| rows.iter().map(|r| r[i].chars().count()).max().unwrap_or_default());
    let mut out = String::new();
    for row in &rows {
        let cells: Vec<String> = row.iter().zip(widths).map(|(cell, w)| format!("{cell:w$}")).collect();
        // Writing to a String cannot fail.
        let _ = writeln!(out, "{}", cells.join("  ").trim_end());
    }
    out.push_str(NOTES);
    out
}

const NOTES: &str = "
* cannot be written: name an output ending in .goo or .zip, and convert it.
`microtome printers NAME` prints a printer's settings; save them, edit them, and give them as --printer FILE.toml.
";

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn all() -> Vec<Printer> {
        printers::all().iter().map(|p| Printer::new(p, &p.settings().unwrap())).collect()
    }

    #[test]
    fn the_table_has_a_row_for_each() {
        let table = table(&all());
        assert_eq!(table.lines().count(), 1 + printers::all().len() + 3);
        let row = |slug: &str| table.lines().find(|l| l.split(' ').next() == Some(slug)).unwrap().to_owned();
        let words = row("elegoo-saturn-3-ultra").split_whitespace().collect::<Vec<_>>().join(" ");
        assert_eq!(
            words,
            "elegoo-saturn-3-ultra ELEGOO Saturn 3 Ultra 11520 x 5120 19 x 24 218.88 x 122.88 x 260 goo"
        );
        assert!(row("prusa-sl1").contains(" 47.25 ") && row("anycubic-photon-mono-x").ends_with(" pwmx"));
        assert!(row("elegoo-mars-3").ends_with(" encrypted-ctb *"));
        assert!(table.lines().all(|l| l.trim_end() == l));
    }

    #[test]
    fn json_says_the_same_and_the_text_reads_back() {
        let json = serde_json::to_value(all()).unwrap();
        let sl1 = json.as_array().unwrap().iter().find(|p| p["slug"] == "prusa-sl1").unwrap();
        assert_eq!(sl1["pixels"], serde_json::json!([2560, 1440]));
        assert_eq!((&sl1["orientation"], &sl1["written"]), (&"portrait".into(), &true.into()));
        for preset in printers::all() {
            let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
            std::fs::write(file.path(), preset.toml).unwrap();
            let mut s = Settings::resin();
            printers::apply(file.path().to_str().unwrap(), &mut s).unwrap();
            assert_eq!(s, preset.settings().unwrap());
        }
    }
}
