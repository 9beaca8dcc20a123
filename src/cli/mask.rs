//! `microtome mask`.

use super::exit::CliError;
use super::mesh_args::MeshArgs;
use super::options::RunArgs;
use super::progress::Spinner;
use super::report;
use super::setting_flags::ResinFlags;
use crate::job::JobError;
use crate::job::output::OutputError;
use crate::job::resin::{self, PlateOptions, ResinJob, ResinSummary};
use crate::lattice::nm;
use crate::mask::check::CheckSettings;
use crate::mesh::{Placement, Transform};
use crate::resin::Format;
use crate::settings::Settings;
use clap::Args;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Arguments of `mask`.
#[derive(Debug, Args)]
pub struct MaskArgs {
    /// The models: STL files, binary or ASCII; several are arranged on one plate, a name given twice is there twice
    #[arg(value_name = "MODEL", required = true)]
    pub models: Vec<PathBuf>,
    /// Where the masks go: a file of one of the formats by its extension, or a folder of PNG pictures [default: the first model's name with the extension that the printer reads]
    #[arg(long, short, value_name = "FILE|DIR/")]
    pub output: Option<PathBuf>,
    /// Only say what would be printed: resin, layers, and a lower bound of the time; nothing is written
    #[arg(long, conflicts_with_all = ["output", "check_report", "check_pictures"])]
    pub estimate_only: bool,
    /// The layers to write, counted from 0, the last one excluded; the output holds only these [default: all]
    #[arg(long, value_name = "A..B", value_parser = layer_range)]
    pub layers: Option<Range<u32>>,
    /// Look for islands, suction cups and trapped resin, and report areas layer by layer
    #[arg(long)]
    pub check: bool,
    /// Write the checks' report to this file, as JSON; implies --check
    #[arg(long, value_name = "FILE")]
    pub check_report: Option<PathBuf>,
    /// Draw the worst layers that the checks find into this folder, as PNG; implies --check
    #[arg(long, value_name = "DIR")]
    pub check_pictures: Option<PathBuf>,
    /// How far beside the layer beneath it a pixel still counts as supported, for --check [default: 0.1]
    #[arg(long, value_name = "MM", value_parser = reach)]
    pub check_reach: Option<f64>,
    /// Turn each model about the vertical, counter-clockwise from above
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true, value_parser = angle)]
    pub rotate: f64,
    /// Least distance between models on the plate
    #[arg(long, value_name = "MM", default_value_t = 3.0, value_parser = spacing)]
    pub spacing: f64,
    /// Keep the models' coordinates; the plate's corner is at 0, 0
    #[arg(long)]
    pub no_place: bool,
    /// List the settings of loaded files that have no effect here
    #[arg(long)]
    pub list_ignored: bool,
    /// Faulty meshes.
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// How to run.
    #[command(flatten)]
    pub run: RunArgs,
    /// The printer and the settings.
    #[command(flatten)]
    pub settings: ResinFlags,
}

/// Cuts models into masks as asked.
///
/// # Errors
/// [`CliError`]; the output is then as it was before.
pub fn run(args: &MaskArgs) -> Result<(), CliError> {
    args.run.set_threads();
    let mut settings = Settings::resin();
    let given = args.settings.apply(&mut settings)?;
    let (format, output) = output(args, &settings)?;
    let checked = args.check || args.check_report.is_some() || args.check_pictures.is_some();
    let defaults = CheckSettings::default();
    let check = CheckSettings { reach_mm: args.check_reach.unwrap_or(defaults.reach_mm), ..defaults };
    let image = &settings.image;
    let job = ResinJob {
        settings: &settings,
        plate: PlateOptions {
            transform: Transform {
                scale: [
                    image.relative_correction_x,
                    image.relative_correction_y,
                    image.relative_correction_z,
                ],
                turn: args.rotate,
            },
            placement: if args.no_place { Placement::Keep } else { Placement::DropAndCentre },
            spacing: nm(args.spacing),
            mesh: args.mesh.options(),
        },
        backend: args.run.backend(),
        layers: args.layers.clone(),
        name: args.models.first().and_then(|m| m.file_stem()).unwrap_or_default().to_string_lossy().into(),
        date: super::source_date_epoch(),
        check: checked.then_some(check),
        check_report: args.check_report.clone(),
        check_pictures: args.check_pictures.clone(),
        picture: None,
    };
    let spinner = Spinner::new(args.run.quiet);
    let mut summary = match args.estimate_only {
        true => resin::estimate(&args.models, &job, format, &spinner)?,
        false => resin::run(&args.models, &job, format, &output, &spinner)?,
    };
    drop(spinner);

    summary.warnings.splice(0..0, given.warnings.iter().map(ToString::to_string));
    summary.ignored_settings = report::ignored_keys(&given.files);
    if !args.run.quiet {
        report::warning_lines(&summary.warnings);
        report::ignored(&given.files, args.list_ignored);
        if !args.run.json {
            people(&summary);
        }
    }
    if args.run.json {
        report::json(&summary)?;
    }
    Ok(())
}

/// Where the masks go and in which format.
fn output(args: &MaskArgs, settings: &Settings) -> Result<(Format, PathBuf), JobError> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None => {
            let first = args.models.first().cloned().unwrap_or_default();
            first.with_extension(settings.output_extension(None)?)
        }
    };
    if path == Path::new("-") {
        return Err(OutputError {
            path,
            source: std::io::ErrorKind::Unsupported.into(),
            remedy: "masks cannot go to standard output, as their heads are completed last; name a file with -o",
        }
        .into());
    }
    Ok((resin::format_of(&path, settings)?, path))
}

/// The summary for people on stderr.
fn people(s: &ResinSummary) {
    let mut err = std::io::stderr().lock();
    let adapter = s.backend.adapter.as_deref().map_or(String::new(), |a| format!(" {a}"));
    let seconds: f64 = s.stages.iter().map(|t| t.seconds).sum();
    let weight = s.weight_g.map_or(String::new(), |g| format!(", {g:.2} g"));
    let cost = s.cost.map_or(String::new(), |c| format!(", {c:.2} money"));
    // An estimate has no output.
    let first = s.models.first().map_or("", |m| m.model.as_str());
    let (name, done) = match s.output.as_str() {
        "" => (first, "estimated".to_owned()),
        output => (output, format!("{} bytes", s.bytes)),
    };
    let text = format!(
        "{name}: {} layers of {} x {} pixels to z = {:.3} mm, {} triangles\n\
         resin {:.2} ml{weight}{cost}, at least {}; largest layer {} with {:.1} mm2\n",
        s.layers,
        s.panel.width,
        s.panel.height,
        s.print_z_mm,
        s.triangles,
        s.volume_ml,
        report::duration(s.time_lower_bound_s),
        s.largest_layer.layer,
        s.largest_layer.area_mm2,
    );
    drop(err.write_all(text.as_bytes()));
    if let Some(check) = &s.check {
        drop(writeln!(err, "{}", check.line()));
    }
    drop(writeln!(err, "{done} by {}{adapter} in {seconds:.3} s", s.backend.kind));
}

/// `A..B`, `A..` or `..B`.
fn layer_range(text: &str) -> Result<Range<u32>, String> {
    let wrong = || "expected A..B such as 100..120, A.. or ..B, counted from 0".to_owned();
    let (from, to) = text.split_once("..").ok_or_else(wrong)?;
    let bound = |text: &str, missing: u32| match text.trim() {
        "" => Ok(missing),
        digits => digits.parse::<u32>().map_err(|_| wrong()),
    };
    let (from, to) = (bound(from, 0)?, bound(to, u32::MAX)?);
    if from < to { Ok(from..to) } else { Err(format!("{text} holds no layer; B must be greater than A")) }
}

fn reach(text: &str) -> Result<f64, String> {
    super::mesh_args::length(text, 0.0, 10.0)
}

pub(super) fn angle(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| v.abs() <= 3600.0);
    value.ok_or_else(|| format!("`{text}` is no angle; give degrees, such as 45 or -12.5"))
}

fn spacing(text: &str) -> Result<f64, String> {
    super::mesh_args::length(text, 0.0, 1000.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_read() {
        assert_eq!(angle("-12.5"), Ok(-12.5));
        assert!(angle("nan").is_err() && angle("inf").is_err() && angle("north").is_err());
    }

    #[test]
    fn ranges_of_layers_are_read() {
        assert_eq!(layer_range("3..7"), Ok(3..7));
        assert_eq!(layer_range("3.."), Ok(3..u32::MAX));
        assert_eq!(layer_range("..7"), Ok(0..7));
        for wrong in ["", "3", "7..3", "3..3", "-1..2", "a..b", "1...4", "..-"] {
            assert!(layer_range(wrong).is_err(), "{wrong}");
        }
    }
}
