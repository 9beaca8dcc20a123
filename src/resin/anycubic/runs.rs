//! Layer data `pw0`: runs of sixteen greys.
//!
//! The upper half of a byte is the grey, 0..=15, that readers take for `17 * grey` of 255. Black and
//! white are followed by twelve bits of length (the lower half of the byte, then a byte), up to 4095; the
//! other greys by four, up to 15. Longer runs are split, full parts first; runs go on from row to row.

use crate::mask::MaskLayer;

/// Longest run of black or white.
const LONGEST: u32 = 0xFFF;

/// Longest run of another grey.
const LONGEST_GREY: u32 = 15;

/// Bytes behind the runs that [`encode`] hands to the writer and that do not go into the file: lit pixels,
/// then first column, first row, last column and last row of the lit pixels, u32 each.
pub(super) const TRAILER: usize = 20;

/// The grey in 16 levels, 0..=15: the nearest one, so that areas keep their size on the average. (Others cut
/// the lower four bits off; what either has written reads back as it was written.)
pub(super) fn level(grey: u8) -> u8 {
    ((u32::from(grey) * 15 + 127) / 255) as u8
}

/// The grey that a reader gets for a grey: the nearest multiple of 17. 0 and 255 stay what they are, greys
/// below 9 become black.
pub fn canonical_grey(grey: u8) -> u8 {
    level(grey) * 17
}

/// The mask that a reader gets for a mask, see [`canonical_grey`].
pub fn canonical(mask: &MaskLayer) -> MaskLayer {
    let mut out = MaskLayer::default();
    for r in &mask.runs {
        out.push(r.start, r.end, canonical_grey(r.value));
    }
    out
}

/// The runs of a mask, and the trailer.
pub(super) fn encode(mask: &MaskLayer, width: u32, pixels: u32) -> Vec<u8> {
    let mut out = Vec::with_capacity(4 * mask.runs.len() + 2 * (pixels / LONGEST) as usize + 2 + TRAILER);
    let (mut grey, mut length, mut at) = (0, 0, 0);
    let mut add = |out: &mut Vec<u8>, next: u8, more: u32| {
        if next != grey {
            put(out, grey, length);
            (grey, length) = (next, more);
        } else {
            length += more;
        }
    };
    for r in &mask.runs {
        if r.start > at {
            add(&mut out, 0, r.start - at);
        }
        add(&mut out, level(r.value), r.end - r.start);
        at = r.end;
    }
    add(&mut out, 0, pixels.saturating_sub(at));
    put(&mut out, grey, length);
    for number in trailer(mask, width.max(1)) {
        out.extend_from_slice(&number.to_le_bytes());
    }
    out
}

/// Appends one run.
fn put(out: &mut Vec<u8>, grey: u8, length: u32) {
    if length == 0 {
        return;
    }
    if grey == 0 || grey == 15 {
        if length <= LONGEST {
            out.extend_from_slice(&[grey << 4 | (length >> 8) as u8, length as u8]);
            return;
        }
        const PAIRS: usize = 512;
        // Full runs: 0F FF or FF FF.
        const FULL: [[u8; 2 * PAIRS]; 2] = {
            let mut black = [0xFF; 2 * PAIRS];
            let mut i = 0;
            while i < black.len() {
                black[i] = 0x0F;
                i += 2;
            }
            [black, [0xFF; 2 * PAIRS]]
        };
        let full = &FULL[usize::from(grey == 15)];
        let mut left = (length / LONGEST) as usize;
        while left > 0 {
            let now = left.min(PAIRS);
            out.extend_from_slice(&full[..2 * now]);
            left -= now;
        }
        let rest = length % LONGEST;
        if rest > 0 {
            out.extend_from_slice(&[grey << 4 | (rest >> 8) as u8, rest as u8]);
        }
    } else {
        out.resize(out.len() + (length / LONGEST_GREY) as usize, grey << 4 | LONGEST_GREY as u8);
        let rest = length % LONGEST_GREY;
        if rest > 0 {
            out.push(grey << 4 | rest as u8);
        }
    }
}

/// Lit pixels and their bounds, see [`TRAILER`]; all zero for a black mask.
fn trailer(mask: &MaskLayer, width: u32) -> [u32; 5] {
    let (mut lit, mut lo, mut hi) = (0, [u32::MAX; 2], [0; 2]);
    // First pixel of the row that the last run ends in.
    let mut row = 0;
    for r in mask.runs.iter().filter(|r| level(r.value) > 0) {
        lit += r.end - r.start;
        if r.start - row >= width {
            row = r.start - r.start % width;
        }
        let (left, right) = (r.start - row, r.end - 1 - row);
        if lo[1] == u32::MAX {
            lo[1] = row / width;
        }
        lo[0] = lo[0].min(left);
        if right < width {
            hi[0] = hi[0].max(right);
        } else {
            // A run that goes on into the next row touches both borders.
            (lo[0], hi[0]) = (0, width - 1);
            row += right - right % width;
        }
    }
    hi[1] = row / width;
    if lit == 0 { [0; 5] } else { [lit, lo[0], lo[1], hi[0], hi[1]] }
}

/// What is wrong with layer data.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Fault {
    /// The runs cover only so many pixels.
    Short(u64),
    /// The runs cover at least so many pixels.
    Long(u64),
    /// So many bytes follow behind the last pixel.
    Rest(usize),
}

/// The mask of layer data. Empty data is a black layer, and the two bytes of a checksum that early files have
/// behind the last pixel are passed over.
pub(super) fn decode(data: &[u8], pixels: u32) -> Result<MaskLayer, Fault> {
    let mut mask = MaskLayer::default();
    let mut at: u32 = 0;
    let mut bytes = data.iter();
    while at < pixels {
        let Some(&byte) = bytes.next() else { break };
        let (grey, low) = (byte >> 4, u32::from(byte & 15));
        let length = if grey == 0 || grey == 15 {
            let Some(&more) = bytes.next() else { break };
            low << 8 | u32::from(more)
        } else {
            low
        };
        if length > pixels - at {
            return Err(Fault::Long(u64::from(at) + u64::from(length)));
        }
        mask.push(at, at + length, grey * 17);
        at += length;
    }
    let rest = bytes.len();
    match at {
        _ if at < pixels && !data.is_empty() => Err(Fault::Short(at.into())),
        _ if rest > 2 => Err(Fault::Rest(rest)),
        _ => Ok(mask),
    }
}
