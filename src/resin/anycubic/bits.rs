//! Layer data `pws` of the Photon S: runs of one bit, read only.
//!
//! A byte is a run: bit 7 lit, bits 0 to 6 its length. As many whole images follow each other as there are
//! steps of anti-aliasing `n`; a pixel lit in `k` of them has the grey `k * (256 / n) - 1`.

use super::runs::Fault;
use crate::mask::MaskLayer;

/// The mask of layer data with `planes` images, 1..=16.
pub(super) fn decode(data: &[u8], pixels: u32, planes: u8) -> Result<MaskLayer, Fault> {
    // (start, end, number of planes lit), ascending.
    let mut sum: Vec<(u32, u32, u8)> = Vec::new();
    let mut bytes = data.iter();
    for _ in 0..planes {
        let mut plane = Vec::new();
        let mut at: u32 = 0;
        while at < pixels {
            let Some(&byte) = bytes.next() else { return Err(Fault::Short(at.into())) };
            let length = u32::from(byte & 0x7F);
            if length > pixels - at {
                return Err(Fault::Long(u64::from(at) + u64::from(length)));
            }
            if byte & 0x80 != 0 && length > 0 {
                plane.push((at, at + length, 1));
            }
            at += length;
        }
        sum = if sum.is_empty() { plane } else { add(&sum, &plane) };
    }
    if bytes.len() > 2 {
        return Err(Fault::Rest(bytes.len()));
    }
    let step = 256 / u32::from(planes.max(1));
    let mut mask = MaskLayer::default();
    for (start, end, count) in sum {
        mask.push(start, end, (u32::from(count) * step).saturating_sub(1).min(255) as u8);
    }
    Ok(mask)
}

/// The sum of two lists of runs.
fn add(a: &[(u32, u32, u8)], b: &[(u32, u32, u8)]) -> Vec<(u32, u32, u8)> {
    let mut out = Vec::with_capacity(a.len() + b.len());
    let (mut a, mut b) = (a.iter().copied().peekable(), b.iter().copied().peekable());
    let mut at = 0;
    loop {
        let (next_a, next_b) = (a.peek().copied(), b.peek().copied());
        let count = |r: Option<(u32, u32, u8)>| r.filter(|r| r.0 <= at).map_or(0, |r| r.2);
        let border = |r: Option<(u32, u32, u8)>| r.map_or(u32::MAX, |r| if r.0 > at { r.0 } else { r.1 });
        let end = border(next_a).min(border(next_b));
        if end == u32::MAX {
            return out;
        }
        let lit = count(next_a) + count(next_b);
        if lit > 0 {
            out.push((at, end, lit));
        }
        at = end;
        a.next_if(|r| r.1 <= at);
        b.next_if(|r| r.1 <= at);
    }
}
