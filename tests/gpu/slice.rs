//! Counting, emitting, and whole slices.

use crate::compare::{ensure, same, same_segments};
use crate::meshes::{self, adjacency, planes};
use crate::{Bench, SIZES, Test};
use libtest_mimic::Failed;
use microtome::gpu::dispatch::Recording;
use microtome::gpu::{Buffer, Device, GpuError};
use microtome::lattice::{LIMIT, Point2};
use microtome::mesh::{Adjacency, Mesh, OPEN};
use microtome::shaders::{SLICE_COUNT, SLICE_EMIT, SliceSizes};
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
    ("a_planted_fault_is_seen", planted),
];

const TOP: i32 = LIMIT - 1;

fn sizes(mesh: &Mesh, planes: &[i32]) -> SliceSizes {
    SliceSizes { triangles: mesh.triangles.len() as u32, planes: planes.len() as u32, padding: [0; 2] }
}

fn count(device: &Device, mesh: &Mesh, planes: &[i32]) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
    let vertices = Buffer::upload(device, "vertices", &mesh.vertices)?;
    let triangles = Buffer::upload(device, "triangles", &mesh.triangles)?;
    let heights = Buffer::upload(device, "planes", planes)?;
    let first = Buffer::<u32>::zeroed(device, "first", triangles.len())?;
    let count = Buffer::<u32>::zeroed(device, "count", triangles.len())?;
    let mut recording = Recording::new(device)?;
    let arrays: [&dyn microtome::gpu::dispatch::Bind; 5] = [&vertices, &triangles, &heights, &first, &count];
    recording.dispatch(&SLICE_COUNT, &sizes(mesh, planes), &arrays, triangles.len() as u64)?;
    let (first, count) = (recording.read_back(&first)?, recording.read_back(&count)?);
    let submission = recording.submit()?;
    Ok((first.take(device, &submission)?, count.take(device, &submission)?))
}

/// The kernel alone, fed with the twin's counts.
fn emit(device: &Device, mesh: &Mesh, links: &Adjacency, planes: &[i32]) -> Result<Segments, GpuError> {
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
    let mut recording = Recording::new(device)?;
    let arrays: [&dyn microtome::gpu::dispatch::Bind; 8] =
        [&vertices, &triangles, &heights, &twin, &firsts, &offsets, &start, &next];
    recording.dispatch(&SLICE_EMIT, &sizes(mesh, planes), &arrays, triangles.len() as u64)?;
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
    let links = adjacency(mesh);
    let resident = slicer.upload(mesh, &links)?;
    let device = slicer.slice(&resident, planes)?;
    same_segments(what, &device, &cpu::slice(mesh, &links, planes))?;
    Ok(device)
}

fn count_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    for triangles in SIZES {
        for count_planes in [0, 1, 2, 63, 257] {
            let mesh = meshes::soup(triangles, triangles as u64, 40);
            let planes = planes(&mesh, count_planes);
            let (first, counts) = count(&device, &mesh, &planes)?;
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
            let mesh = meshes::soup(triangles, triangles as u64 + 9, reach);
            let (links, planes) = (adjacency(&mesh), planes(&mesh, planes_count));
            let segments = emit(&device, &mesh, &links, &planes)?;
            let what = format!("{triangles} × {planes_count}");
            same_segments(&what, &segments, &cpu::slice(&mesh, &links, &planes))?;
        }
    }
    Ok(())
}

fn fold(bench: &Bench) -> Result<(), Failed> {
    let device = bench.narrow()?;
    for triangles in [767, 768, 769, 2_303, 2_304] {
        let mesh = meshes::soup(triangles, 5, 1_000);
        let (links, planes) = (adjacency(&mesh), planes(&mesh, 9));
        let (twin_first, twin_counts) = cpu::count(&mesh, &planes);
        let (first, counts) = count(&device, &mesh, &planes)?;
        same(&format!("first of {triangles}"), &first, &twin_first)?;
        same(&format!("count of {triangles}"), &counts, &twin_counts)?;
        let segments = emit(&device, &mesh, &links, &planes)?;
        same_segments(&format!("{triangles}"), &segments, &cpu::slice(&mesh, &links, &planes))?;
    }
    let mesh = meshes::soup(2_305, 5, 1_000);
    let beyond = count(&device, &mesh, &[0]);
    ensure(matches!(beyond, Err(GpuError::TooLarge { limit: 9, .. })), "2,305 triangles should be refused")
}

fn bodies(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let cuboid = meshes::cuboid((-5_000_000, -4_000_000, 0), (5_000_000, 4_000_000, 3_000_000));
    let heights = [-1, 0, 1, 1_500_000, 2_999_999, 3_000_000, 3_000_001];
    let segments = check(&mut slicer, "box", &cuboid, &heights)?;
    // The planes 1 ..= z_max meet the four sides, eight triangles each.
    ensure(segments.start.len() == 4 * 8, format!("the box has {} segments", segments.start.len()))?;
    ensure(segments.next.iter().all(|&n| n != OPEN), "a closed body has no open link")?;
    for (what, mesh) in [
        ("sphere", meshes::sphere(4, 20e6)),
        ("torus", meshes::torus(48, 30e6, 11e6)),
        ("fan", meshes::fan(3_000, 25e6)),
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
    let whole = meshes::cuboid((-TOP, -TOP, -TOP), (TOP, TOP, TOP));
    let heights = [-TOP, 1 - TOP, -1, 0, 1, 12_345_678, TOP - 1, TOP];
    check(&mut slicer, "whole lattice", &whole, &heights)?;
    // Upright and slanted needles, one lattice step thin.
    let needle = meshes::cuboid((TOP - 1, -TOP, -TOP), (TOP, TOP, TOP));
    check(&mut slicer, "blade", &needle, &heights)?;
    let flat = meshes::cuboid((-TOP, -TOP, 0), (TOP, TOP, 1));
    check(&mut slicer, "sheet", &flat, &heights)?;
    for seed in 0..4 {
        let soup = meshes::soup(3_000, seed, TOP);
        check(&mut slicer, &format!("soup {seed}"), &soup, &planes(&soup, 40))?;
    }
    Ok(())
}

fn open(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    for keep in [2, 3, 7] {
        let mut mesh = meshes::sphere(3, 9e6);
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
    check(&mut slicer, "no planes", &meshes::fan(20, 5e6), &[])?;
    check(&mut slicer, "planes that miss", &meshes::fan(20, 5e6), &[-9_000_000, 9_000_000])?;
    check(&mut slicer, "planes that meet again", &meshes::fan(20, 5e6), &[-9, 9]).map(drop)
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
    let mut mesh = meshes::torus(40, 30e6, 11e6);
    mesh.triangles.truncate(3_100);
    let (links, heights) = (adjacency(&mesh), planes(&mesh, 120));
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

fn planted(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let mesh = meshes::torus(16, 30e6, 11e6);
    let (links, heights) = (adjacency(&mesh), planes(&mesh, 30));
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
