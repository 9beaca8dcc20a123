//! What keeps a batch from beginning, or stops it.

use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// Why a batch did not begin, or stopped.
#[derive(Debug, Error)]
pub enum BatchError {
    /// There is nothing to do.
    #[error(
        "{input}: no model in it; give STL files, folders that hold some, globs, or a manifest (.jsonl, .csv)"
    )]
    NoModels {
        /// What was given.
        input: String,
    },
    /// A pattern of file names is wrong.
    #[error("{pattern}: {problem}; quote the pattern and close its brackets")]
    Glob {
        /// The pattern.
        pattern: String,
        /// What is wrong.
        problem: String,
    },
    /// An input is not there or cannot be read.
    #[error("{}: cannot read: {source}; check the path", path.display())]
    Input {
        /// The path.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A manifest is wrong.
    #[error("{}:{line}: {problem}", path.display())]
    Manifest {
        /// The manifest.
        path: PathBuf,
        /// Its line, from 1.
        line: u64,
        /// What is wrong, and the remedy.
        problem: String,
    },
    /// Settings that concern all jobs are wrong.
    #[error("{0}")]
    Settings(String),
    /// The output folder holds a batch already.
    #[error(
        "{}: holds a batch already; --resume goes on with it, --restart begins anew, or choose another folder with -o",
        folder.display()
    )]
    NotFresh {
        /// The folder.
        folder: PathBuf,
    },
    /// Another process works in the output folder.
    #[error("{}: another batch is at work there; wait for it, or choose another folder with -o", folder.display())]
    Locked {
        /// The folder.
        folder: PathBuf,
    },
    /// Journal, report or folder cannot be written: the batch stops.
    #[error("cannot write {}: {source}; what is done stays done: mend the cause (a full disk?), then run again with --resume", path.display())]
    Write {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A journal is of another kind or damaged beyond its last lines.
    #[error("{}:{line}: not a line of a journal: {problem}; move the file away and run with --restart", path.display())]
    Journal {
        /// The journal.
        path: PathBuf,
        /// Its line, from 1.
        line: u64,
        /// What is wrong.
        problem: String,
    },
    /// Workers cannot be started.
    #[error("cannot start a worker process: {0}")]
    Worker(io::Error),
}

impl BatchError {
    /// The exit code of a command that ends so.
    pub const fn exit_code(&self) -> u8 {
        match self {
            Self::Glob { .. } | Self::NotFresh { .. } | Self::Locked { .. } => 2,
            Self::NoModels { .. } | Self::Input { .. } => 3,
            Self::Manifest { .. } | Self::Settings(_) | Self::Journal { .. } => 4,
            Self::Write { .. } => 6,
            Self::Worker(_) => 1,
        }
    }
}
