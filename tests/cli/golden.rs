//! Files that were looked at once and must not change unnoticed. `MICROTOME_BLESS=1` rewrites them.

use super::{Bench, stderr};
use microtome::mesh::shapes;
use sha2::{Digest, Sha256};
use std::path::Path;

/// Compares with `tests/golden/NAME`, naming the first line that differs.
fn same_as_golden(name: &str, text: &str) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(name);
    if std::env::var_os("MICROTOME_BLESS").is_some() {
        std::fs::write(&path, text).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap();
    if let Some(message) = first_difference(&golden, text) {
        panic!("{name}: {message}; MICROTOME_BLESS=1 accepts the new file");
    }
}

fn first_difference(golden: &str, text: &str) -> Option<String> {
    let differs = golden.lines().zip(text.lines()).enumerate().find(|(_, (a, b))| a != b);
    match differs {
        Some((i, (a, b))) => Some(format!("line {}: {a:?} became {b:?}", i + 1)),
        None if golden != text => Some(format!("{} bytes became {}", golden.len(), text.len())),
        None => None,
    }
}

/// The file without the version, which changes with every release.
fn versionless(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes)
        .unwrap()
        .replace(concat!("microtome ", env!("CARGO_PKG_VERSION")), "microtome VERSION")
}

#[test]
fn the_demo_part() {
    let bench = Bench::new();
    let done = bench.run(["demo", "--quiet"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let gcode = versionless(std::fs::read(bench.path("demo.gcode")).unwrap());
    // One line a layer, so that a change shows where it is.
    let digest = |part: &str| {
        let hash: String = Sha256::digest(part).iter().take(12).map(|b| format!("{b:02x}")).collect();
        let z = part.lines().find_map(|l| l.strip_prefix(";Z:")).unwrap_or("head");
        format!("{z}\t{}\t{hash}\n", part.lines().count())
    };
    let parts: String = gcode.split(";LAYER_CHANGE\n").map(digest).collect();
    same_as_golden("demo.layers", &parts);
}

#[test]
fn a_small_plate_whole() {
    let bench = Bench::new();
    let plate = shapes::cuboid([0.0; 3], [12.0, 8.0, 0.8]);
    let more =
        ["--layer-height", "0.2", "--first-layer-height", "0.2", "--skirts", "1", "--top-solid-layers", "1"];
    let gcode = bench.slice(&bench.stl("plate.stl", &plate), &more);
    same_as_golden("plate.gcode", &versionless(gcode));
}

#[test]
fn the_comparison_sees_a_difference() {
    assert_eq!(first_difference("a\nb\n", "a\nb\n"), None);
    assert!(first_difference("a\nb\n", "a\nc\n").unwrap().contains("line 2"));
    assert!(first_difference("a\nb\n", "a\nb\nc\n").unwrap().contains("bytes"));
}
