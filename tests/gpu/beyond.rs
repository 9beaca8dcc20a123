//! What is out of reach of the layer below: the kernels against their twins, and against the CPU's rows.

use crate::compare::{ensure, same};
use crate::meshes::Random;
use crate::slice::changed;
use crate::{Bench, SIZES, Test};
use libtest_mimic::Failed;
use microtome::gpu::dispatch::{Bind, Recording};
use microtome::gpu::{Buffer, Device, GpuError, Options};
use microtome::lattice::Point2;
use microtome::shaders::{BEYOND_COUNT, BEYOND_FILL, BeyondSizes, Kernel};
use microtome::slice::cpu;
use microtome::span::algebra::sub;
use microtome::span::beyond::pairs::Pairs;
use microtome::span::beyond::{beyond, gpu, half_widths, thick_half_widths, twin};
use microtome::span::morph::dilate_disc;
use microtome::span::{RowFrame, Rows, RowsBuilder, scan};

pub const TESTS: &[Test] = &[
    ("beyond_kernels_equal_their_twins", kernels_equal_twins),
    ("what_hangs_equals_the_rest_of_a_dilation", layers),
    ("beyond_on_few_groups_equals_its_twin", narrow),
    ("a_planted_fault_in_what_hangs_is_seen", planted),
    ("a_drifted_beyond_kernel_is_seen", drifted),
];

/// Counts, offsets and spans as the two kernels leave them.
type Left = (Vec<u32>, Vec<[i32; 2]>);

fn run(device: &Device, kernels: [&Kernel; 2], pairs: &Pairs) -> Result<Left, GpuError> {
    let rows = pairs.places.len();
    let sizes = BeyondSizes { rows: rows as u32, ..BeyondSizes::default() };
    let offset = Buffer::upload(device, "offset", &pairs.offset)?;
    let spans = Buffer::upload(device, "spans", &pairs.spans)?;
    let places = Buffer::upload(device, "places", &pairs.places)?;
    let cover_offset = Buffer::upload(device, "cover offset", &pairs.cover_offset)?;
    let cover = Buffer::upload(device, "cover", &pairs.cover)?;
    let widths = Buffer::upload(device, "widths", &pairs.widths)?;
    let given: [&dyn Bind; 6] = [&offset, &spans, &places, &cover_offset, &cover, &widths];
    let counts = Buffer::<u32>::zeroed(device, "counts", rows)?;
    let mut recording = Recording::new(device, false)?;
    recording.dispatch(kernels[0], &sizes, &[&given[..], &[&counts]].concat(), rows as u64)?;
    let counts = recording.read_back(&counts)?;
    let counts = counts.take(device, &recording.submit()?)?;
    let sums = cpu::scan(&counts);
    let total = sums.last().map_or(0, |&total| total as usize).min(1 << 20);
    let left_offset = Buffer::upload(device, "left offset", &sums)?;
    let left = Buffer::<[i32; 2]>::zeroed(device, "left", total)?;
    let mut recording = Recording::new(device, false)?;
    recording.dispatch(kernels[1], &sizes, &[&given[..], &[&left_offset, &left]].concat(), rows as u64)?;
    let left = recording.read_back(&left)?;
    let left = left.take(device, &recording.submit()?)?;
    Ok((counts, left))
}

fn twins(pairs: &Pairs) -> Left {
    let counts = twin::count(pairs);
    let left = twin::fill(pairs, &cpu::scan(&counts));
    (counts, left)
}

fn random_area(random: &mut Random, rows: usize) -> Rows {
    let mut below = |n: u64| (random.next() % n) as i32;
    let mut out = RowsBuilder::new(below(19) - 9);
    for _ in 0..rows {
        let mut at = below(300) - 300;
        for _ in 0..below(7) {
            let end = at + 1 + below(90);
            out.push(at, end);
            at = end + 1 + below(120);
        }
        out.end_row();
    }
    out.finish()
}

/// Pairs of random areas of so many rows in all, and what is left of them.
fn random_pairs(seed: u64, rows: usize) -> Result<(Pairs, Vec<Rows>), Failed> {
    let mut random = Random(seed);
    let (mut pairs, mut expected) = (Pairs::default(), Vec::new());
    let mut rest = rows;
    while rest > 0 {
        let rows = rest.min(1 + (random.next() % 70) as usize);
        rest -= rows;
        let (a, b) = (random_area(&mut random, rows), random_area(&mut random, rows));
        let (radius, pitch) = ((random.next() % 60) as i64, 1 + (random.next() % 30) as i64);
        let widths = thick_half_widths(radius, pitch, random.next() as u32 % 2);
        ensure(pairs.push(&a, &b, &widths), format!("seed {seed}: refused"))?;
        expected.push(beyond(&a, &b, &widths));
    }
    Ok((pairs, expected))
}

fn check(device: &Device, what: &str, pairs: &Pairs, expected: &[Rows]) -> Result<usize, Failed> {
    let found = gpu::beyond(device, pairs)?;
    ensure(found.len() == expected.len(), format!("{what}: {} areas", found.len()))?;
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        same(&format!("{what}, area {i}"), found.spans(), expected.spans())?;
        for (k, row) in expected.iter() {
            same(&format!("{what}, area {i}, row {k}"), found.row(k), row)?;
        }
    }
    Ok(found.iter().map(|rows| rows.spans().len()).sum())
}

fn kernels_equal_twins(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut spans = 0;
    for (seed, rows) in (1..).zip(SIZES.into_iter().chain([2_047, 2_049, 5_000])) {
        let (pairs, expected) = random_pairs(seed, rows)?;
        let (found, twins) = (run(&device, [&BEYOND_COUNT, &BEYOND_FILL], &pairs)?, twins(&pairs));
        same(&format!("{rows} rows: counts"), &found.0, &twins.0)?;
        same(&format!("{rows} rows: spans"), &found.1, &twins.1)?;
        spans += check(&device, &format!("{rows} rows"), &pairs, &expected)?;
    }
    ensure(spans > 5_000, format!("{spans} spans"))
}

/// A star that grows from layer to layer, on the rows of a frame.
fn star(layer: u32, frame: &RowFrame) -> Rows {
    let corner = |i: u32| {
        let radius = 9e6 + f64::from(layer) * 0.3e6 + if i.is_multiple_of(2) { 0.0 } else { -4e6 };
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 14.0).sin_cos();
        Point2::new((radius * cos) as i32, (radius * sin) as i32)
    };
    let ring: Vec<Point2> = (0..14).map(corner).collect();
    scan([&ring[..]], frame)
}

fn layers(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut left = 0;
    for degrees in [0.0, 45.0, 90.0, 135.0] {
        let frame = RowFrame::new(degrees, 0.0, 100_000.0);
        let stars: Vec<Rows> = (0..12).map(|layer| star(layer, &frame)).collect();
        let (mut pairs, mut expected) = (Pairs::default(), Vec::new());
        for (pair, reach) in stars.windows(2).zip([0.0, 50_000.0, 100_000.0, 200_000.0, 350_000.0].repeat(3))
        {
            let radius = frame.units(reach);
            ensure(pairs.push(&pair[1], &pair[0], &half_widths(radius, frame.pitch())), "refused")?;
            expected.push(sub(&pair[1], &dilate_disc(&pair[0], radius, |k| frame.t(k))));
        }
        left += check(&device, &format!("{degrees} degrees"), &pairs, &expected)?;
    }
    ensure(left > 1_000, format!("{left} spans"))
}

fn narrow(bench: &Bench) -> Result<(), Failed> {
    let device = bench.narrow()?;
    let (pairs, expected) = random_pairs(77, 2_000)?;
    check(&device, "three groups to a dimension", &pairs, &expected).map(drop)
}

fn planted(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let (pairs, expected) = random_pairs(5, 700)?;
    check(&device, "unharmed", &pairs, &expected)?;
    let seen = |pairs: &Pairs| check(&device, "harmed", pairs, &expected).is_err();
    let mut harmed = pairs.clone();
    harmed.cover.iter_mut().for_each(|s| s[1] += 1);
    ensure(seen(&harmed), "longer spans below went unseen")?;
    let mut harmed = pairs.clone();
    harmed.widths.iter_mut().for_each(|w| *w += 1);
    ensure(seen(&harmed), "a wider reach went unseen")?;
    let mut harmed = pairs.clone();
    harmed.places[300].first += 1;
    ensure(seen(&harmed), "another row below went unseen")?;
    let mut harmed = pairs;
    harmed.spans[200][0] -= 1;
    ensure(seen(&harmed), "a longer span went unseen")
}

/// The smallest slips that a kernel could make against its twin must show on random areas.
fn drifted(bench: &Bench) -> Result<(), Failed> {
    let device = bench.open(Options::default())?;
    let (pairs, _) = random_pairs(9, 500)?;
    let expected = twins(&pairs);
    let slips = [
        (0, "beyond 1", "cover[middle].y + by > at", "cover[middle].y + by >= at"),
        (0, "beyond 2", "j <= 2u * place.reach", "j < 2u * place.reach"),
        (0, "beyond 3", "max(covered, span.y + by)", "max(covered, span.y)"),
        (0, "beyond 4", "min(next, span.x - by)", "span.x - by"),
        (0, "beyond 5", "j - place.reach, place.reach - j, j < place.reach", "0u, 0u, j < place.reach"),
        (0, "beyond 6", "left += 1u", "left = 1u"),
        (1, "beyond 7", "min(ahead.y, span.y)", "max(ahead.y, span.y)"),
        (1, "beyond 8", "vec2<i32>(at, end);", "vec2<i32>(span.x, end);"),
        (1, "beyond 9", "left_offset[row];", "left_offset[row + 1u];"),
    ];
    for (which, name, old, new) in slips {
        let mut kernels = [BEYOND_COUNT, BEYOND_FILL];
        kernels[which] = changed(&kernels[which], name, old, new)?;
        // Counts that are wrong would have the second kernel write elsewhere.
        let found = run(&device, [&kernels[0], &kernels[1]], &pairs)?;
        ensure(found != expected, format!("'{new}' in {} went unseen", kernels[which].name))?;
    }
    Ok(())
}
