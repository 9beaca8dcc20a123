//! `microtome below`.

use super::{Bench, stderr, stdout};
use microtome::mesh::{Adjacency, Mesh, audit, load, shapes};
use std::path::Path;

fn read(path: &Path) -> Mesh {
    load(path).unwrap().mesh
}

#[test]
fn a_part_so_far_is_written_and_closed_on_request() {
    let bench = Bench::new();
    bench.stl("ring.stl", &shapes::moved(shapes::torus(10.0, 3.0, 60, 30), [500.0, 70.0, 33.0]));
    let run = |more: &[&str]| {
        let args = ["below", "ring.stl", "--z", "2.5", "-o", "low.stl"];
        let done = bench.run(args.iter().chain(more));
        assert!(done.status.success(), "{more:?}: {}", stderr(&done));
        (read(&bench.path("low.stl")), done)
    };
    let (open, done) = run(&[]);
    assert!(stderr(&done).contains("2.500"), "{}", stderr(&done));
    assert!(audit(&open, &Adjacency::build(&open)).open_edges > 0);
    let bounds = open.world_bounds().unwrap();
    assert_eq!((bounds[0][2], bounds[1][2]), (0, 2_500_000), "from the bed to the plane");

    let (binary, done) = run(&["--cap", "--json"]);
    let summary: serde_json::Value = serde_json::from_str(&stdout(&done)).unwrap();
    assert_eq!(summary["triangles"].as_u64().unwrap(), binary.triangles.len() as u64);
    let found = audit(&binary, &Adjacency::build(&binary));
    assert_eq!(found.open_edges, 0, "also after rounding to the file's floats");
    let volume = summary["volume_mm3"].as_f64().unwrap();
    assert!((found.volume_mm3 / volume - 1.0).abs() < 1e-4);
    let section = 2.0 * std::f64::consts::PI * 10.0 * 2.0 * (9.0f64 - 0.25).sqrt();
    assert!((summary["section_mm2"].as_f64().unwrap() / section - 1.0).abs() < 0.01);

    let (ascii, _) = run(&["--cap", "--ascii"]);
    assert_eq!(ascii, binary);
    assert!(std::fs::read(bench.path("low.stl")).unwrap().starts_with(b"solid"));
    let piped = bench.run(["below", "ring.stl", "--z", "2.5", "-o", "-", "--cap", "--quiet"]);
    let (same, _) = run(&["--cap"]);
    assert_eq!(same, binary);
    assert_eq!(piped.stdout, std::fs::read(bench.path("low.stl")).unwrap());
    assert_eq!(bench.names(), ["low.stl", "ring.stl"]);
}

#[test]
fn heights_beyond_the_part() {
    let bench = Bench::new();
    bench.stl("box.stl", &shapes::cuboid([5.0, 5.0, -3.0], [15.0, 15.0, 4.0]));
    for (z, more, code) in [("0", "--cap", 3), ("-2", "--cap", 3), ("-2", "--no-place", 0), ("x", "--cap", 2)]
    {
        let done = bench.run(["below", "box.stl", "--z", z, more, "-o", "low.stl"]);
        assert_eq!(done.status.code(), Some(code), "{z} {more}: {}", stderr(&done));
        if code == 3 {
            assert!(stderr(&done).contains("nothing lies under"), "{}", stderr(&done));
            assert_eq!(bench.names(), ["box.stl"], "nothing is left behind");
        }
    }
    let done = bench.run(["below", "box.stl", "--z", "99", "--cap", "-o", "low.stl"]);
    assert!(done.status.success());
    assert_eq!(read(&bench.path("low.stl")).triangles, read(&bench.path("box.stl")).triangles);
    let done = bench.run(["below", "missing.stl", "--z", "1", "-o", "low.stl"]);
    assert_eq!(done.status.code(), Some(3));
    let done = bench.run(["below", "box.stl", "--z", "1", "-o", "no/such/low.stl"]);
    assert_eq!(done.status.code(), Some(6));
}
