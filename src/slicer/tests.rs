#![allow(clippy::unwrap_used, clippy::panic)]

use super::*;
use crate::job::progress::Silent;
use crate::mesh::{shapes, stl_write};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

/// A folder with a cuboid of 10 x 8 x 2 mm in it.
fn folder() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let model = dir.path().join("block.stl");
    write(&model, [10.0, 8.0, 2.0]);
    (dir, model)
}

fn write(path: &Path, size: [f64; 3]) {
    let mesh = shapes::cuboid([0.0; 3], size);
    stl_write::write_stl_binary(&mesh, &mut fs::File::create(path).unwrap()).unwrap();
}

fn cpu() -> Slicer {
    Slicer::new(BackendOptions::new(crate::job::backend::Backend::Cpu, None, None))
}

/// A resin printer with few pixels.
fn small_panel(request: Request) -> Request {
    let panel = [
        ("display_pixels_x", "320"),
        ("display_pixels_y", "200"),
        ("display_width", "64"),
        ("display_height", "40"),
        ("max_print_height", "100"),
        ("layer_height", "0.2"),
        ("initial_layer_height", "0.2"),
    ];
    let request = panel.into_iter().fold(request, |r, (key, value)| r.set(key, value));
    Request { technology: Technology::Resin, ..request }
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn an_output_comes_with_its_facts_and_a_picture() {
    let (dir, model) = folder();
    let output = dir.path().join("new/folder/a.gcode");
    let request = Request::new(&model)
        .output(&output)
        .set("layer_height", "0.2")
        .set("filament_density", "1.24")
        .set("exposure_time", "3")
        .picture(dir.path().join("pictures/a.png"));
    let outcome = cpu().slice(&request, &Silent).unwrap();
    let bytes = fs::read(&output).unwrap();
    assert_eq!((outcome.bytes, outcome.crc32), (bytes.len() as u64, crc32fast::hash(&bytes)));
    assert_eq!((outcome.triangles, outcome.backend.as_str()), (12, "cpu"));
    assert!(outcome.layers > 5 && outcome.print_z_mm > 1.5 && outcome.time_lower_bound_s > 1.0);
    let m = &outcome.material;
    assert!(m.mm > 10.0 && m.g.unwrap() > 0.1 && m.cost.is_none() && !m.mm_by_role.is_empty());
    assert!(outcome.stages.iter().any(|(stage, _)| stage == "walls") && outcome.seconds > 0.0);
    assert!(outcome.warnings[0].starts_with("settings: exposure_time = 3: a setting of resin printers"));
    let picture = image::open(dir.path().join("pictures/a.png")).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (320, 240));
    assert!(picture.pixels().any(|p| *p != picture[(0, 0)]), "something is drawn");

    let estimate = Request { picture: None, output: None, ..request.clone() }.estimate();
    let said = cpu().slice(&estimate, &Silent).unwrap();
    assert_eq!((said.bytes, said.crc32, said.layers), (0, 0, outcome.layers));
    assert_eq!(said.material, outcome.material);
    let drawn = Request { picture: Some(dir.path().join("e.png")), ..estimate };
    assert_eq!(cpu().slice(&drawn, &Silent).unwrap().material, outcome.material);
    assert!(dir.path().join("e.png").is_file());
}

#[test]
fn masks_are_made_into_files_and_folders() {
    let (dir, model) = folder();
    let request = |output: &str| small_panel(Request::new(&model)).output(dir.path().join(output));
    let request_with = |output: &str| Request { check: true, ..request(output) };
    let done = cpu().slice(&request_with("a.goo").picture(dir.path().join("p/a.png")), &Silent).unwrap();
    let bytes = fs::read(dir.path().join("a.goo")).unwrap();
    assert_eq!((done.bytes, done.crc32), (bytes.len() as u64, crc32fast::hash(&bytes)));
    assert_eq!((done.layers, done.print_z_mm), (10, 2.0));
    assert!((done.material.cm3 - 0.16).abs() < 1e-3 && done.material.mm == 0.0);
    let picture = image::open(dir.path().join("p/a.png")).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (320, 240));
    assert!(picture.pixels().any(|p| *p != picture[(0, 0)]));

    let stack = cpu().slice(&request("deep/stack/"), &Silent).unwrap();
    let folder = dir.path().join("deep/stack");
    let all: Vec<u8> = names(&folder).iter().flat_map(|n| fs::read(folder.join(n)).unwrap()).collect();
    assert_eq!((stack.bytes, stack.crc32), (all.len() as u64, crc32fast::hash(&all)));

    let two = cpu().slice(&request("b.zip").copies(2), &Silent).unwrap();
    assert!((two.material.cm3 - 2.0 * done.material.cm3).abs() < 1e-9 && two.triangles == 24);
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let (dir, model) = folder();
    let slicer = cpu();
    for (make, name) in
        [(Request::clone as fn(&Request) -> Request, "a.gcode"), (|r| small_panel(r.clone()), "a.goo")]
    {
        let bytes = |threads: Option<u16>| {
            let output = dir.path().join(name);
            let request = Request { threads, check: true, ..make(&Request::new(&model)).output(&output) };
            slicer.slice(&request, &Silent).unwrap();
            fs::read(output).unwrap()
        };
        let first = bytes(None);
        assert!([1, 3, 2, 1].into_iter().all(|n| bytes(Some(n)) == first), "{name}");
    }
    let none = slicer.slice(&Request::new(&model).output("x").threads(0), &Silent).unwrap_err();
    assert_eq!(
        (none.kind, none.message.as_str()),
        (FailureKind::Settings, "threads: 0 is out of range; allowed: 1 to 1024")
    );
}

#[test]
fn failures_say_what_they_are_about() {
    let (dir, model) = folder();
    let output = dir.path().join("o.gcode");
    let failure = |request: &Request| {
        let failure = cpu().slice(request, &Silent).unwrap_err();
        assert_eq!(failure.message.lines().count(), 1, "{failure:?}");
        assert!(!failure.disk_full && !failure.transient, "{failure:?}");
        (failure.kind, failure.message)
    };
    let good = Request::new(&model).output(&output);
    for (request, kind, part) in [
        (Request::default(), FailureKind::Settings, "model: no file is named"),
        (Request::new(&model), FailureKind::Settings, "output: no file is named"),
        (Request::new("no.stl").output(&output), FailureKind::Model, "no.stl: no such file"),
        (good.clone().set("layer_height", "x"), FailureKind::Settings, "layer_height"),
        (good.clone().set("layer_height", "0.9"), FailureKind::Settings, "layer_height"),
        (good.clone().copies(0), FailureKind::Settings, "copies: 0 is out of range"),
        (Request { orient: "up".to_owned(), ..good.clone() }, FailureKind::Settings, "allowed: auto"),
        (Request { rotate: f64::NAN, ..good.clone() }, FailureKind::Settings, "rotate: NaN"),
        (Request { snap_grid: Some(11.0), ..good.clone() }, FailureKind::Settings, "snap_grid: 11 mm"),
        (Request { date: -1, ..good.clone() }, FailureKind::Settings, "date: -1"),
        (Request::new(&model).output(dir.path()), FailureKind::Output, "name a file"),
        (Request::new(&model).output(model.join("x.gcode")), FailureKind::Output, "x.gcode"),
        (
            small_panel(Request::new(&model)).output("a.xyz"),
            FailureKind::Settings,
            "no format of layer masks",
        ),
    ] {
        let (found, message) = failure(&request);
        assert!(found == kind && message.contains(part), "{found:?}: {message}");
    }
    assert_eq!(names(dir.path()), ["block.stl"], "nothing is left");
    // A wish that means nothing is no failure, but worth a word.
    let done = cpu().slice(&Request { check: true, ..good }, &Silent).unwrap();
    assert!(done.warnings.iter().any(|w| w == "check: for resin printers only, so it has no effect here"));
}

/// Does something when a stage begins.
struct At<F>(&'static str, F);

impl<F: Fn() + Sync> Progress for At<F> {
    fn stage(&self, name: &'static str) {
        if name == self.0 {
            (self.1)();
        }
    }
}

#[test]
fn a_model_that_has_changed_is_refused() {
    let (dir, model) = folder();
    for make in [Request::clone as fn(&Request) -> Request, |r| small_panel(r.clone())] {
        write(&model, [10.0, 8.0, 2.0]);
        let expect = Some(files::stat(&model).unwrap());
        let request = make(&Request { expect, ..Request::new(&model).output(dir.path().join("o.zip")) });
        cpu().slice(&request, &Silent).unwrap();
        fs::remove_file(dir.path().join("o.zip")).unwrap();
        let grow = || fs::write(&model, "solid x\n").unwrap();
        // Before it is read, and after.
        let after = cpu().slice(&request, &At("joining facets", grow)).unwrap_err();
        let before = cpu().slice(&request, &Silent).unwrap_err();
        for failure in [after, before] {
            assert!(failure.transient && failure.kind == FailureKind::Model, "{failure:?}");
            assert!(failure.message.contains("the file has changed"), "{failure:?}");
        }
        assert_eq!(names(dir.path()), ["block.stl"]);
    }
}

#[test]
fn cancelling_leaves_nothing_behind_at_any_stage() {
    let (dir, model) = folder();
    let request = Request::new(&model).output(dir.path().join("o.zip"));
    for request in [request.clone(), small_panel(request.clone())] {
        let seen = Mutex::new(Vec::new());
        struct Listen<'a>(&'a Mutex<Vec<&'static str>>);
        impl Progress for Listen<'_> {
            fn stage(&self, name: &'static str) {
                self.0.lock().unwrap().push(name);
            }
        }
        cpu().slice(&request, &Listen(&seen)).unwrap();
        fs::remove_file(dir.path().join("o.zip")).unwrap();
        for stage in seen.into_inner().unwrap() {
            let cancel = Cancel::new();
            let at = At(stage, || cancel.cancel());
            let failure = cpu().slice(&request, &cancel.beside(&at)).unwrap_err();
            assert_eq!((failure.kind, failure.transient), (FailureKind::Cancelled, false), "{stage}");
            assert_eq!(names(dir.path()), ["block.stl"], "{stage}");
        }
    }
    let cancel = Cancel::new();
    cancel.clone().cancel();
    assert_eq!(cpu().slice(&request, &cancel).unwrap_err().message, "cancelled");
}

#[test]
fn panics_are_told_and_the_slicer_goes_on() {
    let (dir, model) = folder();
    let slicer = cpu();
    for threads in [None, Some(1)] {
        let request = Request { threads, ..Request::new(&model).output(dir.path().join("o.gcode")) };
        let boom = At("walls", || panic!("the wall\nis {}", "gone"));
        let failure = slicer.slice(&request, &boom).unwrap_err();
        assert_eq!((failure.kind, failure.transient), (FailureKind::Defect, false));
        assert!(failure.message.ends_with("settings: the wall\\nis gone"), "{failure:?}");
        assert_eq!(names(dir.path()), ["block.stl"]);
        slicer.slice(&request, &Silent).unwrap();
        fs::remove_file(dir.path().join("o.gcode")).unwrap();
    }
}
