#![allow(clippy::unwrap_used, clippy::panic)]

use super::*;

const GB: u64 = 1_000_000_000;

/// SplitMix64.
struct Random(u64);
impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (x ^ x >> 31) % n
    }

    /// Mostly small, up to `2^bits`.
    fn skewed(&mut self, bits: u64) -> u64 {
        let bits = self.below(bits);
        self.below(1 << bits)
    }
}

fn claim(seconds: f64, bytes: u64) -> Claim {
    Claim { seconds, bytes }
}

/// A worker in a simulation: what it does until when.
struct Running {
    start: Start,
    turn: Turn,
    end: f64,
}

/// Works off a schedule; jobs take what they claim, shared by their threads. Gives the starts and the time.
fn simulate(threads: usize, budget: u64, jobs: &[(Claim, Turn)], ahead: usize) -> (Vec<(f64, Start)>, f64) {
    let mut schedule = Schedule::new(threads, budget);
    let (mut time, mut known) = (0.0, 0);
    let mut running: Vec<Running> = Vec::new();
    let mut starts = Vec::new();
    loop {
        while known < jobs.len() && schedule.len() < ahead {
            schedule.add(known, jobs[known].0, jobs[known].1);
            known += 1;
            let unread = jobs[known..].iter().map(|(claim, _)| claim.seconds).sum();
            schedule.set_unread(jobs.len() - known, unread);
        }
        let load = Load {
            jobs: running.len(),
            threads: running.iter().map(|r| r.start.threads).sum(),
            seconds: running.iter().map(|r| (r.end - time) * r.start.threads as f64).sum(),
            bytes: running.iter().map(|r| r.start.claim.bytes).sum(),
            alone: running.iter().any(|r| r.turn == Turn::Alone),
        };
        if let Some(start) = schedule.next(&load) {
            assert!(start.threads >= 1 && load.threads + start.threads <= threads, "{start:?} {load:?}");
            assert!(
                load.jobs == 0 || load.bytes + start.claim.bytes <= budget,
                "{start:?} {load:?} of {budget}"
            );
            let turn = jobs[start.job].1;
            assert!(load.jobs == 0 || (turn != Turn::Alone && !load.alone), "{start:?} {load:?}");
            let end = time + start.claim.seconds / start.threads as f64;
            starts.push((time, start));
            running.push(Running { start, turn, end });
            continue;
        }
        let Some(next) = (0..running.len()).min_by(|a, b| running[*a].end.total_cmp(&running[*b].end)) else {
            break;
        };
        time = running.swap_remove(next).end;
    }
    (starts, time)
}

#[test]
fn limits_hold_and_every_job_is_done_once() {
    for seed in 0..300 {
        let mut random = Random(seed);
        let threads = 1 + random.below(9) as usize;
        let count = 1 + random.below(80) as usize;
        let jobs: Vec<(Claim, Turn)> = (0..count)
            .map(|_| {
                let turn = [Turn::Usual, Turn::Usual, Turn::Usual, Turn::Suspect, Turn::Alone];
                let seconds = 0.001 * (1 + random.skewed(14)) as f64;
                (claim(seconds, random.skewed(32)), turn[random.below(5) as usize])
            })
            .collect();
        let budget = 1 + random.below(4 * GB);
        let ahead = 1 + random.below(40) as usize;
        let (starts, _) = simulate(threads, budget, &jobs, ahead);
        let mut done: Vec<usize> = starts.iter().map(|(_, start)| start.job).collect();
        done.sort_unstable();
        assert_eq!(done, (0..count).collect::<Vec<_>>(), "seed {seed}");
        let again = simulate(threads, budget, &jobs, ahead);
        assert_eq!(again.0, starts, "seed {seed}");
    }
}

#[test]
fn all_cores_finish_together() {
    for seed in 0..40 {
        let mut random = Random(seed);
        let threads = [2, 4, 16][random.below(3) as usize];
        let mut jobs: Vec<(Claim, Turn)> = (0..500)
            .map(|_| (claim(0.005 * (1 + random.skewed(10)) as f64, GB / 100), Turn::Usual))
            .collect();
        // One that would take longer by itself than all others on the other cores.
        jobs.push((claim(300.0, GB), Turn::Usual));
        jobs.sort_by(|(a, _), (b, _)| b.seconds.total_cmp(&a.seconds));
        let (starts, time) = simulate(threads, 64 * GB, &jobs, 64);
        let ideal = jobs.iter().map(|(claim, _)| claim.seconds).sum::<f64>() / threads as f64;
        assert!(time < 1.1 * ideal, "seed {seed}: {time} s, ideal {ideal} s");
        assert!(starts[0].1.threads > 1, "seed {seed}: {:?}", starts[0]);
        // The usual job has one thread.
        let single = starts.iter().filter(|(_, start)| start.threads == 1).count();
        assert!(single > 450, "seed {seed}: {single}");
    }
}

#[test]
fn the_longest_come_first_and_equals_in_order() {
    let mut schedule = Schedule::new(1, GB);
    for (job, seconds) in [1.0, 5.0, 1.0, 0.5, 5.0].into_iter().enumerate() {
        schedule.add(job, claim(seconds, 1), Turn::Usual);
    }
    schedule.add(5, claim(9.0, 1), Turn::Suspect);
    schedule.add(6, claim(99.0, 1), Turn::Alone);
    let order: Vec<usize> = std::iter::from_fn(|| schedule.next(&Load::default())).map(|s| s.job).collect();
    assert_eq!(order, [1, 4, 0, 2, 3, 5, 6]);
    assert!(schedule.is_empty());
}

#[test]
fn a_job_that_does_not_fit_is_overtaken_but_not_for_ever() {
    // A stream of small jobs keeps half of the memory busy; the large one needs more than the other half.
    let mut jobs = vec![(claim(50.0, 6 * GB), Turn::Usual), (claim(40.0, 7 * GB), Turn::Usual)];
    jobs.extend((0..400).map(|_| (claim(1.0, GB), Turn::Usual)));
    let (starts, _) = simulate(4, 10 * GB, &jobs, 64);
    let place = starts.iter().position(|(_, start)| start.job == 1).unwrap();
    assert!((2..30).contains(&place), "small ones pass, but not all of them: {place}");
}

#[test]
fn a_job_larger_than_all_memory_runs_alone_with_all_threads() {
    let mut jobs: Vec<(Claim, Turn)> = (0..20).map(|_| (claim(1.0, GB), Turn::Usual)).collect();
    jobs.push((claim(0.5, 20 * GB), Turn::Usual));
    let (starts, _) = simulate(4, 10 * GB, &jobs, 64);
    let (_, start) = starts.iter().find(|(_, start)| start.job == 20).unwrap();
    assert_eq!(start.threads, 4);
}

#[test]
fn threads_are_shared_out_at_the_end() {
    let start = |left: &[f64]| {
        let mut schedule = Schedule::new(8, GB);
        for (job, seconds) in left.iter().enumerate() {
            schedule.add(job, claim(*seconds, 1), Turn::Usual);
        }
        schedule.next(&Load::default()).unwrap().threads
    };
    assert_eq!(start(&[3.0]), 8);
    assert_eq!(start(&[3.0, 3.0]), 4);
    assert_eq!(start(&[3.0; 8]), 1);
    assert_eq!(start(&[0.004]), 1, "more threads are of no use to a short job");
}

#[test]
fn short_jobs_wait_at_busy_workers_while_there_is_plenty() {
    let mut schedule = Schedule::new(2, GB);
    let busy = claim(0.2, 1000);
    for job in 0..6 {
        schedule.add(job, claim(0.1, 1000), Turn::Usual);
    }
    assert_eq!(schedule.next_behind(&claim(2.0, 1000)), None, "behind a long one nobody waits");
    assert_eq!(schedule.next_behind(&claim(0.2, 10)), None, "its memory would not be free");
    assert_eq!(schedule.next_behind(&busy).unwrap().job, 0);
    assert_eq!(schedule.next_behind(&busy).unwrap().job, 1);
    assert_eq!(schedule.next_behind(&busy), None, "the last few go where there is room first");
    schedule.set_unread(10, 1.0);
    assert!(schedule.next_behind(&busy).is_some());
    schedule.add(9, claim(5.0, 10), Turn::Usual);
    assert_eq!(schedule.next_behind(&busy), None, "a long job waits for an idle worker");
}
