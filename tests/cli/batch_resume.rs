//! Batches that are killed, harmed and taken up again: nothing is lost and nothing is done twice.
#![cfg(target_os = "linux")]

use super::{Bench, stderr};
use microtome::batch::event::{Row, Status};
use microtome::batch::journal;
use microtome::mesh::shapes;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const MODELS: usize = 10;

/// Models, three of which cannot be read, not even by root.
fn models() -> Bench {
    let bench = Bench::new();
    fs::create_dir(bench.path("models")).unwrap();
    for n in 0..MODELS {
        let around = 12 + 6 * n;
        bench.stl(&format!("models/m{n}.stl"), &shapes::sphere(3.0 + n as f64 * 0.3, around, around / 2));
    }
    let whole = fs::read(bench.path("models/m3.stl")).unwrap();
    bench.write("models/truncated.stl", &whole[..whole.len() / 2]);
    std::os::unix::fs::symlink("nowhere.stl", bench.path("models/dangling.stl")).unwrap();
    fs::create_dir(bench.path("models/folder.stl")).unwrap();
    bench.write("models/jobs.csv", "model\nfolder.stl\n");
    bench
}

fn command(bench: &Bench, out: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microtome"));
    command
        .args(["batch", "models", "models/jobs.csv", "-o", out, "--resume", "--threads", "2"])
        .args(["--backend", "cpu", "--retries", "40"])
        .current_dir(bench.dir.path())
        .env_remove("SOURCE_DATE_EPOCH")
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

fn finish(bench: &Bench, out: &str) -> Output {
    command(bench, out).stderr(Stdio::piped()).output().unwrap()
}

fn outputs(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = fs::read_dir(folder).unwrap().map(Result::unwrap);
    let files = entries.filter(|e| e.file_type().unwrap().is_file()).map(|e| e.path());
    let named = files.map(|path| (path.file_name().unwrap().to_str().unwrap().to_owned(), path));
    named
        .filter(|(name, _)| !name.starts_with("report.") && name != "quarantine.jsonl")
        // Orphans of a killed supervisor may be about to rename theirs.
        .filter_map(|(name, path)| Some((name, fs::read(path).ok()?)))
        .collect()
}

fn journal_file(folder: &Path) -> PathBuf {
    folder.join(".microtome/journal-1-of-1.jsonl")
}

/// Complete lines of a kind in the journal, by output.
fn lines(folder: &Path, kind: &str) -> BTreeMap<String, usize> {
    let text = fs::read_to_string(journal_file(folder)).unwrap_or_default();
    let mut found = BTreeMap::new();
    for line in text.split_inclusive('\n').filter(|line| line.ends_with('\n')) {
        let record: serde_json::Value = serde_json::from_str(line).unwrap();
        if let Some(name) = record[kind]["name"].as_str() {
            *found.entry(name.to_owned()).or_default() += 1;
        }
    }
    found
}

/// Name, status, length and checksum.
type Told = (String, Status, Option<(u64, u32)>);

/// Name and status of all jobs, and what the outputs are said to be.
fn results(folder: &Path) -> Vec<Told> {
    let of = |row: Row| (row.name, row.status, row.outcome.map(|o| (o.bytes, o.crc32)));
    journal::read(folder).unwrap().into_iter().map(of).collect()
}

/// An undisturbed batch.
fn reference(bench: &Bench) -> BTreeMap<String, Vec<u8>> {
    let done = finish(bench, "reference");
    assert_eq!(done.status.code(), Some(7), "{}", stderr(&done));
    let results = results(&bench.path("reference"));
    assert_eq!(results.len(), MODELS + 3, "{results:?}");
    let failed: Vec<_> = results.iter().filter(|(_, status, _)| *status != Status::Done).collect();
    assert_eq!(failed.len(), 3, "{failed:?}");
    assert!(failed.iter().all(|(name, ..)| !name.starts_with('m')), "{failed:?}");
    outputs(&bench.path("reference"))
}

/// A running supervisor; killed where a test fails on the way.
struct Running(Child);

impl Running {
    fn start(bench: &Bench, out: &str) -> Self {
        Self(command(bench, out).spawn().unwrap())
    }

    /// Waits until the folder is so, or the batch is over; true in the first case.
    fn until(&mut self, mut so: impl FnMut() -> bool) -> bool {
        let begun = Instant::now();
        loop {
            let over = self.0.try_wait().unwrap().is_some();
            if so() {
                return !over;
            }
            if over {
                return false;
            }
            assert!(begun.elapsed() < Duration::from_secs(300), "the batch does not get on");
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    fn workers(&self) -> Vec<u32> {
        let entries = fs::read_dir("/proc").unwrap().flatten();
        let processes = entries.filter_map(|e| e.file_name().to_str()?.parse::<u32>().ok());
        processes.filter(|pid| parent(*pid) == Some(self.0.id())).collect()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        drop(self.0.kill());
        drop(self.0.wait());
    }
}

fn parent(pid: u32) -> Option<u32> {
    let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
    stat.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()
}

/// Whatever is visible in the folder is whole; at the end all of it is there, once.
fn compare(folder: &Path, expected: &BTreeMap<String, Vec<u8>>, finished: bool) {
    let found = outputs(folder);
    for (name, bytes) in found.iter().filter(|(name, _)| finished || !name.starts_with('.')) {
        assert!(expected.get(name).is_some_and(|other| other == bytes), "{name} is not as it should be");
    }
    if finished {
        assert_eq!(found.len(), expected.len());
        let ended = lines(folder, "ended");
        assert!(expected.keys().all(|name| ended[name] == 1), "{ended:?}");
        let pictures = fs::read_dir(folder.join(".microtome/pictures")).unwrap().flatten();
        let names: Vec<_> = pictures.map(|e| e.file_name().into_string().unwrap()).collect();
        assert!(names.iter().all(|name| name.ends_with(".png") && !name.starts_with('.')), "{names:?}");
    }
}

#[test]
fn a_batch_killed_again_and_again_comes_to_the_same_end() {
    let bench = models();
    let expected = reference(&bench);
    assert_eq!(expected.len(), MODELS);
    let out = bench.path("out");
    let mut kills = 0;
    for done in [0, 1, 4, 7] {
        let mut batch = Running::start(&bench, "out");
        if !batch.until(|| lines(&out, "started").len() > done && lines(&out, "ended").len() >= done) {
            break;
        }
        if done == 4 {
            // A worker first; the batch goes on without it.
            let one = batch.workers().first().map(ToString::to_string).unwrap();
            assert!(Command::new("kill").args(["-9", &one]).status().unwrap().success());
            batch.until(|| lines(&out, "ended").len() > done);
        }
        drop(batch);
        kills += 1;
        compare(&out, &expected, false);
    }
    assert!(kills > 1);
    let last = finish(&bench, "out");
    assert_eq!(last.status.code(), Some(7), "{}", stderr(&last));
    compare(&out, &expected, true);
    assert_eq!(results(&out), results(&bench.path("reference")));
    let started = lines(&out, "started");
    assert!(started.values().all(|tries| *tries <= 1 + kills + 1), "{started:?}");

    // Nothing is left to do, and what cannot be read stays failed.
    let again = finish(&bench, "out");
    assert_eq!(again.status.code(), Some(7));
    assert_eq!(lines(&out, "started"), started);
    assert_eq!(outputs(&out), expected);
}

#[test]
fn outputs_that_were_harmed_are_made_again_and_no_others() {
    let bench = models();
    let expected = reference(&bench);
    let out = bench.path("reference");
    let before = lines(&out, "started");
    // As after a loss of power: no checkpoint has reached the disk, and the last line is torn.
    let text = fs::read_to_string(journal_file(&out)).unwrap();
    let mut kept: String =
        text.lines().filter(|l| !l.contains("\"checkpoint\":")).map(|l| format!("{l}\n")).collect();
    kept.push_str("{\"ended\":{\"name\":\"m1");
    fs::write(journal_file(&out), kept).unwrap();
    let mut names = expected.keys();
    let (gone, cut, changed) = (names.next().unwrap(), names.next().unwrap(), names.next().unwrap());
    fs::remove_file(out.join(gone)).unwrap();
    fs::write(out.join(cut), &expected[cut][..20]).unwrap();
    let mut bytes = expected[changed].clone();
    bytes[100] ^= 1;
    fs::write(out.join(changed), bytes).unwrap();
    assert_eq!(finish(&bench, "reference").status.code(), Some(7));
    assert_eq!(outputs(&out), expected);
    let after = lines(&out, "started");
    let again: Vec<_> = after.keys().filter(|name| after[*name] != before[*name]).collect();
    assert_eq!(again, [gone, cut, changed]);
}

#[test]
fn a_full_disk_stops_the_batch_and_loses_nothing() {
    let bench = models();
    let expected = reference(&bench);
    let size: usize = expected.values().map(Vec::len).sum();
    // In a namespace of its own a plain user may mount a small disk, if the system lets one have any. Then
    // the same with room.
    let script = r#"
        mount -t tmpfs -o size=$1k none out || exit 99
        shift
        "$@" > /dev/null 2> first; code=$?
        mkdir -p kept && cp -r out/. kept/ || exit 98
        mount -o remount,size=1G out || exit 99
        "$@" > /dev/null 2> second; again=$?
        cp -r out/. all/ && echo $code $again"#;
    for folder in ["out", "all"] {
        fs::create_dir(bench.path(folder)).unwrap();
    }
    let batch = command(&bench, "out");
    let namespace = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c", script, "sh"])
        .arg((size * 6 / 10 / 1024).to_string())
        .arg(batch.get_program())
        .args(batch.get_args())
        .current_dir(bench.dir.path())
        .output();
    let done = match namespace {
        Ok(done) if done.status.success() => done,
        other => {
            eprintln!("skipped: no disk of our own may be mounted here: {other:?}");
            return;
        }
    };
    let codes = String::from_utf8_lossy(&done.stdout).trim().to_owned();
    let said = |name: &str| fs::read_to_string(bench.path(name)).unwrap();
    assert!(["9 7", "6 7"].contains(&codes.as_str()), "{codes}: {} {}", said("first"), said("second"));
    assert!(said("first").contains("--resume"), "{}", said("first"));
    compare(&bench.path("kept"), &expected, false);
    assert!(outputs(&bench.path("kept")).len() < expected.len(), "the disk was full on the way");
    compare(&bench.path("all"), &expected, true);
    assert_eq!(results(&bench.path("all")), results(&bench.path("reference")));
}

#[test]
fn a_folder_is_not_begun_twice() {
    let bench = models();
    let start = |more: &[&str]| bench.run(["batch", "models/m0.stl", "-o", "out"].iter().chain(more));
    assert_eq!(start(&[]).status.code(), Some(0));
    let refused = start(&[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(stderr(&refused).contains("--resume"), "{}", stderr(&refused));
    assert_eq!(start(&["--resume"]).status.code(), Some(0));
    let out = bench.path("out");
    assert_eq!(lines(&out, "started").values().sum::<usize>(), 1);
    assert_eq!(start(&["--restart"]).status.code(), Some(0));
    assert_eq!(lines(&out, "started").values().sum::<usize>(), 1);
    assert!(out.join(".microtome/journal-1-of-1.jsonl.old").exists());
    // A changed setting is another job.
    assert_eq!(start(&["--resume", "--layer-height", "0.15"]).status.code(), Some(0));
    assert_eq!(lines(&out, "started").values().sum::<usize>(), 2);
}
