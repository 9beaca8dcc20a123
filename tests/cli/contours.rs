//! `microtome contours`: every format is read back by a small reader of its own.

use super::{Bench, stderr, stdout};
use microtome::mesh::{Mesh, shapes};
use serde_json::Value;
use std::path::Path;

type Ring = Vec<[f64; 2]>;

/// A plane as read from a file: its height and its closed contours.
struct Plane {
    z: f64,
    rings: Vec<Ring>,
}

fn area(rings: &[Ring]) -> f64 {
    let ring = |r: &Ring| -> f64 {
        (0..r.len()).map(|i| (r[i], r[(i + 1) % r.len()])).map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum()
    };
    0.5 * rings.iter().map(ring).sum::<f64>()
}

fn pairs(numbers: &[f64]) -> Ring {
    numbers.chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}

fn number(text: &str) -> f64 {
    text.trim().parse().unwrap_or_else(|_| panic!("{text:?} is no number"))
}

/// The text between the first `from` and the next `to`.
fn between<'a>(text: &'a str, from: &str, to: &str) -> &'a str {
    text.split_once(from).unwrap_or_else(|| panic!("{from} in {text}")).1.split_once(to).unwrap().0
}

fn read_svg(text: &str) -> Vec<Plane> {
    assert!(text.contains(r#"fill-rule="nonzero""#) && text.contains(r#"transform="scale(1 -1)""#));
    let ring = |m: &str| pairs(&m.split([' ', ',']).map(number).collect::<Vec<_>>());
    let plane = |line: &str| Plane {
        z: number(between(line, "data-z=\"", "\"")),
        rings: between(line, " d=\"", "\"").split_terminator('Z').map(|r| ring(&r[1..])).collect(),
    };
    text.lines().filter(|l| l.starts_with("<g id=")).map(plane).collect()
}

fn read_json(text: &str) -> Vec<Plane> {
    let value: Value = serde_json::from_str(text).unwrap();
    let plane = |layer: &Value| {
        let rings: Vec<Ring> = serde_json::from_value(layer["contours"].clone()).unwrap();
        assert!((layer["area"].as_f64().unwrap() - area(&rings)).abs() < 1e-6);
        Plane { z: layer["z"].as_f64().unwrap(), rings }
    };
    value["layers"].as_array().unwrap().iter().map(plane).collect()
}

fn read_wkt(text: &str) -> Vec<Plane> {
    let ring = |text: &str| -> (Ring, f64) {
        let numbers: Vec<f64> = text.split([' ', ',']).filter(|t| !t.is_empty()).map(number).collect();
        let points: Vec<[f64; 3]> = numbers.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect();
        assert!(points.len() >= 4 && points.first() == points.last(), "rings are closed");
        (points[1..].iter().map(|p| [p[0], p[1]]).collect(), points[0][2])
    };
    let plane = |line: &str| {
        let body = line.strip_prefix("MULTIPOLYGON Z ").unwrap();
        if body == "EMPTY" {
            return Plane { z: f64::NAN, rings: vec![] };
        }
        let polygons = body.strip_prefix("(((").unwrap().strip_suffix(")))").unwrap();
        let mut plane = Plane { z: 0.0, rings: vec![] };
        for polygon in polygons.split(")), ((") {
            for (i, text) in polygon.split("), (").enumerate() {
                let (points, z) = ring(text);
                assert_eq!(
                    area(std::slice::from_ref(&points)) > 0.0,
                    i == 0,
                    "holes come after their outline"
                );
                plane.z = z;
                plane.rings.push(points);
            }
        }
        plane
    };
    text.lines().map(plane).collect()
}

fn read_cli(text: &str) -> Vec<Plane> {
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines[..4], ["$$HEADERSTART", "$$ASCII", "$$UNITS/1", "$$VERSION/200"]);
    let begin = lines.iter().position(|l| *l == "$$GEOMETRYSTART").unwrap();
    assert_eq!((lines[begin - 1], *lines.last().unwrap()), ("$$HEADEREND", "$$GEOMETRYEND"));
    let mut planes: Vec<Plane> = Vec::new();
    for line in &lines[begin + 1..lines.len() - 1] {
        let (command, rest) = line.split_once('/').unwrap();
        match command {
            "$$LAYER" => planes.push(Plane { z: number(rest), rings: vec![] }),
            "$$POLYLINE" => {
                let numbers: Vec<f64> = rest.split(',').map(number).collect();
                let mut ring = pairs(&numbers[3..]);
                assert_eq!((numbers[0], numbers[2] as usize), (1.0, ring.len()));
                assert_eq!(ring.first(), ring.last(), "the first point is repeated");
                ring.pop();
                assert_eq!(area(std::slice::from_ref(&ring)) > 0.0, numbers[1] == 1.0);
                planes.last_mut().unwrap().rings.push(ring);
            }
            _ => panic!("{line}"),
        }
    }
    let claimed = lines.iter().find_map(|l| l.strip_prefix("$$LAYERS/")).unwrap();
    assert_eq!(claimed.parse::<usize>().unwrap(), planes.len());
    planes
}

/// White pixels of each picture of a folder, in the order of names.
fn read_png(folder: &Path) -> Vec<usize> {
    let mut names: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    let white = |p: &std::path::PathBuf| {
        let picture = image::open(p).unwrap().to_luma8();
        picture.pixels().filter(|p| p.0[0] == 255).count()
    };
    names.iter().map(white).collect()
}

/// Area of the section of a mesh at height `z` \[nm\] of its lattice, from its triangles one by one.
fn section(mesh: &Mesh, z: f64) -> f64 {
    let mut twice = 0.0;
    for t in &mesh.triangles {
        let p = t.map(|v| mesh.vertices[v as usize]).map(|p| [p.x, p.y, p.z].map(f64::from));
        let (mut start, mut end) = (None, None);
        for (a, b) in [(p[0], p[1]), (p[1], p[2]), (p[2], p[0])] {
            let w = (z - a[2]) / (b[2] - a[2]);
            let at = [a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1])];
            if a[2] >= z && b[2] < z {
                start = Some(at);
            } else if a[2] < z && b[2] >= z {
                end = Some(at);
            }
        }
        if let (Some(s), Some(e)) = (start, end) {
            twice += s[0] * e[1] - s[1] * e[0];
        }
    }
    0.5e-12 * twice
}

/// Runs `contours`, which must succeed, and returns what it prints with `--json`.
fn contours(bench: &Bench, model: &str, out: &str, more: &[&str]) -> Value {
    let mut args = vec!["contours", model, "-o", out, "--json"];
    args.extend(more);
    let done = bench.run(&args);
    assert!(done.status.success(), "{args:?}\n{}", stderr(&done));
    serde_json::from_str(&stdout(&done)).unwrap()
}

fn read(bench: &Bench, name: &str) -> String {
    std::fs::read_to_string(bench.path(name)).unwrap()
}

const HEIGHTS: [&str; 4] = ["--layer-height", "0.5", "--first-layer-height", "0.5"];

#[test]
fn every_format_holds_the_sections_of_the_mesh() {
    let bench = Bench::new();
    let plate = shapes::holed_plate([0.0, 0.0], [30.0, 20.0], [11.0, 9.0], 5.0, 24, [0.0, 3.0]);
    for (name, mesh) in [("ball", shapes::sphere(6.0, 48, 24)), ("plate", plate)] {
        let model = format!("{name}.stl");
        bench.stl(&model, &mesh);
        let summary = contours(&bench, &model, "a.json", &HEIGHTS);
        let bottom = f64::from(mesh.bounds().unwrap()[0].z);
        let exact: Vec<f64> = (0..summary["planes"].as_u64().unwrap())
            .map(|i| section(&mesh, bottom + (i as f64 + 0.5) * 5e5))
            .collect();
        assert!(exact.len() >= 6 && exact.iter().all(|a| *a > 1.0));
        let close = |a: f64, i: usize| (a - exact[i]).abs() < 1e-4;
        for (i, a) in summary["areas_mm2"].as_array().unwrap().iter().enumerate() {
            assert!(close(a.as_f64().unwrap(), i), "{name} {i}: {a} against {}", exact[i]);
        }
        type Reader = fn(&str) -> Vec<Plane>;
        let formats: [(&str, Reader, f64); 4] = [
            ("a.svg", read_svg, 0.25),
            ("a.json", read_json, 0.25),
            ("a.wkt", read_wkt, 0.25),
            ("a.cli", read_cli, 0.5),
        ];
        let mut first: Option<Vec<Plane>> = None;
        for (file, reader, lowest) in formats {
            let said = contours(&bench, &model, file, &HEIGHTS);
            assert_eq!(said["bytes"], bench.path(file).metadata().unwrap().len());
            let planes = reader(&read(&bench, file));
            assert_eq!(planes.len(), exact.len(), "{file}");
            for (i, plane) in planes.iter().enumerate() {
                assert!((plane.z - (lowest + 0.5 * i as f64)).abs() < 1e-12, "{file}: {}", plane.z);
                assert!(
                    close(area(&plane.rings), i),
                    "{file} {i}: {} against {}",
                    area(&plane.rings),
                    exact[i]
                );
            }
            // To the last nanometre the same in all of them, whatever the order and the start of rings.
            let points = |planes: &[Plane]| -> Vec<Vec<[i64; 2]>> {
                let plane = |p: &Plane| {
                    let mut all: Vec<_> =
                        p.rings.iter().flatten().map(|p| p.map(|c| (c * 1e6).round() as i64)).collect();
                    all.sort_unstable();
                    all
                };
                planes.iter().map(plane).collect()
            };
            if let Some(first) = &first {
                assert_eq!(points(first), points(&planes), "{file}");
            }
            first.get_or_insert(planes);
        }
        contours(&bench, &model, "pictures/", &[&HEIGHTS[..], &["--scale", "20"]].concat());
        let white = read_png(&bench.path("pictures"));
        assert_eq!(white.len(), exact.len());
        for (pixels, area) in white.iter().zip(&exact) {
            let found = *pixels as f64 / 400.0;
            assert!((found - area).abs() < 0.02 * area, "{found} against {area}");
        }
        std::fs::remove_dir_all(bench.path("pictures")).unwrap();
    }
}

#[test]
fn counts_are_those_of_the_successors() {
    let bench = Bench::new();
    let tooth = |i: usize| {
        let x = 3.0 * i as f64;
        shapes::cuboid([x, 0.0, 0.0], [x + 2.0, 5.0, 1.0 + i as f64])
    };
    bench.stl("comb.stl", &shapes::merge(&(0..7).map(tooth).collect::<Vec<_>>()));
    let said =
        contours(&bench, "comb.stl", "a.json", &["--layer-height", "0.2", "--first-layer-height", "0.2"]);
    // Tooth i has 5 (i + 1) planes, 8 triangles on each.
    let contours_of = |teeth: std::ops::RangeInclusive<u64>| teeth.map(|n| 5 * n).sum::<u64>();
    assert_eq!(said["planes"], 35);
    assert_eq!(said["contours"], contours_of(1..=7));
    assert_eq!(said["segments"], 8 * contours_of(1..=7));
    assert_eq!((&said["open_chains"], &said["layers"]), (&0.into(), &35.into()));
    assert!(said["times"].as_array().unwrap().len() > 5);

    // A plane on the tip: three segments without length, a cycle, and no contour in the file.
    bench.stl("tip.stl", &shapes::tetrahedron(10.0));
    let tip = shapes::tetrahedron(10.0).bounds().unwrap();
    let high = f64::from(tip[1].z - tip[0].z) * 1e-6;
    bench.write("z.txt", format!("1 # low\n{high:.6}\n"));
    let said = contours(&bench, "tip.stl", "a.json", &["--planes", "z.txt"]);
    assert_eq!((&said["planes"], &said["layers"]), (&2.into(), &1.into()));
    assert_eq!((&said["contours"], &said["segments"]), (&2.into(), &6.into()));

    // A box without its lid, open on the plane of its upper edge only by one wall.
    let mut hole = shapes::cuboid([0.0; 3], [4.0; 3]);
    let wall = hole.triangles.iter().position(|t| {
        let z = t.map(|v| hole.vertices[v as usize].z);
        z.iter().any(|c| *c != z[0])
    });
    hole.triangles.remove(wall.unwrap());
    bench.stl("hole.stl", &hole);
    let said = contours(&bench, "hole.stl", "a.json", &HEIGHTS);
    assert_eq!((&said["planes"], &said["open_chains"], &said["contours"]), (&8.into(), &8.into(), &0.into()));
    assert_eq!(said["segments"], 8 * 7);
    assert!(
        said["warnings"].as_array().unwrap().iter().any(|w| w.as_str().unwrap().contains("open contours"))
    );
    let layers: Value = serde_json::from_str(&read(&bench, "a.json")).unwrap();
    assert_eq!(layers["layers"][0]["open"]["chains"], 1);
}

#[test]
fn planes_of_a_list() {
    let bench = Bench::new();
    bench.stl("box.stl", &shapes::cuboid([0.0; 3], [10.0, 8.0, 4.0]));
    bench.write("z.txt", "# heights\n0\n0.125\n\n3.999999 # just below the top\n4\n5\n");
    let said = contours(&bench, "box.stl", "a.json", &["--planes", "z.txt"]);
    assert_eq!(said["z_mm"], serde_json::json!([0.0, 0.125, 3.999999, 4.0, 5.0]));
    // A vertex on a plane counts as above it.
    assert_eq!(said["areas_mm2"], serde_json::json!([0.0, 80.0, 80.0, 80.0, 0.0]));
    for (text, words) in [
        ("1\n2\nNaN\n", "z.txt:3: NaN"),
        ("1\n2\n1.5\n", "z.txt:3: 1.5"),
        ("1\n\n1\n", "z.txt:3: 1 mm is there twice"),
        ("one\n", "z.txt:1: \"one\""),
        ("", "z.txt:1"),
    ] {
        bench.write("z.txt", text);
        let done = bench.run(["contours", "box.stl", "-o", "b.json", "--planes", "z.txt"]);
        assert_eq!(done.status.code(), Some(4), "{}", stderr(&done));
        assert!(stderr(&done).contains(words), "{words}: {}", stderr(&done));
    }
    bench.write("z.txt", "7\n8\n");
    let done = bench.run(["contours", "box.stl", "-o", "b.json", "--planes", "z.txt"]);
    assert!(
        done.status.code() == Some(3) && stderr(&done).contains("none of the 2 planes"),
        "{}",
        stderr(&done)
    );
    let done = bench.run(["contours", "box.stl", "-o", "b.json", "--planes", "none.txt"]);
    assert!(done.status.code() == Some(4) && stderr(&done).contains("none.txt"), "{}", stderr(&done));
    assert_eq!(bench.names(), ["a.json", "box.stl", "z.txt"]);
}

#[test]
fn planes_in_any_direction() {
    let bench = Bench::new();
    let cube = shapes::cuboid([-2.0, 1.0, 5.0], [8.0, 11.0, 15.0]);
    bench.stl("cube.stl", &cube);
    // Through the middle (3, 6, 10) across the space diagonal: a regular hexagon.
    let d = 19.0 / 3f64.sqrt();
    bench.write("z.txt", format!("{:.6}\n{d:.6}\n", d - 1.0));
    let more = ["--plane-normal", "2,2,2", "--planes", "z.txt", "--no-place"];
    let said = contours(&bench, "cube.stl", "a.json", &more);
    let hexagon = 3.0 * 3f64.sqrt() / 4.0 * 100.0;
    assert!((said["areas_mm2"][1].as_f64().unwrap() - hexagon).abs() < 1e-4, "{}", said["areas_mm2"]);
    assert_eq!(said["contours"], 2);

    // Placed or not, the transform leads back onto the cube's edges.
    bench.write("y.txt", format!("{:.6}\n", 15.0 / 3f64.sqrt()));
    contours(&bench, "cube.stl", "b.json", &["--plane-normal", "2,2,2", "--planes", "y.txt"]);
    for (file, layer) in [("a.json", 1), ("b.json", 0)] {
        let value: Value = serde_json::from_str(&read(&bench, file)).unwrap();
        let vector = |key: &str| -> [f64; 3] { serde_json::from_value(value["frame"][key].clone()).unwrap() };
        let [u, v, n, origin] = ["u", "v", "n", "origin"].map(vector);
        let rings: Vec<Ring> = serde_json::from_value(value["layers"][layer]["contours"].clone()).unwrap();
        let z = value["layers"][layer]["z"].as_f64().unwrap();
        // A diagonal of the triangulation may leave a point, off its side by the rounding.
        let mut corners = 0;
        for [x, y] in &rings[0] {
            let p = [0, 1, 2].map(|i| origin[i] + x * u[i] + y * v[i] + z * n[i]);
            assert!((p.iter().sum::<f64>() / 3f64.sqrt() - d).abs() < 1e-5);
            let sides = [(-2.0, 8.0), (1.0, 11.0), (5.0, 15.0)];
            let on =
                (0..3).filter(|&i| [sides[i].0, sides[i].1].iter().any(|s| (p[i] - s).abs() < 1e-5)).count();
            assert!(on >= 1, "{p:?} lies on a side");
            corners += usize::from(on == 2);
        }
        assert_eq!(corners, 6, "{rings:?}");
    }
}

#[test]
fn a_normal_along_z_changes_nothing_and_along_another_axis_exchanges_axes() {
    let bench = Bench::new();
    bench.stl("part.stl", &shapes::knot(2.0, 1.0, 3000));
    bench.stl("box.stl", &shapes::cuboid([0.0; 3], [10.0, 8.0, 4.0]));
    for file in ["a.svg", "a.json", "a.wkt", "a.cli"] {
        contours(&bench, "part.stl", file, &[]);
        let plain = std::fs::read(bench.path(file)).unwrap();
        contours(&bench, "part.stl", file, &["--plane-normal", "0,0,17.3", "--threads", "1"]);
        assert!(plain == std::fs::read(bench.path(file)).unwrap(), "{file}");
    }
    for (normal, area, planes) in
        [("0,0,-1", 80.0, 8), ("3,0,0", 32.0, 20), ("-3,0,0", 32.0, 20), ("0,-1,0", 40.0, 16)]
    {
        let said =
            contours(&bench, "box.stl", "b.json", &[&HEIGHTS[..], &["--plane-normal", normal]].concat());
        assert_eq!(said["planes"], planes);
        assert!(said["areas_mm2"].as_array().unwrap().iter().all(|a| *a == area), "{normal}");
    }
}

#[test]
fn what_is_refused() {
    let bench = Bench::new();
    bench.stl("box.stl", &shapes::cuboid([0.0; 3], [10.0, 8.0, 4.0]));
    bench.write("page.stl", "<!DOCTYPE html><html></html>");
    for (args, code, words) in [
        (&["box.stl", "-o", "a.gcode"][..], 2, &["a.gcode", ".svg", ".json", ".wkt", ".cli", "folder"][..]),
        (&["box.stl", "-o", "a"], 2, &[".svg"]),
        (&["box.stl"], 2, &["--output"]),
        (&["box.stl", "-o", "a.svg", "--plane-normal", "0,0,0"], 2, &["no direction"]),
        (&["box.stl", "-o", "a.svg", "--plane-normal", "-1,nan,0"], 2, &["no direction"]),
        (&["box.stl", "-o", "a.svg", "--plane-normal", "1,2"], 2, &["three numbers"]),
        (&["box.stl", "-o", "a.svg", "--algorithm", "magic"], 2, &["magic", "grouping"]),
        (&["box.stl", "-o", "pictures/", "--scale", "0"], 4, &["pixels per millimetre"]),
        (&["box.stl", "-o", "a.svg", "--layer-height", "-1"], 4, &["layer_height"]),
        (&["box.stl", "-o", "a.svg", "--layer-height", "9", "--first-layer-height", "9"], 3, &["layer"]),
        (&["page.stl", "-o", "a.svg"], 3, &["HTML"]),
        (&["none.stl", "-o", "a.svg"], 3, &["none.stl"]),
        (&["box.stl", "-o", "no/a.svg"], 6, &["no/a.svg"]),
        (&["box.stl", "-o", "no/a/"], 6, &["no/a"]),
    ] {
        let done = bench.run(["contours"].iter().chain(args));
        assert_eq!(done.status.code(), Some(code), "{args:?}: {}", stderr(&done));
        for word in words {
            assert!(stderr(&done).contains(word), "{args:?}: {word} in {}", stderr(&done));
        }
        assert_eq!(bench.names(), ["box.stl", "page.stl"]);
    }
    // Larger than any bed: contours are cut all the same.
    bench.stl("wide.stl", &shapes::cuboid([0.0; 3], [900.0, 8.0, 700.0]));
    assert_eq!(
        contours(&bench, "wide.stl", "a.wkt", &["--layer-height", "10", "--first-layer-height", "10"])["planes"],
        70
    );
}

#[test]
fn adaptive_layers_reach_the_gcode() {
    let bench = Bench::new();
    bench.stl("ball.stl", &shapes::sphere(8.0, 60, 40));
    let slice = |more: &[&str]| -> (Value, String) {
        let args =
            ["slice", "ball.stl", "-o", "a.gcode", "--json", "--fill-density", "100%", "--skirts", "0"];
        let done = bench.run(args.iter().chain(more));
        assert!(done.status.success(), "{}", stderr(&done));
        (serde_json::from_str(&stdout(&done)).unwrap(), read(&bench, "a.gcode"))
    };
    let (plain, _) = slice(&["--layer-height", "0.1"]);
    let flags = ["--adaptive-layer-height", "--min-layer-height", "0.05", "--adaptive-cusp-height", "0.05"];
    let (adaptive, text) = slice(&flags);
    let volume = |s: &Value| s["filament"]["cm3"].as_f64().unwrap();
    assert!(
        (volume(&adaptive) / volume(&plain) - 1.0).abs() < 0.02,
        "{} {}",
        volume(&adaptive),
        volume(&plain)
    );
    // The height of a layer follows its change; those of threads over air come later.
    let changes = text.split(";LAYER_CHANGE\n").skip(1);
    let heights: Vec<f64> = changes
        .filter_map(|layer| layer.lines().find_map(|l| l.strip_prefix(";HEIGHT:")))
        .map(number)
        .collect();
    let (least, most) =
        heights.iter().skip(1).fold((9.0, 0.0), |(a, b): (f64, f64), h| (a.min(*h), b.max(*h)));
    assert!(least < 0.08 && (most - 0.3).abs() < 1e-9, "{least} {most}");

    let said = contours(&bench, "ball.stl", "a.cli", &flags);
    assert_eq!(said["planes"], adaptive["layers"]);
    let tops: Vec<f64> = read_cli(&read(&bench, "a.cli")).iter().map(|p| p.z).collect();
    assert!(tops.windows(2).all(|w| (0.05 - 1e-9..=0.3 + 1e-9).contains(&(w[1] - w[0]))));
}

#[test]
fn every_algorithm_writes_the_same_file() {
    let bench = Bench::new();
    bench.stl("part.stl", &microtome::mesh::demo_part());
    bench.write("planes.txt", "0.5\n3.1\n3.2\n9\n14.85\n27\n");
    for planes in [&["--layer-height", "0.3"][..], &["--planes", "planes.txt"]] {
        let plain = contours(&bench, "part.stl", "main.json", planes);
        let main = read(&bench, "main.json");
        assert!(main.len() > 1000);
        for algorithm in ["trivial", "sweep", "grouping", "incremental"] {
            let more = [planes, &["--algorithm", algorithm]].concat();
            let summary = contours(&bench, "part.stl", "other.json", &more);
            assert_eq!(summary["backend"]["reason"], format!("--algorithm {algorithm}"));
            assert!(main == read(&bench, "other.json"), "{algorithm} {planes:?}");
            for key in ["planes", "segments", "contours", "open_chains", "areas_mm2", "layers"] {
                assert_eq!(summary[key], plain[key], "{algorithm}: {key}");
            }
        }
    }
}
