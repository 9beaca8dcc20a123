//! A mask → the image of a `.goo` layer.

use crate::mask::MaskLayer;
use crate::resin::words::{SHORT, Words, short};

/// First byte of an image.
pub(super) const IMAGE: u8 = 0x55;

/// Longest run of one chunk: 28 bits.
const LONGEST: u32 = (1 << 28) - 1;

/// Runs whose chunks are written without asking for room in between.
const BLOCK: usize = 512;

/// Most bytes that a run and the gap before it take, while they are not longer than [`LONGEST`].
const RUN: usize = 4 + 5;

/// Room for the at most 32 pieces into which the runs of one mask are split where they are longer.
const SPARE: usize = 32 * 5;

/// A grey before the first run from which no grey differs by little.
const NOTHING: i32 = 1000;

/// Chunks of black of up to [`SHORT`] pixels; those of white differ in the two highest bits of the
/// first byte, those of grey in one of them and in having the grey behind it.
static BLACK: [u32; SHORT] = {
    let mut table = [0; SHORT];
    let mut length = 1;
    while length < SHORT {
        let [_, _, upper, lower] = (length as u32 >> 4).to_be_bytes();
        let last = length as u8 & 15;
        table[length] = match length {
            1..0x10 => short([last, 0, 0], 1),
            0x10..0x1000 => short([0x10 | last, lower, 0], 2),
            _ => short([0x20 | last, upper, lower], 3),
        };
        length += 1;
    }
    table
};

/// The image of a layer of `pixels` pixels: 0x55, chunks that cover every pixel, checksum.
pub fn encode(mask: &MaskLayer, pixels: u32) -> Vec<u8> {
    // Two bytes for most gaps and runs; the buffer grows where that is too little.
    let mut chunks = Chunks(Words::new(mask.runs.len() * 4 + BLOCK * RUN + SPARE));
    chunks.0.make_room(SPARE);
    chunks.0.put(u64::from(IMAGE) << 56, 1);
    // The first chunk is no difference: not all readers may begin at black.
    let (mut at, mut before) = (0u32, NOTHING);
    for block in mask.runs.chunks(BLOCK) {
        chunks.0.make_room(block.len() * RUN + SPARE);
        for run in block {
            // Runs ascend; if they did not, the result would be wrong, and readers would refuse it.
            let (gap, lit) = (run.start.wrapping_sub(at), run.end.wrapping_sub(run.start));
            if gap > 0 {
                before = 0;
            }
            match (BLACK.get(gap as usize), BLACK.get(lit as usize)) {
                (Some(gap), Some(code)) => {
                    chunks.0.put_short(*gap, gap >> 24);
                    chunks.lit_short(run.value, before, lit, *code);
                }
                _ => chunks.long(gap, lit, run.value, before),
            }
            (at, before) = (run.end, i32::from(run.value));
        }
    }
    chunks.0.make_room(SPARE);
    chunks.plain(0, pixels.saturating_sub(at));
    let mut image = chunks.0.done();
    let sum = checksum(image.get(1..).unwrap_or_default());
    image.push(sum);
    image
}

/// The inverted sum of the bytes of all chunks.
pub(super) fn checksum(chunks: &[u8]) -> u8 {
    !chunks.iter().fold(0, |sum: u8, b| sum.wrapping_add(*b))
}

/// Chunks of one image.
struct Chunks(Words);

impl Chunks {
    /// A lit run of `length` pixels, of which `code` is the chunk if it were black, behind one of grey
    /// `before`.
    #[inline(always)]
    fn lit_short(&mut self, value: u8, before: i32, length: u32, code: u32) {
        if value == 255 {
            self.0.put_short(code | 0xC0, code >> 24);
        } else if !self.difference(value, before, length) {
            let word = code & 0xFF | 0x40 | u32::from(value) << 8 | (code & 0xFF_FF00) << 8;
            self.0.put_short(word, (code >> 24) + 1);
        }
    }

    /// A gap and a lit run, one of which is not in the table.
    #[inline(never)]
    fn long(&mut self, gap: u32, lit: u32, value: u8, before: i32) {
        self.plain(0, gap);
        if value == 255 {
            self.plain(3, lit);
        } else if !self.difference(value, before, lit) {
            self.grey(value, lit);
        }
    }

    /// A run of grey as its difference to the grey before, where that is shorter.
    #[inline(always)]
    fn difference(&mut self, value: u8, before: i32, length: u32) -> bool {
        let step = i32::from(value) - before;
        // Between 2 and 15 pixels both kinds take two bytes, and all readers know the plain one.
        if step.unsigned_abs() > 15 || !(length == 1 || (16..=255).contains(&length)) {
            return false;
        }
        let several = u32::from(length > 1);
        let first = 0x80 | u32::from(step < 0) << 5 | several << 4 | step.unsigned_abs();
        self.0.put_short(first | length << 8, 1 + several);
        true
    }

    /// A run of black or white of any length: type, number of length bytes and the four lowest bits of
    /// the length, then its other bits.
    fn plain(&mut self, kind: u64, length: u32) {
        for piece in pieces(length) {
            let further = further(piece);
            let first = kind << 6 | further << 4 | u64::from(piece & 15);
            self.0.put(first << 56 | u64::from(piece >> 4) << (56 - 8 * further), 1 + further as usize);
        }
    }

    /// A run of grey of any length: as [`Self::plain`], with the grey behind the first byte.
    fn grey(&mut self, value: u8, length: u32) {
        for piece in pieces(length) {
            let further = further(piece);
            let first = 0x40 | further << 4 | u64::from(piece & 15);
            let word = first << 56 | u64::from(value) << 48 | u64::from(piece >> 4) << (48 - 8 * further);
            self.0.put(word, 2 + further as usize);
        }
    }
}

/// Splits a length into such that chunks can hold.
fn pieces(length: u32) -> impl Iterator<Item = u32> {
    let rest = length % LONGEST;
    std::iter::repeat_n(LONGEST, (length / LONGEST) as usize).chain((rest > 0).then_some(rest))
}

/// Number of length bytes behind the first byte, for lengths up to [`LONGEST`].
fn further(length: u32) -> u64 {
    // Four bits are in the first byte.
    u64::from((35 - length.leading_zeros()) / 8)
}
