//! The image of a `.goo` layer → its mask.

use super::NAME;
use super::encode::{IMAGE, checksum};
use crate::mask::MaskLayer;
use crate::resin::ReadError;

/// The mask of an image of `pixels` pixels, which is that of layer `layer`.
///
/// # Errors
/// [`ReadError::Damaged`] where the image is not one, its checksum is wrong, a chunk is cut off or
/// leaves the range of greys, or the chunks cover more or fewer pixels.
pub fn decode(image: &[u8], pixels: u32, layer: u32) -> Result<MaskLayer, ReadError> {
    let damaged = |what: &str, value: String, expected: String| ReadError::Damaged {
        format: NAME,
        what: format!("layer {layer}, {what}"),
        value,
        expected,
    };
    let [IMAGE, chunks @ .., sum] = image else {
        let found = format!("{:02x?}", image.get(..2).unwrap_or(image));
        return Err(damaged("start of the image", found, format!("{IMAGE:#04x}, chunks and a checksum")));
    };
    let right = checksum(chunks);
    if *sum != right {
        return Err(damaged("checksum", format!("{sum:#04x}"), format!("{right:#04x}")));
    }

    let mut mask = MaskLayer::default();
    let (mut at, mut grey) = (0u32, 0u8);
    let mut rest = chunks;
    while let [first, behind @ ..] = rest {
        let place = 1 + chunks.len() - rest.len();
        let cut = || damaged("last chunk", format!("cut off at byte {place}"), "a whole chunk".to_owned());
        let length;
        if first >> 6 == 2 {
            let step = first & 15;
            let next = if first & 0x20 == 0 { grey.checked_add(step) } else { grey.checked_sub(step) };
            grey = next.ok_or_else(|| {
                let expected = "one that leaves a grey of 0 to 255".to_owned();
                damaged(&format!("difference at byte {place}"), format!("{step} from grey {grey}"), expected)
            })?;
            (length, rest) = match (first & 0x10, behind) {
                (0, _) => (1, behind),
                (_, [length, behind @ ..]) => (u32::from(*length), behind),
                _ => return Err(cut()),
            };
        } else {
            let mut behind = behind;
            grey = match (first >> 6, behind) {
                (0, _) => 0,
                (3, _) => 255,
                (_, [value, after @ ..]) => {
                    behind = after;
                    *value
                }
                _ => return Err(cut()),
            };
            let (upper, after) = behind.split_at_checked(usize::from(first >> 4 & 3)).ok_or_else(cut)?;
            let upper = upper.iter().fold(0, |sum, b| sum << 8 | u32::from(*b));
            (length, rest) = (upper << 4 | u32::from(first & 15), after);
        }
        let end = at.checked_add(length).filter(|end| *end <= pixels).ok_or_else(|| {
            let what = format!("length of the chunk at byte {place}");
            damaged(&what, length.to_string(), format!("at most the {} pixels left", pixels - at))
        })?;
        mask.push(at, end, grey);
        at = end;
    }
    if at != pixels {
        return Err(damaged("number of pixels covered", at.to_string(), pixels.to_string()));
    }
    Ok(mask)
}
