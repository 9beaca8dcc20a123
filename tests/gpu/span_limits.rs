//! Spans on real panels, and what is too large for a binding, a dispatch or the budget.

use crate::compare::ensure;
use crate::meshes::planes;
use crate::span::{check, sub_rows, window};
use crate::{Bench, Test};
use libtest_mimic::Failed;
use microtome::gpu::{Fault, FaultKind, GpuError, Options};
use microtome::mesh::{Adjacency, shapes};
use microtome::slice::gpu::GpuSlicer;
use microtome::slice::{chunk, cpu};
use microtome::span::gpu::GpuSpans;
use microtome::span::{RowWindow, twin};
use std::sync::Arc;

pub const TESTS: &[Test] = &[
    ("spans_of_a_7680_x_4320_panel", panel_8k),
    ("spans_of_a_15120_x_6230_panel_exceed_a_binding", panel_16k),
    ("span_runs_are_cut_where_a_dispatch_cannot_hold_them", narrow),
    ("span_runs_are_cut_by_the_budget", budget),
    ("a_plane_whose_spans_are_too_large_is_refused", single),
    ("spans_on_far_diagonals_are_refused", diagonals),
    ("a_fault_in_any_run_of_spans_is_an_error", faults),
    ("every_span_kernel_is_timed", times),
];

fn panel_8k(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let mesh = shapes::torus(30.0, 11.0, 80, 40);
    // Layer middles of 2 mm, for there are to be few.
    let heights: Vec<i32> = (0..11).map(|k| -10_000_000 + 2_000_000 * k).collect();
    for n in [1, 4] {
        // 28.5 µm; the part lies in the middle of the panel.
        let base = -4_320 / 2 * 28_500;
        let window = RowWindow::new([1, 0], 0, base, 28_500, &sub_rows(n, 28_500), 4_320)?;
        check(&device, &mut spans, ("torus", &mesh), &heights, (0.0, &window))?;
    }
    Ok(())
}

fn panel_16k(bench: &Bench) -> Result<(), Failed> {
    // 19 µm between rows, 16 rows to a line: 99,680 rows a plane, up to four crossings on each.
    let mesh = shapes::torus(50.0, 8.0, 60, 16);
    let heights: Vec<i32> = (0..7).map(|k| -6_000_000 + 2_000_000 * k).collect();
    let base = -6_230 / 2 * 19_000;
    let window = RowWindow::new([1, 0], 0, base, 19_000, &sub_rows(16, 19_000), 6_230)?;
    // Room for the rows of seven planes and the crossings of two.
    let options = Options { largest_binding: 3 << 20, ..Options::default() };
    let device = bench.open(options)?;
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let runs = check(&device, &mut spans, ("ring", &mesh), &heights, (0.0, &window))?;
    ensure((3..7).contains(&runs), format!("{runs} runs"))
}

fn narrow(bench: &Bench) -> Result<(), Failed> {
    // Nine workgroups a dispatch.
    let device = bench.narrow()?;
    let mesh = shapes::torus(30.0, 11.0, 24, 12);
    let heights = planes(&mesh, 30);
    let window = window(&mesh, [1, 0], 300_000, 1)?;
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let runs = check(&device, &mut spans, ("torus", &mesh), &heights, (0.0, &window))?;
    ensure(runs > 3, format!("{runs} runs"))
}

fn budget(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mesh = shapes::torus(30.0, 11.0, 40, 40);
    let (heights, window) = (planes(&mesh, 30), window(&mesh, [1, 0], 100_000, 4)?);
    let mut seen = Vec::new();
    for bytes in [2_000_000, 4_000_000, 1 << 29] {
        let mut spans = GpuSpans::new(Arc::clone(&device))?.with_budget(bytes);
        seen.push(check(&device, &mut spans, ("torus", &mesh), &heights, (0.0, &window))?);
    }
    ensure(seen[0] > seen[1] && seen[1] > seen[2] && seen[2] == 1, format!("{seen:?} runs"))?;
    let links = Adjacency::build(&mesh);
    let resident = GpuSlicer::new(Arc::clone(&device))?.upload(&mesh, &links)?;
    let per_plane = chunk::segments_per_plane(&mesh, &heights);
    for bytes in [1_000, 300_000] {
        let mut spans = GpuSpans::new(Arc::clone(&device))?.with_budget(bytes);
        let refused = spans.scan(&resident, &heights, &per_plane, &window, |_, _| Ok::<(), GpuError>(()));
        ensure(matches!(refused, Err(GpuError::Budget { .. })), format!("{refused:?}"))?;
    }
    // A wrong number of segments is no reason to believe what comes out.
    let mut wrong = per_plane;
    wrong[9] += 1;
    let mut spans = GpuSpans::new(device)?;
    let refused = spans.scan(&resident, &heights, &wrong, &window, |_, _| Ok::<(), GpuError>(()));
    ensure(matches!(refused, Err(GpuError::Validation(_))), format!("{refused:?}"))
}

fn single(bench: &Bench) -> Result<(), Failed> {
    let device = bench.open(Options { largest_binding: 16_384, ..Options::default() })?;
    let mesh = shapes::cuboid([0.0; 3], [10.0, 8.0, 3.0]);
    let links = Adjacency::build(&mesh);
    let resident = GpuSlicer::new(Arc::clone(&device))?.upload(&mesh, &links)?;
    // The first two miss the body; it has two crossings on each of 3,200 rows.
    let heights = [-9_000_000, -8_000_000, 0, 500_000];
    let per_plane = chunk::segments_per_plane(&mesh, &heights);
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let mut planes = 0;
    let mut scan = |window: &RowWindow, planes: &mut usize| {
        spans.scan(&resident, &heights, &per_plane, window, |run, rows| {
            *planes += run.len();
            assert!(rows.iter().all(|rows| rows.as_ref().is_some_and(|rows| rows.is_empty())));
            Ok::<(), GpuError>(())
        })
    };
    let window = RowWindow::new([1, 0], 0, -4_001_000, 2_500, &[0], 3_210)?;
    let refused = scan(&window, &mut planes);
    ensure(
        matches!(refused, Err(GpuError::TooLarge { unit: "crossings", needs: 6_400, limit: 4_096, .. })),
        format!("{refused:?}"),
    )?;
    ensure(planes == 2, format!("{planes} planes before"))?;
    let window = RowWindow::new([1, 0], 0, -4_001_000, 1_000, &[0], 8_010)?;
    let refused = scan(&window, &mut planes);
    ensure(
        matches!(refused, Err(GpuError::TooLarge { needs: 32_048, limit: 16_384, .. })),
        format!("{refused:?}"),
    )
}

fn diagonals(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    // x + y reaches 1.2 m.
    let mut mesh = shapes::cuboid([0.0; 3], [200.0, 200.0, 10.0]);
    mesh.vertices.iter_mut().for_each(|v| (v.x, v.y) = (v.x + 500_000_000, v.y + 500_000_000));
    let heights = [-50_000_000, 0];
    let resident = GpuSlicer::new(Arc::clone(&device))?.upload(&mesh, &Adjacency::build(&mesh))?;
    let per_plane = chunk::segments_per_plane(&mesh, &heights);
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let diagonal = RowWindow::new([1, 1], 0, -300_000_000, 100_000, &[0], 6_000)?;
    let mut planes = 0;
    let refused = spans.scan(&resident, &heights, &per_plane, &diagonal, |run, _| {
        planes += run.len();
        Ok::<(), GpuError>(())
    });
    ensure(matches!(refused, Err(GpuError::TooLarge { limit: 0x3fff_ffff, .. })), format!("{refused:?}"))?;
    ensure(planes == 1, format!("{planes} planes before"))?;
    let axis = RowWindow::new([0, 1], 0, -700_000_000, 100_000, &[0], 4_000)?;
    check(&device, &mut spans, ("far box", &mesh), &heights, (90.0, &axis)).map(drop)
}

/// A run is two submissions, one that counts and one that makes spans. What was handed over before the
/// fault is right.
fn faults(bench: &Bench) -> Result<(), Failed> {
    let mesh = shapes::torus(30.0, 11.0, 24, 24);
    let (heights, window) = (planes(&mesh, 40), window(&mesh, [1, 0], 300_000, 2)?);
    let links = Adjacency::build(&mesh);
    let per_plane = chunk::segments_per_plane(&mesh, &heights);
    let segments = cpu::slice(&mesh, &links, &heights);
    let expected = twin::scan(&window, heights.len() as u32, &segments).unwrap_or_default();
    let mut before = Vec::new();
    for submission in [0, 1, 2, 5, u32::MAX] {
        for kind in [FaultKind::Timeout, FaultKind::Lost, FaultKind::OutOfMemory, FaultKind::Validation] {
            let fault = Some(Fault { submission, kind });
            let device = bench.open(Options { fault, ..Options::default() })?;
            let resident = GpuSlicer::new(Arc::clone(&device))?.upload(&mesh, &links)?;
            let mut spans = GpuSpans::new(device)?.with_budget(400_000);
            let mut all = Vec::new();
            let result = spans.scan(&resident, &heights, &per_plane, &window, |_, rows| {
                all.extend(rows);
                Ok::<(), GpuError>(())
            });
            let what = format!("{kind:?} in submission {submission}: {result:?}");
            let played = match (kind, result) {
                (FaultKind::Timeout, Err(GpuError::Timeout { .. }))
                | (FaultKind::Lost, Err(GpuError::Lost(_)))
                | (FaultKind::OutOfMemory, Err(GpuError::OutOfMemory(_)))
                | (FaultKind::Validation, Err(GpuError::Validation(_))) => true,
                (_, result) => submission == u32::MAX && result.is_ok(),
            };
            ensure(played, what.clone())?;
            ensure(expected.starts_with(&all), format!("{what}: other planes"))?;
            before.push(all.len());
        }
    }
    before.sort_unstable();
    before.dedup();
    ensure(before.len() > 2 && before.last() == Some(&heights.len()), format!("{before:?} planes before"))
}

fn times(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mesh = shapes::torus(30.0, 11.0, 24, 24);
    let (heights, window) = (planes(&mesh, 9), window(&mesh, [1, 0], 300_000, 4)?);
    let mut spans = GpuSpans::new(Arc::clone(&device))?.with_timing();
    check(&device, &mut spans, ("torus", &mesh), &heights, (0.0, &window))?;
    let kernels: Vec<_> = spans.take_times().into_iter().map(|time| time.kernel).collect();
    for name in ["slice_count", "slice_emit_even", "span_count", "span_fill", "span_sort", "span_compact"] {
        ensure(!spans.device().info().timestamps || kernels.contains(&name), format!("{name}: {kernels:?}"))?;
    }
    ensure(spans.take_times().is_empty(), "times are handed over once")
}
