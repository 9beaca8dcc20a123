//! `microtome batch`.

use super::batch_view::{View, ViewOptions};
use super::exit::CliError;
use super::interrupt;
use super::mesh_args::MeshArgs;
use super::options::{BackendArg, memory_size};
use super::report;
use super::setting_flags::AllFlags;
use crate::batch::item::{self, technology_of};
use crate::batch::report::count;
use crate::batch::shard::Shard;
use crate::batch::{self, BatchError, BatchOptions, Input, Limits, Totals, names};
use crate::job::{JobError, memory};
use crate::settings::{PrinterTechnology, Settings, keys};
use crate::slicer::{Request, Technology};
use clap::{Args, ValueEnum};
use std::num::NonZero;
use std::path::{Path, PathBuf};

/// How the prints are made, as typed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum TechnologyArg {
    /// G-code for filament printers
    Filament,
    /// Layer masks for resin printers
    Resin,
}

/// Arguments of `batch`.
#[derive(Debug, Args)]
pub struct BatchArgs {
    /// Models, folders (searched to the bottom), patterns such as 'parts/*.stl', and manifests: a job a line, as JSON (.jsonl) or CSV (.csv)
    #[arg(value_name = "INPUT", required = true)]
    pub inputs: Vec<String>,
    /// Folder for the outputs, the journal and the reports; made if it is not there
    #[arg(long, short, value_name = "DIR")]
    pub output: PathBuf,
    /// What kind of printer [default: resin where --printer or --format is given, else filament]
    #[arg(long, value_enum)]
    pub technology: Option<TechnologyArg>,
    /// Extension of a resin printer's files, such as goo or sl1 [default: what the printer reads]
    #[arg(long, value_name = "EXTENSION")]
    pub format: Option<String>,
    /// Go on where an earlier run ended: what is done and unchanged is skipped; on a fresh folder simply start
    #[arg(long)]
    pub resume: bool,
    /// Forget earlier runs in the output folder and begin anew
    #[arg(long, conflicts_with = "resume")]
    pub restart: bool,
    /// With --resume: try again what failed before
    #[arg(long, requires = "resume")]
    pub retry_failed: bool,
    /// Do only part I of N of the jobs, from 1; models are assigned by the hash of their content
    #[arg(long, value_name = "I/N", value_parser = shard)]
    pub shard: Option<Shard>,
    /// Only say what would be printed: filament, volume, layers, price, and a lower bound of the time
    #[arg(long)]
    pub estimate_only: bool,
    /// How many of each model are laid on the bed
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub copies: u32,
    /// Memory of all models in flight [default: half of the machine's]
    #[arg(long, value_name = "SIZE", value_parser = memory_size)]
    pub memory: Option<u64>,
    /// Memory that one model may take before it is given up [default: that of all]
    #[arg(long, value_name = "SIZE", value_parser = memory_size)]
    pub job_memory: Option<u64>,
    /// Time that one model may take before it is given up [default: 3600]
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub job_time: Option<f64>,
    /// Further tries after a failure that may pass, such as a lost device or a dead worker
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub retries: u32,
    /// CPU threads of all workers together [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Where to intersect planes and triangles; the output is the same everywhere
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: BackendArg,
    /// Part of the name of the GPU to use (see `microtome devices`); a software device is used only when named here
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// With --backend auto: worker processes that may hold a GPU
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub device_workers: u16,
    /// A failure that the workers' GPUs play, as for `worker`
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "SPEC", hide = true)]
    pub fault: Option<String>,
    /// No pictures of layers in the report
    #[arg(long)]
    pub no_pictures: bool,
    /// Keep a file of figures for the text collector of Prometheus' node exporter up to date
    #[arg(long, value_name = "FILE.prom")]
    pub prometheus: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Print a line of JSON on standard output for each event
    #[arg(long)]
    pub json: bool,
    /// Keep the models' coordinates instead of dropping them onto the bed and centring them there
    #[arg(long)]
    pub no_place: bool,
    /// Turn each model about the vertical, counter-clockwise from above; resin only
    #[arg(long, value_name = "DEGREES", default_value_t = 0.0, allow_negative_numbers = true, value_parser = super::mask::angle)]
    pub rotate: f64,
    /// Look for islands, suction cups and trapped resin; resin only
    #[arg(long)]
    pub check: bool,
    /// Support what hangs inside this mesh, however steep; in the models' coordinates, may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Supports")]
    pub support_enforcer: Vec<PathBuf>,
    /// Support nothing inside this mesh; in the models' coordinates, may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Supports")]
    pub support_blocker: Vec<PathBuf>,
    /// Faulty meshes.
    #[command(flatten)]
    pub mesh: MeshArgs,
    /// The printer and the settings.
    #[command(flatten)]
    pub settings: AllFlags,
}

/// Time that one job may take \[s\].
const JOB_SECONDS: f64 = 3600.0;

/// Runs a batch.
///
/// # Errors
/// [`CliError`]: the batch could not begin or had to stop, or not all jobs were done.
pub fn run(args: &BatchArgs) -> Result<(), CliError> {
    let format = args.format.as_deref().map(names::extension_of_format).transpose();
    let format = format.map_err(|e| BatchError::Settings(format!("--format: {e}")))?;
    let base = args.request(format.as_deref())?;
    let technology = printer_technology(base.technology);
    let mut settings = Settings::of(technology);
    let given = args.settings.apply(&mut settings)?;
    args.settings.check_others(technology)?;
    let input =
        Input { inputs: &args.inputs, base: &base, folder: &args.output, extension: format.as_deref() };
    let items = item::items(&input)?;
    // What only lines of manifests use is complete with these.
    if items.iter().any(|item| item.place.is_none()) {
        match technology {
            PrinterTechnology::Fff => settings.validate(),
            PrinterTechnology::Sla => settings.validate_resin(),
        }
        .map_err(JobError::from)?;
    }
    if !args.quiet {
        let stray = |key: &str| keys::find(key).is_some_and(|k| !k.technology.fits(technology));
        let mixed = items.iter().any(|item| item.request.technology != base.technology);
        let said = given.warnings.iter().filter(|w| !(mixed && stray(&w.key)));
        report::warning_lines(&said.map(ToString::to_string).collect::<Vec<_>>());
    }
    let mut view = View::new(args.view(), interrupt::watch())?;
    let totals = batch::run(&items, &args.options()?, &mut view)?;
    view.finish(&totals)?;
    finished(&totals, &args.output, args.shard.unwrap_or_default())
}

impl BatchArgs {
    /// What holds for each job that a manifest does not say otherwise.
    fn request(&self, format: Option<&str>) -> Result<Request, BatchError> {
        let mesh = &self.mesh;
        let orient = mesh.orient.to_possible_value().map_or(String::new(), |v| v.get_name().to_owned());
        let mut request = Request {
            printer: self.settings.printer.clone(),
            load: self.settings.load.clone(),
            settings: self.settings.values(),
            copies: self.copies,
            orient,
            match_tolerance: mesh.match_tolerance,
            snap_grid: mesh.snap_grid,
            no_place: self.no_place,
            support_enforcers: self.support_enforcer.clone(),
            support_blockers: self.support_blocker.clone(),
            rotate: self.rotate,
            check: self.check,
            estimate: self.estimate_only,
            date: super::source_date_epoch(),
            ..Request::default()
        };
        request.technology = match self.technology {
            Some(TechnologyArg::Filament) => Technology::Filament,
            Some(TechnologyArg::Resin) => Technology::Resin,
            None => technology_of(&request, format).unwrap_or_default(),
        };
        let fits = |format| names::is_gcode(format) == (request.technology == Technology::Filament);
        match format.filter(|format| !fits(format)) {
            Some(format) => {
                let printers = match request.technology {
                    Technology::Filament => "filament",
                    Technology::Resin => "resin",
                };
                let problem =
                    format!("--format {format}: {printers} printers have no such files; leave it out");
                Err(BatchError::Settings(problem))
            }
            None => Ok(request),
        }
    }

    fn view(&self) -> ViewOptions {
        ViewOptions {
            quiet: self.quiet,
            json: self.json,
            folder: self.output.clone(),
            shard: self.shard.unwrap_or_default(),
            prometheus: self.prometheus.clone(),
        }
    }

    fn options(&self) -> Result<BatchOptions, BatchError> {
        let cores = || std::thread::available_parallelism().map_or(1, NonZero::get);
        let memory = self.memory.unwrap_or_else(|| memory::of_machine() / 2);
        Ok(BatchOptions {
            folder: self.output.clone(),
            resume: self.resume,
            restart: self.restart,
            retry_failed: self.retry_failed,
            shard: self.shard.unwrap_or_default(),
            threads: self.threads.map_or_else(cores, usize::from),
            limits: Limits {
                memory,
                job_memory: self.job_memory.unwrap_or(memory),
                job_seconds: self.job_time.unwrap_or(JOB_SECONDS),
                retries: self.retries,
            },
            backend: self.backend.options(self.adapter.clone(), None),
            device_workers: usize::from(self.device_workers),
            pictures: !self.no_pictures,
            estimate: self.estimate_only,
            worker: std::env::current_exe().map_err(BatchError::Worker)?,
            #[cfg(feature = "gpu")]
            fault: self.fault.clone(),
            #[cfg(not(feature = "gpu"))]
            fault: None,
        })
    }
}

fn printer_technology(technology: Technology) -> PrinterTechnology {
    match technology {
        Technology::Filament => PrinterTechnology::Fff,
        Technology::Resin => PrinterTechnology::Sla,
    }
}

/// How many jobs are not done, and where to look, where that is so.
///
/// # Errors
/// [`CliError::Unfinished`].
pub(super) fn finished(totals: &Totals, folder: &Path, shard: Shard) -> Result<(), CliError> {
    let bad = totals.failed + totals.quarantined;
    let all = totals.done + totals.skipped + bad + totals.left;
    let see = format!("see {}", batch::report::page(folder, shard).display());
    let message = match totals.exit_code() {
        0 => return Ok(()),
        9 => {
            let why = totals.stopped.as_deref().unwrap_or("stopped");
            let failed = if bad > 0 { format!(", {bad} failed") } else { String::new() };
            format!("{why}: {} of {all} jobs are not done{failed}; --resume goes on; {see}", totals.left)
        }
        code => {
            let again = batch::report::quarantine(folder, shard);
            let what = if code == 8 { "none of" } else { &format!("{bad} of") };
            let verb = if code == 8 { "succeeded" } else { "failed" };
            format!("{what} {} {verb}; {see} and {}", count(all, "job", "jobs"), again.display())
        }
    };
    Err(CliError::Unfinished(totals.exit_code(), message))
}

/// `I/N`.
fn shard(text: &str) -> Result<Shard, String> {
    let shard = text.split_once('/').and_then(|(index, count)| {
        Some(Shard { index: index.trim().parse().ok()?, count: count.trim().parse().ok()? })
    });
    shard
        .filter(|s| s.index >= 1 && s.index <= s.count)
        .ok_or_else(|| format!("`{text}` is no shard; give I/N with I from 1 to N, such as 3/10"))
}

fn seconds(text: &str) -> Result<f64, String> {
    let value = text.parse::<f64>().ok().filter(|v| *v > 0.0 && *v <= 1e7);
    value.ok_or_else(|| format!("`{text}` is no time; give seconds above 0"))
}
