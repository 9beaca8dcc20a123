//! Limits of time and memory.

use crate::batch::options::Limits;
use crate::batch::pool::{RETIRE_BYTES, Sentence, Slot};

/// What is to be done about a worker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Measure {
    /// It is idle and holds memory that others need.
    Retire,
    /// It or its job goes too far.
    Kill(Sentence),
}

/// A worker as the watch sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Watched {
    /// How long its job has taken \[s\]; `None` = it has none.
    pub seconds: Option<f64>,
    /// What its job was taken to need \[bytes\].
    pub claim: u64,
    /// What it takes \[bytes\].
    pub resident: u64,
    /// Whether its end is on its way.
    pub condemned: bool,
}

impl From<&Slot> for Watched {
    fn from(slot: &Slot) -> Self {
        let task = slot.hand().front();
        Self {
            seconds: task.map(|task| task.since.elapsed().as_secs_f64()),
            claim: task.map_or(0, |task| task.claim.bytes),
            resident: slot.resident,
            condemned: slot.condemned(),
        }
    }
}

/// Measures against workers, by number. `own` is the memory of this process \[bytes\].
pub(super) fn measures(workers: &[Watched], own: u64, limits: &Limits) -> Vec<(usize, Measure)> {
    let mut found = Vec::new();
    let alive = || workers.iter().enumerate().filter(|(_, w)| !w.condemned);
    for (number, worker) in alive() {
        match worker.seconds {
            Some(seconds) if seconds > limits.job_seconds => {
                found.push((number, Measure::Kill(Sentence::Time)));
            }
            Some(_) if worker.resident > limits.job_memory => {
                found.push((number, Measure::Kill(Sentence::Memory)));
            }
            None if worker.resident > RETIRE_BYTES => found.push((number, Measure::Retire)),
            _ => {}
        }
    }
    let sum = own + workers.iter().map(|w| w.resident).sum::<u64>();
    // One measure at a time: what it frees is seen at the next look.
    if sum > limits.memory && found.is_empty() && workers.iter().all(|w| !w.condemned) {
        let idle = alive().filter(|(_, w)| w.seconds.is_none()).max_by_key(|(_, w)| w.resident);
        let busy = || alive().filter(|(_, w)| w.seconds.is_some());
        // The one that exceeds its claim most; the youngest of equals has the least to lose.
        let excess = |w: &Watched| i128::from(w.resident) - i128::from(w.claim);
        let youth = |a: &Watched, b: &Watched| b.seconds.partial_cmp(&a.seconds);
        let worst = busy().max_by(|(_, a), (_, b)| {
            excess(a).cmp(&excess(b)).then(youth(a, b).unwrap_or(std::cmp::Ordering::Equal))
        });
        match (idle, worst, busy().count()) {
            (Some((number, worker)), ..) if worker.resident > WORTH => found.push((number, Measure::Retire)),
            (_, Some((number, _)), 1) => found.push((number, Measure::Kill(Sentence::Memory))),
            (_, Some((number, _)), _) => found.push((number, Measure::Kill(Sentence::Crowd))),
            _ => {}
        }
    }
    found
}

/// A fresh process holds about this much, so that replacing one that holds less frees nothing \[bytes\].
const WORTH: u64 = 32 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    const MB: u64 = 1_000_000;

    fn limits() -> Limits {
        Limits { memory: 1000 * MB, job_memory: 800 * MB, job_seconds: 60.0, retries: 2 }
    }

    fn busy(seconds: f64, claim: u64, resident: u64) -> Watched {
        Watched { seconds: Some(seconds), claim: claim * MB, resident: resident * MB, ..Watched::default() }
    }

    #[test]
    fn what_keeps_within_limits_is_left_alone() {
        let all = [busy(59.0, 100, 700), busy(1.0, 10, 200), Watched::default()];
        assert!(measures(&all, 50 * MB, &limits()).is_empty());
    }

    #[test]
    fn each_limit_is_seen() {
        let kill = |number, sentence| vec![(number, Measure::Kill(sentence))];
        let of = |all: &[Watched]| measures(all, 50 * MB, &limits());
        assert_eq!(of(&[busy(61.0, 1, 1)]), kill(0, Sentence::Time));
        assert_eq!(of(&[busy(1.0, 1, 1), busy(1.0, 900, 801)]), kill(1, Sentence::Memory));
        // Both fit by themselves; the second takes 400 MB more than it claimed, the first only 100.
        assert_eq!(of(&[busy(9.0, 450, 550), busy(5.0, 0, 400), busy(1.0, 1, 1)]), kill(1, Sentence::Crowd));
        assert_eq!(of(&[busy(9.0, 100, 500), busy(5.0, 100, 500)]), kill(1, Sentence::Crowd), "the youngest");
        let idle = Watched { resident: 200 * MB, ..Watched::default() };
        assert_eq!(of(&[busy(9.0, 500, 790), idle]), vec![(1, Measure::Retire)], "an idle one goes first");
        let idle = Watched { resident: 300 * MB, ..Watched::default() };
        assert_eq!(of(&[idle]), vec![(0, Measure::Retire)]);
    }

    #[test]
    fn nobody_is_ended_twice() {
        let condemned = Watched { condemned: true, ..busy(61.0, 0, 900) };
        assert!(measures(&[condemned, busy(1.0, 1, 500)], 0, &limits()).is_empty());
    }

    #[test]
    fn alone_over_the_budget_is_over_the_limit() {
        let limits = Limits { job_memory: u64::MAX, ..limits() };
        assert_eq!(measures(&[busy(1.0, 1, 1001)], 0, &limits), vec![(0, Measure::Kill(Sentence::Memory))]);
    }
}
