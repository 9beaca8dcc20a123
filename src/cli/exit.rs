//! Exit codes: what a script can tell from them.

use super::setting_flags::FlagError;
use crate::batch::BatchError;
use crate::bench::BenchError;
use crate::export::UnknownFormat;
use crate::job::JobError;
use crate::resin::ReadError;
use crate::settings::printers::PrinterError;
use std::path::PathBuf;
use std::process::ExitCode;
use thiserror::Error;

/// Printed under `microtome --help`.
pub const EXIT_CODES: &str = "Exit codes:
  0  done; the output is complete
  1  a defect of microtome itself; no output was written
  2  the command line was not understood
  3  the model cannot be read, sliced or placed, or a container is damaged
  4  a setting, a list of planes or a G-code template is wrong
  5  the GPU asked for is missing or failed
  6  the output cannot be written
  7  batch: some jobs failed; the others are done
  8  batch: no job succeeded
  9  batch: stopped on the way; --resume goes on
A message on stderr names the file, the place and the remedy. With any code but 0 the output file is as it was before.";

/// Why a command ended early.
#[derive(Debug, Error)]
pub enum CliError {
    /// A setting on the command line, or in a file that it names, is wrong.
    #[error(transparent)]
    Setting(#[from] FlagError),
    /// No printer has the name given.
    #[error(transparent)]
    Printer(#[from] PrinterError),
    /// The name of an output says nothing about its format.
    #[error(transparent)]
    Format(#[from] UnknownFormat),
    /// A job failed.
    #[error(transparent)]
    Job(#[from] JobError),
    /// A benchmark failed, or its outputs differ.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// A device gave other bytes than the CPU.
    #[error(
        "{adapter} gave other bytes than the CPU; please report this with the output of `microtome devices`; use --backend cpu"
    )]
    Differs {
        /// The device.
        adapter: String,
    },
    /// A file of a resin printer cannot be read.
    #[error("{}: {source}", path.display())]
    Container {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ReadError,
    },
    /// Layers of such a file cannot be read.
    #[error("{}: {damaged} of {layers} layers are damaged; the first: {first}", path.display())]
    DamagedLayers {
        /// The file.
        path: PathBuf,
        /// Number of damaged layers.
        damaged: u32,
        /// Number of layers.
        layers: u32,
        /// What is wrong with the first.
        first: ReadError,
    },
    /// A layer that the print does not have.
    #[error("--picture-layer {index}: the print has {count} layers, counted from 0; choose among these")]
    NoSuchLayer {
        /// The layer asked for.
        index: usize,
        /// Number of layers.
        count: usize,
    },
    /// A batch could not be begun or had to stop.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// Not all jobs of a batch are done: 7, 8 or 9, and how many, in one line.
    #[error("{1}")]
    Unfinished(u8, String),
    /// Standard output could not be written.
    #[error("cannot write to standard output: {0}")]
    Stdout(#[from] std::io::Error),
}

impl CliError {
    /// The exit code of this failure; 0 where only the reader of a pipe has gone.
    pub fn code(&self) -> ExitCode {
        ExitCode::from(match self {
            Self::Format(_) => 2,
            Self::Setting(_) | Self::Printer(_) | Self::NoSuchLayer { .. } => 4,
            Self::Container { .. } | Self::DamagedLayers { .. } => 3,
            Self::Differs { .. } => 5,
            Self::Stdout(e) if e.kind() == std::io::ErrorKind::BrokenPipe => 0,
            Self::Stdout(_) => 6,
            Self::Bench(BenchError::Different { .. }) => 1,
            Self::Bench(BenchError::Threads { .. }) => 2,
            Self::Job(JobError::Output(e)) if e.is_broken_pipe() => 0,
            Self::Job(e) | Self::Bench(BenchError::Job(e)) => e.kind().exit_code(),
            Self::Batch(e) => e.exit_code(),
            Self::Unfinished(code, _) => *code,
        })
    }
}
