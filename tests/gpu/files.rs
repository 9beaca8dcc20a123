//! Whole files from the program: the GPU's are the CPU's.

use crate::compare::ensure;
use crate::{Bench, Test};
use libtest_mimic::Failed;
use microtome::mesh::{Mesh, demo_part, shapes, stl_write::write_stl_binary};
use std::path::Path;
use std::process::{Command, Output};

pub const TESTS: &[Test] = &[
    ("gcode_files_equal_the_cpu's", files),
    ("gcode_files_with_supports_equal_the_cpu's", supports),
    ("mask_files_equal_the_cpu's", masks),
    ("mask_files_survive_a_failing_device", failing),
    ("a_missing_gpu_is_exit_code_5_without_a_file", missing),
    ("a_batch_survives_a_lost_device", batch),
];

/// The outputs of a batch of a few models, by name, and what its journal says.
fn outputs(folder: &Path, out: &str, more: &[&str]) -> Result<(Vec<Vec<u8>>, String), Failed> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microtome"));
    command.args(["batch", "in", "--threads", "1", "-o", out]).args(more).current_dir(folder);
    let done = command.env_remove("SOURCE_DATE_EPOCH").output()?;
    ensure(done.status.success(), String::from_utf8_lossy(&done.stderr).into_owned())?;
    let out = folder.join(out);
    let files = (0..6).map(|i| std::fs::read(out.join(format!("{i}.gcode")))).collect::<Result<_, _>>()?;
    Ok((files, std::fs::read_to_string(out.join(".microtome/journal-1-of-1.jsonl"))?))
}

/// A device is lost in the middle of a batch: by itself the worker goes on with the CPU and then a new device;
/// where a GPU is demanded the job is tried again.
fn batch(bench: &Bench) -> Result<(), Failed> {
    let adapter = bench.adapter.info.name.as_str();
    let dir = tempfile::tempdir()?;
    std::fs::create_dir(dir.path().join("in"))?;
    for i in 0..6 {
        let mut stl = Vec::new();
        write_stl_binary(&shapes::sphere(5.0 + f64::from(i), 60, 40), &mut stl)?;
        std::fs::write(dir.path().join(format!("in/{i}.stl")), stl)?;
    }
    let (cpu, _) = outputs(dir.path(), "cpu", &["--backend", "cpu"])?;
    let lost = |backend| ["--backend", backend, "--adapter", adapter, "--fault", "lost@5"];
    let (auto, journal) = outputs(dir.path(), "auto", &lost("auto"))?;
    ensure(cpu == auto, "auto: the files differ".to_owned())?;
    ensure(journal.matches("the CPU took over").count() == 1, format!("auto: {journal}"))?;
    ensure(journal.matches("\"backend\":\"gpu\"").count() >= 5, format!("auto: {journal}"))?;
    let (gpu, journal) = outputs(dir.path(), "gpu", &lost("gpu"))?;
    ensure(cpu == gpu, "gpu: the files differ".to_owned())?;
    ensure(journal.matches("\"attempts\":2").count() == 1, format!("gpu: {journal}"))?;
    ensure(journal.matches("\"backend\":\"gpu\"").count() == 6, format!("gpu: {journal}"))
}

fn run(folder: &Path, more: &[&str]) -> Result<Output, Failed> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microtome"));
    command.args(["slice", "model.stl"]).args(more).current_dir(folder);
    Ok(command.env_remove("SOURCE_DATE_EPOCH").output()?)
}

fn gcode(folder: &Path, more: &[&str]) -> Result<Vec<u8>, Failed> {
    let more: Vec<&str> = more.iter().copied().chain(["-o", "out.gcode", "--resolution", "0.005"]).collect();
    let done = run(folder, &more)?;
    ensure(done.status.success(), String::from_utf8_lossy(&done.stderr).into_owned())?;
    Ok(std::fs::read(folder.join("out.gcode"))?)
}

fn files(bench: &Bench) -> Result<(), Failed> {
    let adapter = bench.adapter.info.name.as_str();
    let mut open = shapes::sphere(12.0, 40, 30);
    open.triangles.remove(700);
    let bodies: [(&str, Mesh); 4] = [
        ("the demo part", demo_part()),
        ("a ball", shapes::sphere(15.0, 120, 80)),
        ("a ball with a hole", open),
        ("a knot", shapes::upright(&shapes::knot(30.0, 6.0, 20_000))),
    ];
    for (name, mesh) in bodies {
        let dir = tempfile::tempdir()?;
        let mut stl = Vec::new();
        write_stl_binary(&mesh, &mut stl)?;
        std::fs::write(dir.path().join("model.stl"), stl)?;
        let cpu = gcode(dir.path(), &["--backend", "cpu"])?;
        let gpu = gcode(dir.path(), &["--backend", "gpu", "--adapter", adapter, "--threads", "1"])?;
        ensure(cpu.len() > 10_000, format!("{name}: {} bytes", cpu.len()))?;
        ensure(cpu == gpu, format!("{name}: the files differ"))?;
        let planted = gcode(dir.path(), &["--backend", "cpu", "--layer-height", "0.31"])?;
        ensure(cpu != planted, format!("{name}: the comparison is blind"))?;
    }
    Ok(())
}

/// Supports rest on what slicing found, on whichever device.
fn supports(bench: &Bench) -> Result<(), Failed> {
    let adapter = bench.adapter.info.name.as_str();
    let bodies = [("the demo part", demo_part()), ("a ball", shapes::sphere(8.0, 80, 60))];
    for (name, mesh) in bodies {
        let dir = tempfile::tempdir()?;
        let mut stl = Vec::new();
        write_stl_binary(&mesh, &mut stl)?;
        std::fs::write(dir.path().join("model.stl"), stl)?;
        let on = ["--set", "support_material=1", "--set", "support_material_threshold=45"];
        let file = |with: &[&str]| gcode(dir.path(), &[&on, with].concat());
        let cpu = file(&["--backend", "cpu"])?;
        let gpu = file(&["--backend", "gpu", "--adapter", adapter, "--threads", "1"])?;
        ensure(cpu == gpu, format!("{name}: the files differ"))?;
        let planted = file(&["--backend", "cpu", "--set", "support_material_threshold=20"])?;
        ensure(cpu != planted, format!("{name}: the comparison is blind"))?;
    }
    Ok(())
}

/// Masks on a panel, as a file of some format.
fn mask(folder: &Path, output: &str, more: &[&str]) -> Result<Vec<u8>, Failed> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_microtome"));
    command.args(["mask", "model.stl", "-o", output]).args(more).current_dir(folder);
    let done = command.env_remove("SOURCE_DATE_EPOCH").output()?;
    ensure(done.status.success(), String::from_utf8_lossy(&done.stderr).into_owned())?;
    Ok(std::fs::read(folder.join(output))?)
}

fn masks(bench: &Bench) -> Result<(), Failed> {
    let adapter = bench.adapter.info.name.as_str();
    let gpu = ["--backend", "gpu", "--adapter", adapter, "--threads", "1"];
    let mut open = shapes::sphere(6.0, 40, 30);
    open.triangles.remove(700);
    let base = ["--layer-height", "0.3", "--initial-layer-height", "0.3"];
    // 8K with sub-rows, portrait, 12K with correction, and 16K.
    let cases: [(&str, &str, Mesh, &[&str]); 5] = [
        (
            "an 8K panel",
            "a.nanodlp",
            demo_part(),
            &["--printer", "concepts3d-athena-8k", "--anti-aliasing", "4"],
        ),
        ("a portrait panel", "a.sl1", demo_part(), &["--printer", "prusa-sl1s"]),
        (
            "corrected outlines",
            "a.goo",
            shapes::sphere(8.0, 60, 40),
            &["--printer", "elegoo-saturn-3-ultra", "--absolute-correction=-0.05"],
        ),
        (
            "a 16K panel",
            "a.goo",
            shapes::upright(&shapes::knot(12.0, 3.0, 20_000)),
            &["--printer", "elegoo-jupiter-2"],
        ),
        ("an open mesh", "a.zip", open, &["--printer", "elegoo-mars-5"]),
    ];
    for (name, output, mesh, more) in cases {
        let dir = tempfile::tempdir()?;
        let mut stl = Vec::new();
        write_stl_binary(&mesh, &mut stl)?;
        std::fs::write(dir.path().join("model.stl"), stl)?;
        let file = |with: &[&str]| mask(dir.path(), output, &[&base, more, with].concat());
        let cpu = file(&["--backend", "cpu"])?;
        ensure(cpu == file(&gpu)?, format!("{name}: the files differ"))?;
        let planted = file(&["--backend", "cpu", "--rotate", "1"])?;
        ensure(cpu != planted, format!("{name}: the comparison is blind"))?;
    }
    Ok(())
}

/// A device that fails on the way: the CPU goes on, with the same bytes.
fn failing(bench: &Bench) -> Result<(), Failed> {
    let adapter = bench.adapter.info.name.as_str();
    let dir = tempfile::tempdir()?;
    let mut stl = Vec::new();
    write_stl_binary(&shapes::sphere(8.0, 100, 80), &mut stl)?;
    std::fs::write(dir.path().join("model.stl"), stl)?;
    let panel = ["--printer", "elegoo-mars-4", "--layer-height", "0.1"];
    let cpu = mask(dir.path(), "a.goo", &[&panel[..], &["--backend", "cpu"]].concat())?;
    // One MiB holds neither the mesh nor a run.
    let starved = ["--backend", "auto", "--adapter", adapter, "--memory", "1M"];
    ensure(cpu == mask(dir.path(), "a.goo", &[&panel[..], &starved].concat())?, "the files differ")
}

fn missing(_: &Bench) -> Result<(), Failed> {
    let dir = tempfile::tempdir()?;
    let mut stl = Vec::new();
    write_stl_binary(&shapes::sphere(10.0, 20, 10), &mut stl)?;
    std::fs::write(dir.path().join("model.stl"), stl)?;
    let done = run(dir.path(), &["--backend", "gpu", "--adapter", "no such device", "-o", "out.gcode"])?;
    let text = String::from_utf8_lossy(&done.stderr).into_owned();
    ensure(done.status.code() == Some(5), format!("{done:?}"))?;
    ensure(text.contains("no such device") && text.contains("--backend cpu"), text)?;
    ensure(!dir.path().join("out.gcode").exists(), "a file was left")
}
