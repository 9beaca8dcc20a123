//! Devices that stay open from job to job: the same bytes, and a new device after a failure.

use crate::compare::ensure;
use crate::{Bench, Test};
use libtest_mimic::Failed;
use microtome::gpu::{Fault, FaultKind, GpuError};
use microtome::job::JobError;
use microtome::job::backend::{Backend, BackendOptions};
use microtome::job::filament::{self, FilamentJob};
use microtome::job::part::MeshOptions;
use microtome::job::progress::Silent;
use microtome::job::resin::{self, PlateOptions, ResinJob};
use microtome::job::summary::{BackendSummary, Stopwatch};
use microtome::job::warm::FaultPlan;
use microtome::mesh::stl_write::write_stl_binary;
use microtome::mesh::{Loaded, Mesh, Placement, Transform, shapes};
use microtome::resin::Format;
use microtome::settings::{Settings, printers};
use std::path::Path;

pub const TESTS: &[Test] = &[
    ("many_jobs_on_one_warm_device_equal_the_cpu", many),
    ("masks_on_a_warm_device_equal_the_cpu", masks),
    ("after_a_loss_the_next_job_has_a_device_again", lost),
    ("a_device_that_fails_again_and_again_is_given_up", given_up),
    ("jobs_side_by_side_share_one_device", side_by_side),
];

/// A wish for the device under test.
fn wish(bench: &Bench, backend: Backend) -> BackendOptions {
    BackendOptions::new(backend, Some(bench.adapter.info.name.clone()), Some(4 << 20))
}

fn opened(wish: &BackendOptions) -> u32 {
    wish.warm.as_ref().map_or(0, |warm| warm.opened())
}

/// The G-code of a mesh, where it was sliced, and the warnings about that.
fn slice(mesh: &Mesh, backend: &BackendOptions) -> Result<(Vec<u8>, BackendSummary, Vec<String>), JobError> {
    let settings = Settings::default();
    let job = FilamentJob {
        mesh: MeshOptions::default(),
        settings: &settings,
        placement: Placement::DropAndCentre,
        backend: backend.clone(),
        stem: "body".to_owned(),
        date: 0,
        modifiers: Default::default(),
        copies: 1,
    };
    let facets = mesh.triangles.len() as u64;
    let loaded = Loaded { mesh: mesh.clone(), facets, collapsed: 0, warnings: Vec::new() };
    let planned = filament::plan_mesh(loaded, "body", &job, &Silent, Stopwatch::default())?;
    let mut text = Vec::new();
    let summary =
        filament::write(planned, &job, &mut text, &Silent).map_err(|e| e.at(Path::new("memory")))?;
    let warnings = summary.warnings.into_iter().filter(|w| w.contains("CPU took over")).collect();
    Ok((text, summary.backend, warnings))
}

fn on_cpu(mesh: &Mesh) -> Result<Vec<u8>, JobError> {
    Ok(slice(mesh, &BackendOptions::new(Backend::Cpu, None, None))?.0)
}

/// Bodies of all sizes, large ones before small ones, so that what is left in reused memory would show.
fn bodies() -> Vec<Mesh> {
    let ball = |k: u32| {
        let [around, rings] = [12 + 9 * (k % 4), 8 + 5 * (k % 3)].map(|n| n as usize);
        shapes::sphere(3.0 + f64::from(k % 5), around, rings)
    };
    let body = |k: u32| match k % 4 {
        0 => shapes::torus(9.0, 2.0 + 0.1 * f64::from(k), 40, 20),
        1 => shapes::cuboid([0.0; 3], [4.0 + f64::from(k), 6.0, 2.0]),
        _ => ball(k),
    };
    (0..20).map(body).collect()
}

fn many(bench: &Bench) -> Result<(), Failed> {
    let warm = wish(bench, Backend::Gpu).kept_warm();
    let clone = warm.clone();
    ensure(warm == clone && warm != wish(bench, Backend::Gpu).kept_warm(), "pools are told apart")?;
    let mut different = 0;
    let mut last = Vec::new();
    for (number, body) in bodies().iter().enumerate() {
        let (text, backend, warnings) = slice(body, if number % 2 == 0 { &warm } else { &clone })?;
        ensure(text == on_cpu(body)?, format!("body {number}: other G-code"))?;
        ensure(backend.kind == "gpu" && warnings.is_empty(), format!("{backend:?} {warnings:?}"))?;
        different += u32::from(text != last);
        last = text;
    }
    ensure(different == 20, "the bodies are alike, the comparison is blind")?;
    ensure(opened(&warm) == 1, format!("{} devices were opened", opened(&warm)))
}

fn masks(bench: &Bench) -> Result<(), Failed> {
    let dir = tempfile::tempdir()?;
    let settings = printers::find("elegoo-mars")?.settings()?;
    let run = |mesh: &Mesh, backend: &BackendOptions| -> Result<(Vec<u8>, &str, f64), Failed> {
        let (model, output) = (dir.path().join("body.stl"), dir.path().join("body.ctb"));
        let mut bytes = Vec::new();
        write_stl_binary(mesh, &mut bytes)?;
        std::fs::write(&model, bytes)?;
        let job = ResinJob {
            settings: &settings,
            plate: PlateOptions {
                transform: Transform { scale: [1.0; 3], turn: 0.0 },
                placement: Placement::DropAndCentre,
                spacing: 3_000_000,
                mesh: MeshOptions::default(),
            },
            backend: backend.clone(),
            layers: Some(0..30),
            name: "body".to_owned(),
            date: 0,
            check: None,
            check_report: None,
            check_pictures: None,
            picture: None,
        };
        let models = [model];
        let summary = resin::run(&models, &job, Format::Ctb, &output, &Silent)?;
        let estimate = resin::estimate(&models, &job, Format::Ctb, &Silent)?;
        ensure(estimate.volume_ml == summary.volume_ml && estimate.bytes == 0, "another volume")?;
        Ok((std::fs::read(output)?, summary.backend.kind, summary.volume_ml))
    };
    let warm = wish(bench, Backend::Gpu).kept_warm();
    for (number, body) in bodies().iter().enumerate().step_by(3) {
        let (bytes, kind, volume) = run(body, &warm)?;
        ensure(kind == "gpu" && volume > 0.0, format!("body {number} on {kind}"))?;
        let plain = run(body, &BackendOptions::new(Backend::Cpu, None, None))?;
        ensure(bytes == plain.0, format!("body {number}: other masks"))?;
        // Filament jobs use the same device.
        slice(body, &warm)?;
    }
    ensure(opened(&warm) == 1, format!("{} devices were opened", opened(&warm)))
}

fn lost(bench: &Bench) -> Result<(), Failed> {
    let body = shapes::sphere(8.0, 30, 20);
    let expected = on_cpu(&body)?;
    for kind in [FaultKind::Lost, FaultKind::Timeout, FaultKind::OutOfMemory, FaultKind::Validation] {
        // Jobs take two submissions or more: the second job fails on its way.
        for submission in [0, 3] {
            let what = format!("{kind:?} in submission {submission}");
            let plan = FaultPlan { fault: Fault { submission, kind }, devices: 1 };
            let auto = wish(bench, Backend::Auto).with_faults(plan);
            let mut warned = 0;
            for job in 0..4 {
                let (text, backend, warnings) = slice(&body, &auto)?;
                ensure(text == expected, format!("{what}: job {job} gives other G-code"))?;
                warned += warnings.len();
                ensure(backend.kind == "gpu" || !warnings.is_empty(), format!("{what}: {backend:?}"))?;
            }
            ensure(warned == 1 && opened(&auto) == 2, format!("{what}: {warned} warnings, {auto:?}"))?;

            let demanded = wish(bench, Backend::Gpu).with_faults(plan);
            let results: Vec<_> = (0..4).map(|_| slice(&body, &demanded)).collect();
            let failed: Vec<_> = results.iter().filter_map(|r| r.as_ref().err()).collect();
            let played = |e: &JobError| match (kind, e) {
                (FaultKind::Lost, JobError::Device(e)) => matches!(e, GpuError::Lost(_)),
                (FaultKind::Timeout, JobError::Device(e)) => matches!(e, GpuError::Timeout { .. }),
                (FaultKind::OutOfMemory, JobError::Device(e)) => matches!(e, GpuError::OutOfMemory(_)),
                (FaultKind::Validation, JobError::Device(e)) => matches!(e, GpuError::Validation(_)),
                _ => false,
            };
            ensure(failed.len() == 1 && played(failed[0]), format!("{what}: {failed:?}"))?;
            ensure(results[3].as_ref().is_ok_and(|r| r.0 == expected), format!("{what}: the last job"))?;
        }
    }
    Ok(())
}

fn given_up(bench: &Bench) -> Result<(), Failed> {
    let body = shapes::sphere(8.0, 30, 20);
    let expected = on_cpu(&body)?;
    let plan = FaultPlan { fault: Fault { submission: 1, kind: FaultKind::Lost }, devices: 9 };
    let auto = wish(bench, Backend::Auto).with_faults(plan);
    for job in 0..6 {
        let (text, _, warnings) = slice(&body, &auto)?;
        ensure(text == expected, format!("job {job}: other G-code"))?;
        let said = warnings.first().map_or("", String::as_str);
        ensure(said.contains("is used no more") == (job >= 3), format!("job {job}: {warnings:?}"))?;
    }
    ensure(opened(&auto) == 3, format!("{auto:?}"))?;
    // Who demands a GPU goes on trying.
    let demanded = BackendOptions { backend: Backend::Gpu, ..auto.clone() };
    ensure(slice(&body, &demanded).is_err() && opened(&auto) == 4, format!("{auto:?}"))
}

fn side_by_side(bench: &Bench) -> Result<(), Failed> {
    let body = shapes::torus(9.0, 3.0, 60, 40);
    let expected = on_cpu(&body)?;
    for backend in [Backend::Gpu, Backend::Auto] {
        let warm = wish(bench, backend).kept_warm();
        let results: Vec<_> = std::thread::scope(|scope| {
            let job = || (0..3).map(|_| slice(&body, &warm)).collect::<Vec<_>>();
            let threads: Vec<_> = (0..4).map(|_| scope.spawn(job)).collect();
            threads.into_iter().flat_map(|t| t.join().unwrap_or_default()).collect()
        });
        ensure(results.len() == 12, "a job panicked")?;
        for result in results {
            let (text, used, warnings) = result?;
            ensure(text == expected && warnings.is_empty(), format!("{used:?} {warnings:?}"))?;
            ensure(used.kind == "gpu" || backend == Backend::Auto, "waits for the device")?;
        }
        ensure(opened(&warm) == 1, format!("{warm:?}"))?;
    }
    Ok(())
}
