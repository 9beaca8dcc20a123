//! Exclusive prefix sums of any length on the device.

use super::buffer::Buffer;
use super::dispatch::Recording;
use super::{Device, GpuError};
use crate::shaders::{AddSizes, GROUP_SIZE, SCAN_ADD, SCAN_BLOCK, SCAN_BLOCK_LEN, ScanSizes};

/// Memory that a scan works in, kept from one to the next.
#[derive(Default)]
pub struct Scratch {
    /// Per level the sums of its blocks, and these scanned.
    levels: Vec<(Buffer<u32>, Buffer<u32>)>,
}

/// Records the exclusive prefix sums of `values`; `sums` may be one longer and then ends with the total.
///
/// Sums wrap modulo 2^32: a caller for whom that matters looks for a sum below its predecessor, which
/// is certain to be there when one has wrapped.
///
/// # Errors
/// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
pub fn record(
    device: &Device,
    recording: &mut Recording,
    scratch: &mut Scratch,
    values: &Buffer<u32>,
    sums: &Buffer<u32>,
) -> Result<(), GpuError> {
    // Blocks of each level, from the values up, until one block is left.
    let mut lengths = vec![sums.len()];
    while let Some(&len) = lengths.last().filter(|&&len| len > SCAN_BLOCK_LEN as usize) {
        lengths.push(len.div_ceil(SCAN_BLOCK_LEN as usize));
    }
    for (level, &len) in lengths.iter().enumerate() {
        let blocks = len.div_ceil(SCAN_BLOCK_LEN as usize);
        match scratch.levels.get_mut(level) {
            Some((a, b)) => {
                a.resize(device, blocks)?;
                b.resize(device, blocks)?;
            }
            None => scratch.levels.push((
                Buffer::zeroed(device, "block sums", blocks)?,
                Buffer::zeroed(device, "scanned block sums", blocks)?,
            )),
        }
    }
    let levels = &scratch.levels[..lengths.len()];
    let (mut input, mut output) = (values, sums);
    for (block_sums, scanned) in levels {
        let sizes = ScanSizes { input: input.len() as u32, output: output.len() as u32, padding: [0; 2] };
        let lanes = output.len().div_ceil(SCAN_BLOCK_LEN as usize) as u64 * u64::from(GROUP_SIZE);
        recording.dispatch(&SCAN_BLOCK, &sizes, &[input, output, block_sums], lanes)?;
        (input, output) = (block_sums, scanned);
    }
    // Downwards: the topmost level is one block and needs nothing added.
    for level in (0..levels.len().saturating_sub(1)).rev() {
        let target = if level == 0 { sums } else { &levels[level - 1].1 };
        let sizes = AddSizes { sums: target.len() as u32, padding: [0; 3] };
        recording.dispatch(&SCAN_ADD, &sizes, &[&levels[level].1, target], target.len() as u64)?;
    }
    Ok(())
}

/// The kernels in plain Rust.
pub mod twin {
    use crate::shaders::SCAN_BLOCK_LEN;

    /// Twin of `scan_block.wgsl`: exclusive sums within blocks and each block's sum. `values` count as 0
    /// beyond their end; the sums have length `output`.
    pub fn block(values: &[u32], output: usize) -> (Vec<u32>, Vec<u32>) {
        let mut sums = Vec::with_capacity(output);
        let mut block_sums = Vec::new();
        for i in 0..output {
            if i % SCAN_BLOCK_LEN as usize == 0 {
                block_sums.push(0u32);
            }
            let Some(sum) = block_sums.last_mut() else { break };
            sums.push(*sum);
            *sum = sum.wrapping_add(values.get(i).copied().unwrap_or(0));
        }
        (sums, block_sums)
    }

    /// Twin of `scan_add.wgsl`.
    pub fn add(before: &[u32], sums: &mut [u32]) {
        for (block, before) in sums.chunks_mut(SCAN_BLOCK_LEN as usize).zip(before) {
            block.iter_mut().for_each(|sum| *sum = sum.wrapping_add(*before));
        }
    }
}
