//! Raw triangles to a mesh with links, on the device: sorted, rounded, welded and paired as on the CPU.

use crate::compare::{ensure, same, same_segments};
use crate::meshes::{Random, planes, soup};
use crate::slice::changed;
use crate::{Bench, SIZES, Test};
use libtest_mimic::Failed;
use microtome::gpu::dispatch::Recording;
use microtome::gpu::sort::Sorter;
use microtome::gpu::{Buffer, Device, GpuError, Options};
use microtome::mesh::{Adjacency, Mesh, load_bytes, shapes};
use microtome::shaders::{EDGE_KEYS, EDGE_PAIRS, EdgeSizes, Kernel, WELD_CORNERS, WeldSizes};
use microtome::slice::cpu;
use microtome::slice::gpu::GpuSlicer;
use std::path::Path;

pub const TESTS: &[Test] = &[
    ("a_sort_equals_its_twin", sort),
    ("a_built_mesh_equals_the_loaded_one", bodies),
    ("built_soups_equal_the_loaded_ones", soups),
    ("every_float_is_rounded_as_on_the_cpu", floats),
    ("a_mesh_is_built_in_parts", parts),
    ("a_build_beyond_the_budget_is_refused", budget),
    ("a_moved_corner_is_seen", planted),
    ("a_drifted_build_is_seen", drifted),
];

type Facets = Vec<[[f32; 3]; 3]>;

fn facets(mesh: &Mesh) -> Facets {
    let mm = |v: u32| {
        let p = mesh.vertices[v as usize];
        [p.x, p.y, p.z].map(|c| (f64::from(c) * 1e-6) as f32)
    };
    mesh.triangles.iter().map(|t| t.map(mm)).collect()
}

fn stl(facets: &Facets) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((facets.len() as u32).to_le_bytes());
    for facet in facets {
        bytes.extend([0; 12]);
        facet.as_flattened().iter().for_each(|c| bytes.extend(c.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Builds on the device and compares with the CPU's mesh and links.
fn check(slicer: &mut GpuSlicer, what: &str, facets: &Facets) -> Result<(), Failed> {
    let loaded = load_bytes(Path::new("soup.stl"), &stl(facets))?;
    let links = Adjacency::build(&loaded.mesh);
    let built = slicer.build(facets, loaded.mesh.origin)?;
    ensure(
        built.vertices == loaded.mesh.vertices.len() as u64,
        format!("{what}: {} vertices", built.vertices),
    )?;
    ensure(built.collapsed == loaded.collapsed, format!("{what}: {} collapsed", built.collapsed))?;
    let arrays = slicer.download(&built.mesh)?;
    same(&format!("{what}: vertices"), &arrays.vertices, &loaded.mesh.vertices)?;
    same(&format!("{what}: triangles"), &arrays.triangles, &loaded.mesh.triangles)?;
    same(&format!("{what}: twin"), &arrays.adjacency.twin, &links.twin)?;
    // The resident mesh is sliced twice at different planes.
    for count in [1, 23] {
        let heights = planes(&loaded.mesh, count);
        let segments = slicer.slice(&built.mesh, &heights)?;
        same_segments(what, &segments, &cpu::slice(&loaded.mesh, &links, &heights))?;
    }
    Ok(())
}

fn sort(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut random = Random(8);
    for len in SIZES.into_iter().map(|n| 3 * n).chain([2_046, 2_049, 6_144, 30_000]) {
        for bits in [0, 1, 4, 7, 20, 32] {
            // Keys come from a kernel, as everything that is sorted does.
            let triangles: Vec<[u32; 3]> =
                (0..len / 3).map(|_| [0; 3].map(|_| random.next() as u32 >> 2)).collect();
            let resident = Buffer::upload(&device, "triangles", &triangles)?;
            let mut sorter = Sorter::new(&device, 3 * triangles.len())?;
            let mut recording = Recording::new(&device, false)?;
            let sizes = EdgeSizes { half_edges: 3 * triangles.len() as u32, padding: [0; 3] };
            let arrays: [&dyn microtome::gpu::dispatch::Bind; 3] =
                [&resident, sorter.keys(), sorter.values()];
            recording.dispatch(&EDGE_KEYS, &sizes, &arrays, u64::from(sizes.half_edges))?;
            sorter.record(&device, &mut recording, bits)?;
            let (keys, values) = (recording.read_back(sorter.keys())?, recording.read_back(sorter.values())?);
            let submission = recording.submit()?;
            let keys = keys.take(&device, &submission)?;
            let sorted: Vec<(u32, u32)> = keys.into_iter().zip(values.take(&device, &submission)?).collect();
            let mut twin: Vec<(u32, u32)> = (0u32..)
                .zip(triangles.as_flattened())
                .map(|(h, &from)| {
                    let to = triangles[h as usize / 3][(h as usize + 1) % 3];
                    (2 * from.max(to) + u32::from(from < to), h)
                })
                .collect();
            // Whole digits are sorted by.
            let mask = (1u64 << (bits.div_ceil(4) * 4)) - 1;
            twin.sort_by_key(|pair| u64::from(pair.0) & mask);
            same(&format!("{len} keys by {bits} bits"), &sorted, &twin)?;
        }
    }
    Ok(())
}

fn bodies(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let mut holed = shapes::sphere(9.0, 30, 20);
    holed.triangles.retain(|t| t[0] % 7 != 3);
    for (what, mesh) in [
        ("box", shapes::cuboid([0.0; 3], [10.0, 8.0, 3.0])),
        ("holed sphere", holed),
        ("torus", shapes::torus(30.0, 11.0, 48, 48)),
        ("fan", shapes::fan(6_000)),
        ("knot", shapes::knot(30.0, 6.0, 20_000)),
    ] {
        check(&mut slicer, what, &facets(&mesh))?;
    }
    Ok(())
}

/// Few places for many corners: collapsed facets, edges shared by many, opposite and equal facets.
fn soups(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    for (seed, count) in [1, 2, 21, 22, 85, 86, 300, 2_000, 5_000].into_iter().enumerate() {
        for range in [3, 6, 40] {
            let mut random = Random(seed as u64);
            let mut corner = || [0; 3].map(|_: i32| (random.next() % range) as f32 * 0.1 - 0.2);
            let mut soup: Facets = (0..count).map(|_| [corner(), corner(), corner()]).collect();
            soup.push([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
            check(&mut slicer, &format!("seed {seed}, {count} facets, {range} steps"), &soup)?;
        }
    }
    // Thousands of triangles on one edge, most of them one way.
    let spoke = |i: u32| [[0.0; 3], [0.0, 0.0, 1.0], [i as f32 * 0.01 + 1.0, (i % 7) as f32, 0.5]];
    let mut book: Facets = (0..3_000).map(spoke).collect();
    book.iter_mut().skip(5).step_by(3).for_each(|facet| facet.swap(0, 1));
    check(&mut slicer, "book", &book)
}

fn floats(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let mut random = Random(77);
    let mut float = || loop {
        // Every exponent equally often.
        let value = f32::from_bits(random.next() as u32);
        if value.abs() < 1_000.0 {
            return value;
        }
    };
    let mut soup: Facets = (0..3_000).map(|_| [0; 3].map(|_| [0; 3].map(|_| float()))).collect();
    // Halves of a nanometre either way, zeros, and the smallest numbers.
    let odd = [0.007_812_5, -0.007_812_5, 0.0, -0.0, f32::MIN_POSITIVE, -1e-45, 5e-7, -5e-7, 4.9e-7, 1.5e-6];
    soup.extend(
        (0..200).map(|i| [0, 1, 2].map(|c| [0, 1, 2].map(|a| odd[(i * 7 + c * 3 + a * (i + 1)) % 10]))),
    );
    check(&mut slicer, "floats", &soup)
}

fn parts(bench: &Bench) -> Result<(), Failed> {
    let options = Options { largest_binding: 3_600, ..Options::default() };
    let mut slicer = GpuSlicer::new(bench.open(options)?)?;
    let mut soup = facets(&shapes::sphere(9.0, 12, 10));
    soup.truncate(200);
    ensure(soup.len() == 200, "two parts of a hundred facets")?;
    check(&mut slicer, "sphere", &soup)?;
    let larger = facets(&shapes::sphere(9.0, 30, 20));
    let refused = slicer.build(&larger, [0; 3]).map(drop);
    ensure(matches!(refused, Err(GpuError::TooLarge { limit: 3_600, .. })), format!("{refused:?}"))
}

fn budget(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?.with_budget(100_000);
    let refused = slicer.build(&facets(&shapes::sphere(9.0, 30, 20)), [0; 3]).map(drop);
    ensure(matches!(refused, Err(GpuError::Budget { budget: 100_000, .. })), format!("{refused:?}"))
}

fn planted(bench: &Bench) -> Result<(), Failed> {
    let mut slicer = GpuSlicer::new(bench.plain()?)?;
    let soup = facets(&shapes::torus(30.0, 11.0, 16, 16));
    let loaded = load_bytes(Path::new("soup.stl"), &stl(&soup))?;
    let whole = slicer.build(&soup, loaded.mesh.origin)?;
    let whole = slicer.download(&whole.mesh)?;
    let mut moved = soup.clone();
    moved[100][1][2] += 0.000_01;
    let other = slicer.build(&moved, loaded.mesh.origin)?;
    let other = slicer.download(&other.mesh)?;
    ensure(same("vertices", &other.vertices, &whole.vertices).is_err(), "a moved corner went unseen")?;
    ensure(
        same("links", &other.adjacency.twin, &whole.adjacency.twin).is_err(),
        "an opened edge went unseen",
    )?;
    moved.clone_from(&soup);
    moved.swap(3, 90);
    let other = slicer.build(&moved, loaded.mesh.origin)?;
    ensure(slicer.download(&other.mesh)? != whole, "another order of facets went unseen")
}

/// One kernel alone: floats to lattice points about the origin.
fn corners(device: &Device, kernel: &Kernel, floats: &[f32]) -> Result<Vec<i32>, GpuError> {
    let raw = Buffer::upload(device, "floats", floats)?;
    let array = || Buffer::<i32>::zeroed(device, "coordinates", floats.len() / 3);
    let (x, y, z) = (array()?, array()?, array()?);
    let mut recording = Recording::new(device, false)?;
    let sizes = WeldSizes { items: floats.len() as u32, ..WeldSizes::default() };
    recording.dispatch(kernel, &sizes, &[&raw, &x, &y, &z], floats.len() as u64)?;
    let back = [recording.read_back(&x)?, recording.read_back(&y)?, recording.read_back(&z)?];
    let submission = recording.submit()?;
    let mut all = Vec::new();
    for axis in back {
        axis.take_into(device, &submission, &mut all)?;
    }
    Ok(all)
}

/// One kernel alone: half-edges that the host has sorted.
fn pairs(device: &Device, kernel: &Kernel, mesh: &Mesh) -> Result<Vec<u32>, GpuError> {
    let corner = |h: u32| mesh.triangles[h as usize / 3][h as usize % 3];
    let mut sorted: Vec<u32> = (0..3 * mesh.triangles.len() as u32).collect();
    sorted.sort_by_key(|&h| {
        let (from, to) = (corner(h), corner(if h % 3 == 2 { h - 2 } else { h + 1 }));
        (from.min(to), from.max(to), from < to)
    });
    let triangles = Buffer::upload(device, "triangles", &mesh.triangles)?;
    let values = Buffer::upload(device, "half-edges", &sorted)?;
    let twin = Buffer::<u32>::zeroed(device, "twin", sorted.len())?;
    let mut recording = Recording::new(device, false)?;
    let sizes = EdgeSizes { half_edges: sorted.len() as u32, padding: [0; 3] };
    recording.dispatch(kernel, &sizes, &[&triangles, &values, &twin], sorted.len() as u64)?;
    let twin = recording.read_back(&twin)?;
    twin.take(device, &recording.submit()?)
}

/// The smallest slips that these kernels could make must show.
fn drifted(bench: &Bench) -> Result<(), Failed> {
    let device = bench.open(Options::default())?;
    let mut random = Random(5);
    let floats: Vec<f32> = (0..3_000)
        .map(|_| {
            f32::from_bits((random.next() as u32 & 0x807f_ffff) | ((100 + random.next() as u32 % 36) << 23))
        })
        .chain([0.007_812_5, -0.007_812_5, 5e-7])
        .collect();
    let nm = |mm: f32| (f64::from(mm) * 1e6).round() as i64 as i32;
    let expected: Vec<i32> = (0..3)
        .flat_map(|axis| floats.iter().skip(axis).step_by(3).map(|&mm| nm(mm)).collect::<Vec<_>>())
        .collect();
    same("points", &corners(&device, &WELD_CORNERS, &floats)?, &expected)?;
    let slips = [
        ("1u << (shift - 1u)", "0u"),
        ("(1u << (shift - 33u))", "0u"),
        ("exponent <= 104u", "exponent <= 112u"),
        ("shift == 32u", "shift == 33u"),
        ("item / 3u", "(item + 1u) / 3u"),
    ];
    for (name, (old, new)) in ["round 1", "round 2", "round 3", "round 4", "round 5"].into_iter().zip(slips) {
        let kernel = changed(&WELD_CORNERS, name, old, new)?;
        let seen = corners(&device, &kernel, &floats)? != expected;
        ensure(seen, format!("'{new}' for '{old}' in weld_corners went unseen"))?;
    }
    // Few vertices, so that most edges are shared by many.
    let mut mesh = soup(60, 3, 9);
    mesh.triangles.iter_mut().flatten().for_each(|v| *v %= 7);
    mesh.triangles.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    let expected = Adjacency::build(&mesh).twin;
    same("twin", &pairs(&device, &EDGE_PAIRS, &mesh)?, &expected)?;
    let slips = [
        ("run_end(place, edge) + rank", "run_end(place, edge)"),
        ("partner < begin", "partner < begin + 1u"),
        ("half_edge % 3u == 2u", "half_edge % 3u == 1u"),
        ("return place + 1u", "return place"),
        ("begin > 0u &&", "begin > 9u &&"),
    ];
    for (name, (old, new)) in ["pair 1", "pair 2", "pair 3", "pair 4", "pair 5"].into_iter().zip(slips) {
        let kernel = changed(&EDGE_PAIRS, name, old, new)?;
        let seen = pairs(&device, &kernel, &mesh)? != expected;
        ensure(seen, format!("'{new}' for '{old}' in edge_pairs went unseen"))?;
    }
    Ok(())
}
