//! Counting, emitting, and whole slices.

use crate::compare::{ensure, same, same_segments};
use crate::meshes::{planes, soup};
use crate::{Bench, SIZES, Test};
use libtest_mimic::Failed;
use microtome::gpu::dispatch::Recording;
use microtome::gpu::{Buffer, Device, GpuError, Options};
use microtome::lattice::{LIMIT, Point2, Point3, mm};
use microtome::mesh::{Adjacency, Mesh, OPEN, shapes};
use microtome::shaders::{Kernel, SLICE_COUNT, SLICE_EMIT, SLICE_EMIT_EVEN, SliceSizes};
use microtome::slice::gpu::GpuSlicer;
use microtome::slice::{Segments, chunk, cpu};

pub const TESTS: &[Test] = &[
    ("slice_count_equals_its_twin", count_equals_twin),
    ("slice_emit_equals_its_twin", emit_equals_twin),
    ("slice_kernels_cross_the_fold", fold),
    ("slices_of_bodies_equal_the_twin", bodies),
    ("slices_at_the_corners_of_the_lattice_equal_the_twin", corners),
    ("slices_of_open_meshes_equal_the_twin", open),
    ("slices_of_nothing_are_empty", nothing),
    ("chunked_equals_unchunked", chunked),
    ("pieces_of_a_mesh_equal_the_whole", pieces),
    ("a_planted_fault_is_seen", planted),
    ("a_drifted_kernel_is_seen", drifted),
];

const TOP: i32 = LIMIT - 1;

fn sizes(mesh: &Mesh, planes: &[i32]) -> SliceSizes {
    let (triangles, planes) = (mesh.triangles.len() as u32, planes.len() as u32);
    SliceSizes { triangles, planes, ..SliceSizes::default() }
}

fn count(
    device: &Device,
    kernel: &Kernel,
    mesh: &Mesh,
    planes: &[i32],
) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
    let vertices = Buffer::upload(device, "vertices", &mesh.vertices)?;
    let triangles = Buffer::upload(device, "triangles", &mesh.triangles)?;
    let heights = Buffer::upload(device, "planes", planes)?;
    let first = Buffer::<u32>::zeroed(device, "first", triangles.len())?;
    let count = Buffer::<u32>::zeroed(device, "count", triangles.len())?;
    let mut recording = Recording::new(device, false)?;
    let arrays: [&dyn microtome::gpu::dispatch::Bind; 5] = [&vertices, &triangles, &heights, &first, &count];
    recording.dispatch(kernel, &sizes(mesh, planes), &arrays, triangles.len() as u64)?;
    let (first, count) = (recording.read_back(&first)?, recording.read_back(&count)?);
    let submission = recording.submit()?;
    Ok((first.take(device, &submission)?, count.take(device, &submission)?))
}

/// The kernel alone, fed with the twin's counts.
fn emit(
    device: &Device,
    kernel: &Kernel,
    mesh: &Mesh,
    links: &Adjacency,
    planes: &[i32],
) -> Result<Segments, GpuError> {
    let (first, counts) = cpu::count(mesh, planes);
    let offset = cpu::scan(&counts);
    let total = offset.last().map_or(0, |&n| n as usize);
    let vertices = Buffer::upload(device, "vertices", &mesh.vertices)?;
    let triangles = Buffer::upload(device, "triangles", &mesh.triangles)?;
    let heights = Buffer::upload(device, "planes", planes)?;
    let twin = Buffer::upload(device, "twin", &links.twin)?;
    let firsts = Buffer::upload(device, "first", &first)?;
    let offsets = Buffer::upload(device, "offset", &offset)?;
    let start = Buffer::<Point2>::zeroed(device, "start", total)?;
    let next = Buffer::<u32>::zeroed(device, "next", total)?;
    let mut recording = Recording::new(device, false)?;
    let arrays: [&dyn microtome::gpu::dispatch::Bind; 8] =
        [&vertices, &triangles, &heights, &twin, &firsts, &offsets, &start, &next];
    let sizes = SliceSizes { segments: total as u32, ..sizes(mesh, planes) };
    let items = if kernel.wgsl.contains("fn owner") { total } else { triangles.len() };
    recording.dispatch(kernel, &sizes, &arrays, items as u64)?;
    let (start, next) = (recording.read_back(&start)?, recording.read_back(&next)?);
    let submission = recording.submit()?;
    Ok(Segments {
        first,
        offset,
        start: start.take(device, &submission)?,
        next: next.take(device, &submission)?,
    })
}

/// A whole slice on the device and on the twin.
fn check(slicer: &mut GpuSlicer, what: &str, mesh: &Mesh, planes: &[i32]) -> Result<Segments, Failed> {
    let links = Adjacency::build(mesh);
    let resident = slicer.upload(mesh, &links)?;
    let device = slicer.slice(&resident, planes)?;
    same_segments(what, &device, &cpu::slice(mesh, &links, planes))?;
    Ok(device)
}

fn count_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    for triangles in SIZES {
        for count_planes in [0, 1, 2, 63, 257] {
            let mesh = soup(triangles, triangles as u64, 40);
            let planes = planes(&mesh, count_planes);
            let (first, counts) = count(&device, &SLICE_COUNT, &mesh, &planes)?;
            let (twin_first, twin_counts) = cpu::count(&mesh, &planes);
            same(&format!("first, {triangles} × {count_planes}"), &first, &twin_first)?;
            same(&format!("count, {triangles} × {count_planes}"), &counts, &twin_counts)?;
        }
    }
    Ok(())
}

fn emit_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    for triangles in SIZES {
        for (planes_count, reach) in [(0, 40), (1, 40), (63, 40), (63, TOP)] {
            let mesh = soup(triangles, triangles as u64 + 9, reach);
            let (links, planes) = (Adjacency::build(&mesh), planes(&mesh, planes_count));
            for kernel in [SLICE_EMIT, SLICE_EMIT_EVEN] {
                let segments = emit(&device, &kernel, &mesh, &links, &planes)?;
                let what = format!("{}, {triangles} × {planes_count}", kernel.name);
                same_segments(&what, &segments, &cpu::slice(&mesh, &links, &planes))?;
            }
        }
    }
    Ok(())
}

fn fold(bench: &Bench) -> Result<(), Failed> {
    let device = bench.narrow()?;
    for triangles in [767, 768, 769, 2_303, 2_304] {
        let mesh = soup(triangles, 5, 1_000);
        let (links, planes) = (Adjacency::build(&mesh), planes(&mesh, 9));
        let (twin_first, twin_counts) = cpu::count(&mesh, &planes);
        let (first, counts) = count(&device, &SLICE_COUNT, &mesh, &planes)?;
        same(&format!("first of {triangles}"), &first, &twin_first)?;
        same(&format!("count of {triangles}"), &counts, &twin_counts)?;
        for kernel in [SLICE_EMIT, SLICE_EMIT_EVEN] {
            // Per segment the grid is full long before.
            let few = if kernel.name == SLICE_EMIT.name { &planes[..] } else { &planes[..1] };
            let segments = emit(&device, &kernel, &mesh, &links, few)?;
            same_segments(&format!("{triangles}"), &segments, &cpu::slice(&mesh, &links, few))?;
        }
    }
    let mesh = soup(2_305, 5, 1_000);
    let beyond = count(&device, &SLICE_COUNT, &mesh, &[0]);
    ensure(matches!(beyond, Err(GpuError::TooLarge { limit: 9, .. })), "2,305 triangles should be refused")
}

fn bodies(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let cuboid = shapes::cuboid([0.0; 3], [10.0, 8.0, 3.0]);
    // From just below its bottom to just above its top.
    let heights = [-1_500_001, -1_500_000, -1_499_999, 0, 1_499_999, 1_500_000, 1_500_001];
    let segments = check(&mut slicer, "box", &cuboid, &heights)?;
    // Four planes, those above the bottom up to the top itself, meet the four sides, eight triangles each.
    ensure(segments.start.len() == 4 * 8, format!("the box has {} segments", segments.start.len()))?;
    ensure(segments.next.iter().all(|&n| n != OPEN), "a closed body has no open link")?;
    for (what, mesh) in [
        ("sphere", shapes::sphere(20.0, 40, 30)),
        ("torus", shapes::torus(30.0, 11.0, 48, 48)),
        ("fan", shapes::fan(6_000)),
    ] {
        for count in [1, 7, 300] {
            // Half of the planes run through vertices.
            check(&mut slicer, what, &mesh, &planes(&mesh, count))?;
        }
    }
    Ok(())
}

fn corners(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let top = mm(TOP);
    let whole = shapes::cuboid([-top; 3], [top; 3]);
    ensure(whole.bounds() == Some([-TOP, TOP].map(|c| Point3::new(c, c, c))), "it fills the lattice")?;
    let heights = [-TOP, 1 - TOP, -1, 0, 1, 12_345_678, TOP - 1, TOP];
    check(&mut slicer, "whole lattice", &whole, &heights)?;
    let mut leaning = whole.clone();
    // Every upper corner over the opposite lower one.
    leaning.vertices.iter_mut().filter(|v| v.z > 0).for_each(|v| (v.x, v.y) = (-v.x, -v.y));
    check(&mut slicer, "leaning", &leaning, &heights)?;
    let mut thin = whole;
    thin.vertices.iter_mut().for_each(|v| v.z = v.z.clamp(-1, 0));
    check(&mut slicer, "one step thin", &thin, &heights)?;
    for seed in 0..4 {
        let mesh = soup(3_000, seed, TOP);
        check(&mut slicer, &format!("soup {seed}"), &mesh, &planes(&mesh, 40))?;
    }
    Ok(())
}

fn open(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    for keep in [2, 3, 7] {
        let mut mesh = shapes::sphere(9.0, 30, 20);
        let mut i = 0;
        mesh.triangles.retain(|_| {
            i += 1;
            i % keep != 0
        });
        let heights = planes(&mesh, 50);
        let segments = check(&mut slicer, "holed sphere", &mesh, &heights)?;
        ensure(segments.next.contains(&OPEN), "a holed body has open links")?;
    }
    Ok(())
}

fn nothing(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let empty = Mesh::default();
    check(&mut slicer, "no triangles", &empty, &[1, 2, 3])?;
    check(&mut slicer, "nothing at all", &empty, &[])?;
    check(&mut slicer, "no planes", &shapes::fan(40), &[])?;
    check(&mut slicer, "planes that miss", &shapes::fan(40), &[-50_000_000, 50_000_000])?;
    check(&mut slicer, "planes that meet again", &shapes::fan(40), &[-9, 9]).map(drop)
}

/// Per triangle and plane: where it starts and in which triangle it goes on; independent of the run.
fn by_plane(segments: &Segments, from: usize) -> Vec<(usize, usize, Point2, Option<usize>)> {
    let triangle_of = |slot: usize| segments.offset.partition_point(|&o| o as usize <= slot) - 1;
    (0..segments.start.len())
        .map(|slot| {
            let t = triangle_of(slot);
            let k = segments.first[t] as usize + slot - segments.offset[t] as usize;
            let next = segments.next[slot];
            (from + k, t, segments.start[slot], (next != OPEN).then(|| triangle_of(next as usize)))
        })
        .collect()
}

fn chunked(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let mut mesh = shapes::torus(30.0, 11.0, 40, 40);
    mesh.triangles.truncate(3_100);
    let (links, heights) = (Adjacency::build(&mesh), planes(&mesh, 120));
    let resident = slicer.upload(&mesh, &links)?;
    let mut whole = by_plane(&slicer.slice(&resident, &heights)?, 0);
    whole.sort_unstable();
    let per_plane = chunk::segments_per_plane(&mesh, &heights);
    for limit in [1, 777, 5_000, u64::MAX] {
        let runs = chunk::runs(&per_plane, limit);
        let mut parts = Vec::new();
        slicer.slice_runs(&resident, &heights, &runs, |run, segments| -> Result<(), Failed> {
            let twin = cpu::slice(&mesh, &links, &heights[run.clone()]);
            same_segments(&format!("run {run:?}"), &segments, &twin)?;
            parts.extend(by_plane(&segments, run.start));
            Ok(())
        })?;
        parts.sort_unstable();
        same(&format!("runs of at most {limit}"), &parts, &whole)?;
    }
    Ok(())
}

/// Every limit that cuts a mesh or its segments into pieces gives the same buffers as none.
fn pieces(bench: &Bench) -> Result<(), Failed> {
    let mut open = shapes::torus(30.0, 11.0, 30, 30);
    open.triangles.truncate(1_700);
    let bodies = [("torus", open), ("soup", soup(900, 4, 1_000)), ("fan", shapes::fan(1_500))];
    let mut seen = 0;
    for binding in [7_200, 12_000, 30_000] {
        let options = Options { largest_binding: binding, ..Options::default() };
        let mut slicer = GpuSlicer::new(bench.open(options)?)?;
        let mut resident = slicer.upload(&shapes::fan(50), &Adjacency::build(&shapes::fan(50)))?;
        for (what, mesh) in &bodies {
            let (links, heights) = (Adjacency::build(mesh), planes(mesh, 70));
            slicer.upload_into(&mut resident, mesh, &links)?;
            seen = seen.max(resident.pieces());
            for heights in [&heights[..], &heights[..9]] {
                let what = format!("{what}, {binding} B, {} planes", heights.len());
                let device = slicer.slice(&resident, heights)?;
                same_segments(&what, &device, &cpu::slice(mesh, &links, heights))?;
            }
        }
    }
    ensure(seen >= 3, format!("{seen} pieces"))
}

fn planted(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let mesh = shapes::torus(30.0, 11.0, 16, 16);
    let (links, heights) = (Adjacency::build(&mesh), planes(&mesh, 30));
    let resident = slicer.upload(&mesh, &links)?;
    let device = slicer.slice(&resident, &heights)?;
    let twin = cpu::slice(&mesh, &links, &heights);
    same_segments("unharmed", &device, &twin)?;
    let seen = |harm: fn(&mut Segments)| {
        let mut harmed = device.clone();
        harm(&mut harmed);
        ensure(same_segments("harmed", &harmed, &twin).is_err(), "a fault in the device's buffer went unseen")
    };
    seen(|s| s.first[3] ^= 1)?;
    seen(|s| s.offset[40] += 1)?;
    seen(|s| s.start[100].x += 1)?;
    seen(|s| s.next[7] = OPEN)?;
    seen(|s| s.next.truncate(5))?;
    // The same where it matters: another input on the device than on the twin.
    let mut moved = mesh.clone();
    moved.vertices[20].x += 1_000;
    let resident = slicer.upload(&moved, &links)?;
    let device = slicer.slice(&resident, &heights)?;
    ensure(same_segments("moved", &device, &twin).is_err(), "a moved vertex went unseen")
}

/// A kernel with one spot of its text changed.
pub fn changed(kernel: &Kernel, name: &'static str, old: &str, new: &str) -> Result<Kernel, Failed> {
    ensure(kernel.wgsl.matches(old).count() == 1, format!("'{old}' is not once in {}", kernel.name))?;
    let wgsl = Box::leak(kernel.wgsl.replacen(old, new, 1).into_boxed_str());
    Ok(Kernel { name, wgsl, bindings: kernel.bindings })
}

/// The smallest slips that a kernel could make against its twin must show on these meshes.
fn drifted(bench: &Bench) -> Result<(), Failed> {
    let device = bench.open(Options::default())?;
    let mut mesh = soup(500, 3, 12);
    let heights: Vec<i32> = (-13..14).collect();
    let slips = [("planes[middle] <= z", "planes[middle] < z"), ("planes[high] <= z", "planes[high] < z")];
    for (name, (old, new)) in ["count 1", "count 2"].into_iter().zip(slips) {
        let kernel = changed(&SLICE_COUNT, name, old, new)?;
        let (first, counts) = count(&device, &kernel, &mesh, &heights)?;
        let seen = (first, counts) != cpu::count(&mesh, &heights);
        ensure(seen, format!("'{new}' in slice_count went unseen"))?;
    }
    let links = Adjacency::build(&mesh);
    let slips = [
        ("let above_b = b.z >= z", "let above_b = b.z > z"),
        ("let swap = a.z >= z", "let swap = a.z > z"),
        ("divisor >> 1u", "(divisor - 1u) >> 1u"),
        ("(k - first[neighbour])", "(k - first[t])"),
        ("upper >= lower", "upper < lower"),
    ];
    for (name, (old, new)) in ["emit 1", "emit 2", "emit 3", "emit 4", "emit 5"].into_iter().zip(slips) {
        let kernel = changed(&SLICE_EMIT, name, old, new)?;
        let segments = emit(&device, &kernel, &mesh, &links, &heights)?;
        let seen = segments != cpu::slice(&mesh, &links, &heights);
        ensure(seen, format!("'{new}' in slice_emit went unseen"))?;
    }
    let slips = [
        ("offset[sizes.piece + middle] <= slot", "offset[sizes.piece + middle] < slot"),
        ("(slot - offset[sizes.piece + t])", "(place - offset[sizes.piece + t] + 1u)"),
        ("lane * (GROUP_SIZE - 1u)", "lane * (GROUP_SIZE - 9u)"),
    ];
    for (name, (old, new)) in ["even 1", "even 2", "even 3"].into_iter().zip(slips) {
        let kernel = changed(&SLICE_EMIT_EVEN, name, old, new)?;
        let segments = emit(&device, &kernel, &mesh, &links, &heights)?;
        let seen = segments != cpu::slice(&mesh, &links, &heights);
        ensure(seen, format!("'{new}' in slice_emit_even went unseen"))?;
    }
    // Slips in the digits show on long edges only.
    mesh = soup(500, 3, TOP);
    let (links, heights) = (Adjacency::build(&mesh), planes(&mesh, 40));
    let slips = [("+ (middle >> 16u)", ""), ("digit * d0 > ((rest << 16u) | next) {", "false {")];
    for (name, (old, new)) in ["emit 6", "emit 7"].into_iter().zip(slips) {
        let kernel = changed(&SLICE_EMIT, name, old, new)?;
        let segments = emit(&device, &kernel, &mesh, &links, &heights)?;
        let seen = segments != cpu::slice(&mesh, &links, &heights);
        ensure(seen, format!("'{new}' for '{old}' went unseen"))?;
    }
    Ok(())
}
