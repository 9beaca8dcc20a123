//! Where a running batch stands: counts, rate and time left, from its events.

use super::event::{Event, Status, Totals};
use crate::job::FailureKind;
use crate::slicer::Failure;
use std::collections::BTreeMap;

/// What a job costs beside its triangles, as bytes of its model: layers, fills and output of a part of any
/// size. Without it the time left would be far too short where the small models come last.
const JOB_WEIGHT: u64 = 1 << 20;

/// What a worker is at.
#[derive(Clone, Debug, PartialEq)]
pub struct Doing {
    /// The job.
    pub name: String,
    /// Counted from 1.
    pub attempt: u32,
    /// When it began, on the clock of [`Tally::event`] \[s\].
    pub since: f64,
}

/// Counts of a running batch. Times are seconds since its begin, told by the caller.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Jobs of this shard, as far as known.
    pub jobs: usize,
    /// Bytes of their models.
    pub bytes: u64,
    /// Jobs done by this run.
    pub done: usize,
    /// Jobs that an earlier run had done.
    pub skipped: usize,
    /// Jobs that failed, in this run or earlier.
    pub failed: usize,
    /// Jobs that crashed their worker, broke a limit or kept failing.
    pub quarantined: usize,
    /// Jobs of other shards.
    pub elsewhere: usize,
    /// Further tries.
    pub retries: usize,
    /// Worker processes lost.
    pub workers_lost: usize,
    /// Bytes of the models of all jobs that have ended, in this run or earlier.
    pub bytes_done: u64,
    /// Jobs done with warnings.
    pub with_warnings: usize,
    /// Length of filament of the jobs done by this run \[mm\].
    pub filament_mm: f64,
    /// Volume of the same \[cm³\].
    pub cm3: f64,
    /// Mass of those whose density is known \[g\].
    pub g: f64,
    /// Price of those for which it is known.
    pub cost: f64,
    /// What each worker is at.
    pub workers: Vec<Option<Doing>>,
    /// The most memory a worker has reported, summed over workers; at the end that of all together \[bytes\].
    pub peak_bytes: u64,
    /// Jobs that ended in this run, for good or bad, with what they weighed.
    worked: (usize, u64),
    worker_peaks: BTreeMap<usize, u64>,
    ended: bool,
}

impl Tally {
    /// Takes an event in.
    pub fn event(&mut self, event: &Event<'_>, now: f64) {
        match *event {
            Event::Begun { jobs, bytes, workers } => {
                (self.jobs, self.bytes) = (jobs, bytes);
                self.workers = vec![None; workers];
            }
            Event::Elsewhere { size, .. } => {
                self.elsewhere += 1;
                self.jobs = self.jobs.saturating_sub(1);
                self.bytes = self.bytes.saturating_sub(size);
            }
            Event::Skipped { size, failed, .. } => {
                *(if failed { &mut self.failed } else { &mut self.skipped }) += 1;
                self.bytes_done += size;
            }
            Event::Started { name, attempt, worker } => {
                if self.workers.len() <= worker {
                    self.workers.resize(worker + 1, None);
                }
                self.workers[worker] = Some(Doing { name: name.to_owned(), attempt, since: now });
            }
            Event::Done { name, size, outcome } => {
                self.done += 1;
                self.gone(size);
                self.with_warnings += usize::from(!outcome.warnings.is_empty());
                self.filament_mm += outcome.material.mm;
                self.cm3 += outcome.material.cm3;
                self.g += outcome.material.g.unwrap_or(0.0);
                self.cost += outcome.material.cost.unwrap_or(0.0);
                if let Some(worker) = self.free(name) {
                    let peak = self.worker_peaks.entry(worker).or_default();
                    *peak = outcome.peak_bytes.max(*peak);
                    self.peak_bytes = self.peak_bytes.max(self.worker_peaks.values().sum());
                }
            }
            Event::Failed { name, size, failure, again, .. } => {
                self.free(name);
                if again {
                    self.retries += 1;
                    return;
                }
                *(match verdict(failure) {
                    Status::Quarantined => &mut self.quarantined,
                    Status::Done | Status::Failed => &mut self.failed,
                }) += 1;
                self.gone(size);
            }
            Event::WorkerLost { worker, .. } => {
                self.workers_lost += 1;
                if let Some(doing) = self.workers.get_mut(worker) {
                    *doing = None;
                }
            }
            Event::Warning { .. } => {}
            Event::Ended(totals) => self.end(totals),
        }
    }

    /// Jobs that workers are at.
    pub fn running(&self) -> usize {
        self.workers.iter().flatten().count()
    }

    /// Jobs that have ended, in this run or earlier.
    pub const fn ended(&self) -> usize {
        self.done + self.skipped + self.failed + self.quarantined
    }

    /// Jobs that nobody is at.
    pub fn waiting(&self) -> usize {
        self.jobs.saturating_sub(self.ended() + self.running())
    }

    /// Whether the batch has ended.
    pub const fn is_over(&self) -> bool {
        self.ended
    }

    /// What is done and what there is, as [`Self::eta`] weighs it.
    pub const fn weight(&self) -> (u64, u64) {
        let done = self.bytes_done + self.ended() as u64 * JOB_WEIGHT;
        (done, self.bytes + self.jobs as u64 * JOB_WEIGHT)
    }

    /// Models that this run has finished, a minute. Skipped ones do not count.
    pub fn models_per_minute(&self, now: f64) -> f64 {
        if now > 0.0 { self.worked.0 as f64 * 60.0 / now } else { 0.0 }
    }

    /// Time left \[s\], once there is something to judge by: models cost by their bytes, plus the same for each.
    pub fn eta(&self, now: f64) -> Option<f64> {
        if self.ended {
            return Some(0.0);
        }
        let (done, all) = self.weight();
        (self.worked.1 > 0).then(|| now * all.saturating_sub(done) as f64 / self.worked.1 as f64)
    }

    fn gone(&mut self, size: u64) {
        self.bytes_done += size;
        self.worked.0 += 1;
        self.worked.1 += size + JOB_WEIGHT;
    }

    fn free(&mut self, name: &str) -> Option<usize> {
        let worker = self.workers.iter().position(|w| w.as_ref().is_some_and(|d| d.name == name))?;
        self.workers[worker] = None;
        Some(worker)
    }

    fn end(&mut self, totals: &Totals) {
        (self.done, self.skipped) = (totals.done, totals.skipped);
        (self.failed, self.quarantined) = (totals.failed, totals.quarantined);
        (self.retries, self.workers_lost) = (totals.retries, totals.workers_lost);
        self.peak_bytes = self.peak_bytes.max(totals.peak_bytes);
        self.workers.fill(None);
        self.ended = true;
    }
}

/// How a failure that is not tried again ends its job.
pub const fn verdict(failure: &Failure) -> Status {
    match failure.kind {
        FailureKind::Model | FailureKind::Settings => Status::Failed,
        _ => Status::Quarantined,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slicer::Outcome;

    const MIB: u64 = 1 << 20;

    fn done(tally: &mut Tally, name: &str, size: u64, now: f64) {
        tally.event(&Event::Started { name, attempt: 1, worker: 0 }, now);
        tally.event(&Event::Done { name, size, outcome: &Outcome::default() }, now);
    }

    #[test]
    fn small_models_at_the_end_take_their_time() {
        let mut tally = Tally::default();
        tally.event(&Event::Begun { jobs: 11, bytes: 9 * MIB, workers: 1 }, 0.0);
        assert_eq!(tally.eta(1.0), None);
        done(&mut tally, "large", 9 * MIB, 10.0);
        assert!((tally.eta(10.0).unwrap_or_default() - 10.0).abs() < 1e-9, "{:?}", tally.eta(10.0));
        assert!((tally.models_per_minute(10.0) - 6.0).abs() < 1e-9);
    }

    #[test]
    fn skipped_jobs_and_those_of_others_are_no_measure_of_speed() {
        let mut tally = Tally::default();
        tally.event(&Event::Begun { jobs: 4, bytes: 4 * MIB, workers: 1 }, 0.0);
        tally.event(&Event::Skipped { name: "a", size: MIB, failed: false }, 0.0);
        tally.event(&Event::Elsewhere { name: "b", size: MIB }, 0.0);
        done(&mut tally, "c", MIB, 3.0);
        assert_eq!((tally.jobs, tally.ended(), tally.waiting()), (3, 2, 1));
        assert!((tally.eta(3.0).unwrap_or_default() - 3.0).abs() < 1e-9);
        assert!((tally.models_per_minute(3.0) - 20.0).abs() < 1e-9);
    }

    #[test]
    fn failures_are_told_apart_and_free_their_worker() {
        let mut tally = Tally::default();
        tally.event(&Event::Begun { jobs: 2, bytes: 0, workers: 2 }, 0.0);
        for (name, kind, worker) in [("a", FailureKind::Model, 0), ("b", FailureKind::Crashed, 1)] {
            let failure = Failure::new(kind, String::new());
            tally.event(&Event::Started { name, attempt: 1, worker }, 0.0);
            assert_eq!(tally.running(), 1);
            let again = Event::Failed { name, size: 1, failure: &failure, attempt: 1, again: true };
            tally.event(&again, 1.0);
            assert_eq!(tally.running(), 0);
            tally.event(&Event::Started { name, attempt: 2, worker }, 1.0);
            let last = Event::Failed { name, size: 1, failure: &failure, attempt: 2, again: false };
            tally.event(&last, 2.0);
        }
        assert_eq!((tally.failed, tally.quarantined, tally.retries), (1, 1, 2));
        assert_eq!((tally.ended(), tally.waiting(), tally.bytes_done), (2, 0, 2));
    }

    #[test]
    fn memory_is_summed_over_workers() {
        let mut tally = Tally::default();
        tally.event(&Event::Begun { jobs: 3, bytes: 0, workers: 2 }, 0.0);
        for (name, worker, peak_bytes) in [("a", 0, 5), ("b", 1, 7), ("c", 0, 4)] {
            tally.event(&Event::Started { name, attempt: 1, worker }, 0.0);
            let outcome = Outcome { peak_bytes, ..Outcome::default() };
            tally.event(&Event::Done { name, size: 0, outcome: &outcome }, 0.0);
        }
        assert_eq!(tally.peak_bytes, 12);
    }
}
