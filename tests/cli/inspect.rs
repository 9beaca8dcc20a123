//! `microtome inspect`.

use super::{Bench, stderr};
use microtome::mask::{MaskLayer, Panel};
use microtome::resin::anycubic::Anycubic;
use microtome::resin::{Container, LayerInfo, Motion, Preview, Print, Totals};
use std::io::Cursor;
use std::sync::Arc;

/// Three layers of 40 x 30 pixels of 50 um: black, a row, all.
fn container() -> Vec<u8> {
    let panel = Panel {
        width: 40,
        height: 30,
        pitch_x: 50_000,
        pitch_y: 50_000,
        mirror_x: false,
        mirror_y: false,
        portrait: false,
    };
    let print = Print {
        name: "part".into(),
        date: 0,
        machine: String::new(),
        printer_model: String::new(),
        material: String::new(),
        panel,
        build_height: 100.0,
        layers: 3,
        layer_height: 0.05,
        first_layer_height: 0.05,
        exposure: 2.5,
        bottom_exposure: 30.0,
        bottom_layers: 1,
        transition_layers: 0,
        motion: Motion::default(),
        bottom_motion: Motion::default(),
        light: 255,
        bottom_light: 255,
        anti_aliasing: 1,
        density: 0.0,
        cost: 0.0,
        config: String::new(),
        preview: Arc::new(Preview { width: 1, height: 1, rgb: vec![9; 3] }),
    };
    let format = Anycubic::new("pwmx").unwrap();
    let mut out = Cursor::new(Vec::new());
    let mut sink = format.begin(&mut out, &print).unwrap();
    for (index, pixels) in [(0, 0), (1, 40), (2, 1200)] {
        let mut mask = MaskLayer::default();
        mask.push(0, pixels, 255);
        let z = 0.05 * f64::from(index + 1);
        let info = LayerInfo { index, z, height: 0.05, exposure: 2.5, ..LayerInfo::default() };
        sink.layer(&info, &format.encode(&mask, &panel)).unwrap();
    }
    sink.finish(&Totals { time: 100.0, volume_ml: 0.3, ..Totals::default() }).unwrap();
    out.into_inner()
}

#[test]
fn a_whole_file_is_described() {
    let bench = Bench::new();
    bench.write("a.pwmx", container());
    let done = bench.run(["inspect", "a.pwmx", "--layers"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let text = String::from_utf8(done.stdout).unwrap();
    for part in
        ["anycubic, 3 layers of 0.05 mm", "Photon Mono X", "40 x 30 pixels, 2 x 1.5 mm", "3 layers decoded"]
    {
        assert!(text.contains(part), "{part} in\n{text}");
    }

    let done = bench.run(["inspect", "a.pwmx", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!((&json["layers"], &json["decoded"], &json["damaged"]), (&3.into(), &3.into(), &0.into()));
    let lit: Vec<_> =
        json["per_layer"].as_array().unwrap().iter().map(|l| l["lit"].as_u64().unwrap()).collect();
    assert_eq!(lit, [0, 40, 1200]);
    let area = json["per_layer"][2]["area_mm2"].as_f64().unwrap();
    assert!((area - 3.0).abs() < 1e-9, "{area}");

    let done = bench.run(["inspect", "a.pwmx", "--head", "--json"]);
    let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
    assert_eq!((&json["exposure"], &json["decoded"]), (&2.5.into(), &0.into()));
}

#[test]
fn a_layer_becomes_a_picture() {
    let bench = Bench::new();
    bench.write("a.pwmx", container());
    let done = bench.run(["inspect", "a.pwmx", "--layer", "1", "--png", "1.png"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let picture = image::open(bench.path("1.png")).unwrap().into_luma8();
    assert_eq!(picture.dimensions(), (40, 30));
    assert!(picture.enumerate_pixels().all(|(_, y, p)| p.0[0] == if y == 0 { 255 } else { 0 }));
    let done = bench.run(["inspect", "a.pwmx", "--layer", "3", "--png", "3.png"]);
    assert_eq!(done.status.code(), Some(3));
    assert!(stderr(&done).contains("there is no layer 3"), "{}", stderr(&done));
    assert!(!bench.path("3.png").exists());
}

#[test]
fn damage_ends_with_code_3_and_one_line() {
    let bench = Bench::new();
    let whole = container();
    let last = whole.len() - 1;
    let mut damaged = whole.clone();
    damaged[last] ^= 1;
    for (name, bytes, said) in [
        (
            "cut.pwmx",
            &whole[..last],
            "cut.pwmx: 1 of 3 layers are damaged; the first: anycubic: ends at byte",
        ),
        ("bit.pwmx", &damaged, "bit.pwmx: 1 of 3 layers are damaged; the first: anycubic: layer 2 at byte"),
        ("head.pwmx", &whole[..40], "head.pwmx: anycubic: ends at byte 40"),
        ("text.goo", b"some text", "text.goo: is no container known here"),
        ("empty.goo", b"", "it is empty"),
    ] {
        bench.write(name, bytes);
        let done = bench.run(["inspect", name, "--json"]);
        let err = stderr(&done);
        assert_eq!(done.status.code(), Some(3), "{name}: {err}");
        assert!(err.contains(said) && err.lines().count() == 1, "{name}: {err}");
        if !done.stdout.is_empty() {
            let json: serde_json::Value = serde_json::from_slice(&done.stdout).unwrap();
            assert_eq!((&json["decoded"], &json["damaged"]), (&2.into(), &1.into()));
        }
    }
    let done = bench.run(["inspect", "missing.goo"]);
    assert_eq!(done.status.code(), Some(3));
    assert_eq!(bench.run(["inspect", "a.goo", "--png", "x.png"]).status.code(), Some(2));
}
