//! A mask as a grey picture.

use crate::mask::MaskLayer;
use std::io::{self, Write};

/// Writes a mask of `width` x `height` pixels as an 8-bit grey PNG, holding one row at a time. Runs beyond the
/// last pixel are left out.
///
/// # Errors
/// Those of the writer; `InvalidInput` where the picture has no pixels.
pub fn write(mask: &MaskLayer, width: u32, height: u32, out: impl Write) -> io::Result<()> {
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Grayscale);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::NoFilter);
    let mut header = encoder.write_header().map_err(failed)?;
    let mut stream = header.stream_writer().map_err(failed)?;
    let mut row = vec![0; width as usize];
    let mut runs = mask.runs.iter().peekable();
    for y in 0..u64::from(height) {
        let (first, end) = (y * u64::from(width), (y + 1) * u64::from(width));
        row.fill(0);
        while let Some(run) = runs.peek() {
            let (from, to) = (u64::from(run.start).max(first), u64::from(run.end).min(end));
            if let Some(pixels) = from.checked_sub(first).zip(to.checked_sub(first)).and_then(|(from, to)| {
                // Both are at most the width.
                row.get_mut(from as usize..to as usize)
            }) {
                pixels.fill(run.value);
            }
            if u64::from(run.end) > end {
                break;
            }
            runs.next();
        }
        stream.write_all(&row)?;
    }
    stream.finish().map_err(failed)?;
    header.finish().map_err(failed)
}

fn failed(error: png::EncodingError) -> io::Error {
    match error {
        png::EncodingError::IoError(e) => e,
        other => io::Error::new(io::ErrorKind::InvalidInput, other),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_where_the_runs_are() {
        let mut mask = MaskLayer::default();
        // Over the end of a row, a whole row and more, single pixels, the last pixel.
        for (start, end, value) in [(3, 9, 255), (10, 11, 7), (13, 31, 128), (39, 40, 1)] {
            mask.push(start, end, value);
        }
        let mut bytes = Vec::new();
        write(&mask, 8, 5, &mut bytes).unwrap();
        let picture = image::load_from_memory(&bytes).unwrap().into_luma8();
        assert_eq!(picture.dimensions(), (8, 5));
        let mut expected = vec![0; 40];
        for r in &mask.runs {
            expected[r.start as usize..r.end as usize].fill(r.value);
        }
        assert_eq!(picture.into_raw(), expected);
        let mut black = Vec::new();
        write(&MaskLayer::default(), 8, 5, &mut black).unwrap();
        assert!(image::load_from_memory(&black).unwrap().into_luma8().into_raw().iter().all(|p| *p == 0));
        assert!(write(&mask, 0, 5, Vec::new()).is_err());
    }
}
