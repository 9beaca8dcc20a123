//! `--duplicate` lays copies of a part side by side.

use super::{Bench, stderr, stdout};
use microtome::mesh::shapes;
use serde_json::Value;

#[test]
fn copies_lie_side_by_side() {
    let bench = Bench::new();
    let model = bench.stl("box.stl", &shapes::cuboid([0.0; 3], [20.0, 10.0, 3.0]));
    let slice = |more: &[&str]| -> Value {
        let args = ["slice", "box.stl", "-o", "a.gcode", "--json", "--skirts", "0"];
        let done = bench.run(args.iter().chain(more));
        assert!(done.status.success(), "{}", stderr(&done));
        serde_json::from_str(&stdout(&done)).unwrap()
    };
    let [one, four] = ["1", "4"].map(|n| slice(&["--duplicate", n, "--duplicate-distance", "5"]));
    let number = |v: &Value| v.as_f64().unwrap();
    for role in ["External perimeter", "Perimeter", "Solid infill"] {
        let [a, b] = [&one, &four].map(|s| number(&s["filament"]["mm_by_role"][role]));
        assert!((b / a - 4.0).abs() < 0.02, "{role}: {a} and {b} mm");
    }
    assert_eq!(four["triangles"], 48);
    // A row of 4 x 20 mm and three distances, centred on the bed of 200 mm.
    let [low, high] = [0, 1].map(|i| number(&four["bounds_mm"][i][0]));
    assert!((low - 52.5).abs() < 0.5 && (high - 147.5).abs() < 0.5, "{low} to {high}");
    let plain = bench.slice(&model, &[]);
    assert!(plain == bench.slice(&model, &["--duplicate", "1"]), "one copy is the part itself");
}

#[test]
fn modifiers_go_with_every_copy() {
    let bench = Bench::new();
    let mut part = shapes::cuboid([-2.0, -2.0, 0.0], [2.0, 2.0, 6.0]);
    let roof = shapes::cuboid([-9.0, -9.0, 6.0], [9.0, 9.0, 7.0]);
    let first = part.vertices.len() as u32;
    part.vertices.extend(roof.vertices);
    part.triangles.extend(roof.triangles.into_iter().map(|t| t.map(|v| v + first)));
    bench.stl("part.stl", &part);
    bench.stl("where.stl", &shapes::cuboid([3.0, -9.0, 1.0], [9.0, 9.0, 6.5]));
    let support = |copies: &str| {
        let args = ["slice", "part.stl", "--estimate-only", "--json", "--support-material=1"];
        let only = ["--support-material-auto=0", "--support-enforcer", "where.stl", "--duplicate", copies];
        let done = bench.run(args.iter().chain(&only));
        let summary: Value = serde_json::from_str(&stdout(&done)).unwrap();
        summary["filament"]["mm_by_role"]["Support material"].as_f64().unwrap()
    };
    let [one, three] = ["1", "3"].map(support);
    assert!(one > 5.0 && (three / one - 3.0).abs() < 0.1, "{one} and {three} mm");
}

#[test]
fn a_crowded_bed_is_refused() {
    let bench = Bench::new();
    bench.stl("box.stl", &shapes::cuboid([0.0; 3], [90.0, 90.0, 1.0]));
    let done = bench.run(["slice", "box.stl", "--duplicate", "5"]);
    let text = stderr(&done);
    assert_eq!(done.status.code(), Some(3), "{text}");
    assert!(text.contains("box.stl: the 5 parts need") && text.lines().count() == 1, "{text}");
    assert_eq!(bench.names(), ["box.stl"]);
}
