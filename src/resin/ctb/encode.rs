//! A mask → the runs of a `.ctb` layer, before they are masked by a key.

use crate::mask::MaskLayer;
use crate::resin::words::{SHORT, Words, short};
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

/// Chunks of black of up to [`SHORT`] pixels; those of a grey have it in the lower bits of the first
/// byte.
static BLACK: [u32; SHORT] = {
    let mut table = [0; SHORT];
    let mut length = 1;
    while length < SHORT {
        let [_, _, upper, lower] = (length as u32).to_be_bytes();
        table[length] = match length {
            1 => short([0, 0, 0], 1),
            2..0x80 => short([0x80, lower, 0], 2),
            _ => short([0x80, 0x80 | upper, lower], 3),
        };
        length += 1;
    }
    table
};

/// The grey that is read back for a grey: `v | 1`, and 0 for 1.
pub fn canonical_grey(value: u8) -> u8 {
    if value < 2 { 0 } else { value | 1 }
}

/// The mask with its greys as they are read back, see [`canonical_grey`].
pub fn quantised(mask: &MaskLayer) -> MaskLayer {
    let mut out = MaskLayer { runs: Vec::with_capacity(mask.runs.len()) };
    for run in &mask.runs {
        out.push(run.start, run.end, canonical_grey(run.value));
    }
    out
}

/// Runs of all `pixels` pixels.
pub(super) fn encode(mask: &MaskLayer, pixels: u32) -> Vec<u8> {
    // Greys that become equal are joined.
    let plain = mask.runs.iter().all(|r| r.value == 255);
    let mask = if plain { Cow::Borrowed(mask) } else { Cow::Owned(quantised(mask)) };
    let mut chunks = Words::new(mask.runs.len() * 4 + BLOCK * 2 * CHUNK + SPARE);
    let mut at = 0u32;
    for block in mask.runs.chunks(BLOCK) {
        chunks.make_room(block.len() * 2 * CHUNK + SPARE);
        for run in block {
            // Runs ascend; if they did not, the result would be wrong, and readers would refuse it.
            let (gap, lit) = (run.start.wrapping_sub(at), run.end.wrapping_sub(run.start));
            let grey = run.value >> 1;
            match (BLACK.get(gap as usize), BLACK.get(lit as usize)) {
                (Some(gap), Some(lit)) => {
                    chunks.put_short(*gap, gap >> 24);
                    chunks.put_short(lit | u32::from(grey), lit >> 24);
                }
                _ => {
                    long(&mut chunks, 0, gap);
                    long(&mut chunks, grey, lit);
                }
            }
            at = run.end;
        }
    }
    chunks.make_room(SPARE);
    long(&mut chunks, 0, pixels.saturating_sub(at));
    chunks.done()
}

/// A run of any length: the grey, whose bit 7 says that a length follows. The number of ones that the
/// length begins with is the number of bytes that follow its first.
#[inline(never)]
fn long(chunks: &mut Words, grey: u8, mut length: u32) {
    let grey = u64::from(grey);
    while length > 1 {
        let piece = length.min(LONGEST);
        let bytes = (38 - piece.leading_zeros()) / 7;
        let ones = 0x100 - (0x200 >> bytes);
        let word = (0x80 | grey) << 56 | ones << 48 | u64::from(piece) << (56 - 8 * bytes);
        chunks.put(word, 1 + bytes as usize);
        length -= piece;
    }
    chunks.put(grey << 56, length as usize);
}
