//! `mask` as its users run it.

use super::{Bench, stderr, stdout};
use microtome::mesh::{Mesh, demo_part, shapes};
use microtome::resin::{LayerInfo, format};
use std::path::Path;
use std::process::Output;

/// Every extension that can be written, and a folder.
const OUTPUTS: [&str; 12] = [
    "a.goo",
    "a.ctb",
    "a.sl1",
    "a.sl1s",
    "a.zip",
    "a.nanodlp",
    "a.svg.zip",
    "a.pwmo",
    "a.pwmx",
    "a.pm3",
    "a.pm5",
    "layers/",
];

/// A panel small enough for quick tests, with pixels that are not square.
const SMALL: [&str; 12] = [
    "--display-pixels-x",
    "640",
    "--display-pixels-y",
    "400",
    "--display-width",
    "64",
    "--display-height",
    "48",
    "--max-print-height",
    "100",
    "--layer-height",
    "0.2",
];

fn mask(bench: &Bench, model: &str, output: &str, more: &[&str]) -> Output {
    let args = ["mask", model, "-o", output, "--initial-layer-height", "0.2"];
    bench.run(args.iter().chain(&SMALL).chain(more))
}

fn lit(bench: &Bench, output: &str) -> Vec<u64> {
    let mut reader = format::open(&bench.path(output)).unwrap();
    (0..reader.head().layers).map(|i| reader.layer(i).unwrap().0.lit()).collect()
}

fn infos(bench: &Bench, output: &str) -> Vec<LayerInfo> {
    let mut reader = format::open(&bench.path(output)).unwrap();
    (0..reader.head().layers).map(|i| reader.layer(i).unwrap().1).collect()
}

fn refused(done: &Output, code: i32, parts: &[&str]) {
    let text = stderr(done);
    assert_eq!(done.status.code(), Some(code), "{text}");
    assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    assert_eq!(text.trim_end().lines().count(), 1, "{text}");
}

/// A box whose sides lie on the borders of pixels when it is centred: 100 x 50 pixels of 0.1 x 0.12 mm.
fn hundred_by_fifty() -> Mesh {
    shapes::cuboid([0.0; 3], [10.0, 6.0, 2.0])
}

#[test]
fn every_container_holds_the_same_masks() {
    let bench = Bench::new();
    bench.stl("part.stl", &hundred_by_fifty());
    for output in OUTPUTS {
        let done = mask(&bench, "part.stl", output, &[]);
        assert!(done.status.success(), "{output}: {}", stderr(&done));
        assert_eq!(lit(&bench, output), [5000; 10], "{output}");
        let inspected = bench.run(["inspect", output]);
        assert!(inspected.status.success(), "{output}: {}", stderr(&inspected));
    }
}

#[test]
fn runs_and_threads_do_not_change_a_byte() {
    let bench = Bench::new();
    bench.stl("demo.stl", &demo_part());
    for output in OUTPUTS.iter().filter(|o| !o.ends_with('/')) {
        let file = |more: &[&str]| {
            let more: Vec<&str> = ["--anti-aliasing", "4"].iter().chain(more).copied().collect();
            let done = mask(&bench, "demo.stl", output, &more);
            assert!(done.status.success(), "{output}: {}", stderr(&done));
            std::fs::read(bench.path(output)).unwrap()
        };
        let first = file(&["--threads", "1"]);
        assert!(first == file(&["--threads", "1"]) && first == file(&["--threads", "3"]), "{output}");
        assert!(first != file(&["--anti-aliasing", "8"]), "{output}: the comparison sees a difference");
    }
}

#[test]
fn exposures_follow_the_settings_and_the_range_keeps_its_place() {
    let bench = Bench::new();
    bench.stl("part.stl", &hundred_by_fifty());
    let set = ["--bottom-layers", "2", "--transition-layers", "1", "--initial-exposure-time", "20"];
    let set: Vec<&str> = set.iter().chain(&["--exposure-time", "2"]).copied().collect();
    assert!(mask(&bench, "part.stl", "all.goo", &set).status.success());
    let all = infos(&bench, "all.goo");
    let exposures: Vec<f64> = all.iter().map(|l| l.exposure).collect();
    assert_eq!(exposures, [20.0, 20.0, 11.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0, 2.0]);
    let range: Vec<&str> = set.iter().chain(&["--layers", "1..4"]).copied().collect();
    assert!(mask(&bench, "part.stl", "some.goo", &range).status.success());
    let some: Vec<(f64, f64)> = infos(&bench, "some.goo").iter().map(|l| (l.exposure, l.z)).collect();
    let same: Vec<(f64, f64)> = all[1..4].iter().map(|l| (l.exposure, l.z)).collect();
    assert_eq!(some, same);
    refused(&mask(&bench, "part.stl", "none.goo", &["--layers", "10.."]), 4, &["10 layers", "--layers"]);
}

#[test]
fn the_first_layer_is_as_thick_as_the_others_unless_it_is_asked_for() {
    let bench = Bench::new();
    bench.stl("part.stl", &hundred_by_fifty());
    let tops = |more: &[&str]| {
        let args = ["mask", "part.stl", "-o", "a.goo"];
        let done = bench.run(args.iter().chain(&SMALL).chain(more));
        assert!(done.status.success(), "{}", stderr(&done));
        infos(&bench, "a.goo")[..2].iter().map(|l| l.z).collect::<Vec<_>>()
    };
    assert_eq!(tops(&[]), [0.2, 0.4]);
    assert_eq!(tops(&["--initial-layer-height", "0.1"]), [0.1, 0.3]);
}

#[test]
fn outlines_are_corrected_in_millimetres_and_pixels() {
    let bench = Bench::new();
    bench.stl("part.stl", &hundred_by_fifty());
    let counts = |more: &[&str]| {
        let done = mask(&bench, "part.stl", "a.goo", more);
        assert!(done.status.success(), "{}", stderr(&done));
        lit(&bench, "a.goo")
    };
    // A box grown by a pixel on each side, its corners rounded away.
    let grown = counts(&["--absolute-correction", "1px"]);
    assert!(grown.iter().all(|&n| (102 * 52 - 4..=102 * 52).contains(&n)), "{grown:?}");
    assert_eq!(counts(&["--absolute-correction=-2px"]), [96 * 46; 10]);
    let foot = counts(&["--elefant-foot-compensation", "0.24", "--elefant-foot-compensation-layers", "2"]);
    // Along x 0.24 mm are 2.4 pixels, of which the centres of 2 go; half of it takes 1.
    assert_eq!(foot[..3], [96 * 46, 98 * 48, 5000]);
}

#[test]
fn several_models_share_a_plate() {
    let bench = Bench::new();
    bench.stl("a.stl", &hundred_by_fifty());
    bench.stl("b.stl", &shapes::cuboid([0.0; 3], [5.0, 12.0, 1.0]));
    let args =
        ["mask", "a.stl", "b.stl", "a.stl", "-o", "plate.goo", "--initial-layer-height", "0.2", "--json"];
    let done = bench.run(args.iter().chain(&SMALL));
    assert!(done.status.success(), "{}", stderr(&done));
    let summary: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    assert_eq!(summary["models"].as_array().unwrap().len(), 3);
    let counts = lit(&bench, "plate.goo");
    assert_eq!(counts.len(), 10);
    // Corners on the plate are whole micrometres, so that a side may miss the border of pixels.
    assert!(counts[0].abs_diff(2 * 5000 + 50 * 100) <= 250, "{counts:?}");
    assert!(counts[9].abs_diff(2 * 5000) <= 200, "{counts:?}");
    let crowd = vec!["a.stl"; 40];
    let args = ["mask", "-o", "crowd.goo"];
    let done = bench.run(args.iter().chain(&SMALL).chain(&crowd));
    refused(&done, 3, &["40 parts", "64.00 x 48.00"]);
}

#[test]
fn what_the_printer_cannot_hold_is_refused_and_nothing_is_written() {
    let bench = Bench::new();
    bench.stl("long.stl", &shapes::cuboid([0.0; 3], [60.0, 10.0, 2.0]));
    bench.stl("wide.stl", &shapes::cuboid([0.0; 3], [10.0, 60.0, 2.0]));
    bench.stl("tall.stl", &shapes::cuboid([0.0; 3], [10.0, 10.0, 200.0]));
    bench.stl("thin.stl", &shapes::cuboid([0.0; 3], [0.01, 0.01, 2.0]));
    let models = bench.names();
    assert!(mask(&bench, "wide.stl", "turned.goo", &["--rotate", "90"]).status.success());
    std::fs::remove_file(bench.path("turned.goo")).unwrap();
    refused(&mask(&bench, "wide.stl", "a.goo", &[]), 3, &["wide.stl", "10.00 x 60.00", "--rotate"]);
    refused(&mask(&bench, "tall.stl", "a.goo", &[]), 3, &["tall.stl", "200.00 mm high"]);
    refused(&mask(&bench, "thin.stl", "a.goo", &["--rotate", "10"]), 3, &["thin.stl", "lights a pixel"]);
    refused(&mask(&bench, "long.stl", "a.xyz", &[]), 4, &["xyz", ".goo"]);
    refused(&mask(&bench, "long.stl", "no/such/a.goo", &[]), 6, &["no/such/a.goo", "create the folder"]);
    refused(&mask(&bench, "long.stl", "a.pm5s", &[]), 4, &["a.pm5s", "not written"]);
    refused(&mask(&bench, "long.stl", "-", &[]), 6, &["standard output", "name a file"]);
    let report = ["--check-report", "no/such/report.json"];
    refused(&mask(&bench, "long.stl", "a.goo", &report), 6, &["no/such/report.json", "create the folder"]);
    refused(&mask(&bench, "no.stl", "a.goo", &[]), 3, &["no.stl"]);
    refused(&bench.run(["mask", "long.stl", "-o", "a.goo"]), 4, &["--printer"]);
    refused(
        &bench.run(["mask", "long.stl", "-o", "a.goo", "--printer", "elego-mars-4"]),
        4,
        &["elegoo-mars-4"],
    );
    let encrypted = ["mask", "long.stl", "-o", "a.ctb", "--printer", "elegoo-saturn-4-ultra-16k"];
    refused(&bench.run(encrypted), 4, &["encrypted", ".goo"]);
    assert_eq!(bench.names(), models, "no file was left");
}

#[test]
fn checks_find_an_island_and_a_cup() {
    let bench = Bench::new();
    // A plate with a tube on it, closed by the plate and so a cup, and a cube that floats beside it.
    let base = shapes::cuboid([0.0; 3], [20.0, 10.0, 1.0]);
    let outer = shapes::cuboid([1.0, 1.0, 0.5], [9.0, 9.0, 4.0]);
    let mut inner = shapes::cuboid([2.0, 2.0, 1.0], [8.0, 8.0, 4.0]);
    inner.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let island = shapes::cuboid([14.0, 4.0, 2.0], [16.0, 6.0, 4.0]);
    bench.stl("part.stl", &shapes::merge(&[base, outer, inner, island]));
    let more = ["--check-report", "report.json", "--check-pictures", "worst", "--json"];
    let done = mask(&bench, "part.stl", "a.goo", &more);
    assert!(done.status.success(), "{}", stderr(&done));
    let summary: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    let report: serde_json::Value =
        serde_json::from_slice(&std::fs::read(bench.path("report.json")).unwrap()).unwrap();
    assert_eq!(summary["check"], report);
    assert_eq!(report["islands"]["count"], 1, "{report}");
    assert_eq!(report["cups"]["count"], 1, "{report}");
    assert_eq!(report["trapped"]["count"], 0, "{report}");
    let island = &report["islands"]["listed"][0];
    assert_eq!(island["layer"], 10);
    assert!((island["area_mm2"].as_f64().unwrap() - 4.0).abs() < 0.3, "{island}");
    let text = stderr(&done);
    assert!(text.contains("1 island:") && text.contains("suction cup"), "{text}");
    assert!(std::fs::read_dir(bench.path("worst")).unwrap().count() >= 2);
}

#[test]
fn open_meshes_are_closed_as_contours_are() {
    let bench = Bench::new();
    let mut part = shapes::cylinder(5.0, 4.0, 64);
    // One of the wall: a hole in a lid leaves every section whole.
    let upright =
        |t: &[u32; 3]| t.iter().any(|&v| part.vertices[v as usize].z != part.vertices[t[0] as usize].z);
    let wall = part.triangles.iter().position(upright).unwrap();
    part.triangles.remove(wall);
    bench.stl("open.stl", &part);
    let done = mask(&bench, "open.stl", "a.goo", &[]);
    assert!(done.status.success() && stderr(&done).contains("open edges"), "{}", stderr(&done));
    // 78.5 mm2 of pixels of 0.012 mm2: no row runs out of the part through the hole.
    let counts = lit(&bench, "a.goo");
    assert!(counts.iter().all(|n| n.abs_diff(6545) < 60), "{counts:?}");
}

#[test]
fn an_existing_folder_of_other_things_is_left_alone() {
    let bench = Bench::new();
    bench.stl("part.stl", &hundred_by_fifty());
    assert!(mask(&bench, "part.stl", "layers/", &[]).status.success());
    let first = std::fs::read_dir(bench.path("layers")).unwrap().count();
    assert!(mask(&bench, "part.stl", "layers/", &["--layers", "0..3"]).status.success());
    let second = std::fs::read_dir(bench.path("layers")).unwrap().count();
    assert_eq!(first - second, 7, "layers of an earlier run do not stay");
    std::fs::create_dir(bench.path("letters")).unwrap();
    bench.write("letters/dear.txt", "dear");
    refused(&mask(&bench, "part.stl", "letters/", &[]), 6, &["letters", "holds other files"]);
    assert_eq!(std::fs::read(bench.path("letters/dear.txt")).unwrap(), b"dear");
}

#[test]
fn a_damaged_container_is_named_and_not_trusted() {
    let bench = Bench::new();
    bench.stl("part.stl", &hundred_by_fifty());
    for output in OUTPUTS.iter().filter(|o| !o.ends_with('/')) {
        assert!(mask(&bench, "part.stl", output, &[]).status.success());
        let whole = std::fs::read(bench.path(output)).unwrap();
        let cut = bench.write(&format!("cut_{output}"), &whole[..whole.len() * 2 / 3]);
        let done = bench.run(["inspect", cut.to_str().unwrap()]);
        assert_eq!(done.status.code(), Some(3), "{output}: {}", stderr(&done));
        assert!(stderr(&done).contains(Path::new(output).file_name().unwrap().to_str().unwrap()), "{output}");
    }
}
