//! Prefix sums.

use crate::compare::{ensure, same};
use crate::meshes::Random;
use crate::{Bench, SIZES, Test};
use libtest_mimic::Failed;
use microtome::gpu::dispatch::Recording;
use microtome::gpu::scan::{Scratch, record, twin};
use microtome::gpu::{Buffer, Device, GpuError};
use microtome::shaders::{AddSizes, GROUP_SIZE, SCAN_ADD, SCAN_BLOCK, SCAN_BLOCK_LEN, ScanSizes};
use microtome::slice::cpu;

pub const TESTS: &[Test] = &[
    ("scan_block_equals_its_twin", block_equals_twin),
    ("scan_add_equals_its_twin", add_equals_twin),
    ("scan_equals_its_twin_at_every_level", whole_equals_twin),
    ("scan_crosses_the_fold", fold),
    ("scan_wraps_like_its_twin", wraps),
    ("scan_reuses_its_scratch", reuse),
];

const BLOCK: usize = SCAN_BLOCK_LEN as usize;

fn values(len: usize, most: u64) -> Vec<u32> {
    let mut random = Random(len as u64);
    (0..len).map(|_| (random.next() % most) as u32).collect()
}

fn block(device: &Device, values: &[u32], output: usize) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
    let input = Buffer::upload(device, "values", values)?;
    let sums = Buffer::<u32>::zeroed(device, "sums", output)?;
    let block_sums = Buffer::<u32>::zeroed(device, "block sums", output.div_ceil(BLOCK))?;
    let sizes = ScanSizes { input: values.len() as u32, output: output as u32, padding: [0; 2] };
    let mut recording = Recording::new(device, false)?;
    let lanes = output.div_ceil(BLOCK) as u64 * u64::from(GROUP_SIZE);
    recording.dispatch(&SCAN_BLOCK, &sizes, &[&input, &sums, &block_sums], lanes)?;
    let (sums, block_sums) = (recording.read_back(&sums)?, recording.read_back(&block_sums)?);
    let submission = recording.submit()?;
    Ok((sums.take(device, &submission)?, block_sums.take(device, &submission)?))
}

fn add(device: &Device, before: &[u32], sums: &[u32]) -> Result<Vec<u32>, GpuError> {
    let before = Buffer::upload(device, "before", before)?;
    let target = Buffer::upload(device, "sums", sums)?;
    let mut recording = Recording::new(device, false)?;
    let sizes = AddSizes { sums: sums.len() as u32, padding: [0; 3] };
    recording.dispatch(&SCAN_ADD, &sizes, &[&before, &target], sums.len() as u64)?;
    let sums = recording.read_back(&target)?;
    let submission = recording.submit()?;
    sums.take(device, &submission)
}

fn whole(device: &Device, scratch: &mut Scratch, counts: &[u32]) -> Result<Vec<u32>, GpuError> {
    let values = Buffer::upload(device, "values", counts)?;
    let sums = Buffer::<u32>::zeroed(device, "sums", counts.len() + 1)?;
    let mut recording = Recording::new(device, false)?;
    record(device, &mut recording, scratch, &values, &sums)?;
    let sums = recording.read_back(&sums)?;
    let submission = recording.submit()?;
    sums.take(device, &submission)
}

fn block_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    for len in SIZES.into_iter().chain([BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 7]) {
        let values = values(len, 1 << 20);
        // As many sums as values, and one more for the total.
        for output in [len, len + 1] {
            let (sums, block_sums) = block(&device, &values, output)?;
            let (twin_sums, twin_block_sums) = twin::block(&values, output);
            same(&format!("sums of {len}"), &sums, &twin_sums)?;
            same(&format!("block sums of {len}"), &block_sums, &twin_block_sums)?;
        }
    }
    Ok(())
}

fn add_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    for len in SIZES.into_iter().chain([BLOCK - 1, BLOCK, BLOCK + 1, 3 * BLOCK + 7]) {
        let mut sums = values(len, 1 << 20);
        let before = values(len.div_ceil(BLOCK), 1 << 30);
        let device_sums = add(&device, &before, &sums)?;
        twin::add(&before, &mut sums);
        same(&format!("sums of {len}"), &device_sums, &sums)?;
    }
    Ok(())
}

fn whole_equals_twin(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let two = BLOCK * BLOCK;
    for len in SIZES.into_iter().chain([BLOCK - 2, BLOCK - 1, BLOCK, 100_000, two - 2, two - 1, two]) {
        let counts = values(len, 900);
        let sums = whole(&device, &mut Scratch::default(), &counts)?;
        same(&format!("scan of {len}"), &sums, &cpu::scan(&counts))?;
    }
    Ok(())
}

fn fold(bench: &Bench) -> Result<(), Failed> {
    let device = bench.narrow()?;
    let most = 9 * BLOCK;
    for len in [3 * BLOCK, 3 * BLOCK + 1, 5 * BLOCK, most - 1, most] {
        let values = values(len, 1 << 20);
        let (sums, block_sums) = block(&device, &values, len)?;
        let (twin_sums, twin_block_sums) = twin::block(&values, len);
        same(&format!("sums of {len}"), &sums, &twin_sums)?;
        same(&format!("block sums of {len}"), &block_sums, &twin_block_sums)?;
    }
    let beyond = block(&device, &values(most + 1, 2), most + 1);
    ensure(matches!(beyond, Err(GpuError::TooLarge { .. })), format!("{beyond:?}"))?;
    let most = 9 * GROUP_SIZE as usize;
    for len in [3 * 256, 3 * 256 + 1, most - 1, most] {
        let mut sums = values(len, 1 << 20);
        let before = values(len.div_ceil(BLOCK), 1 << 30);
        let device_sums = add(&device, &before, &sums)?;
        twin::add(&before, &mut sums);
        same(&format!("added to {len}"), &device_sums, &sums)?;
        let counts = &sums[..len - 1];
        same(
            &format!("scan of {len}"),
            &whole(&device, &mut Scratch::default(), counts)?,
            &cpu::scan(counts),
        )?;
    }
    let beyond = add(&device, &[0, 0], &values(most + 1, 2));
    ensure(matches!(beyond, Err(GpuError::TooLarge { .. })), format!("{beyond:?}"))
}

fn wraps(bench: &Bench) -> Result<(), Failed> {
    let counts = values(3 * BLOCK, 1 << 32);
    let sums = whole(&*bench.plain()?, &mut Scratch::default(), &counts)?;
    ensure(sums.windows(2).any(|w| w[1] < w[0]), "these sums should wrap")?;
    same("wrapped scan", &sums, &cpu::scan(&counts))
}

fn reuse(bench: &Bench) -> Result<(), Failed> {
    let device = bench.plain()?;
    let mut scratch = Scratch::default();
    for len in [10, 5 * BLOCK, 3, 2 * BLOCK, 50_000, 0] {
        let counts = values(len, 900);
        same(&format!("scan of {len}"), &whole(&device, &mut scratch, &counts)?, &cpu::scan(&counts))?;
    }
    Ok(())
}
