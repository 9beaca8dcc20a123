//! `microtome batch`.

use super::exit::CliError;
use super::options::{BackendArg, memory_size};
use crate::batch::shard::Shard;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

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
}

/// Runs a batch.
///
/// # Errors
/// [`CliError`]: the batch could not begin or had to stop, or not all jobs were done.
pub fn run(args: &BatchArgs) -> Result<(), CliError> {
    let _ = args;
    Ok(())
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
