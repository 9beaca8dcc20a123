//! What is written, where, and what is not.

use super::{Bench, stderr, stdout};
use microtome::mesh::shapes;

#[test]
fn json_is_alone_on_stdout_and_says_what_was_done() {
    let bench = Bench::new();
    bench.stl("box.stl", &shapes::cuboid([0.0; 3], [20.0, 20.0, 4.0]));
    let done = bench.run([
        "slice",
        "box.stl",
        "-o",
        "a.gcode",
        "--json",
        "--layer-height",
        "0.2",
        "--first-layer-height",
        "0.2",
    ]);
    assert!(done.status.success(), "{}", stderr(&done));
    let summary: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    assert_eq!(summary["layers"], 20);
    assert_eq!(summary["triangles"], 12);
    assert_eq!(summary["segments"], 20 * 8);
    assert_eq!(summary["backend"]["kind"], "cpu");
    assert!(summary["filament"]["mm"].as_f64().unwrap() > 100.0);
    assert_eq!(summary["bytes"].as_u64().unwrap(), std::fs::metadata(bench.path("a.gcode")).unwrap().len());
    assert!(summary["stages"].as_array().unwrap().len() > 5);
}

#[test]
fn quiet_is_quiet_and_progress_stays_off_pipes() {
    let bench = Bench::new();
    bench.stl("box.stl", &shapes::cuboid([0.0; 3], [20.0, 20.0, 4.0]));
    let done = bench.run(["slice", "box.stl", "-o", "a.gcode", "--quiet"]);
    assert!(done.status.success());
    assert_eq!((stdout(&done), stderr(&done)), (String::new(), String::new()));
    let done = bench.run(["slice", "box.stl"]);
    assert!(done.status.success());
    assert!(
        !stderr(&done).contains('\r') && !stderr(&done).contains('\u{1b}'),
        "no control characters on a pipe"
    );
    assert_eq!(bench.names(), ["a.gcode", "box.gcode", "box.stl"], "the default name is the model's");
}

#[test]
fn gcode_can_go_to_a_pipe_whose_reader_leaves() {
    let bench = Bench::new();
    bench.stl("ball.stl", &shapes::sphere(20.0, 200, 100));
    let whole = bench.run(["slice", "ball.stl", "-o", "-", "--quiet"]);
    assert!(whole.status.success(), "{}", stderr(&whole));
    assert!(whole.stdout == bench.slice(&bench.path("ball.stl"), &[]));
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_microtome"))
        .args(["slice", "ball.stl", "-o", "-"])
        .current_dir(bench.dir.path())
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let done = child.wait_with_output().unwrap();
    assert_eq!(done.status.code(), Some(0), "{}", stderr(&done));
    assert!(!stderr(&done).contains("error"), "{}", stderr(&done));
}

#[cfg(unix)]
#[test]
fn a_killed_run_leaves_the_old_file() {
    let bench = Bench::new();
    bench.stl("ball.stl", &shapes::sphere(40.0, 600, 400));
    bench.write("a.gcode", "old");
    for delay_ms in [5, 20, 60, 120] {
        let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_microtome"))
            .args([
                "slice",
                "ball.stl",
                "-o",
                "a.gcode",
                "--quiet",
                "--layer-height",
                "0.05",
                "--first-layer-height",
                "0.05",
            ])
            .current_dir(bench.dir.path())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(delay_ms));
        child.kill().unwrap();
        let finished = child.wait().unwrap().success();
        let text = std::fs::read(bench.path("a.gcode")).unwrap();
        assert!(finished || text == b"old" || text.ends_with(b"; prusaslicer_config = end\n"), "half a file");
        assert!(bench.names().iter().filter(|n| n.ends_with(".part")).count() <= 1);
        bench.write("a.gcode", "old");
    }
    assert_eq!(bench.names().iter().filter(|n| !n.ends_with(".part")).count(), 2);
}

#[test]
fn the_demo_writes_its_two_files_and_one_hash() {
    let bench = Bench::new();
    let done = bench.run(["demo"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let text = stdout(&done);
    let hash = text
        .lines()
        .find(|l| l.contains("cpu"))
        .and_then(|l| l.split_whitespace().find(|w| w.len() == 64))
        .unwrap()
        .to_owned();
    let same = text.split_whitespace().filter(|w| w.len() == 64).all(|w| w == hash);
    assert!(same, "{text}");
    assert_eq!(bench.names(), ["demo.gcode", "demo.png"]);
    let picture = image::open(bench.path("demo.png")).unwrap();
    assert!(picture.width() >= 800);
}

#[test]
fn devices_lists_or_says_there_is_none() {
    let bench = Bench::new();
    let done = bench.run(["devices"]);
    assert!(done.status.success(), "{}", stderr(&done));
    assert!(stdout(&done).contains("auto"), "{}", stdout(&done));
    let json = bench.run(["devices", "--json"]);
    let value: serde_json::Value = serde_json::from_str(&stdout(&json)).unwrap();
    assert!(value["adapters"].is_array());
}
