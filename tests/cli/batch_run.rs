//! Whole batches: the same files as `slice` gives, whatever goes wrong on the way.

use super::{Bench, stderr};
use microtome::batch::event::Row;
use microtome::batch::journal;
use microtome::mesh::{Mesh, shapes};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Good models of several sizes, by name.
fn good() -> Vec<(String, Mesh)> {
    let mut all: Vec<(String, Mesh)> = (0..6)
        .map(|n| (format!("box{n}.stl"), shapes::cuboid([0.0; 3], [6.0 + f64::from(n), 8.0, 5.0])))
        .collect();
    all.push(("ball.stl".to_owned(), shapes::sphere(8.0, 60, 30)));
    all.push(("ring.stl".to_owned(), shapes::torus(12.0, 3.0, 80, 20)));
    all.push(("knot.stl".to_owned(), shapes::knot(8.0, 2.0, 8000)));
    all
}

/// A folder `in` with the good models, and broken ones if that is wanted.
fn bench(broken: bool) -> Bench {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("in")).unwrap();
    for (name, mesh) in good() {
        bench.stl(&format!("in/{name}"), &mesh);
    }
    if broken {
        let whole = std::fs::read(bench.path("in/ball.stl")).unwrap();
        bench.write("in/cut.stl", &whole[..whole.len() / 2]);
        bench.write("in/empty.stl", "");
        bench.write("in/prose.stl", "This is no model.\n");
    }
    bench
}

fn batch(bench: &Bench, args: &[&str]) -> Output {
    bench.run([&["batch", "--backend", "cpu"], args].concat())
}

/// What `slice` makes of the good models, by name of output.
fn sliced(bench: &Bench) -> BTreeMap<String, Vec<u8>> {
    let one = |(name, _): (String, Mesh)| {
        let bytes = bench.slice(&bench.path(&format!("in/{name}")), &["--backend", "cpu"]);
        (name.replace(".stl", ".gcode"), bytes)
    };
    good().into_iter().map(one).collect()
}

/// All files in a folder that are no reports.
fn outputs(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files
        .filter(|path| path.extension().is_some_and(|e| e == "gcode"))
        .map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read(path).unwrap())
        })
        .collect()
}

/// The journal's rows without what depends on time and memory.
fn rows(folder: &Path) -> Vec<Row> {
    let mut rows = journal::read(folder).unwrap();
    for outcome in rows.iter_mut().filter_map(|row| row.outcome.as_mut()) {
        (outcome.seconds, outcome.cpu_seconds, outcome.peak_bytes) = (0.0, 0.0, 0);
        outcome.stages.clear();
    }
    rows
}

/// Names of the jobs in the order of the report.
fn reported(folder: &Path) -> Vec<String> {
    let mut report = csv::Reader::from_path(folder.join("report.csv")).unwrap();
    let column = report.headers().unwrap().iter().position(|h| h == "name").unwrap();
    report.records().map(|record| record.unwrap()[column].to_owned()).collect()
}

#[test]
fn outputs_are_those_of_slice_for_any_number_of_threads() {
    let bench = bench(true);
    let expected = sliced(&bench);
    let mut first: Option<(Vec<Row>, Vec<String>)> = None;
    for threads in ["1", "2", "3"] {
        let folder = bench.path("out");
        let done = batch(&bench, &["in", "-o", "out", "--threads", threads]);
        assert_eq!(done.status.code(), Some(7), "{}", stderr(&done));
        assert!(outputs(&folder) == expected, "--threads {threads}");
        // The request names the folder, which is the same each time.
        let found = (rows(&folder), reported(&folder));
        assert_eq!(found.0.iter().filter(|row| row.failure.is_some()).count(), 3);
        assert!(found.1.is_sorted() && found.1.len() == 12, "by name, as the folder was read: {:?}", found.1);
        match &first {
            Some(first) => assert!(*first == found, "--threads {threads}\n{first:#?}\n{found:#?}"),
            None => first = Some(found),
        }
        std::fs::remove_dir_all(&folder).unwrap();
    }
}

#[test]
fn the_exit_code_tells_how_it_went() {
    let bench = bench(true);
    let code = |args: &[&str]| {
        let done = batch(&bench, args);
        (done.status.code(), stderr(&done))
    };
    assert_eq!(code(&["in/box0.stl", "in/box1.stl", "-o", "good"]).0, Some(0));
    let (some, text) = code(&["in/box0.stl", "in/empty.stl", "-o", "some"]);
    assert_eq!(some, Some(7), "{text}");
    assert_eq!(code(&["in/prose.stl", "in/empty.stl", "-o", "none"]).0, Some(8));
    assert_eq!(code(&["in/box0.stl", "-o", "good"]).0, Some(2), "not without --resume");
    assert_eq!(code(&["in/box0.stl", "in/box1.stl", "-o", "good", "--resume"]).0, Some(0));
}

#[test]
fn equal_names_do_not_overwrite_each_other() {
    let bench = bench(false);
    std::fs::create_dir(bench.path("more")).unwrap();
    bench.stl("more/ball.stl", &shapes::sphere(5.0, 24, 12));
    let done = batch(&bench, &["in/ball.stl", "more/ball.stl", "-o", "out"]);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    let found: Vec<Vec<u8>> = outputs(&bench.path("out")).into_values().collect();
    let slice = |name: &str| bench.slice(&bench.path(name), &["--backend", "cpu"]);
    let mut expected = vec![slice("in/ball.stl"), slice("more/ball.stl")];
    expected.sort_by_key(Vec::len);
    let mut found = found;
    found.sort_by_key(Vec::len);
    assert!(found == expected);
}

#[test]
fn an_estimate_writes_nothing_and_says_the_same() {
    let bench = bench(false);
    assert_eq!(batch(&bench, &["in", "-o", "full"]).status.code(), Some(0));
    assert_eq!(batch(&bench, &["in", "-o", "guess", "--estimate-only"]).status.code(), Some(0));
    assert!(outputs(&bench.path("guess")).is_empty());
    let material = |folder: &str| -> Vec<(String, u64)> {
        let grams = |row: &Row| row.outcome.as_ref().unwrap().material.mm.to_bits();
        rows(&bench.path(folder)).iter().map(|row| (row.name.clone(), grams(row))).collect()
    };
    assert_eq!(material("full"), material("guess"));
}

/// The program in the background.
#[cfg(target_os = "linux")]
fn spawn(bench: &Bench, args: &[&str]) -> std::process::Child {
    Command::new(env!("CARGO_BIN_EXE_microtome"))
        .args(["batch", "--backend", "cpu"])
        .args(args)
        .current_dir(bench.dir.path())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Processes whose parent this is, that run our program.
#[cfg(target_os = "linux")]
fn children(parent: u32) -> Vec<u32> {
    let of = |entry: std::fs::DirEntry| {
        let pid: u32 = entry.file_name().to_str()?.parse().ok()?;
        let status = std::fs::read_to_string(entry.path().join("stat")).ok()?;
        // The name of the program, in parentheses, may hold anything.
        let ppid: u32 = status.rsplit_once(')')?.1.split_whitespace().nth(1)?.parse().ok()?;
        (ppid == parent).then_some(pid)
    };
    std::fs::read_dir("/proc").unwrap().flatten().filter_map(of).collect()
}

#[cfg(target_os = "linux")]
fn kill(pid: u32) {
    Command::new("sh").args(["-c", &format!("kill -9 {pid}")]).status().unwrap();
}

/// Waits for something that happens soon.
#[cfg(target_os = "linux")]
fn wait_for<T>(mut what: impl FnMut() -> Option<T>) -> T {
    for _ in 0..6000 {
        if let Some(found) = what() {
            return found;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    panic!("it did not happen");
}

#[cfg(target_os = "linux")]
#[test]
fn killed_workers_are_replaced() {
    let bench = bench(false);
    let mut child = spawn(&bench, &["in", "-o", "out", "--threads", "2"]);
    let victim = wait_for(|| children(child.id()).pop());
    kill(victim);
    assert_eq!(child.wait().unwrap().code(), Some(0));
    assert!(outputs(&bench.path("out")) == sliced(&bench));
}

#[cfg(target_os = "linux")]
#[test]
fn a_killed_batch_goes_on_and_leaves_no_worker_behind() {
    let bench = bench(false);
    let journal = |folder: &Path| {
        let path: PathBuf = folder.join(".microtome/journal-1-of-1.jsonl");
        std::fs::read_to_string(path).unwrap_or_default().matches("{\"ended\":").count()
    };
    let folder = bench.path("out");
    let mut child = spawn(&bench, &["in", "-o", "out", "--threads", "2"]);
    let workers = wait_for(|| (journal(&folder) >= 2).then(|| children(child.id())));
    kill(child.id());
    child.wait().unwrap();
    // They end when their input does; what has ended has no program, even if nobody has asked for its status.
    let gone = |pid: &u32| std::fs::read_link(format!("/proc/{pid}/exe")).is_err();
    wait_for(|| workers.iter().all(gone).then_some(()));
    let before = journal(&folder);
    let done = batch(&bench, &["in", "-o", "out", "--resume"]);
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    assert_eq!(journal(&folder), good().len().max(before), "what was done is not done again");
    assert!(outputs(&folder) == sliced(&bench));
}
