//! A device that fails on the way: the CPU takes over, with the same bytes and one warning.

use crate::compare::ensure;
use crate::{Bench, Test};
use libtest_mimic::Failed;
use microtome::contour::{TraceOptions, trace};
use microtome::gpu::{Fault, FaultKind, GpuError};
use microtome::job::JobError;
use microtome::job::backend::{Backend, BackendOptions, contours};
use microtome::job::filament::{self, FilamentJob};
use microtome::job::progress::Silent;
use microtome::job::summary::{Stopwatch, Summary};
use microtome::mesh::{Adjacency, Loaded, Mesh, Placement, shapes};
use microtome::settings::Settings;

pub const TESTS: &[Test] = &[
    ("contours_survive_a_fault_in_any_run", any_run),
    ("gcode_survives_every_fault", gcode),
    ("a_small_budget_gives_the_same_contours", small_budget),
];

const KINDS: [FaultKind; 4] =
    [FaultKind::Timeout, FaultKind::Lost, FaultKind::OutOfMemory, FaultKind::Validation];

fn wish(bench: &Bench, backend: Backend, fault: Option<Fault>, memory: u64) -> BackendOptions {
    let adapter = Some(bench.adapter.info.name.clone());
    BackendOptions { fault, ..BackendOptions::new(backend, adapter, Some(memory)) }
}

/// Whether an error is the one that was played.
fn is(error: &JobError, kind: FaultKind) -> bool {
    let JobError::Device(error) = error else { return false };
    match kind {
        FaultKind::Timeout => matches!(error, GpuError::Timeout { .. }),
        FaultKind::Lost => matches!(error, GpuError::Lost(_)),
        FaultKind::OutOfMemory => matches!(error, GpuError::OutOfMemory(_)),
        FaultKind::Validation => matches!(error, GpuError::Validation(_)),
    }
}

fn body() -> (Mesh, Adjacency, Vec<i32>) {
    let mut mesh = shapes::sphere(15.0, 40, 30);
    mesh.triangles.remove(700);
    let links = Adjacency::build(&mesh);
    (mesh, links, (-74..75).map(|k| k * 200_000).collect())
}

fn options() -> TraceOptions {
    TraceOptions { simplify_tolerance: Some(5_000), match_tolerance: 100_000, memory_budget: 1 << 20 }
}

fn any_run(bench: &Bench) -> Result<(), Failed> {
    let (mesh, links, planes) = body();
    let expected = trace(&mesh, &links, &planes, &options())?;
    // Room for some thousand segments: every run is two submissions, one that counts and one that emits.
    let memory = 400_000;
    let mut starts = Vec::new();
    for submission in [0, 1, 2, 3, 4, 7] {
        for kind in KINDS {
            let fault = Some(Fault { submission, kind });
            let what = format!("{kind:?} in submission {submission}");
            let wish = wish(bench, Backend::Auto, fault, memory);
            let traced = contours(&mesh, &links, &planes, &wish, &options())?;
            ensure(traced.layers == expected, format!("{what}: other contours"))?;
            let warning = traced.warning.ok_or_else(|| format!("{what}: no warning"))?;
            ensure(warning.contains("the CPU took over"), warning.clone())?;
            starts.push(warning.split("from layer ").nth(1).unwrap_or("1").to_owned());
        }
    }
    starts.dedup();
    ensure(starts.len() > 2, format!("the CPU took over at {starts:?} only"))
}

fn small_budget(bench: &Bench) -> Result<(), Failed> {
    let (mesh, links, planes) = body();
    let expected = trace(&mesh, &links, &planes, &options())?;
    for (memory, survives) in [(1 << 30, true), (300_000, true), (60_000, false)] {
        let traced = contours(&mesh, &links, &planes, &wish(bench, Backend::Auto, None, memory), &options())?;
        ensure(traced.layers == expected, format!("{memory} bytes: other contours"))?;
        ensure(traced.warning.is_none() == survives, format!("{memory} bytes: {:?}", traced.warning))?;
        let demanded = contours(&mesh, &links, &planes, &wish(bench, Backend::Gpu, None, memory), &options());
        ensure(demanded.is_ok() == survives, format!("{memory} bytes"))?;
    }
    Ok(())
}

fn gcode(bench: &Bench) -> Result<(), Failed> {
    let settings = Settings::default();
    let write = |backend: BackendOptions| -> Result<(Vec<u8>, Summary), JobError> {
        let job = FilamentJob {
            mesh: microtome::job::part::MeshOptions::default(),
            settings: &settings,
            placement: Placement::DropAndCentre,
            backend,
            stem: "ball".to_owned(),
            date: 0,
            modifiers: Default::default(),
            copies: 1,
        };
        let mesh = shapes::sphere(12.0, 40, 30);
        let facets = mesh.triangles.len() as u64;
        let loaded = Loaded { mesh, facets, collapsed: 0, warnings: Vec::new() };
        let planned = filament::plan_mesh(loaded, "ball", &job, &Silent, Stopwatch::default())?;
        let mut text = Vec::new();
        let summary = filament::write(planned, &job, &mut text, &Silent)
            .map_err(|e| e.at(std::path::Path::new("memory")))?;
        Ok((text, summary))
    };
    let (expected, plain) = write(BackendOptions { backend: Backend::Cpu, ..BackendOptions::default() })?;
    for kind in KINDS {
        let fault = Some(Fault { submission: 3, kind });
        let (text, summary) = write(wish(bench, Backend::Auto, fault, 300_000))?;
        ensure(text == expected, format!("{kind:?}: other G-code"))?;
        ensure(summary.warnings.len() == plain.warnings.len() + 1, format!("{:?}", summary.warnings))?;
        let refused = write(wish(bench, Backend::Gpu, fault, 300_000)).err();
        ensure(refused.as_ref().is_some_and(|e| is(e, kind)), format!("{kind:?}: {refused:?}"))?;
    }
    let (other, _) = write(BackendOptions { backend: Backend::Cpu, ..BackendOptions::default() })?;
    ensure(other == expected && expected.len() > 10_000, "the comparison is blind")
}
