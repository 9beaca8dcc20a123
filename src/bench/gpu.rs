//! The slicing kernels on every GPU asked for.

use super::case::Case;
use super::cpu::Reference;
use super::machine::{Time, middle, once, pool};
use super::report::{Sink, Stage};
use super::{BenchError, Options, RAW};
use crate::contour::{self, LayerContours};
use crate::gpu::{Device, GpuError, Selection};
use crate::job::JobError;
use crate::slice::chunk;
use crate::slice::gpu::GpuSlicer;
use std::sync::Arc;

/// A device and how the report calls it.
pub(super) struct Engine {
    name: String,
    slicer: GpuSlicer,
}

/// Opens all devices asked for, before anything is measured.
pub(super) fn open(names: &[String]) -> Result<Vec<Engine>, BenchError> {
    let open = |name: &String| {
        let device = Device::open(&Selection::Named(name.clone()))?;
        let info = device.info();
        // On a software device the device's time is CPU time.
        let software = if info.software { " (software)" } else { "" };
        let name = format!("{}{software}", info.name.split(" (").next().unwrap_or_default());
        Ok(Engine { name, slicer: GpuSlicer::new(Arc::new(device))?.with_timing() })
    };
    names.iter().map(open).collect::<Result<_, GpuError>>().map_err(|e| JobError::from(e).into())
}

/// One run's times.
struct Run {
    upload: Time,
    kernels: f64,
    copies: f64,
    walk: Time,
}

/// Upload, kernels, copies and walk, each apart.
pub(super) fn measure(
    engine: &mut Engine,
    case: &Case,
    reference: &Reference,
    options: &Options,
    sink: &mut Sink<'_>,
) -> Result<(), BenchError> {
    let threads = options.threads.iter().copied().max().unwrap_or(1);
    let pool = pool(threads)?;
    let mut runs = Vec::new();
    let mut layers = Vec::new();
    for _ in 0..options.runs.max(1) {
        layers.clear();
        runs.push(pool.install(|| run(engine, case, &mut layers)).map_err(JobError::from)?);
    }
    let stage = |name| Stage::new(&engine.name, name, threads);
    let wall = |of: fn(&Run) -> f64| {
        middle(&runs.iter().map(|r| Time { wall: of(r), cpu: None }).collect::<Vec<_>>())
    };
    let upload = middle(&runs.iter().map(|r| r.upload).collect::<Vec<_>>());
    sink.row(stage("upload").bytes([24, 12, 0, 0], "24 T + 12 V"), upload, None);
    if engine.slicer.device().info().timestamps {
        sink.row(stage("kernels").bytes([88, 24, 0, 24], "88 T + 24 V + 24 S"), wall(|r| r.kernels), None);
        sink.row(stage("copies").bytes([8, 0, 0, 12], "8 T + 12 S"), wall(|r| r.copies), None);
    } else {
        // Without a clock on the device both are one figure.
        sink.row(stage("slice").bytes([96, 24, 0, 36], "96 T + 24 V + 36 S"), wall(|r| r.copies), None);
    }
    let walk = middle(&runs.iter().map(|r| r.walk).collect::<Vec<_>>());
    let verdict = reference.verdict(&layers);
    sink.row(stage("walk").bytes([16, 0, 0, 56], "16 T + 56 S"), walk, Some(verdict));
    Ok(())
}

fn run(engine: &mut Engine, case: &Case, layers: &mut Vec<LayerContours>) -> Result<Run, GpuError> {
    let slicer = &mut engine.slicer;
    let (upload, resident) = once(|| slicer.upload(&case.mesh, &case.adjacency));
    let resident = resident?;
    drop(slicer.take_times());
    let runs = chunk::runs(&case.per_plane, slicer.max_segments());
    let mut walk = Time { wall: 0.0, cpu: Some(0.0) };
    let (slice, done) = once(|| {
        slicer.slice_runs::<GpuError>(&resident, &case.planes, &runs, |run, segments| {
            let (time, contours) =
                once(|| contour::contours_of(&case.mesh, &case.planes[run], &segments, &RAW));
            walk.wall += time.wall;
            walk.cpu = walk.cpu.zip(time.cpu).map(|(sum, more)| sum + more);
            layers.extend(contours);
            Ok(())
        })
    });
    done?;
    let kernels: u64 = slicer.take_times().iter().map(|t| t.nanoseconds).sum();
    let kernels = kernels as f64 * 1e-9;
    // What is left of the wall time: transfers, encoding, driver.
    let copies = (slice.wall - walk.wall - kernels).max(0.0);
    Ok(Run { upload, kernels, copies, walk })
}
