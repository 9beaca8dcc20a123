//! Enforcers, blockers, the report and the picture of supports.

use super::{Bench, stderr, stdout};
use microtome::mesh::shapes;
use serde_json::Value;

const ON: [&str; 4] = ["--support-material", "--support-material-threshold", "45", "--quiet"];

fn json(bytes: &[u8]) -> Value {
    serde_json::from_slice(bytes).unwrap()
}

/// Runs `slice` with `--json` and a report; both.
fn report(bench: &Bench, model: &str, more: &[&str]) -> (Value, Value) {
    let args = ["slice", model, "-o", "out.gcode", "--json", "--support-report", "report.json"];
    let done = bench.run(args.iter().chain(more));
    assert!(done.status.success(), "{more:?}: {}", stderr(&done));
    (json(stdout(&done).as_bytes()), json(&std::fs::read(bench.path("report.json")).unwrap()))
}

#[test]
fn a_report_names_what_hangs_and_every_choice() {
    let bench = Bench::new();
    bench.stl("tee.stl", &shapes::tee());
    let (off, none) = report(&bench, "tee.stl", &["--dont-support-bridges=0"]);
    assert!(off["in_air"].is_null(), "supports are off");
    assert_eq!(none["style"], "none");
    // Two arms of 20 x 20 mm.
    let hanging = none["in_air"]["part_mm2"].as_f64().unwrap();
    assert!((hanging - 800.0).abs() < 40.0, "{hanging}");
    let largest = &none["in_air"]["largest"];
    assert!((largest["z_mm"].as_f64().unwrap() - 20.0).abs() < 0.31, "{largest}");
    assert!((largest["mm2"].as_f64().unwrap() - 400.0).abs() < 20.0, "{largest}");
    let styles: Vec<_> = none["choices"].as_array().unwrap().iter().map(|c| c["style"].clone()).collect();
    assert_eq!(styles, ["grid", "snug", "organic"]);
    assert_eq!(bench.names(), ["out.gcode", "report.json", "tee.stl"]);
}

#[test]
fn modifiers_that_do_not_fit_are_said() {
    let bench = Bench::new();
    bench.stl("tee.stl", &shapes::tee());
    bench.stl("far.stl", &shapes::cuboid([0.0, 0.0, 500.0], [1.0, 1.0, 501.0]));
    let run = |more: &[&str]| bench.run(["slice", "tee.stl", "-o", "out.gcode"].iter().chain(more));
    let done = run(&["--support-blocker", "far.stl", "--support-material"]);
    assert!(done.status.success());
    assert!(stderr(&done).contains("far.stl: meets no layer"), "{}", stderr(&done));
    let done = run(&["--support-enforcer", "tee.stl"]);
    assert!(done.status.success());
    assert!(stderr(&done).contains("supports are off"), "{}", stderr(&done));
    let done = run(&["--support-enforcer", "missing.stl", "--support-material"]);
    assert_eq!(done.status.code(), Some(3));
    assert!(stderr(&done).contains("missing.stl"), "{}", stderr(&done));
    bench.write("bad.stl", "not a mesh");
    let done = run(&["--support-blocker", "bad.stl", "--support-material"]);
    assert_eq!(done.status.code(), Some(3));
    assert!(stderr(&done).contains("bad.stl"), "{}", stderr(&done));
    // No G-code without the report that was asked for.
    std::fs::remove_file(bench.path("out.gcode")).unwrap();
    let done = run(&["--support-report", "no/such/folder/report.json"]);
    assert_eq!(done.status.code(), Some(6));
    assert!(!bench.path("out.gcode").exists());
}

#[test]
fn enforcers_make_supports_and_blockers_take_them_away() {
    let bench = Bench::new();
    bench.stl("tee.stl", &shapes::tee());
    // Around one arm, from the bar's middle outwards.
    let arm = shapes::cuboid([8.0, -50.0, 15.0], [60.0, 50.0, 30.0]);
    bench.stl("arm.stl", &arm);
    let hanging = |more: &[&str]| {
        let (_, found) =
            report(&bench, "tee.stl", &[&["--support-material", "--dont-support-bridges=0"], more].concat());
        found["hanging_mm2"].as_f64().unwrap()
    };
    let (both, none) = (hanging(&[]), hanging(&["--support-material-auto=0"]));
    let enforced = hanging(&["--support-material-auto=0", "--support-enforcer", "arm.stl"]);
    let blocked = hanging(&["--support-blocker", "arm.stl"]);
    assert!(none == 0.0 && (both - 800.0).abs() < 40.0, "{both} {none}");
    // The arm beyond 8 mm: 17 x 20 mm.
    assert!((enforced - 340.0).abs() < 20.0, "{enforced}");
    assert!((blocked - (both - enforced)).abs() < 5.0, "{blocked} {both} {enforced}");
}

#[test]
fn a_picture_shows_what_hangs() {
    let bench = Bench::new();
    bench.stl("tee.stl", &shapes::tee());
    let more = ["--support-picture", "tee.png", "--dont-support-bridges=0"];
    bench.slice(&bench.path("tee.stl"), &[&ON[..], &more].concat());
    let image = image::open(bench.path("tee.png")).unwrap().to_rgb8();
    let red = image.pixels().filter(|p| p.0[0] > 180 && p.0[1] < 100 && p.0[2] < 100).count();
    let grey = image.pixels().filter(|p| p.0[0].abs_diff(p.0[2]) < 16 && p.0[0] < 230).count();
    assert!(red > 500 && grey > 10_000, "{red} {grey}");
}
