//! `microtome contours`.

use super::exit::CliError;
use super::mesh_args::MeshArgs;
use super::options::RunArgs;
use super::progress::Spinner;
use super::report;
use super::setting_flags::SettingFlags;
use crate::export::Format;
use crate::job::contours::{self, ContoursJob, ContoursSummary};
use crate::mesh::Placement;
use crate::settings::Settings;
use crate::slice::classic::Algorithm;
use crate::slice::direction::Direction;
use clap::{Args, ValueEnum};
use std::io::{self, Write};
use std::path::PathBuf;

/// How planes and triangles are intersected, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum AlgorithmArg {
    /// The core's own, on the CPU or a GPU
    Main,
    /// Every plane against every triangle
    Trivial,
    /// A sweep plane with the triangles that it meets
    Sweep,
    /// Triangles grouped by their lowest and highest z
    Grouping,
    /// Buckets of planes, or an interval tree where they are not evenly spaced
    Incremental,
}

/// Arguments of `contours`.
#[derive(Debug, Args)]
pub struct ContoursArgs {
    /// The model: an STL file, binary or ASCII
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// A file ending in .svg, .json, .wkt or .cli, or a folder (it exists, or ends in /) for a PNG per plane
    #[arg(long, short, value_name = "OUT")]
    pub output: PathBuf,
    /// Cut at the heights in a text file, in mm above the bed, ascending, one a line, # for comments
    #[arg(long, value_name = "FILE")]
    pub planes: Option<PathBuf>,
    /// Normal of the planes; the part is turned so that it points up, and heights are measured along it
    #[arg(long, value_name = "X,Y,Z", default_value = "0,0,1", value_parser = normal, allow_hyphen_values = true)]
    pub plane_normal: Direction,
    /// How to intersect planes and triangles; the contours are the same
    #[arg(long, value_enum, default_value = "main")]
    pub algorithm: AlgorithmArg,
    /// Pixels per mm of PNG pictures
    #[arg(long, value_name = "N", default_value_t = 10.0)]
    pub scale: f64,
    /// List the settings of loaded files that have no effect here
    #[arg(long)]
    pub list_ignored: bool,
    /// Keep the model's coordinates instead of dropping it onto the bed and centring it there
    #[arg(long)]
    pub no_place: bool,
    /// How to deal with faults.
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// How to run.
    #[command(flatten)]
    pub run: RunArgs,
    /// The settings.
    #[command(flatten)]
    pub settings: SettingFlags,
}

/// Three numbers with commas between them.
fn normal(text: &str) -> Result<Direction, String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|t| t.trim().parse::<f64>()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, z]) => Direction::new([x, y, z]).map_err(|e| e.to_string()),
        _ => Err("not three numbers with commas between them, such as 0,0,1".to_owned()),
    }
}

/// Cuts a model as asked.
///
/// # Errors
/// [`CliError`]; a single file is then as it was before.
pub fn run(args: &ContoursArgs) -> Result<(), CliError> {
    args.run.set_threads();
    let format = Format::of(&args.output)?;
    let mut settings = Settings::default();
    let given = args.settings.apply(&mut settings)?;
    let job = ContoursJob {
        settings: &settings,
        placement: if args.no_place { Placement::Keep } else { Placement::DropAndCentre },
        direction: args.plane_normal,
        planes: args.planes.as_deref(),
        algorithm: match args.algorithm {
            AlgorithmArg::Main => Algorithm::Main,
            AlgorithmArg::Trivial => Algorithm::Trivial,
            AlgorithmArg::Sweep => Algorithm::Sweep,
            AlgorithmArg::Grouping => Algorithm::Grouping,
            AlgorithmArg::Incremental => Algorithm::Incremental,
        },
        backend: args.run.backend(),
        mesh: args.mesh.options(),
        format,
        scale: args.scale,
    };
    let spinner = Spinner::new(args.run.quiet);
    let mut summary = contours::run(&args.model, &args.output, &job, &spinner)?;
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

/// The summary for people on stderr.
fn people(s: &ContoursSummary) {
    let adapter = s.backend.adapter.as_deref().map_or(String::new(), |a| format!(" {a}"));
    let seconds: f64 = s.times.iter().map(|t| t.seconds).sum();
    let text = format!(
        "{}: {} planes, {} with contours, {} triangles, {} segments\n\
         {} contours, {} open chains\n\
         {} bytes in {} files by {}{adapter} in {:.3} s\n",
        s.output,
        s.planes,
        s.layers,
        s.triangles,
        s.segments,
        s.contours,
        s.open_chains,
        s.bytes,
        s.files,
        s.backend.kind,
        seconds,
    );
    // Nobody is left to tell when stderr is closed.
    drop(io::stderr().lock().write_all(text.as_bytes()));
}
