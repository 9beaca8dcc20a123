//! Which job comes next, and with how many threads.
//!
//! Longest first (Graham, "Bounds on multiprocessing timing anomalies", 1969): what is left for the end is
//! short, so that all cores finish together. A job normally has one thread, as many jobs side by side waste
//! less than one job on many threads. The exceptions are a job so long that the rest would be done before
//! it, and the last few jobs.

pub mod estimate;
#[cfg(test)]
mod tests;

pub use estimate::{Claim, Estimator};

use std::cmp::Reverse;
use std::collections::BTreeMap;

/// A job that does not fit into memory is overtaken by so many others before these have to wait too.
const PATIENCE: u32 = 16;

/// More threads than one are of no use to a job shorter than this per thread \[s\].
const SHORTEST_SHARE: f64 = 0.02;

/// A job that ends so much later than all others together might is not worth a thread more.
const LATE: f64 = 1.1;

/// Jobs up to this long may be handed to a worker that is still busy \[s\]. If the worker takes longer than
/// foreseen the job waits behind it while others might be free.
const SHORT: f64 = 0.3;

/// Which jobs have to let others go first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Turn {
    /// In order of length.
    #[default]
    Usual,
    /// After all usual ones: it was in hand when a supervisor died, and may be the cause.
    Suspect,
    /// After all others, and alone: it took more memory than there was beside others.
    Alone,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Rank {
    turn: Turn,
    micros: Reverse<u64>,
    job: usize,
}

#[derive(Clone, Copy, Debug)]
struct Waiting {
    claim: Claim,
    overtaken: u32,
}

/// What is in hand at the moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Load {
    /// Jobs.
    pub jobs: usize,
    /// Their threads.
    pub threads: usize,
    /// What they still have to do \[thread seconds\].
    pub seconds: f64,
    /// Memory, claimed or taken, whichever is more, with that of idle workers and our own \[bytes\].
    pub bytes: u64,
    /// Whether one of them is to be alone.
    pub alone: bool,
}

/// A job to be begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Start {
    /// Which.
    pub job: usize,
    /// With so many threads.
    pub threads: usize,
    /// What it is taken to need.
    pub claim: Claim,
}

/// Jobs that wait for their turn. What it says depends on nothing but the order of calls.
#[derive(Clone, Debug)]
pub struct Schedule {
    threads: usize,
    budget: u64,
    waiting: BTreeMap<Rank, Waiting>,
    seconds: f64,
    unread: (usize, f64),
}

impl Schedule {
    /// An empty schedule for so many threads and so much memory \[bytes\] in all.
    pub fn new(threads: usize, budget: u64) -> Self {
        Self { threads: threads.max(1), budget, waiting: BTreeMap::new(), seconds: 0.0, unread: (0, 0.0) }
    }

    /// Adds a job, counted from 0 in the order of the batch, which decides between equals.
    pub fn add(&mut self, job: usize, claim: Claim, turn: Turn) {
        let rank = Rank { turn, micros: Reverse((claim.seconds * 1e6) as u64), job };
        if self.waiting.insert(rank, Waiting { claim, overtaken: 0 }).is_none() {
            self.seconds += claim.seconds;
        }
    }

    /// How many jobs are still to be added at most, and what they take on one thread \[s\].
    pub fn set_unread(&mut self, jobs: usize, seconds: f64) {
        self.unread = (jobs, seconds);
    }

    /// How many jobs wait.
    pub fn len(&self) -> usize {
        self.waiting.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// The job that an idle worker is to do now, if there is one that fits. One that is larger than all
    /// memory runs alone.
    pub fn next(&mut self, load: &Load) -> Option<Start> {
        let free = self.threads.checked_sub(load.threads).filter(|free| *free > 0 && !load.alone)?;
        let mut found = None;
        for (rank, waiting) in &self.waiting {
            let room =
                rank.turn != Turn::Alone && load.bytes.saturating_add(waiting.claim.bytes) <= self.budget;
            if room || load.jobs == 0 {
                found = Some((*rank, waiting.claim));
                break;
            }
            if waiting.overtaken >= PATIENCE {
                return None;
            }
        }
        let (rank, claim) = found?;
        for (_, waiting) in self.waiting.range_mut(..rank) {
            waiting.overtaken += 1;
        }
        // Nothing may run beside a job that is alone, so that it has all threads.
        let fits = load.bytes.saturating_add(claim.bytes) <= self.budget;
        let threads = if rank.turn == Turn::Alone || !fits {
            free.min(useful(claim.seconds))
        } else {
            self.share(&claim, load, free)
        };
        self.remove(&rank);
        Some(Start { job: rank.job, threads, claim })
    }

    /// A short job for a worker that is still busy with one of this claim, so that it need not wait for us
    /// in between. Only while there is plenty to do, as the job cannot move to another worker easily.
    pub fn next_behind(&mut self, busy: &Claim) -> Option<Start> {
        let plenty = self.waiting.len() + self.unread.0 > 2 * self.threads;
        let (rank, waiting) = self.waiting.first_key_value()?;
        let (rank, claim) = (*rank, waiting.claim);
        let short = busy.seconds.max(claim.seconds) <= SHORT;
        // It comes when the other's memory is free again.
        let fits = claim.bytes <= busy.bytes && waiting.overtaken == 0;
        (plenty && short && fits && rank.turn == Turn::Usual).then(|| {
            self.remove(&rank);
            Start { job: rank.job, threads: 1, claim }
        })
    }

    fn remove(&mut self, rank: &Rank) {
        if let Some(waiting) = self.waiting.remove(rank) {
            self.seconds = if self.waiting.is_empty() { 0.0 } else { self.seconds - waiting.claim.seconds };
        }
    }

    /// Threads for a job that waits: as few as finish it about together with all the others, or, where fewer
    /// jobs than threads are left, its part of these.
    fn share(&self, claim: &Claim, load: &Load, free: usize) -> usize {
        let all = (load.seconds + self.seconds + self.unread.1) / self.threads as f64;
        let critical = (claim.seconds / (all * LATE).max(1e-9)).ceil() as usize;
        let left = (self.waiting.len() + self.unread.0).max(1);
        critical.max(free / left).clamp(1, free).min(useful(claim.seconds))
    }
}

/// More threads than this do not make a job of that length \[s\] shorter.
fn useful(seconds: f64) -> usize {
    ((seconds / SHORTEST_SHARE) as usize).max(1)
}
