//! A mask → the runs of a `.ctb` layer, before they are masked by a key.

use crate::mask::MaskLayer;
use crate::resin::words::Words;
use std::borrow::Cow;

/// Longest run of one chunk: 28 bits.
const LONGEST: u32 = (1 << 28) - 1;

/// Runs whose chunks are written without asking for room in between.
const BLOCK: usize = 512;

/// Most bytes of a chunk.
const CHUNK: usize = 5;

/// Room for the at most 32 pieces into which the runs of one mask are split where they are longer than
/// [`LONGEST`].
const SPARE: usize = 32 * CHUNK;

/// The mask with its greys as they are read back: `v | 1`, and 0 for 1.
pub fn quantised(mask: &MaskLayer) -> MaskLayer {
    let mut out = MaskLayer { runs: Vec::with_capacity(mask.runs.len()) };
    for run in &mask.runs {
        out.push(run.start, run.end, if run.value < 2 { 0 } else { run.value | 1 });
    }
    out
}

/// Runs of all `pixels` pixels.
pub(super) fn encode(mask: &MaskLayer, pixels: u32) -> Vec<u8> {
    // Greys that become equal are joined.
    let plain = mask.runs.iter().all(|r| r.value == 255);
    let mask = if plain { Cow::Borrowed(mask) } else { Cow::Owned(quantised(mask)) };
    let mut chunks = Words::new(mask.runs.len() * 4 + BLOCK * 2 * CHUNK + SPARE);
    let mut at = 0;
    for block in mask.runs.chunks(BLOCK) {
        chunks.make_room(block.len() * 2 * CHUNK + SPARE);
        for run in block {
            let (start, end) = (run.start.min(pixels), run.end.min(pixels));
            put(&mut chunks, 0, start.saturating_sub(at));
            put(&mut chunks, run.value >> 1, end.saturating_sub(start));
            at = end;
        }
    }
    chunks.make_room(CHUNK + SPARE);
    put(&mut chunks, 0, pixels.saturating_sub(at));
    chunks.done()
}

/// A run: the grey, whose bit 7 says that a length follows. The number of ones that the length begins
/// with is the number of bytes that follow its first.
#[inline(always)]
fn put(chunks: &mut Words, grey: u8, mut length: u32) {
    if length > LONGEST {
        length = split(chunks, grey, length);
    }
    let grey = u64::from(grey);
    if length <= 1 {
        chunks.put(grey << 56, length as usize);
        return;
    }
    let bytes = (38 - length.leading_zeros()) / 7;
    let ones = 0x100 - (0x200 >> bytes);
    let word = (0x80 | grey) << 56 | ones << 48 | u64::from(length) << (56 - 8 * bytes);
    chunks.put(word, 1 + bytes as usize);
}

/// Writes all pieces but the last of a run that is too long for one chunk, and gives that one's length.
#[cold]
fn split(chunks: &mut Words, grey: u8, mut length: u32) -> u32 {
    while length > LONGEST {
        put(chunks, grey, LONGEST);
        length -= LONGEST;
    }
    length
}
