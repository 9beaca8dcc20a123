//! The runs of a `.ctb` layer → its mask.

use super::NAME;
use crate::mask::MaskLayer;
use crate::resin::ReadError;

/// The mask of `pixels` pixels of layer `layer`, whose runs are no longer masked by a key.
///
/// # Errors
/// [`ReadError::Damaged`] where a run is cut off, or runs cover more or fewer pixels.
pub(super) fn decode(runs: &[u8], pixels: u32, layer: u32) -> Result<MaskLayer, ReadError> {
    let damaged = |what: &str, value: String, expected: String| ReadError::Damaged {
        format: NAME,
        what: format!("layer {layer}, {what}"),
        value,
        expected,
    };
    let mut mask = MaskLayer::default();
    let mut at = 0u32;
    let mut rest = runs;
    while let [first, behind @ ..] = rest {
        let place = runs.len() - rest.len();
        let mut length = 1;
        rest = behind;
        if first & 0x80 != 0 {
            let cut = || damaged("last run", format!("cut off at byte {place}"), "a whole run".to_owned());
            let [ones, behind @ ..] = behind else { return Err(cut()) };
            let further = ones.leading_ones();
            if further > 3 {
                let what = format!("length of the run at byte {place}");
                return Err(damaged(&what, format!("{ones:#04x}..."), "below 0xf0".to_owned()));
            }
            let (lower, behind) = behind.split_at_checked(further as usize).ok_or_else(cut)?;
            length = lower.iter().fold(u32::from(ones & (0x7F >> further)), |n, b| n << 8 | u32::from(*b));
            rest = behind;
        }
        let end = at.checked_add(length).filter(|end| *end <= pixels).ok_or_else(|| {
            let what = format!("length of the run at byte {place}");
            damaged(&what, length.to_string(), format!("at most the {} pixels left", pixels - at))
        })?;
        let grey = first & 0x7F;
        mask.push(at, end, if grey == 0 { 0 } else { grey << 1 | 1 });
        at = end;
    }
    if at != pixels {
        return Err(damaged("number of pixels covered", at.to_string(), pixels.to_string()));
    }
    Ok(mask)
}
