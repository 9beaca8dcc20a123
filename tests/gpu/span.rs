//! Segments to spans: every kernel against its twin, and whole runs against the scan of contours.

use crate::compare::{ensure, same};
use crate::meshes::{Random, planes, soup};
use crate::slice::changed;
use crate::{Bench, SIZES, Test};
use libtest_mimic::Failed;
use microtome::contour::{TraceOptions, trace};
use microtome::gpu::dispatch::{Bind, Recording};
use microtome::gpu::{Buffer, Device, GpuError, Options};
use microtome::lattice::Point2;
use microtome::mesh::{Adjacency, Mesh, OPEN, shapes};
use microtome::shaders::{Kernel, SPAN_COMPACT, SPAN_COUNT, SPAN_FILL, SPAN_SORT, SpanSizes};
use microtome::slice::gpu::GpuSlicer;
use microtome::slice::{Segments, chunk, cpu};
use microtome::span::gpu::GpuSpans;
use microtome::span::twin::{self, Counted};
use microtome::span::{self, RowFrame, RowWindow, Rows};
use std::sync::Arc;

pub const TESTS: &[Test] = &[
    ("span_count_equals_its_twin", count_equals_twin),
    ("span_fill_equals_its_twin", fill_equals_twin),
    ("span_sort_and_compact_equal_their_twins", sort_equals_twin),
    ("spans_of_bodies_equal_the_scan_of_their_contours", bodies),
    ("spans_of_open_meshes_name_the_open_planes", open),
    ("spans_of_nothing_are_empty", nothing),
    ("spans_of_a_mesh_in_pieces_equal_the_whole", pieces),
    ("a_planted_fault_in_spans_is_seen", planted),
    ("a_drifted_span_kernel_is_seen", drifted),
];

/// Angle and direction of the rows that a device takes.
pub const AXES: [(f64, [i32; 2]); 4] = [(0.0, [1, 0]), (90.0, [0, 1]), (45.0, [1, 1]), (135.0, [-1, 1])];

/// Offsets of `n` sub-rows, at the middles of equal parts of the pitch; of one row none.
pub fn sub_rows(n: i64, pitch: i64) -> Vec<i64> {
    if n == 1 { vec![0] } else { (0..n).map(|j| ((2 * j + 1) * pitch + n) / (2 * n)).collect() }
}

/// Lines that cover a mesh.
pub fn window(mesh: &Mesh, axes: [i32; 2], pitch: i64, n: i64) -> Result<RowWindow, Failed> {
    let [a, b] = axes.map(i64::from);
    let t = || mesh.vertices.iter().map(|v| a * i64::from(v.y) - b * i64::from(v.x));
    let (low, high) = (t().min().unwrap_or(0), t().max().unwrap_or(0));
    let line = low.div_euclid(pitch) - 1;
    let lines = (high.div_euclid(pitch) + 2 - line) as u32;
    // A phase of its own, so that not all is a multiple of the pitch.
    let base = line * pitch + pitch / 3;
    Ok(RowWindow::new(axes, (line * n) as i32, base, pitch, &sub_rows(n, pitch), lines)?)
}

/// Where two areas part.
fn same_row(what: &str, device: &Rows, k: i32, expected: &[span::Span]) -> Result<(), Failed> {
    same(&format!("{what}: row {k}"), device.row(k), expected)
}

/// Holds the rows of a plane against the scan of its rings, one scan for each of the lines' rows.
pub fn same_as_scan(
    what: &str,
    rows: &Rows,
    rings: &[&[Point2]],
    (degrees, window): (f64, &RowWindow),
) -> Result<(), Failed> {
    let (sizes, first) = (window.sizes(), window.first());
    let scale = RowFrame::new(degrees, 0.0, 1e6).scale();
    let mut inside = 0;
    for sub in 0..sizes.sub_rows {
        let pitch = f64::from(sizes.pitch) / scale;
        let frame = RowFrame::new(degrees, f64::from(window.t(sub)) / scale, pitch);
        ensure(frame.pitch() == i64::from(sizes.pitch), "the frame has another pitch")?;
        let expected = span::scan(rings.iter().copied(), &frame);
        for line in 0..sizes.lines {
            let row = line * sizes.sub_rows + sub;
            let t = i64::from(window.t(row));
            let k = frame.row_below(t);
            ensure(frame.t(k) == t, "the frame's rows lie elsewhere")?;
            same_row(what, rows, first + row as i32, expected.row(k))?;
            inside += expected.row(k).len();
        }
    }
    ensure(rows.spans().len() == inside, format!("{what}: spans outside the window"))?;
    let ends = (rows.row(rows.first()), rows.row(rows.end() - 1));
    ensure(rows.is_empty() || !ends.0.is_empty() && !ends.1.is_empty(), format!("{what}: empty ends"))
}

/// All planes of a mesh on the device, in how many runs, and against the contours.
pub fn check(
    device: &Arc<Device>,
    spans: &mut GpuSpans,
    (what, mesh): (&str, &Mesh),
    heights: &[i32],
    (degrees, window): (f64, &RowWindow),
) -> Result<usize, Failed> {
    let links = Adjacency::build(mesh);
    let resident = GpuSlicer::new(Arc::clone(device))?.upload(mesh, &links)?;
    let per_plane = chunk::segments_per_plane(mesh, heights);
    let options = TraceOptions { simplify_tolerance: None, match_tolerance: 0, memory_budget: 1 << 28 };
    let layers = trace(mesh, &links, heights, &options)?;
    let (mut runs, mut next) = (0, 0);
    spans.scan(&resident, heights, &per_plane, window, |run, rows| -> Result<(), Failed> {
        ensure(run.start == next && run.len() == rows.len(), format!("{what}: run {run:?}"))?;
        (runs, next) = (runs + 1, run.end);
        for (k, rows) in run.zip(rows) {
            let what = format!("{what}, {degrees} degrees, plane {k}");
            let layer = &layers[k];
            ensure(rows.is_none() == (layer.walked.open > 0), format!("{what}: {:?}", layer.walked))?;
            if let Some(rows) = rows {
                let rings: Vec<&[Point2]> = layer.rings.iter().map(|r| &r[..]).collect();
                same_as_scan(&what, &rows, &rings, (degrees, window))?;
            }
        }
        Ok(())
    })?;
    ensure(next == heights.len(), format!("{what}: {next} planes"))?;
    Ok(runs)
}

fn sizes_of(window: &RowWindow, heights: &[i32], segments: &Segments) -> SpanSizes {
    SpanSizes {
        planes: heights.len() as u32,
        triangles: segments.first.len() as u32,
        segments: segments.start.len() as u32,
        ..window.sizes()
    }
}

fn run_count(
    device: &Device,
    kernel: &Kernel,
    sizes: &SpanSizes,
    segments: &Segments,
) -> Result<Counted, GpuError> {
    let start = Buffer::upload(device, "start", &segments.start)?;
    let next = Buffer::upload(device, "next", &segments.next)?;
    let first = Buffer::upload(device, "first", &segments.first)?;
    let offset = Buffer::upload(device, "offset", &segments.offset)?;
    let zeroed = |len| Buffer::<u32>::zeroed(device, "result", len);
    let (count, bucket) = (zeroed(segments.start.len())?, zeroed(segments.start.len())?);
    let steps = zeroed((sizes.planes * sizes.rows) as usize + 1)?;
    let totals = zeroed(4 + sizes.planes as usize)?;
    let mut recording = Recording::new(device, false)?;
    let arrays: [&dyn Bind; 8] = [&start, &next, &first, &offset, &count, &bucket, &steps, &totals];
    recording.dispatch(kernel, sizes, &arrays, sizes.segments.into())?;
    let [count, bucket] = [recording.read_back(&count)?, recording.read_back(&bucket)?];
    let [steps, totals] = [recording.read_back(&steps)?, recording.read_back(&totals)?];
    let submission = recording.submit()?;
    Ok(Counted {
        count: count.take(device, &submission)?,
        bucket: bucket.take(device, &submission)?,
        steps: steps.take(device, &submission)?,
        totals: totals.take(device, &submission)?,
    })
}

/// What the later kernels are given.
struct Scanned {
    counted: Counted,
    offset: Vec<u32>,
    row_count: Vec<u32>,
    row_offset: Vec<u32>,
}

fn scanned(sizes: &SpanSizes, segments: &Segments) -> (SpanSizes, Scanned) {
    let counted = twin::count(sizes, segments);
    let offset = cpu::scan(&counted.count);
    let row_count = cpu::scan(&counted.steps);
    let row_offset = cpu::scan(&row_count);
    (SpanSizes { crossings: counted.totals[0], ..*sizes }, Scanned { counted, offset, row_count, row_offset })
}

/// The kernel's keys, each bucket's sorted.
fn run_fill(
    device: &Device,
    kernel: &Kernel,
    sizes: &SpanSizes,
    segments: &Segments,
    scanned: &Scanned,
) -> Result<Vec<u32>, GpuError> {
    let start = Buffer::upload(device, "start", &segments.start)?;
    let next = Buffer::upload(device, "next", &segments.next)?;
    let offset = Buffer::upload(device, "offset", &scanned.offset)?;
    let bucket = Buffer::upload(device, "bucket", &scanned.counted.bucket)?;
    let row_offset = Buffer::upload(device, "row offset", &scanned.row_offset)?;
    let expected = Buffer::upload(device, "expected", &scanned.row_count)?;
    let keys = Buffer::<u32>::zeroed(device, "keys", sizes.crossings as usize)?;
    let mut recording = Recording::new(device, false)?;
    let arrays: [&dyn Bind; 7] = [&start, &next, &offset, &bucket, &row_offset, &expected, &keys];
    recording.dispatch(kernel, sizes, &arrays, sizes.crossings.into())?;
    let keys = recording.read_back(&keys)?;
    let mut keys = keys.take(device, &recording.submit()?)?;
    in_order(&mut keys, &scanned.row_offset);
    Ok(keys)
}

fn in_order(keys: &mut [u32], row_offset: &[u32]) {
    for ends in row_offset.windows(2) {
        keys[ends[0] as usize..ends[1] as usize].sort_unstable();
    }
}

/// Keys and counts as the two kernels leave them, then the spans.
type Sorted = (Vec<u32>, Vec<u32>, Vec<[i32; 2]>);

fn run_sort(
    device: &Device,
    kernels: [&Kernel; 2],
    sizes: &SpanSizes,
    row_offset: &[u32],
    keys: &[u32],
) -> Result<Sorted, GpuError> {
    let rows = (sizes.planes * sizes.rows) as usize;
    let offset = Buffer::upload(device, "row offset", row_offset)?;
    let buffer = Buffer::upload(device, "keys", keys)?;
    let count = Buffer::<u32>::zeroed(device, "count", rows)?;
    let mut recording = Recording::new(device, false)?;
    recording.dispatch(kernels[0], sizes, &[&offset, &buffer, &count], rows as u64)?;
    let (sorted, counts) = (recording.read_back(&buffer)?, recording.read_back(&count)?);
    let submission = recording.submit()?;
    let (sorted, counts) = (sorted.take(device, &submission)?, counts.take(device, &submission)?);
    let span_offset = cpu::scan(&counts);
    let spans = span_offset.last().map_or(0, |&total| total as usize);
    let span_offset = Buffer::upload(device, "span offset", &span_offset)?;
    let spans = Buffer::<[i32; 2]>::zeroed(device, "spans", spans.min(keys.len()))?;
    let mut recording = Recording::new(device, false)?;
    recording.dispatch(kernels[1], sizes, &[&offset, &buffer, &span_offset, &spans], rows as u64)?;
    let spans = recording.read_back(&spans)?;
    let spans = spans.take(device, &recording.submit()?)?;
    Ok((sorted, counts, spans))
}

fn twin_sort(sizes: &SpanSizes, row_offset: &[u32], keys: &[u32]) -> Sorted {
    let mut sorted = keys.to_vec();
    let counts = twin::sort(sizes, row_offset, &mut sorted);
    let spans = twin::compact(row_offset, &sorted, &cpu::scan(&counts));
    (sorted, counts, spans)
}

/// Random edges, some of them open, on every axis, and with several rows to a line.
fn cases(triangles: usize) -> Result<Vec<(String, SpanSizes, Segments)>, Failed> {
    let mut cases = Vec::new();
    for (what, mesh) in [("soup", soup(triangles, 3, 40)), ("wide", soup(triangles, 5, 100_000_000))] {
        let heights = planes(&mesh, 12);
        let mut segments = cpu::slice(&mesh, &Adjacency::build(&mesh), &heights);
        // The kernels believe every link; random ones make steep, flat and long edges.
        let (mut random, total) = (Random(triangles as u64), segments.start.len() as u64);
        for next in &mut segments.next {
            *next = if random.next() % 16 == 0 { OPEN } else { (random.next() % total) as u32 };
        }
        for (degrees, axes) in AXES {
            for (n, lines) in [(1, 9), (4, 70), (16, 25)] {
                let reach = if what == "soup" { 40 } else { 100_000_000 };
                let pitch = (4 * reach / lines).max(n * 2);
                let whole = window(&mesh, axes, pitch, n)?;
                // Its first and last row lie inside the mesh.
                let part = RowWindow::new(axes, 0, 0, pitch, &sub_rows(n, pitch), 2)?;
                for window in [whole, part] {
                    let what = format!("{what} of {triangles}, {degrees} degrees, {n} rows a line");
                    cases.push((what, sizes_of(&window, &heights, &segments), segments.clone()));
                }
            }
        }
    }
    Ok(cases)
}

fn same_counted(what: &str, device: &Counted, twin: &Counted) -> Result<(), Failed> {
    same(&format!("{what}: count"), &device.count, &twin.count)?;
    same(&format!("{what}: bucket"), &device.bucket, &twin.bucket)?;
    same(&format!("{what}: steps"), &device.steps, &twin.steps)?;
    same(&format!("{what}: totals"), &device.totals, &twin.totals)
}

fn count_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    for triangles in SIZES {
        for (what, sizes, segments) in cases(triangles)? {
            let counted = run_count(&device, &SPAN_COUNT, &sizes, &segments)?;
            same_counted(&what, &counted, &twin::count(&sizes, &segments))?;
        }
    }
    // Millions of rows, far from the origin.
    let mut tall = shapes::sphere(500.0, 40, 30);
    tall.vertices.iter_mut().for_each(|v| (v.x, v.y) = (v.x + 300_000_000, v.y + 700_000_000));
    let heights: Vec<i32> = (-40..40).map(|k| k * 10_000_000).collect();
    let heights = &heights[40..41];
    let segments = cpu::slice(&tall, &Adjacency::build(&tall), heights);
    for (axes, base, pitch) in [([1, 0], 300_000_000, 150), ([1, 1], -1_000_000_000, 400)] {
        let window = RowWindow::new(axes, 0, base, pitch, &[0, 9, 60], 5_000_000)?;
        let sizes = sizes_of(&window, heights, &segments);
        let counted = run_count(&device, &SPAN_COUNT, &sizes, &segments)?;
        same_counted("tall", &counted, &twin::count(&sizes, &segments))?;
        ensure((counted.totals[2] > 0) == (axes == [1, 1]), format!("{:?}", &counted.totals[..4]))?;
    }
    Ok(())
}

fn fill_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut crossings = 0;
    for triangles in SIZES {
        for (what, sizes, segments) in cases(triangles)? {
            let (sizes, scanned) = scanned(&sizes, &segments);
            let Scanned { counted, offset, row_offset, .. } = &scanned;
            let mut expected = twin::fill(&sizes, &segments, counted, offset, row_offset);
            in_order(&mut expected, row_offset);
            let keys = run_fill(&device, &SPAN_FILL, &sizes, &segments, &scanned)?;
            same(&format!("{what}: keys"), &keys, &expected)?;
            crossings += keys.len();
        }
    }
    ensure(crossings > 100_000, format!("{crossings} crossings"))
}

/// Rows of many lengths, positions that repeat, windings that do not return to zero.
fn random_keys(seed: u64) -> (SpanSizes, Vec<u32>, Vec<u32>) {
    let mut random = Random(seed);
    let mut lengths = vec![0];
    lengths.extend((0..30).chain([63, 64, 65, 100, 255, 256, 257, 1_000]));
    lengths.extend((0..217).map(|_| (random.next() % 40) as u32));
    let rows = lengths.len() as u32 - 1;
    let row_offset = cpu::scan(&lengths);
    let total = row_offset[lengths.len()];
    let reach = [4, 40, 1 << 31][(seed % 3) as usize];
    let keys = (0..total)
        .map(|_| ((random.next() % reach) as u32).wrapping_sub((reach / 2) as u32) ^ 0x8000_0000)
        .collect();
    (
        SpanSizes { rows, planes: 1, sub_rows: 1, lines: rows, pitch: 1, ..SpanSizes::default() },
        row_offset,
        keys,
    )
}

fn sort_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut spans = 0;
    for seed in 0..12 {
        let (sizes, row_offset, keys) = random_keys(seed);
        let sorted = run_sort(&device, [&SPAN_SORT, &SPAN_COMPACT], &sizes, &row_offset, &keys)?;
        let expected = twin_sort(&sizes, &row_offset, &keys);
        same(&format!("sorted {seed}"), &sorted.0, &expected.0)?;
        same(&format!("counts {seed}"), &sorted.1, &expected.1)?;
        same(&format!("spans {seed}"), &sorted.2, &expected.2)?;
        spans += sorted.2.len();
    }
    ensure(spans > 1_000, format!("{spans} spans"))
}

fn bodies(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let mut turned = shapes::cuboid([1.0, -2.0, 0.0], [30.0, 20.0, 6.0]);
    // Sides that lean and are not along the axes.
    turned.vertices.iter_mut().for_each(|v| (v.x, v.y) = (v.x - v.y / 3 + v.z / 5, v.y + v.x / 4));
    for (what, mesh) in [
        ("box", shapes::cuboid([0.0; 3], [10.0, 8.0, 3.0])),
        ("turned box", turned),
        ("sphere", shapes::sphere(20.0, 40, 30)),
        ("torus", shapes::torus(30.0, 11.0, 48, 48)),
        ("fan", shapes::fan(900)),
    ] {
        // Some planes run through vertices.
        let heights = planes(&mesh, 17);
        for (degrees, axes) in AXES {
            for (pitch, n) in [(100_000, 1), (50_001, 2), (333_333, 4), (250_000, 8), (500_000, 16)] {
                let window = window(&mesh, axes, pitch, n)?;
                check(&device, &mut spans, (what, &mesh), &heights, (degrees, &window))?;
            }
        }
        // A window that sees a part only; rows through vertices.
        let window = RowWindow::new([1, 0], 7, 0, 500_000, &[0, 250_000], 5)?;
        check(&device, &mut spans, (what, &mesh), &heights, (0.0, &window))?;
    }
    Ok(())
}

fn open(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let mut mesh = shapes::sphere(9.0, 30, 20);
    mesh.triangles.truncate(900);
    mesh.triangles.remove(333);
    let heights = planes(&mesh, 60);
    let window = window(&mesh, [1, 0], 200_000, 2)?;
    let links = Adjacency::build(&mesh);
    let resident = GpuSlicer::new(Arc::clone(&device))?.upload(&mesh, &links)?;
    let per_plane = chunk::segments_per_plane(&mesh, &heights);
    let mut all = Vec::new();
    spans.scan(&resident, &heights, &per_plane, &window, |_, rows| -> Result<(), Failed> {
        all.extend(rows);
        Ok(())
    })?;
    let segments = cpu::slice(&mesh, &links, &heights);
    let expected = twin::scan(&window, heights.len() as u32, &segments).unwrap_or_default();
    same("planes", &all, &expected)?;
    for (k, rows) in all.iter().enumerate() {
        let segments = cpu::slice(&mesh, &links, &heights[k..=k]);
        ensure(rows.is_none() == segments.next.contains(&OPEN), format!("plane {k}"))?;
    }
    let open = all.iter().filter(|rows| rows.is_none()).count();
    ensure(open > 3 && all.len() - open > 3, format!("{open} open of {}", all.len()))
}

fn nothing(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let fan = shapes::fan(40);
    let few = window(&fan, [1, 0], 100_000, 2)?;
    let none = RowWindow::new([1, 0], 0, 0, 100_000, &[0], 0)?;
    let beside = RowWindow::new([1, 0], 0, 900_000_000, 100_000, &[0], 5)?;
    for (mesh, heights, window) in [
        (&Mesh::default(), &[1, 2, 3][..], &few),
        (&Mesh::default(), &[], &few),
        (&fan, &[], &few),
        (&fan, &[-50_000_000, 50_000_000], &few),
        (&fan, &[0, 5], &none),
        (&fan, &[0, 5], &beside),
    ] {
        let what = ("nothing", mesh);
        check(&device, &mut spans, what, heights, (0.0, window))?;
    }
    Ok(())
}

fn pieces(bench: &Bench) -> Result<(), Failed> {
    let mesh = shapes::torus(30.0, 11.0, 40, 40);
    let (heights, window) = (planes(&mesh, 20), window(&mesh, [1, 0], 400_000, 2)?);
    for largest_binding in [13_000, 20_000] {
        let device = bench.open(Options { largest_binding, ..Options::default() })?;
        let resident = GpuSlicer::new(Arc::clone(&device))?.upload(&mesh, &Adjacency::build(&mesh))?;
        ensure(resident.pieces() > 1, format!("{} pieces", resident.pieces()))?;
        let mut spans = GpuSpans::new(Arc::clone(&device))?;
        let runs = check(&device, &mut spans, ("torus", &mesh), &heights, (0.0, &window))?;
        ensure(runs > 2, format!("{runs} runs"))?;
    }
    Ok(())
}

/// What is wrong on the device must show against the scan of the contours.
fn planted(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mesh = shapes::torus(30.0, 11.0, 24, 24);
    let (heights, window) = (planes(&mesh, 9), window(&mesh, [1, 0], 300_000, 4)?);
    let links = Adjacency::build(&mesh);
    let segments = cpu::slice(&mesh, &links, &heights);
    let expected = twin::scan(&window, heights.len() as u32, &segments);
    let mut slicer = GpuSlicer::new(Arc::clone(&device))?;
    let mut spans = GpuSpans::new(Arc::clone(&device))?;
    let mut seen = |mesh: &Mesh, heights: &[i32], window: &RowWindow| -> Result<bool, Failed> {
        let resident = slicer.upload(mesh, &links)?;
        let per_plane = chunk::segments_per_plane(mesh, heights);
        let mut all = Vec::new();
        spans.scan(&resident, heights, &per_plane, window, |_, rows| -> Result<(), Failed> {
            all.extend(rows);
            Ok(())
        })?;
        Ok(Some(all) != expected)
    };
    ensure(!seen(&mesh, &heights, &window)?, "the unharmed run parts from the twins")?;
    let mut moved = mesh.clone();
    moved.vertices[20].x += 1_000;
    ensure(seen(&moved, &heights, &window)?, "a moved vertex went unseen")?;
    let mut higher = heights.clone();
    higher[4] += 500;
    ensure(seen(&mesh, &higher, &window)?, "a moved plane went unseen")?;
    let sizes = window.sizes();
    let base = i64::from(sizes.base) + 100;
    let shifted = RowWindow::new([1, 0], window.first(), base, 300_000, &sub_rows(4, 300_000), sizes.lines)?;
    ensure(seen(&mesh, &heights, &shifted)?, "moved rows went unseen")
}

/// The smallest slips that a kernel could make against its twin must show on these meshes.
fn drifted(bench: &Bench) -> Result<(), Failed> {
    let device = bench.open(Options::default())?;
    let cases = cases(257)?;
    let slips = [
        ("count 1", "t < sizes.base", "t <= sizes.base"),
        ("count 2", "row_offset_in_line(within) <= rest", "row_offset_in_line(within) < rest"),
        ("count 3", "line >= sizes.lines", "line > sizes.lines"),
        ("count 4", "steps[plane * sizes.rows + end], 1u", "steps[plane * sizes.rows + end], 2u"),
        ("count 5", "max(p.y, q.y)", "max(p.x, q.y)"),
        ("count 6", "atomicAdd(&totals[4u + plane], 1u)", "atomicAdd(&totals[4u], 1u)"),
        ("count 7", "lane * (GROUP_SIZE - 1u)", "lane * (GROUP_SIZE - 9u)"),
        ("count 8", "atomicAdd(&totals[0], sum)", "atomicAdd(&totals[0], sum + 1u)"),
    ];
    for (name, old, new) in slips {
        let kernel = changed(&SPAN_COUNT, name, old, new)?;
        let mut seen = false;
        for (_, sizes, segments) in &cases {
            seen |= run_count(&device, &kernel, sizes, segments)? != twin::count(sizes, segments);
        }
        ensure(seen, format!("'{new}' in span_count went unseen"))?;
    }
    let slips = [
        ("fill 1", "(dt - 1u) >> 1u", "dt >> 1u"),
        ("fill 2", "select(0u, 1u, up)", "select(1u, 0u, up)"),
        ("fill 3", "q.y > p.y", "q.y < p.y"),
        ("fill 4", "high.x >= low.x", "high.x < low.x"),
        ("fill 5", "row % sizes.sub_rows", "0u"),
        ("fill 6", "(item - offset[slot])", "(item - offset[slot]) * 0u"),
        ("fill 7", "sizes.a * p.y - sizes.b * p.x", "sizes.a * p.y + sizes.b * p.x"),
    ];
    for (name, old, new) in slips {
        let kernel = changed(&SPAN_FILL, name, old, new)?;
        let mut seen = false;
        for (_, sizes, segments) in &cases {
            let (sizes, scanned) = scanned(sizes, segments);
            let Scanned { counted, offset, row_offset, .. } = &scanned;
            let mut expected = twin::fill(&sizes, segments, counted, offset, row_offset);
            in_order(&mut expected, row_offset);
            seen |= run_fill(&device, &kernel, &sizes, segments, &scanned)? != expected;
        }
        ensure(seen, format!("'{new}' in span_fill went unseen"))?;
    }
    let slips = [
        (0, "sort 1", "child + 1u < length", "child + 2u < length"),
        (0, "sort 2", "keys[at - 1u] > key", "keys[at - 1u] < key"),
        (0, "sort 3", "select(1i, -1i,", "select(1i, 1i,"),
        (0, "sort 4", "before != 0i && winding == 0i", "winding == 0i"),
        (0, "sort 5", "(keys[i] >> 1u) == at", "keys[i] == 2u * at"),
        (0, "sort 6", "row_offset[row + 2u]", "row_offset[row + 1u]"),
        (1, "compact 1", "2u * i + 1u", "2u * i"),
        (1, "compact 2", "row_offset[row + 1u]", "row_offset[row]"),
    ];
    for (which, name, old, new) in slips {
        let mut kernels = [SPAN_SORT, SPAN_COMPACT];
        kernels[which] = changed(&kernels[which], name, old, new)?;
        let (sizes, row_offset, keys) = random_keys(1);
        let sorted = run_sort(&device, [&kernels[0], &kernels[1]], &sizes, &row_offset, &keys)?;
        let seen = sorted != twin_sort(&sizes, &row_offset, &keys);
        ensure(seen, format!("'{new}' in {name} went unseen"))?;
    }
    Ok(())
}
