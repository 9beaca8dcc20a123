//! News of a running batch.

use super::key::Key;
use crate::slicer::{Failure, Outcome};
use serde::{Deserialize, Serialize};

/// What happened. `name` is that of [`super::Item`]; jobs are told apart by it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "event", rename_all = "snake_case")]
pub enum Event<'a> {
    /// The batch begins.
    Begun {
        /// Jobs of this shard, as far as known: all jobs where there are several shards.
        jobs: usize,
        /// Bytes of their models.
        bytes: u64,
        /// Worker processes.
        workers: usize,
    },
    /// A job that belongs to another shard.
    Elsewhere {
        /// The job.
        name: &'a str,
        /// Size of its model \[bytes\].
        size: u64,
    },
    /// A job that an earlier run has done.
    Skipped {
        /// The job.
        name: &'a str,
        /// Size of its model \[bytes\].
        size: u64,
        /// Whether the earlier run had failed at it, so that it still counts as failed.
        failed: bool,
    },
    /// A worker has begun.
    Started {
        /// The job.
        name: &'a str,
        /// Counted from 1.
        attempt: u32,
        /// Number of the worker, from 0.
        worker: usize,
    },
    /// Done; the output is in its place.
    Done {
        /// The job.
        name: &'a str,
        /// Size of its model \[bytes\].
        size: u64,
        /// What came of it.
        outcome: &'a Outcome,
    },
    /// A try failed.
    Failed {
        /// The job.
        name: &'a str,
        /// Size of its model \[bytes\].
        size: u64,
        /// Why.
        failure: &'a Failure,
        /// Counted from 1.
        attempt: u32,
        /// Whether it will be tried again.
        again: bool,
    },
    /// A worker process died or was killed, and another took its place.
    WorkerLost {
        /// Number of the worker, from 0.
        worker: usize,
        /// Why.
        reason: &'a str,
    },
    /// Something that the whole batch should know.
    Warning {
        /// What, in one line.
        message: &'a str,
    },
    /// The batch has ended.
    Ended(&'a Totals),
}

/// How a job ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// The output is in its place.
    Done,
    /// It will fail again: the model or its settings are wrong.
    Failed,
    /// It crashed its worker, broke a limit or kept failing: not to be tried again without a look.
    Quarantined,
}

/// One job in a report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Row {
    /// The output's name in the output folder.
    pub name: String,
    /// The model.
    pub model: String,
    /// How it ended.
    pub status: Status,
    /// What it is.
    pub key: Key,
    /// SHA-256 of the model.
    pub sha256: String,
    /// Copies on the bed.
    pub copies: u32,
    /// Tries.
    pub attempts: u32,
    /// What came of it, if it was done.
    pub outcome: Option<Outcome>,
    /// Why not, otherwise.
    pub failure: Option<Failure>,
    /// The request, so that what failed can be asked for again.
    pub request: crate::slicer::Request,
}

/// Sums over a batch.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Totals {
    /// Jobs done by this run.
    pub done: usize,
    /// Jobs that an earlier run had done.
    pub skipped: usize,
    /// Jobs that failed, in this run or earlier.
    pub failed: usize,
    /// Jobs put into quarantine, in this run or earlier.
    pub quarantined: usize,
    /// Jobs of other shards.
    pub elsewhere: usize,
    /// Jobs not reached, because the batch was stopped.
    pub left: usize,
    /// Further tries.
    pub retries: usize,
    /// Worker processes lost.
    pub workers_lost: usize,
    /// Wall time \[s\].
    pub seconds: f64,
    /// Most memory of all workers together, as sampled \[bytes\].
    pub peak_bytes: u64,
    /// Why the batch stopped before its end.
    pub stopped: Option<String>,
}

impl Totals {
    /// 0 = all good, 7 = some failed, 8 = none succeeded, 9 = stopped on the way.
    pub const fn exit_code(&self) -> u8 {
        let (good, bad) = (self.done + self.skipped, self.failed + self.quarantined);
        match (self.stopped.is_some() || self.left > 0, good, bad) {
            (true, ..) => 9,
            (_, _, 0) => 0,
            (_, 0, _) => 8,
            _ => 7,
        }
    }
}

/// Receives the news, all from one thread.
pub trait Observer {
    /// Something happened.
    fn event(&mut self, event: &Event<'_>);

    /// Called a few times a second, and by each event.
    fn tick(&mut self) {}

    /// Whether the batch is to stop; what is in hand is given up.
    fn stop(&mut self) -> bool {
        false
    }
}
