//! `--estimate-only` says what a print says, and writes nothing.

use super::{Bench, stderr, stdout};
use microtome::mesh::demo_part::demo_part;
use microtome::mesh::{Mesh, shapes};
use serde_json::Value;
use std::process::Output;

fn summary(done: &Output) -> Value {
    assert!(done.status.success(), "{}", stderr(done));
    serde_json::from_str(&stdout(done)).unwrap()
}

/// What may differ: names, bytes, and how long things took.
fn facts(mut summary: Value) -> Value {
    let fields = summary.as_object_mut().unwrap();
    for key in ["output", "bytes", "stages"] {
        assert!(fields.remove(key).is_some(), "{key}");
    }
    summary
}

/// A roof over a foot: something hangs.
fn table() -> Mesh {
    let mut foot = shapes::cuboid([-3.0, -3.0, 0.0], [3.0, 3.0, 6.0]);
    let top = shapes::cuboid([-12.0, -9.0, 6.0], [12.0, 9.0, 8.0]);
    let first = foot.vertices.len() as u32;
    foot.vertices.extend(top.vertices);
    foot.triangles.extend(top.triangles.into_iter().map(|t| t.map(|v| v + first)));
    foot
}

/// Settings under which filament is decided differently.
const PRINTS: [&[&str]; 9] = [
    &[],
    &["--seam-position", "nearest", "--extrusion-multiplier", "1.07"],
    &["--seam-position", "rear", "--thin-walls=1", "--external-perimeters-first=1"],
    &["--support-material=1", "--support-material-style", "snug", "--layer-height", "0.3"],
    &["--support-material=1", "--support-material-style", "organic"],
    &["--raft-layers", "2", "--skirts", "0", "--gcode-resolution", "0"],
    &["--brim-width", "4", "--retract-restart-extra", "0.05", "--before-layer-gcode", "M117 next"],
    &[
        "--use-firmware-retraction=1",
        "--gcode-flavor",
        "marlin",
        "--overhangs=0",
        "--fill-pattern",
        "honeycomb",
    ],
    &["--infill-every-layers", "2", "--use-relative-e-distances=1", "--thick-bridges=0"],
];

#[test]
fn filament_is_that_of_the_print() {
    let bench = Bench::new();
    bench.stl("demo.stl", &demo_part());
    bench.stl("table.stl", &table());
    bench.stl("ball.stl", &shapes::sphere(6.0, 36, 24));
    let mut seen = Vec::new();
    for model in ["demo.stl", "table.stl", "ball.stl"] {
        for (number, more) in PRINTS.iter().enumerate() {
            if model != "table.stl" && number % 3 != 0 {
                continue;
            }
            let run = |args: &[&str]| {
                summary(&bench.run(["slice", model, "--json"].iter().chain(args).chain(*more)))
            };
            let (print, estimate) = (run(&["-o", "a.gcode"]), run(&["--estimate-only"]));
            assert_eq!((&estimate["bytes"], &estimate["output"]), (&0.into(), &"".into()));
            let times = estimate["time_by_role_s"].as_object().unwrap();
            let sum: f64 = times.values().map(|s| s.as_f64().unwrap()).sum();
            let whole = estimate["time_lower_bound_s"].as_f64().unwrap();
            assert!((sum - whole).abs() < 1e-6 * whole && times.contains_key("travel"), "{times:?}");
            seen.push(print["filament"]["mm"].as_f64().unwrap());
            assert_eq!(facts(estimate), facts(print), "{model} {more:?}");
        }
    }
    // The comparison can fail: the prints are not all alike.
    seen.dedup();
    assert!(seen.len() > 10, "{seen:?}");
    assert_eq!(bench.names(), ["a.gcode", "ball.stl", "demo.stl", "table.stl"]);
}

/// A small panel, so that masks are quick.
const PANEL: [&str; 8] = [
    "--display-pixels-x",
    "640",
    "--display-pixels-y",
    "400",
    "--display-width",
    "64",
    "--display-height",
    "40",
];

#[test]
fn resin_is_that_of_the_masks() {
    let bench = Bench::new();
    bench.stl("demo.stl", &demo_part());
    let mut holed = shapes::sphere(6.0, 36, 24);
    holed.triangles.remove(700);
    bench.stl("holed.stl", &holed);
    let prints: [&[&str]; 3] =
        [&[], &["--anti-aliasing", "4", "--elefant-foot-compensation", "0.2"], &["--check"]];
    for model in ["demo.stl", "holed.stl"] {
        for more in prints {
            let run = |args: &[&str]| {
                summary(&bench.run(["mask", model, "--json"].iter().chain(args).chain(&PANEL).chain(more)))
            };
            let (print, estimate) = (run(&["-o", "a.goo"]), run(&["--estimate-only"]));
            assert!(estimate["volume_ml"].as_f64().unwrap() > 0.1);
            let [mut estimate, mut print] = [facts(estimate), facts(print)];
            // A format is what an estimate does not need.
            estimate["format"] = Value::Null;
            print["format"] = Value::Null;
            assert_eq!(estimate, print, "{model} {more:?}");
        }
    }
    assert_eq!(bench.names(), ["a.goo", "demo.stl", "holed.stl"]);
}

#[test]
fn estimates_fail_as_prints_do() {
    let bench = Bench::new();
    bench.stl("box.stl", &shapes::cuboid([0.0; 3], [10.0, 10.0, 2.0]));
    let code = |args: &[&str]| bench.run(args).status.code();
    assert_eq!(code(&["slice", "none.stl", "--estimate-only"]), Some(3));
    assert_eq!(code(&["slice", "box.stl", "--estimate-only", "--scale", "0"]), Some(2));
    assert_eq!(code(&["slice", "box.stl", "--estimate-only", "--start-gcode", "{no_such_thing}"]), Some(4));
    assert_eq!(code(&["slice", "box.stl", "--estimate-only", "-o", "a.gcode"]), Some(2));
    assert_eq!(code(&["slice", "box.stl", "--estimate-only", "--picture", "a.png"]), Some(2));
    assert_eq!(code(&["mask", "box.stl", "--estimate-only", "-o", "a.goo"]), Some(2));
    let people = bench.run(["slice", "box.stl", "--estimate-only"]);
    let text = stderr(&people);
    assert!(text.starts_with("box.stl: ") && text.contains("\nestimated by cpu in "), "{text}");
    assert_eq!(bench.names(), ["box.stl"]);
}
