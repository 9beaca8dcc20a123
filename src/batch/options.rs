//! How a batch is run.

use super::shard::Shard;
use crate::job::backend::BackendOptions;
use std::path::PathBuf;

/// Limits of single jobs and of all together.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// Memory of all workers together \[bytes\].
    pub memory: u64,
    /// Memory of one job \[bytes\].
    pub job_memory: u64,
    /// Wall time of one job \[s\].
    pub job_seconds: f64,
    /// Further tries after a failure that may pass.
    pub retries: u32,
}

/// How a batch is run.
#[derive(Clone, Debug)]
pub struct BatchOptions {
    /// The output folder; made if it is not there.
    pub folder: PathBuf,
    /// Go on where an earlier run ended; on a fresh folder simply start.
    pub resume: bool,
    /// Forget earlier runs. Their outputs stay until they are replaced.
    pub restart: bool,
    /// With `resume`: try again what failed for good.
    pub retry_failed: bool,
    /// Which part of the batch is ours.
    pub shard: Shard,
    /// CPU threads of all workers together.
    pub threads: usize,
    /// Limits.
    pub limits: Limits,
    /// Where planes and triangles are intersected.
    pub backend: BackendOptions,
    /// Workers that may use a GPU at a time where that is left to us.
    pub device_workers: usize,
    /// A small picture of a layer of each job, for the report.
    pub pictures: bool,
    /// Only say what would be printed.
    pub estimate: bool,
    /// The program that works; `microtome` itself.
    pub worker: PathBuf,
    /// A failure that GPUs of workers play, as for `microtome worker --fault`, for trying out what follows from it.
    #[doc(hidden)]
    pub fault: Option<String>,
}
