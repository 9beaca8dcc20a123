//! What is too large, wrong or too slow is an error, and the device survives it.

use crate::compare::{ensure, same_segments};
use crate::kernels::FOLD;
use crate::meshes::planes;
use crate::{Bench, Test};
use libtest_mimic::Failed;
use microtome::gpu::dispatch::Recording;
use microtome::gpu::timing::CopyTimes;
use microtome::gpu::{Buffer, GpuError, Options};
use microtome::mesh::{Adjacency, shapes};
use microtome::shaders::SCAN_ADD;
use microtome::slice::gpu::GpuSlicer;
use microtome::slice::{chunk, cpu};
use std::sync::Arc;
use std::time::Duration;

pub const TESTS: &[Test] = &[
    ("what_exceeds_a_binding_is_refused", binding),
    ("what_exceeds_the_budget_is_refused", budget),
    ("a_wrong_binding_is_an_error_and_the_device_survives", validation),
    ("a_hung_kernel_is_a_timeout", watchdog),
    ("a_lost_device_is_an_error", lost),
    ("every_kernel_is_timed", times),
];

fn binding(bench: &Bench) -> Result<(), Failed> {
    let options = Options { largest_binding: 16_384, ..Options::default() };
    let mut slicer = GpuSlicer::new(bench.open(options)?)?;
    // 4 bytes each, and one entry more: 4,095 triangles fit.
    let mesh = shapes::fan(4_100);
    let refused = slicer.upload(&mesh, &Adjacency::build(&mesh));
    let message = refused.err().map(|e| e.to_string()).unwrap_or_default();
    ensure(
        message
            .contains(&format!("{} bytes, but the device takes at most 16384", 4 * mesh.triangles.len() + 4)),
        message,
    )?;
    // One triangle with more segments than a binding holds.
    let mesh = shapes::cuboid([0.0; 3], [10.0, 10.0, 3.0]);
    let resident = slicer.upload(&mesh, &Adjacency::build(&mesh))?;
    let heights: Vec<i32> = (0..2_049).collect();
    let refused = slicer.slice(&resident, &heights);
    ensure(
        matches!(refused, Err(GpuError::TooLarge { needs: 2_049, limit: 2_048, .. })),
        format!("{refused:?}"),
    )?;
    slicer.slice(&resident, &heights[1..]).map(drop)?;
    Ok(())
}

fn budget(bench: &Bench) -> Result<(), Failed> {
    let mesh = shapes::fan(1_200);
    let (links, heights) = (Adjacency::build(&mesh), planes(&mesh, 20));
    let per_plane = chunk::segments_per_plane(&mesh, &heights);
    let total = per_plane.iter().sum::<u64>();
    let mut slicer = GpuSlicer::new(bench.plain()?)?.with_budget(400_000);
    let resident = slicer.upload(&mesh, &links)?;
    let limit = slicer.max_segments_beside(&resident)?;
    ensure(limit < total && limit < slicer.max_segments(), format!("{limit} of {total} segments"))?;
    let refused = slicer.slice(&resident, &heights);
    ensure(
        matches!(refused, Err(GpuError::TooLarge { needs, limit: l, .. }) if (needs, l) == (total, limit)),
        format!("{total} segments should be refused"),
    )?;
    let runs = chunk::runs(&per_plane, limit);
    ensure(runs.len() > 2, format!("{runs:?}"))?;
    let mut met = Vec::new();
    slicer.slice_runs(&resident, &heights, &runs, |run, segments| {
        met.push(run.clone());
        same_segments("run", &segments, &cpu::slice(&mesh, &links, &heights[run]))
    })?;
    ensure(met == runs, "runs come in order")?;
    let mut slicer = slicer.with_budget(50_000);
    let refused = slicer.slice(&resident, &heights);
    ensure(matches!(refused, Err(GpuError::Budget { budget: 50_000, .. })), format!("{refused:?}"))
}

fn validation(bench: &Bench) -> Result<(), Failed> {
    let device = bench.open(Options::default())?;
    let array = Buffer::<u32>::zeroed(&device, "array", 10)?;
    let mut recording = Recording::new(&device, false)?;
    // One array where the kernel has two.
    let wrong = recording.dispatch(&SCAN_ADD, &[1u32, 0, 0, 0], &[&array], 1);
    ensure(matches!(wrong, Err(GpuError::Validation(_))), format!("{wrong:?}"))?;
    let mesh = shapes::fan(60);
    let heights = planes(&mesh, 9);
    let links = Adjacency::build(&mesh);
    let mut slicer = GpuSlicer::new(device)?;
    let resident = slicer.upload(&mesh, &links)?;
    same_segments(
        "after the error",
        &slicer.slice(&resident, &heights)?,
        &cpu::slice(&mesh, &links, &heights),
    )
}

fn watchdog(bench: &Bench) -> Result<(), Failed> {
    let options = Options { watchdog: Duration::from_nanos(1), ..Options::default() };
    let device = bench.open(options)?;
    let items = Buffer::<u32>::zeroed(&device, "items", 1 << 22)?;
    let mut recording = Recording::new(&device, false)?;
    // More than any device does between the submission and the next call.
    for _ in 0..40 {
        recording.dispatch(&FOLD, &[1u32 << 22, 0, 0, 0], &[&items], 1 << 22)?;
    }
    let result = recording.read_back(&items)?;
    let hung = result.take(&device, &recording.submit()?);
    ensure(matches!(hung, Err(GpuError::Timeout { .. })), format!("{:?}", hung.map(|items| items.len())))
}

fn lost(bench: &Bench) -> Result<(), Failed> {
    let device = bench.open(Options::default())?;
    let mut slicer = GpuSlicer::new(Arc::clone(&device))?;
    let mesh = shapes::fan(60);
    let links = Adjacency::build(&mesh);
    let resident = slicer.upload(&mesh, &links)?;
    slicer.slice(&resident, &[0, 5])?;
    device.lose();
    for _ in 0..2 {
        let lost = slicer.slice(&resident, &[0, 5]);
        ensure(matches!(lost, Err(GpuError::Lost(_))), format!("{lost:?}"))?;
    }
    let lost = slicer.upload(&mesh, &links).map(drop);
    ensure(matches!(lost, Err(GpuError::Lost(_))), format!("{lost:?}"))?;
    let lost = GpuSlicer::new(device).map(drop);
    ensure(matches!(lost, Err(GpuError::Lost(_))), format!("{lost:?}"))
}

fn times(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?.with_timing();
    let mesh = shapes::torus(30.0, 11.0, 60, 60);
    let resident = slicer.upload(&mesh, &Adjacency::build(&mesh))?;
    slicer.slice(&resident, &planes(&mesh, 20))?;
    let kernels: Vec<_> = slicer.take_times().into_iter().map(|time| time.kernel).collect();
    // 7,201 sums are four blocks: a scan of two levels.
    let all = ["slice_count", "scan_block", "scan_block", "scan_add", "slice_emit"];
    let expected = if slicer.device().info().timestamps { &all[..] } else { &[] };
    ensure(kernels == expected, format!("{kernels:?}"))?;
    ensure(slicer.take_times().is_empty(), "times are handed over once")?;
    let copies = slicer.take_copy_times();
    ensure(copies.uploaded > resident.bytes() && copies.fetched > 0, format!("{copies:?}"))?;
    ensure(slicer.take_copy_times() == CopyTimes::default(), "and so are copies")
}
