//! Bad input: one clear line, a documented exit code, no output left, no panic.

use super::{Bench, stderr};
use microtome::mesh::shapes;

/// Bytes of a binary STL with the given corners.
fn binary(facets: &[[[f32; 3]; 3]], claimed: u32) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend(claimed.to_le_bytes());
    for facet in facets {
        bytes.extend([0u8; 12]);
        bytes.extend(facet.iter().flatten().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0u8; 2]);
    }
    bytes
}

const FACET: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 5.0]];

/// Slices a file with these bytes, expects exit code `code` and every one of `words` in one line of
/// error, and no file beside the input.
fn refused(name: &str, bytes: &[u8], code: i32, words: &[&str]) {
    let bench = Bench::new();
    bench.write(name, bytes);
    let done = bench.run(["slice", name, "-o", "out.gcode"]);
    let text = stderr(&done);
    assert_eq!(done.status.code(), Some(code), "{name}: {text}");
    let errors: Vec<&str> = text.lines().filter(|l| l.starts_with("error:")).collect();
    assert_eq!(errors.len(), 1, "{name}: one line of error\n{text}");
    for word in words {
        assert!(errors[0].contains(word), "{name}: {word:?} is not in {:?}", errors[0]);
    }
    assert!(!text.contains("panicked"), "{text}");
    assert_eq!(bench.names(), [name], "{name}: nothing is left behind");
}

#[test]
fn files_that_hold_no_mesh() {
    refused("empty.stl", b"", 3, &["empty.stl", "empty"]);
    refused("page.stl", b"<!DOCTYPE html><html><body>404</body></html>", 3, &["page.stl", "HTML"]);
    refused("none.stl", &binary(&[], 0), 3, &["none.stl"]);
    refused("none-ascii.stl", b"solid x\nendsolid x\n", 3, &["none-ascii.stl"]);
    let noise: Vec<u8> = (0..5000u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    refused("noise.stl", &noise, 3, &["noise.stl"]);
    refused("model.step", b"ISO-10303-21;\nHEADER;\n", 3, &["model.step", "STL"]);
}

#[test]
fn headers_that_lie() {
    refused("truncated.stl", &binary(&[FACET; 3], 4)[..], 3, &["truncated.stl", "4", "3"]);
    refused("liar.stl", &binary(&[FACET; 2], u32::MAX), 3, &["liar.stl", "4294967295"]);
    refused("cut.stl", &binary(&[FACET; 3], 3)[..84 + 120], 3, &["cut.stl"]);
    refused(
        "cut-ascii.stl",
        b"solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0",
        3,
        &["cut-ascii.stl"],
    );
}

#[test]
fn coordinates_that_are_none() {
    let mut bad = FACET;
    bad[1][2] = f32::NAN;
    refused("nan.stl", &binary(&[FACET, bad], 2), 3, &["nan.stl", "NaN"]);
    bad[1][2] = f32::INFINITY;
    refused("inf.stl", &binary(&[FACET, bad], 2), 3, &["inf.stl", "inf"]);
    bad[1][2] = 1e9;
    refused("huge.stl", &binary(&[FACET, bad], 2), 3, &["huge.stl"]);
    let text = "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 zero 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";
    refused("word.stl", text.as_bytes(), 3, &["word.stl", "5", "zero"]);
    refused("point.stl", &binary(&[[[1.0; 3]; 3]; 4], 4), 3, &["point.stl"]);
}

#[test]
fn parts_that_cannot_be_printed() {
    let bench = Bench::new();
    let cases = [
        ("thin", [10.0, 10.0, 0.1], "layer"),
        ("wide", [500.0, 10.0, 10.0], "bed"),
        ("tall", [10.0, 10.0, 900.0], "max_print_height"),
    ];
    for (name, [x, y, z], word) in cases {
        let model = bench.stl("model.stl", &shapes::cuboid([0.0; 3], [x, y, z]));
        let done = bench.run(["slice", model.to_str().unwrap(), "-o", "out.gcode"]);
        assert_eq!(done.status.code(), Some(3), "{name}: {}", stderr(&done));
        for word in [word, "model.stl"] {
            assert!(stderr(&done).contains(word), "{name}: {}", stderr(&done));
        }
        assert_eq!(bench.names(), ["model.stl"]);
    }
}

#[test]
fn paths_that_lead_nowhere() {
    let bench = Bench::new();
    let missing = bench.run(["slice", "missing.stl"]);
    assert_eq!(missing.status.code(), Some(3));
    assert!(stderr(&missing).contains("missing.stl"), "{}", stderr(&missing));
    let folder = bench.run(["slice", ".", "-o", "out.gcode"]);
    assert_eq!(folder.status.code(), Some(3), "{}", stderr(&folder));
    let model = bench.stl("box.stl", &shapes::cuboid([0.0; 3], [10.0; 3]));
    let nowhere = bench.run(["slice", model.to_str().unwrap(), "-o", "no/such/folder/a.gcode"]);
    assert_eq!(nowhere.status.code(), Some(6), "{}", stderr(&nowhere));
    assert_eq!(bench.names(), ["box.stl"]);
    assert_eq!(bench.run(["slice"]).status.code(), Some(2));
    assert_eq!(bench.run(["slcie", "x"]).status.code(), Some(2));
}
