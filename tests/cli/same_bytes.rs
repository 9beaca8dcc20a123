//! One input and one settings file give one output, whatever machine, thread count or backend.

use super::Bench;
use microtome::mesh::{demo_part, shapes};

#[test]
fn threads_and_runs_do_not_change_a_byte() {
    let bench = Bench::new();
    let model = bench.stl("demo.stl", &demo_part());
    let first = bench.slice(&model, &["--backend", "cpu", "--threads", "1"]);
    assert!(first.len() > 100_000, "a real file of {} bytes", first.len());
    for threads in ["2", "3", "7"] {
        assert!(
            first == bench.slice(&model, &["--backend", "cpu", "--threads", threads]),
            "{threads} threads"
        );
    }
    let planted = bench.slice(&model, &["--backend", "cpu", "--set", "perimeters=2"]);
    assert!(first != planted, "the comparison sees a difference");
}

#[test]
fn a_part_moved_in_its_file_gives_the_same_paths() {
    let bench = Bench::new();
    let here = bench.stl("here.stl", &shapes::cuboid([0.0; 3], [20.0, 10.0, 5.0]));
    let there = bench.stl("there.stl", &shapes::cuboid([100.0, -50.0, 7.0], [120.0, -40.0, 12.0]));
    assert!(bench.slice(&here, &[]) == bench.slice(&there, &[]));
}
