//! What is seen of batches: events, reports, joined shards, figures for Prometheus.

use super::{Bench, stderr};
use microtome::mesh::shapes;
use serde_json::Value;
use std::fs::{read, read_to_string};
use std::path::Path;
use std::process::Output;

/// Two good models and a broken one.
fn bench() -> Bench {
    let bench = Bench::new();
    std::fs::create_dir(bench.path("in")).unwrap();
    bench.stl("in/box.stl", &shapes::cuboid([0.0; 3], [10.0, 8.0, 1.0]));
    bench.stl("in/tip.stl", &shapes::tetrahedron(10.0));
    bench.write("in/torn.stl", &read(bench.path("in/box.stl")).unwrap()[..200]);
    bench
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap_or_else(|| panic!("killed: {}", stderr(output)))
}

fn json(path: &Path) -> Value {
    serde_json::from_str(&read_to_string(path).unwrap()).unwrap()
}

#[test]
fn a_batch_is_told_as_it_runs_and_when_it_is_done() {
    let bench = bench();
    let flags = ["--json", "--prometheus", "figures.prom", "--filament-density", "1.24", "--threads", "2"];
    let done = bench.run(["batch", "in", "-o", "out"].iter().chain(&flags));
    assert_eq!(code(&done), 7, "{}", stderr(&done));

    let text = String::from_utf8(done.stdout.clone()).unwrap();
    let events: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |kind: &str| events.iter().filter(|e| e["event"] == kind).collect::<Vec<_>>();
    assert_eq!((events[0]["event"].as_str(), &events[0]["jobs"]), (Some("begun"), &3.into()));
    let last = events.last().unwrap();
    assert_eq!(
        (last["event"].as_str(), &last["done"], &last["failed"]),
        (Some("ended"), &2.into(), &1.into())
    );
    assert_eq!((of("done").len(), of("failed").len()), (2, 1));
    assert_eq!(of("failed")[0]["failure"]["kind"], "model");

    let report = json(&bench.path("out/report.json"));
    let jobs = report["jobs"].as_array().unwrap();
    let names: Vec<&str> = jobs.iter().map(|job| job["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["box.gcode", "tip.gcode", "torn.gcode"]);
    let bytes = std::fs::metadata(bench.path("out/box.gcode")).unwrap().len();
    assert_eq!(jobs[0]["outcome"]["bytes"], bytes);
    let sum: f64 = (0..2).map(|i| jobs[i]["outcome"]["material"]["mm"].as_f64().unwrap()).sum();
    assert_eq!(report["sums"]["filament_mm"].as_f64(), Some(sum));
    assert_eq!(report["sums"]["jobs_with_mass"], 2);

    let page = read_to_string(bench.path("out/report.html")).unwrap();
    assert_eq!(page.matches("data:image/png;base64,").count(), 2, "a picture of each");
    assert!(page.contains("torn.stl: truncated"));
    let figures = read_to_string(bench.path("figures.prom")).unwrap();
    for (state, count) in [("done", 2), ("failed", 1), ("running", 0), ("waiting", 0)] {
        let line = format!("shard=\"1/1\",state=\"{state}\"}} {count}\n");
        assert!(figures.contains(&line), "{line} in\n{figures}");
    }
}

#[test]
fn without_a_terminal_failures_and_sums_are_lines() {
    let bench = bench();
    let done = bench.run(["batch", "in", "-o", "out", "--no-pictures"]);
    assert_eq!(code(&done), 7);
    assert!(done.stdout.is_empty());
    let said = stderr(&done);
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[0].starts_with("failed: torn.gcode: in/torn.stl: truncated"), "{said}");
    assert!(said.contains("2 done, 1 failed\n") && said.contains("report: out/report.html\n"), "{said}");
    assert!(!said.contains('\u{1b}'), "no terminal, no control codes");

    let quiet = bench.run(["batch", "in", "-o", "quiet", "--no-pictures", "--quiet"]);
    let said = stderr(&quiet);
    let only_errors = |line: &str| line.starts_with("failed: ") || line.starts_with("error: ");
    assert!(quiet.stdout.is_empty() && said.lines().all(only_errors), "{said}");
}

#[test]
fn what_failed_is_done_once_it_is_mended() {
    let bench = bench();
    let flags = ["--no-pictures", "--quiet", "--layer-height", "0.3"];
    let run = |more: &[&str]| bench.run(more.iter().chain(&flags));
    assert_eq!(code(&run(&["batch", "in", "-o", "out"])), 7);
    bench.write("in/torn.stl", read(bench.path("in/box.stl")).unwrap());
    // The manifest brings the settings along.
    let again = bench.run(["batch", "out/quarantine.jsonl", "-o", "again", "--no-pictures", "--quiet"]);
    assert_eq!(code(&again), 0, "{}", stderr(&again));
    assert_eq!(
        read(bench.path("again/torn.gcode")).unwrap().len(),
        read(bench.path("out/box.gcode")).unwrap().len()
    );
    assert!(!bench.path("again/quarantine.jsonl").exists());

    // A model that was changed is another job.
    assert_eq!(code(&run(&["batch", "in", "-o", "out", "--resume"])), 0);
    assert!(!bench.path("out/quarantine.jsonl").exists());
    assert_eq!(read(bench.path("out/torn.gcode")).unwrap(), read(bench.path("again/torn.gcode")).unwrap());
}

#[test]
fn shards_are_joined_and_what_is_missing_is_told() {
    let bench = bench();
    let flags = ["--no-pictures", "--quiet"];
    let shard = |part: &str| bench.run(["batch", "in", "-o", "parts", "--shard", part].iter().chain(&flags));
    shard("1/2");
    let missing = bench.run(["report", "parts"]);
    assert_eq!(code(&missing), 9, "{}", stderr(&missing));
    assert!(stderr(&missing).contains("1 shard of 2 missing: 2"), "{}", stderr(&missing));
    shard("2/2");
    let joined = bench.run(["report", "parts", "-o", "joined", "--json"]);
    assert_eq!(code(&joined), 7, "{}", stderr(&joined));
    let said: Value = serde_json::from_slice(&joined.stdout).unwrap();
    assert_eq!((&said["sums"]["done"], &said["missing"]), (&2.into(), &Value::Array(vec![])));

    bench.run(["batch", "in", "-o", "whole"].iter().chain(&flags));
    let (whole, joined) = (json(&bench.path("whole/report.json")), json(&bench.path("joined/report.json")));
    for sum in ["jobs", "failed", "layers", "bytes", "filament_mm", "time_lower_bound_s"] {
        assert_eq!(whole["sums"][sum], joined["sums"][sum], "{sum}");
    }
    let names = |report: &Value| -> Vec<Value> {
        report["jobs"].as_array().unwrap().iter().map(|job| job["name"].clone()).collect()
    };
    assert_eq!(names(&whole), names(&joined));

    let twice = bench.run(["report", "parts", "whole", "-o", "twice"]);
    assert_eq!(code(&twice), 7, "{}", stderr(&twice));
    let twice = names(&json(&bench.path("twice/report.json")));
    assert!(
        twice.contains(&"parts/box.gcode".into()) && twice.contains(&"whole/box.gcode".into()),
        "{twice:?}"
    );
    assert_eq!(code(&bench.run(["report", "in"])), 3, "no batch");
}
