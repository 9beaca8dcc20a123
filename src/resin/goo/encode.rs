//! A mask → the image of a `.goo` layer.

use crate::mask::MaskLayer;
use crate::resin::words::Words;

/// First byte of an image.
pub(super) const IMAGE: u8 = 0x55;

/// Longest run of one chunk: 28 bits.
pub(super) const LONGEST: u32 = (1 << 28) - 1;

/// Runs whose chunks are written without asking for room in between.
const BLOCK: usize = 512;

/// Most bytes that a run and the gap before it take, while they are not longer than [`LONGEST`].
const RUN: usize = 4 + 5;

/// Room for the at most 32 pieces into which the runs of one mask are split where they are longer.
const SPARE: usize = 32 * 5;

/// The image of a layer of `pixels` pixels: 0x55, chunks that cover every pixel, checksum.
pub fn encode(mask: &MaskLayer, pixels: u32) -> Vec<u8> {
    // Two bytes for most gaps and runs; the buffer grows where that is too little.
    let mut chunks = Chunks(Words::new(mask.runs.len() * 4 + BLOCK * RUN + SPARE));
    chunks.0.make_room(SPARE);
    chunks.0.put(u64::from(IMAGE) << 56, 1);
    let (mut at, mut before) = (0, 0);
    for block in mask.runs.chunks(BLOCK) {
        chunks.0.make_room(block.len() * RUN + SPARE);
        for run in block {
            let start = run.start.min(pixels);
            let gap = start.saturating_sub(at);
            chunks.plain(0, gap);
            if gap > 0 {
                before = 0;
            }
            let end = run.end.min(pixels);
            let lit = end.saturating_sub(start);
            chunks.lit(run.value, before, lit);
            (at, before) = (end, run.value);
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
    /// A run of black or white: type, number of length bytes and the four lowest bits of the length,
    /// then its other bits.
    #[inline(always)]
    fn plain(&mut self, kind: u64, mut length: u32) {
        if length > LONGEST {
            length = self.split(kind, length, |chunks, kind, piece| chunks.plain(kind, piece));
        }
        let further = further(length);
        let first = kind << 6 | u64::from(further) << 4 | u64::from(length & 15);
        let word = first << 56 | u64::from(length >> 4) << (56 - 8 * further);
        // An empty run leaves nothing.
        self.0.put(word, if length == 0 { 0 } else { 1 + further as usize });
    }

    /// A run that is not black, behind one of grey `before`.
    #[inline(always)]
    fn lit(&mut self, value: u8, before: u8, length: u32) {
        if value == 255 {
            self.plain(3, length);
        } else {
            self.grey(value, before, length);
        }
    }

    /// A run of grey: as [`Self::plain`] with the grey behind the first byte, or as the difference to
    /// the grey before, where that is shorter.
    #[inline(always)]
    fn grey(&mut self, value: u8, before: u8, mut length: u32) {
        let mut step = i32::from(value) - i32::from(before);
        if length > LONGEST {
            length = self.split(u64::from(value), length, |chunks, value, piece| {
                chunks.grey(value as u8, 0, piece);
            });
            // The pieces changed what is before.
            step = i32::MAX;
        }
        // Between 2 and 15 pixels both take two bytes, and all readers know the plain one.
        if step.unsigned_abs() <= 15 && (length == 1 || (16..=255).contains(&length)) {
            let several = u64::from(length > 1);
            let first = 0x80 | u64::from(step < 0) << 5 | several << 4 | u64::from(step.unsigned_abs());
            self.0.put(first << 56 | u64::from(length) << 48, 1 + several as usize);
            return;
        }
        let further = further(length);
        let first = 0x40 | u64::from(further) << 4 | u64::from(length & 15);
        let word = first << 56 | u64::from(value) << 48 | u64::from(length >> 4) << (48 - 8 * further);
        self.0.put(word, if length == 0 { 0 } else { 2 + further as usize });
    }

    /// Writes all pieces but the last of a run that is too long for one chunk, and gives that one's
    /// length.
    #[cold]
    fn split(&mut self, kind: u64, mut length: u32, piece: fn(&mut Self, u64, u32)) -> u32 {
        while length > LONGEST {
            piece(self, kind, LONGEST);
            length -= LONGEST;
        }
        length
    }
}

/// Number of length bytes behind the first byte, for lengths up to [`LONGEST`].
#[inline(always)]
fn further(length: u32) -> u32 {
    // Four bits are in the first byte.
    (35 - length.leading_zeros()) / 8
}
