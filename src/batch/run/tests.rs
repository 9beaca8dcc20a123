//! Batches with workers that do what the names of their models say.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use crate::batch::event::{Event, Observer, Row, Status, Totals};
use crate::batch::options::Limits;
use crate::batch::{BatchError, BatchOptions, Item, Shard, journal, run};
use crate::job::FailureKind;
use crate::job::backend::{Backend, BackendOptions};
use crate::slicer::{Failure, Request};
use std::path::{Path, PathBuf};

/// What happened, as words, and when to stop.
#[derive(Default)]
struct Witness {
    seen: Vec<String>,
    stop_after: Option<usize>,
}

impl Observer for Witness {
    fn event(&mut self, event: &Event<'_>) {
        let word = match event {
            Event::Failed { name, again: true, attempt, .. } => format!("{name} again {attempt}"),
            Event::Failed { name, attempt, .. } => format!("{name} failed {attempt}"),
            Event::Done { name, .. } => format!("{name} done"),
            Event::Started { name, attempt, .. } => format!("{name} started {attempt}"),
            Event::WorkerLost { .. } => "lost".to_owned(),
            Event::Warning { .. } => "warning".to_owned(),
            Event::Skipped { name, failed, .. } => format!("{name} skipped {failed}"),
            Event::Elsewhere { .. } => "elsewhere".to_owned(),
            Event::Begun { .. } => "begun".to_owned(),
            Event::Ended(_) => "ended".to_owned(),
        };
        self.seen.push(word);
    }

    fn stop(&mut self) -> bool {
        let done = self.seen.iter().filter(|word| word.ends_with("done")).count();
        self.stop_after.is_some_and(|stop| done >= stop)
    }
}

struct Batch {
    dir: tempfile::TempDir,
    items: Vec<Item>,
    options: BatchOptions,
    witness: Witness,
}

fn scripted() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/workers/scripted.sh")
}

impl Batch {
    fn new(names: &[&str]) -> Self {
        let dir = tempfile::tempdir().unwrap();
        let item = |name: &&str| {
            let model = dir.path().join(format!("{name}.stl"));
            std::fs::write(&model, name).unwrap();
            Item {
                size: name.len() as u64,
                request: Request { model, ..Request::default() },
                name: format!("{name}.gcode"),
                place: None,
                refused: None,
                sha256: None,
            }
        };
        let items = names.iter().map(item).collect();
        let limits = Limits { memory: 1 << 40, job_memory: 1 << 40, job_seconds: 60.0, retries: 2 };
        let options = BatchOptions {
            folder: dir.path().join("out"),
            resume: false,
            restart: false,
            retry_failed: false,
            shard: Shard::default(),
            threads: 2,
            limits,
            backend: BackendOptions::new(Backend::Cpu, None, None),
            device_workers: 0,
            fault: None,
            pictures: false,
            // Nothing is written, so that outputs need not be there to stand.
            estimate: true,
            worker: scripted(),
        };
        Self { dir, items, options, witness: Witness::default() }
    }

    /// Runs it; rows by the order of items, from the journal.
    fn run(&mut self) -> (Totals, Vec<Row>) {
        let totals = run(&self.items, &self.options, &mut self.witness).unwrap();
        let rows = journal::read(&self.options.folder).unwrap();
        let row = |item: &Item| rows.iter().find(|row| row.name == item.name).cloned();
        (totals, self.items.iter().filter_map(row).collect())
    }

    fn count(&self, word: &str) -> usize {
        self.witness.seen.iter().filter(|seen| seen.contains(word)).count()
    }
}

#[test]
fn all_jobs_are_done_with_any_number_of_workers() {
    for threads in [1, 2, 5] {
        let names: Vec<String> = (0..40).map(|n| format!("{}part{n}", "x".repeat(n * 7 % 11))).collect();
        let mut batch = Batch::new(&names.iter().map(String::as_str).collect::<Vec<_>>());
        batch.options.threads = threads;
        let (totals, rows) = batch.run();
        assert_eq!((totals.done, totals.left, totals.exit_code()), (40, 0, 0));
        assert_eq!(rows.len(), 40);
        for (row, item) in rows.iter().zip(&batch.items) {
            assert_eq!((row.status, row.attempts), (Status::Done, 1));
            // The script measures the model's name.
            let outcome = row.outcome.as_ref().unwrap();
            assert_eq!(outcome.bytes as usize, item.request.model.file_name().unwrap().len());
        }
        assert_eq!((batch.count("started"), batch.count(" done"), batch.count("lost")), (40, 40, 0));
        let (first, last) = (&batch.witness.seen[0], batch.witness.seen.last().unwrap());
        assert_eq!((first.as_str(), last.as_str()), ("begun", "ended"));
    }
}

#[test]
fn what_befalls_one_worker_harms_no_other_job() {
    let mut batch = Batch::new(&[
        "a",
        "killed",
        "b",
        "abort",
        "c",
        "exit",
        "d",
        "nonsense",
        "e",
        "broken",
        "f",
        "defect",
        "g",
        "passing",
        "h",
        "killed_once",
        "i",
        "passing_once",
        "j",
    ]);
    let (totals, rows) = batch.run();
    let of = |name: &str| rows.iter().find(|row| row.name == format!("{name}.gcode")).unwrap();
    for (name, kind, attempts, words) in [
        ("killed", FailureKind::Crashed, 3, "its worker was killed (signal 9)"),
        ("abort", FailureKind::Crashed, 3, "crashed (signal 6): stack overflow"),
        ("exit", FailureKind::Crashed, 3, "ended with exit code 7: out of everything"),
        ("nonsense", FailureKind::Crashed, 3, "said what no worker says"),
        ("defect", FailureKind::Defect, 2, "as told"),
        ("passing", FailureKind::Device, 3, "as told"),
    ] {
        let row = of(name);
        let failure = row.failure.as_ref().unwrap();
        assert_eq!(
            (row.status, failure.kind, row.attempts),
            (Status::Quarantined, kind, attempts),
            "{row:?}"
        );
        assert!(failure.message.contains(words), "{row:?}");
    }
    assert_eq!((of("broken").status, of("broken").attempts), (Status::Failed, 1));
    for name in ["killed_once", "passing_once"] {
        assert_eq!((of(name).status, of(name).attempts), (Status::Done, 2));
    }
    assert!(('a'..='j').all(|name| of(&name.to_string()).status == Status::Done));
    assert_eq!((totals.done, totals.failed, totals.quarantined), (12, 1, 6));
    assert_eq!((totals.exit_code(), totals.workers_lost, totals.retries), (7, 13, 13));
    assert_eq!((batch.count("lost"), batch.count("again")), (13, 13));
}

#[test]
fn jobs_have_limits() {
    let mut batch = Batch::new(&["a", "hang", "b"]);
    batch.options.limits.job_seconds = 0.3;
    batch.options.limits.retries = 1;
    let (totals, rows) = batch.run();
    let failure = rows[1].failure.as_ref().unwrap();
    assert_eq!((failure.kind, rows[1].attempts, totals.done), (FailureKind::TimeLimit, 2, 2), "{failure:?}");
    assert!(failure.message.contains("longer than 0.3 s"), "{failure:?}");
}

#[cfg(target_os = "linux")]
#[test]
fn memory_has_limits() {
    // A limit of one job, and of all together, which a job that is alone may not break either.
    for (job, all) in [(30 << 20, 1 << 40), (1 << 40, crate::batch::pool::memory::own() + (40 << 20))] {
        let mut batch = Batch::new(&["a", "eat", "b"]);
        (batch.options.limits.job_memory, batch.options.limits.memory) = (job, all);
        batch.options.limits.retries = 0;
        let (totals, rows) = batch.run();
        let failure = rows[1].failure.as_ref().unwrap();
        assert_eq!((failure.kind, totals.done), (FailureKind::MemoryLimit, 2), "{failure:?}");
        assert!(totals.peak_bytes > 30 << 20);
    }
}

#[test]
fn a_full_disk_stops_the_batch_and_a_later_run_goes_on() {
    let mut batch = Batch::new(&["full_once", "a", "b", "c", "d", "e", "f", "g", "h"]);
    batch.options.threads = 1;
    let (totals, rows) = batch.run();
    // It is the largest and goes first; the worker may have done what waited behind it.
    assert!(totals.done <= 1 && totals.done + totals.left == 9, "{totals:?}");
    assert_eq!((totals.exit_code(), rows.len()), (9, totals.done));
    assert_eq!(totals.stopped.as_deref(), Some("as told"));
    batch.options.resume = true;
    let (again, rows) = batch.run();
    assert_eq!((again.done + totals.done, again.exit_code(), rows.len()), (9, 0, 9));
}

#[test]
fn a_stopped_batch_goes_on_without_doing_anything_twice() {
    let names = ["a", "b", "broken", "c", "d", "e", "f", "g", "h", "i"];
    let mut batch = Batch::new(&names);
    batch.witness.stop_after = Some(4);
    let (totals, rows) = batch.run();
    assert!(totals.left > 0 && totals.exit_code() == 9 && rows.len() + totals.left == 10, "{totals:?}");
    batch.witness = Witness::default();
    batch.options.resume = true;
    let (again, rows) = batch.run();
    assert_eq!((again.skipped, again.done), (totals.done, 9 - totals.done));
    assert_eq!((again.failed, rows.len(), again.exit_code()), (1, 10, 7));
    assert_eq!(batch.count("started") + batch.count("skipped"), 10);
    // All stands, so that no worker is needed.
    batch.options.worker = "/no/such/program".into();
    assert_eq!(batch.run().0.skipped, 9);
    // What failed is tried again if that is wanted.
    batch.options.worker = scripted();
    batch.options.retry_failed = true;
    batch.witness = Witness::default();
    assert_eq!(batch.run().0.failed, 1);
    assert_eq!((batch.count("started"), batch.count("skipped")), (1, 9));
}

#[test]
fn shards_share_the_jobs() {
    let names: Vec<String> = (0..30).map(|n| format!("part{n}")).collect();
    let mut batch = Batch::new(&names.iter().map(String::as_str).collect::<Vec<_>>());
    batch.items[3].refused = Some(Failure::new(FailureKind::Settings, "no".to_owned()));
    let mut sum = (0, 0);
    for index in 1..=3 {
        batch.options.shard = Shard { index, count: 3 };
        let (totals, _) = batch.run();
        assert_eq!(totals.done + totals.failed + totals.elsewhere, 30);
        sum = (sum.0 + totals.done, sum.1 + totals.failed);
    }
    assert_eq!(sum, (29, 1), "each job is done by one shard");
}

#[test]
fn workers_that_cannot_work_end_the_batch() {
    for (name, words) in [("unborn", "exit code 1: no such library"), ("outdated", "is version 0.0.0 now")] {
        let mut batch = Batch::new(&["a", "b"]);
        batch.options.worker = batch.dir.path().join(name);
        std::os::unix::fs::symlink(scripted(), &batch.options.worker).unwrap();
        let error = run(&batch.items, &batch.options, &mut batch.witness).unwrap_err();
        assert!(matches!(error, BatchError::Worker(_)) && error.to_string().contains(words), "{error}");
    }
    let mut batch = Batch::new(&["a"]);
    batch.options.worker = batch.dir.path().join("none");
    let error = run(&batch.items, &batch.options, &mut batch.witness).unwrap_err();
    assert!(matches!(error, BatchError::Worker(_)), "{error}");
}

#[test]
fn models_that_cannot_be_read_fail_without_a_try() {
    let mut batch = Batch::new(&["a", "b", "c", "d"]);
    std::fs::remove_file(&batch.items[1].request.model).unwrap();
    batch.items[2].refused = Some(Failure::new(FailureKind::Settings, "line 3 is wrong".to_owned()));
    // A name that no line of JSON can hold.
    let odd: &std::ffi::OsStr = std::os::unix::ffi::OsStrExt::from_bytes(b"\xff.stl");
    batch.items[3].request.model = odd.into();
    let (totals, rows) = batch.run();
    assert_eq!((totals.done, totals.failed, totals.exit_code()), (1, 3, 7));
    assert_eq!((rows[1].attempts, rows[2].attempts), (0, 0));
    assert_eq!(rows[2].failure.as_ref().unwrap().message, "line 3 is wrong");
}
