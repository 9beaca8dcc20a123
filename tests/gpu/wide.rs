//! 64-bit arithmetic on pairs of u32, and the fold of a really large dispatch.

use crate::compare::{ensure, same};
use crate::kernels::{DIVIDE, FOLD};
use crate::meshes::Random;
use crate::{Bench, Test};
use libtest_mimic::Failed;
use microtome::gpu::dispatch::Recording;
use microtome::gpu::{Buffer, Device, GpuError};

pub const TESTS: &[Test] = &[
    ("wide_arithmetic_equals_u64", wide),
    ("dispatch_crosses_the_fold", fold),
    ("dispatch_goes_past_65535_groups", really_large),
];

fn wide(bench: &Bench) -> Result<(), Failed> {
    const TOP: u32 = (1 << 31) - 1;
    let mut corners =
        vec![0, 1, 2, 3, 0xfffe, 0xffff, 0x1_0000, 0x1_0001, TOP / 2, TOP / 2 + 1, TOP - 1, TOP];
    corners.extend((0..31).map(|bit| 1u32 << bit));
    let mut operands: Vec<[u32; 3]> = Vec::new();
    for &a in &corners {
        for &b in &corners {
            for &d in corners.iter().filter(|&&d| d >= b && d > 0) {
                operands.push([a, b, d]);
            }
        }
    }
    let mut random = Random(2);
    // Every magnitude equally often: uniform values would hardly ever be short.
    let mut next = || (random.next() as u32 & TOP) >> (random.next() % 31);
    for _ in 0..100_000 {
        let (a, b, d) = (next(), next(), next());
        operands.push([a, b.min(d), b.max(d).max(1)]);
    }
    let device = &*bench.plain()?;
    let input = Buffer::upload(device, "operands", &operands)?;
    let output = Buffer::<[u32; 3]>::zeroed(device, "results", operands.len())?;
    let mut recording = Recording::new(device, false)?;
    let sizes = [operands.len() as u32, 0, 0, 0];
    recording.dispatch(&DIVIDE, &sizes, &[&input, &output], operands.len() as u64)?;
    let results = recording.read_back(&output)?;
    let results = results.take(device, &recording.submit()?)?;
    let expected: Vec<[u32; 3]> = operands
        .iter()
        .map(|&[a, b, d]| {
            let product = u64::from(a) * u64::from(b);
            let fraction = (product + u64::from(d) / 2) / u64::from(d);
            [fraction as u32, product as u32, (product >> 32) as u32]
        })
        .collect();
    match results.iter().zip(&expected).position(|(r, e)| r != e) {
        Some(i) => Err(format!("{:?}: {:?}, expected {:?}", operands[i], results[i], expected[i]).into()),
        None => Ok(()),
    }
}

fn run_fold(device: &Device, items: usize) -> Result<Vec<u32>, GpuError> {
    let buffer = Buffer::<u32>::zeroed(device, "items", items)?;
    let mut recording = Recording::new(device, false)?;
    recording.dispatch(&FOLD, &[items as u32, 0, 0, 0], &[&buffer], items as u64)?;
    let result = recording.read_back(&buffer)?;
    result.take(device, &recording.submit()?)
}

fn expected(items: usize) -> Vec<u32> {
    (0..items as u32).map(|i| i.wrapping_mul(2_654_435_761).wrapping_add(1)).collect()
}

fn fold(bench: &Bench) -> Result<(), Failed> {
    let device = bench.narrow()?;
    for items in [0, 1, 255, 256, 257, 767, 768, 769, 1_536, 1_537, 2_303, 2_304] {
        same(&format!("{items} items"), &run_fold(&device, items)?, &expected(items))?;
    }
    let beyond = run_fold(&device, 2_305);
    ensure(matches!(beyond, Err(GpuError::TooLarge { limit: 9, .. })), "2,305 items should be refused")
}

fn really_large(bench: &Bench) -> Result<(), Failed> {
    let items = 65_536 * 256 + 3;
    same("items", &run_fold(&*bench.plain()?, items)?, &expected(items))
}
