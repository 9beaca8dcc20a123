//! The command line.

pub mod batch;
pub mod batch_view;
pub mod bench;
pub mod contours;
pub mod below;
pub mod demo;
pub mod devices;
pub mod exit;
pub mod inspect;
mod interrupt;
pub mod mask;
pub mod mesh_args;
pub mod options;
pub mod printers;
pub mod progress;
pub mod report;
pub mod reports;
pub mod setting_flags;
pub mod slice;
pub mod support_args;
pub mod worker;

use clap::{Parser, Subcommand};
use exit::CliError;
use std::io::Write;
use std::process::ExitCode;

/// Slices triangle meshes for 3D printers, on the CPU or on a GPU, with the same bytes.
#[derive(Debug, Parser)]
#[command(name = "microtome", version, after_help = exit::EXIT_CODES, subcommand_required = true, arg_required_else_help = true)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Slice a model into G-code
    Slice(slice::SliceArgs),
    /// Slice thousands of models: files, folders, patterns, manifests; nothing is lost, --resume goes on
    Batch(batch::BatchArgs),
    /// Answer requests, lines of JSON on standard input, with a device and caches that stay warm
    Worker(worker::WorkerArgs),
    /// Join the reports of batches and shards into one
    Report(reports::ReportArgs),
    /// Cut a model into contours: SVG, JSON, WKT, Common Layer Interface, or a folder of pictures
    Contours(contours::ContoursArgs),
    /// Slice the built-in part into demo.gcode and demo.png, and compare CPU and GPU
    Demo(demo::DemoArgs),
    /// Cut a model off at a height: the part as printed so far, as STL
    Below(below::BelowArgs),
    /// Cut models into the layer masks of a resin printer
    Mask(mask::MaskArgs),
    /// Read a resin printer's file, check every layer, say what is in it
    Inspect(inspect::InspectArgs),
    /// List the GPUs and say which one `--backend auto` would take, and why
    Devices(devices::DevicesArgs),
    /// List the resin printers that are known by name, or describe one as a settings file
    Printers(printers::PrintersArgs),
    /// Time slicing stage by stage: the literature's algorithms, the CPU, GPUs; compare what they give
    Bench(bench::BenchArgs),
}

/// Runs the program on the process's arguments.
pub fn main() -> ExitCode {
    #[cfg(all(feature = "gpu", target_os = "linux"))]
    hush_wayland();
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(e) => {
            // Help and version go to stdout and are no errors; a closed pipe is none either.
            drop(e.print());
            return ExitCode::from(if e.use_stderr() { 2 } else { 0 });
        }
    };
    let outcome = std::panic::catch_unwind(|| run(&cli.command));
    match outcome {
        Ok(Ok(())) => ExitCode::SUCCESS,
        Ok(Err(e)) => {
            let code = e.code();
            if code != ExitCode::SUCCESS {
                drop(writeln!(std::io::stderr(), "error: {e}"));
            }
            code
        }
        Err(_) => {
            drop(writeln!(
                std::io::stderr(),
                "error: this is a defect of microtome, please report it with the model and the command; no output was written"
            ));
            ExitCode::from(1)
        }
    }
}

/// Keeps the driver's look for a Wayland display from complaining on stderr where there is no session, as
/// on a server: it wants an absolute path, and finds nothing there.
#[cfg(all(feature = "gpu", target_os = "linux"))]
fn hush_wayland() {
    const NAME: &str = "XDG_RUNTIME_DIR";
    if std::env::var_os(NAME).is_none() {
        // SAFETY: `main` calls this before anything else, so that no other thread reads the environment. A
        // folder that nobody can make, unlike one in the temporary folder, holds nobody's socket.
        unsafe { std::env::set_var(NAME, "/nonexistent") };
    }
}

fn run(command: &Command) -> Result<(), CliError> {
    match command {
        Command::Slice(args) => slice::run(args),
        Command::Mask(args) => mask::run(args),
        Command::Batch(args) => batch::run(args),
        Command::Worker(args) => worker::run(args),
        Command::Report(args) => reports::run(args),
        Command::Contours(args) => contours::run(args),
        Command::Demo(args) => demo::run(args),
        Command::Below(args) => below::run(args),
        Command::Inspect(args) => inspect::run(args),
        Command::Devices(args) => devices::run(args),
        Command::Printers(args) => printers::run(args),
        Command::Bench(args) => bench::run(args),
    }
}

/// The date that goes into files: `SOURCE_DATE_EPOCH` (reproducible-builds.org), else 1970-01-01, so that
/// two runs give the same bytes.
fn source_date_epoch() -> i64 {
    let given = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|v| v.trim().parse::<i64>().ok());
    // The year 9999 is as far as the date format reaches.
    given.unwrap_or(0).clamp(0, 253_402_300_799)
}
