//! `microtome slice`.

use super::exit::CliError;
use super::mesh_args::MeshArgs;
use super::options::RunArgs;
use super::progress::Spinner;
use super::report;
use super::setting_flags::SettingFlags;
use super::support_args::SupportArgs;
use crate::job::JobError;
use crate::job::filament::{self, FilamentJob, Planned};
use crate::job::output::{OutputError, OutputFile};
use crate::job::toolpaths::{save_png, toolpaths};
use crate::mesh::Placement;
use crate::picture;
use crate::settings::Settings;
use clap::Args;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `slice`.
#[derive(Debug, Args)]
pub struct SliceArgs {
    /// The model: an STL file, binary or ASCII
    #[arg(value_name = "MODEL")]
    pub model: PathBuf,
    /// Where the G-code goes; `-` is standard output [default: the model's name with .gcode]
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Only say what would be printed: filament as that of the G-code, layers, and a lower bound of the time; nothing is written
    #[arg(long, conflicts_with_all = ["output", "picture"])]
    pub estimate_only: bool,
    /// List the settings of loaded files that have no effect here
    #[arg(long)]
    pub list_ignored: bool,
    /// Keep the model's coordinates instead of dropping it onto the bed and centring it there
    #[arg(long)]
    pub no_place: bool,
    /// Lay so many of the model on the bed, duplicate_distance apart
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub duplicate: u32,
    /// Draw the toolpaths of a layer, seen from above, as a PNG picture
    #[arg(long, value_name = "FILE")]
    pub picture: Option<PathBuf>,
    /// The layer that is drawn, counted from 0 [default: the middle one]
    #[arg(long, value_name = "N", requires = "picture")]
    pub picture_layer: Option<u32>,
    /// Faulty meshes.
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// Supports.
    #[command(flatten)]
    pub supports: SupportArgs,
    /// How to run.
    #[command(flatten)]
    pub run: RunArgs,
    /// The settings.
    #[command(flatten)]
    pub settings: SettingFlags,
}

/// Slices a model as asked.
///
/// # Errors
/// [`CliError`]; the output is then as it was before.
pub fn run(args: &SliceArgs) -> Result<(), CliError> {
    args.run.set_threads();
    let mut settings = Settings::default();
    let given = args.settings.apply(&mut settings)?;

    let output = args.output.clone().unwrap_or_else(|| args.model.with_extension("gcode"));
    let job = FilamentJob {
        settings: &settings,
        placement: if args.no_place { Placement::Keep } else { Placement::DropAndCentre },
        mesh: args.mesh.options(),
        backend: args.run.backend(),
        stem: stem(&args.model),
        date: super::source_date_epoch(),
        modifiers: args.supports.modifiers(),
        copies: args.duplicate,
    };
    let spinner = Spinner::new(args.run.quiet);
    let mut planned = filament::plan_with(&args.model, &job, args.supports.wish(), &spinner)?;
    if let Some(path) = &args.picture {
        draw(path, args.picture_layer, &planned, &job)?;
    }
    let record = std::mem::take(&mut planned.supports);
    let mut summary = if args.estimate_only {
        let summary = filament::count(planned, &job, &spinner)?;
        args.supports.write(record, &summary)?;
        summary
    } else if output == Path::new("-") {
        let failed = |e| JobError::from(OutputError::new(Path::new("standard output"), e));
        let mut out = io::BufWriter::with_capacity(1 << 18, io::stdout().lock());
        let summary = filament::write(planned, &job, &mut out, &spinner)
            .map_err(|e| e.at(Path::new("standard output")))?;
        out.flush().map_err(failed)?;
        args.supports.write(record, &summary)?;
        summary
    } else {
        let mut out = OutputFile::create(&output).map_err(JobError::from)?;
        let summary = filament::write(planned, &job, &mut out, &spinner).map_err(|e| e.at(&output))?;
        // A report that cannot be written leaves no G-code that nobody has a report of.
        args.supports.write(record, &summary)?;
        out.commit().map_err(JobError::from)?;
        summary
    };
    drop(spinner);

    if !args.estimate_only {
        summary.output = output.display().to_string();
    }
    summary.warnings.splice(0..0, given.warnings.iter().map(ToString::to_string));
    summary.ignored_settings = report::ignored_keys(&given.files);
    if !args.run.quiet {
        report::warnings(&summary);
        report::ignored(&given.files, args.list_ignored);
        if !args.run.json {
            report::people(&summary);
        }
    }
    if args.run.json {
        report::json(&summary)?;
    }
    Ok(())
}

/// Size of the picture of a layer \[pixels\].
const PICTURE: (u32, u32) = (1600, 1200);

/// Draws the toolpaths of a layer.
fn draw(path: &Path, index: Option<u32>, planned: &Planned, job: &FilamentJob<'_>) -> Result<(), CliError> {
    let count = planned.layers.len();
    let index = index.map_or(count / 2, |n| n as usize);
    let Some(plan) = toolpaths(planned, job, index) else {
        return Err(CliError::NoSuchLayer { index, count });
    };
    let strokes = picture::toolpaths::strokes(&plan);
    let image = picture::strokes::render(&strokes, PICTURE.0, PICTURE.1);
    Ok(save_png(&image, path).map_err(JobError::from)?)
}

/// The model's name without folder and extension, for templates.
fn stem(path: &Path) -> String {
    path.file_stem().map_or_else(String::new, |s| s.to_string_lossy().into_owned())
}
