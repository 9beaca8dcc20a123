//! Files that are not what they should be: each is refused in one clear line, or used with a warning.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use super::random::Random;
use super::shapes::{knot, sphere, tetrahedron};
use super::stl_write::{write_stl_ascii, write_stl_binary};
use super::*;
use std::fs;
use std::path::Path;

fn binary(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    write_stl_binary(mesh, &mut bytes).unwrap();
    bytes
}

fn ascii(mesh: &Mesh) -> String {
    let mut bytes = Vec::new();
    write_stl_ascii(mesh, &mut bytes).unwrap();
    String::from_utf8(bytes).unwrap()
}

/// Writes a file, loads it, and checks that a refusal is one line that names the file.
fn load_file(name: &str, bytes: &[u8]) -> Result<Loaded, MeshError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, bytes).unwrap();
    let result = load(&path);
    if let Err(e) = &result {
        let message = e.to_string();
        assert!(message.starts_with(&path.display().to_string()) && !message.contains('\n'), "{message}");
    }
    result
}

/// The refusal's message without the folder.
fn refusal(name: &str, bytes: &[u8]) -> String {
    let message = load_file(name, bytes).unwrap_err().to_string();
    message.split_once(&format!("{name}: ")).unwrap().1.to_string()
}

/// A binary tetrahedron with one coordinate replaced.
fn with_coordinate(facet: usize, corner: usize, axis: usize, value: f32) -> Vec<u8> {
    let mut bytes = binary(&tetrahedron(10.0));
    let at = 84 + 50 * facet + 12 + 12 * corner + 4 * axis;
    bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
    bytes
}

#[test]
fn good_files_load_whatever_form_they_have() {
    let mesh = knot(10.0, 3.0, 2000);
    let expected = load_file("a.stl", &binary(&mesh)).unwrap();
    assert_eq!(
        (expected.facets, expected.collapsed, expected.warnings.len()),
        (mesh.triangles.len() as u64, 0, 0)
    );
    assert_eq!(expected.mesh.triangles.len(), mesh.triangles.len());
    assert_eq!(expected.mesh.vertices.len(), mesh.vertices.len());

    let text = ascii(&mesh);
    let bom = ["\u{FEFF}", &text].concat();
    let utf16: Vec<u8> = bom.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let utf16_be: Vec<u8> = bom.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let mut solid = binary(&mesh);
    solid[..9].copy_from_slice(b"solid abc");
    for bytes in [
        text.as_bytes(),
        text.to_uppercase().as_bytes(),
        text.replace('\n', "\r\n").as_bytes(),
        bom.as_bytes(),
        &utf16,
        &utf16_be,
        &solid,
    ] {
        let loaded = load_file("a.stl", bytes).unwrap();
        assert_eq!(loaded.mesh, expected.mesh);
        assert!(loaded.warnings.is_empty());
    }
    assert!(load_file("part", &binary(&mesh)).is_ok(), "no extension");
    assert!(load_file("part.obj", &binary(&mesh)).is_ok(), "content decides");
}

#[test]
fn the_number_of_threads_changes_nothing() {
    let mesh = knot(10.0, 3.0, 70_000);
    let (binary, text) = (binary(&mesh), ascii(&mesh));
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let a = load_bytes(Path::new("a.stl"), &binary).unwrap().mesh;
            let b = load_bytes(Path::new("a.stl"), text.as_bytes()).unwrap().mesh;
            assert_eq!(a, b);
            let adjacency = Adjacency::build(&a);
            let report = audit(&a, &adjacency);
            (a, adjacency, report)
        })
    };
    assert!(run(1) == run(3));
}

#[test]
fn what_is_not_a_file_of_triangles_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    assert!(matches!(load(&folder.path().join("no.stl")), Err(MeshError::Missing { .. })));
    assert!(matches!(load(folder.path()), Err(MeshError::Directory { .. })));
    assert!(matches!(load_file("a.stl", b""), Err(MeshError::Empty { .. })));
    assert!(matches!(load_file("a.stl", b"<!DOCTYPE html>\n<html>"), Err(MeshError::Html { .. })));
    assert!(matches!(load_file("a.stl", b"\n <?xml version='1.0'?> <HTML>"), Err(MeshError::Html { .. })));
    assert!(matches!(load_file("a.stl", b"v 1 2 3\nf 1 2 3\n"), Err(MeshError::NotStl { .. })));
    assert!(matches!(load_file("a.stl", b"PK\x03\x04..."), Err(MeshError::NotStl { .. })));
    assert!(matches!(load_file("a.stl", &[7; 60]), Err(MeshError::TooShort { .. })));
    assert!(matches!(load_file("a.stl", &[0; 84]), Err(MeshError::NoTriangles { .. })));
    assert!(matches!(load_file("a.stl", &[0; 184]), Err(MeshError::NoTriangles { .. })));
    assert!(matches!(load_file("a.stl", b"solid a\nendsolid a\n"), Err(MeshError::NoTriangles { .. })));
    for name in ["a.obj", "a.3mf", "a.PLY"] {
        let message = refusal(name, b"v 1 2 3\nf 1 2 3\n");
        assert!(message.contains("not supported; supported are binary and ASCII STL"), "{message}");
    }
}

#[test]
fn a_header_that_lies_is_caught_before_anything_is_allocated() {
    let mut bytes = binary(&tetrahedron(10.0));
    bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    assert!(refusal("a.stl", &bytes).contains("its header promises 4294967295 facets, the file holds 4"));
    let whole = binary(&tetrahedron(10.0));
    for length in 84..whole.len() {
        let held = (length - 84) / 50;
        let message = refusal("a.stl", &whole[..length]);
        assert!(
            message.contains(&format!("promises 4 facets, the file holds {held};")) || length < 134,
            "{message}"
        );
    }
    let longer = [&whole[..], &[1, 2, 3]].concat();
    let loaded = load_file("a.stl", &longer).unwrap();
    assert!(matches!(loaded.warnings[..], [Warning::TrailingBytes { bytes: 3, facets: 4, .. }]));
}

#[test]
fn bad_coordinates_are_named() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let message = refusal("a.stl", &with_coordinate(2, 1, 2, value));
        assert!(
            message.starts_with(&format!("z of corner 2 of facet 3 is {value:?}, not a finite")),
            "{message}"
        );
    }
    assert!(
        refusal("a.stl", &with_coordinate(3, 0, 1, 1e30)).contains("y of corner 1 of facet 4 is 1e30 mm")
    );
    let message = refusal("a.stl", &with_coordinate(3, 0, 0, 5000.0));
    assert!(
        message.contains("x of corner 1 of facet 4 is 5000.0 mm") && message.contains("units"),
        "{message}"
    );

    let text = ascii(&tetrahedron(10.0));
    let nth = |n: usize, word: &str| {
        let mut lines: Vec<String> = text.lines().map(String::from).collect();
        lines[n] = format!("vertex 0 {word} 0");
        lines.join("\r\n")
    };
    for word in ["nan", "-inf", "Infinity", "1e39"] {
        let message = refusal("a.stl", nth(11, word).as_bytes());
        assert!(message.starts_with("line 12: y of corner 2 of facet 2 is"), "{message}");
    }
    assert!(
        refusal("a.stl", nth(11, "9e5").as_bytes())
            .contains("line 12: y of corner 2 of facet 2 is 900000.0 mm")
    );
    assert!(
        refusal("a.stl", nth(11, "zwei").as_bytes()).starts_with("line 12: expected a number, found `zwei`")
    );
}

#[test]
fn cut_and_collapsed_files() {
    let text = ascii(&tetrahedron(10.0));
    assert!(
        refusal("a.stl", &text.as_bytes()[..text.len() - 60]).contains("ends before its last facet does")
    );
    let open = load_file("a.stl", text.replace("endsolid microtome", "").as_bytes()).unwrap();
    assert!(matches!(open.warnings[..], [Warning::NoEndSolid { .. }]));
    let mut one = load_file("a.stl", &with_coordinate(0, 0, 0, 0.0)).unwrap();
    assert_eq!(one.collapsed, 0);
    one = load_file(
        "a.stl",
        &[
            &binary(&tetrahedron(10.0))[..80],
            &5u32.to_le_bytes(),
            &binary(&tetrahedron(10.0))[84..],
            &[0; 50],
        ]
        .concat(),
    )
    .unwrap();
    assert_eq!((one.collapsed, one.facets, one.mesh.triangles.len()), (1, 5, 4));
    let dust = refusal("a.stl", &binary(&tetrahedron(1e-7)));
    assert!(dust.contains("all 4 facets collapse"), "{dust}");
}

/// Whatever the bytes, the loader returns; a mesh that it returns keeps its promises.
#[test]
fn random_cut_and_altered_files_never_panic() {
    let seeds = [binary(&sphere(9.0, 12, 8)), ascii(&tetrahedron(7.0)).into_bytes()];
    let mut loaded = 0;
    for seed in 0..4000u64 {
        let mut random = Random(seed);
        let mut bytes = seeds[seed as usize % 2].clone();
        match random.below(5) {
            0 => bytes = (0..random.below(700)).map(|_| random.next() as u8).collect(),
            1 => bytes.truncate(random.below(bytes.len())),
            2 => {
                for _ in 0..1 + random.below(8) {
                    let at = random.below(bytes.len());
                    bytes[at] = random.next() as u8;
                }
            }
            3 => {
                let (from, to) = (random.below(bytes.len()), random.below(bytes.len()));
                drop(bytes.drain(from.min(to)..from.max(to)));
            }
            _ => {
                let at = random.below(bytes.len());
                let piece = bytes[at..].to_vec();
                bytes.splice(random.below(at)..at, piece);
            }
        }
        let run = std::panic::catch_unwind(|| load_bytes(Path::new("a.stl"), &bytes));
        let Ok(result) = run else { panic!("seed {seed}") };
        let Ok(Loaded { mesh, facets, collapsed, .. }) = result else { continue };
        loaded += 1;
        assert_eq!(mesh.triangles.len() as u64 + collapsed, facets, "seed {seed}");
        let sound = |t: &[u32; 3]| {
            t.iter().all(|&v| (v as usize) < mesh.vertices.len())
                && t[0] != t[1]
                && t[1] != t[2]
                && t[0] != t[2]
        };
        assert!(mesh.triangles.iter().all(sound), "seed {seed}");
        let limit = crate::lattice::LIMIT;
        assert!(mesh.vertices.iter().all(|v| [v.x, v.y, v.z].iter().all(|c| c.abs() < limit)), "seed {seed}");
        let found = audit(&mesh, &Adjacency::build(&mesh));
        assert_eq!(found.triangles, mesh.triangles.len() as u64, "seed {seed}");
    }
    assert!(loaded > 100, "the altered files must not all be refused early: {loaded}");
}
