//! Outlines of real layers on the rows that infill lies on: the device's spans are the CPU's.

use crate::compare::{ensure, same};
use crate::{Bench, Test};
use libtest_mimic::Failed;
use microtome::contour::{ExPolygon, TraceOptions, trace};
use microtome::gpu::GpuError;
use microtome::lattice::Point2;
use microtome::mesh::{Adjacency, Mesh, demo_part, shapes};
use microtome::region::areas::areas;
use microtome::settings::Settings;
use microtome::slice::planes;
use microtome::span::gpu::GpuSpans;
use microtome::span::{self, RowFrame, Rows, rings};
use std::sync::Arc;

pub const TESTS: &[Test] = &[
    ("outlines_on_infill_rows_equal_the_scan", outlines),
    ("outlines_in_many_runs_equal_the_scan", runs),
    ("a_planted_fault_in_outlines_is_seen", planted),
];

/// The areas of every layer, as infill gets them.
fn layers(mesh: &Mesh) -> Result<Vec<Vec<ExPolygon>>, Failed> {
    let settings = Settings::default();
    let heights = planes::plane_zs(&planes::of_mesh(mesh, &settings)?, mesh.origin[2]);
    let options = TraceOptions { simplify_tolerance: Some(5_000), ..TraceOptions::new(&settings.slicing) };
    let traced = trace(mesh, &Adjacency::build(mesh), &heights, &options)?;
    Ok(traced.iter().map(|l| areas(&l.rings)).collect())
}

fn flat(layers: &[Vec<ExPolygon>]) -> Vec<Vec<&[Point2]>> {
    layers.iter().map(|l| l.iter().flat_map(ExPolygon::rings).map(|r| &r[..]).collect()).collect()
}

fn check(spans: &mut GpuSpans, planes: &[Vec<&[Point2]>], frame: &RowFrame) -> Result<usize, Failed> {
    let window = rings::window(planes, frame)?;
    let (mut next, mut runs) = (0, 0);
    spans.scan_rings(planes, frame, &window, |run, rows| -> Result<(), Failed> {
        ensure(run.start == next && run.len() == rows.len(), format!("run {run:?}"))?;
        (next, runs) = (run.end, runs + 1);
        for (k, rows) in run.zip(rows) {
            let rows = rows.unwrap_or_default();
            equal(&format!("{frame:?}, layer {k}"), &rows, &span::scan(planes[k].iter().copied(), frame))?;
        }
        Ok(())
    })?;
    ensure(next == planes.len(), format!("{next} layers"))?;
    Ok(runs)
}

fn equal(what: &str, device: &Rows, expected: &Rows) -> Result<(), Failed> {
    for k in device.first().min(expected.first())..device.end().max(expected.end()) {
        same(&format!("{what}: row {k}"), device.row(k), expected.row(k))?;
    }
    Ok(())
}

/// The angles of rectilinear, of its turned layers, of triangles and stars, and one that is none of these.
const ANGLES: [f64; 8] = [0.0, 45.0, 90.0, 135.0, 60.0, 105.0, 165.0, 22.5];

fn outlines(bench: &Bench) -> Result<(), Failed> {
    let mut spans = GpuSpans::new(bench.plain()?)?;
    for mesh in [demo_part(), shapes::upright(&shapes::knot(20.0, 4.0, 20_000)), shapes::sphere(9.0, 80, 60)]
    {
        let layers = layers(&mesh)?;
        let planes = flat(&layers);
        for degrees in ANGLES {
            // Solid lines and sparse ones at a fifth.
            for pitch in [407_080.0, 2_035_398.0] {
                check(&mut spans, &planes, &RowFrame::new(degrees, 0.0, pitch))?;
            }
        }
    }
    Ok(())
}

fn runs(bench: &Bench) -> Result<(), Failed> {
    let mut spans = GpuSpans::new(bench.plain()?)?.with_budget(1 << 18);
    let layers = layers(&shapes::sphere(9.0, 80, 60))?;
    let runs = check(&mut spans, &flat(&layers), &RowFrame::new(30.0, 0.0, 407_080.0))?;
    ensure(runs > 2, format!("{runs} runs"))
}

fn planted(bench: &Bench) -> Result<(), Failed> {
    let device: Arc<_> = bench.plain()?;
    let mut spans = GpuSpans::new(device)?;
    let layers = layers(&shapes::sphere(5.0, 40, 30))?;
    let mut moved = layers.clone();
    moved[9][0].contour[3].x += 40;
    for degrees in [45.0, 30.0] {
        let frame = RowFrame::new(degrees, 0.0, 20_000.0);
        let (planes, wrong) = (flat(&layers), flat(&moved));
        let window = rings::window(&planes, &frame)?;
        let mut found = Vec::new();
        spans.scan_rings(&wrong, &frame, &window, |_, rows| -> Result<(), GpuError> {
            found.extend(rows.into_iter().map(Option::unwrap_or_default));
            Ok(())
        })?;
        let seen = |k: usize| equal("", &found[k], &span::scan(planes[k].iter().copied(), &frame)).is_err();
        ensure(seen(9) && !seen(8), format!("{degrees} degrees: the comparison is blind"))?;
    }
    Ok(())
}
