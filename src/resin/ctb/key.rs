//! The key that layer data is masked with. It hides nothing, but printers expect it.

use sha2::{Digest, Sha256};

/// A key for a file that begins as told to `content`. Never 0, which means "none" and which some
/// printers are said to reject.
pub(super) fn from_content(content: Sha256) -> u32 {
    let [a, b, c, d, ..] = <[u8; 32]>::from(content.finalize());
    // As other writers, no small number and none that is negative where it is taken as signed.
    u32::from_le_bytes([a, b, c, d]) & 0x7FFF_FFFF | 0x100
}

/// XORs the data of layer `index` with the words that follow from `key`: an arithmetic progression
/// whose start and step depend on both. Twice gives back the data.
///
/// The step's constant ends in ...423; the prose of catibo's document prints ...424, its code does not.
pub(super) fn apply(key: u32, index: u32, data: &mut [u8]) {
    let step = key.wrapping_mul(0x2D83_CDAC).wrapping_add(0xD8A8_3423);
    let start = index.wrapping_mul(0x1E15_30CD).wrapping_add(0xEC3D_47CD).wrapping_mul(step);
    // Eight words at a time, which the compiler puts into vector registers.
    let mut lanes = [0u32, 1, 2, 3, 4, 5, 6, 7].map(|i| start.wrapping_add(step.wrapping_mul(i)));
    let (blocks, rest) = data.as_chunks_mut::<32>();
    for block in blocks {
        for (word, lane) in block.as_chunks_mut::<4>().0.iter_mut().zip(&mut lanes) {
            *word = (u32::from_le_bytes(*word) ^ *lane).to_le_bytes();
            *lane = lane.wrapping_add(step.wrapping_mul(8));
        }
    }
    for (byte, mask) in rest.iter_mut().zip(lanes.iter().flat_map(|lane| lane.to_le_bytes())) {
        *byte ^= mask;
    }
}
