//! One input and one settings file give one output, whatever machine, thread count or backend.

use super::{Bench, stderr};
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
    let there = bench.stl("there.stl", &shapes::cuboid([100.0, -50.0, 7.0], [20.0, 10.0, 5.0]));
    assert!(bench.slice(&here, &[]) == bench.slice(&there, &[]));
}

/// The name of a Vulkan device of any kind, or `None`.
fn any_adapter() -> Option<String> {
    #[cfg(feature = "gpu")]
    return microtome::gpu::adapters().into_iter().next().map(|a| a.name);
    #[cfg(not(feature = "gpu"))]
    None
}

#[test]
fn the_gpu_writes_the_same_file() {
    let Some(adapter) = any_adapter() else {
        assert!(
            std::env::var_os("MICROTOME_REQUIRE_GPU").is_none(),
            "MICROTOME_REQUIRE_GPU is set and there is no GPU"
        );
        eprintln!("no GPU here: not compared");
        return;
    };
    let bench = Bench::new();
    for (name, mesh) in [("demo.stl", demo_part()), ("ball.stl", shapes::sphere(15.0, 60, 40))] {
        let model = bench.stl(name, &mesh);
        let cpu = bench.slice(&model, &["--backend", "cpu"]);
        let gpu = bench.slice(&model, &["--backend", "gpu", "--adapter", &adapter]);
        assert!(cpu == gpu, "{name} on {adapter}");
    }
    let done =
        bench.run(["slice", "demo.stl", "--backend", "gpu", "--adapter", "no such device", "-o", "x.gcode"]);
    assert_eq!(done.status.code(), Some(5), "{}", stderr(&done));
    assert!(!bench.path("x.gcode").exists());
}
