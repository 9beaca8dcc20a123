//! Masks as PNG: 8-bit grey, rows unfiltered, written from runs without making pixels; and back.
//!
//! After the PNG specification (W3C, third edition), sections 5 and 7 to 11. A stream from a general
//! encoder is never smaller here: what differs from row to row is a handful of runs, and the cost of long
//! runs is at deflate's bound already.

use super::deflate::{Stretches, zlib};
use super::preview::scaled;
use super::{Preview, ReadError};
use crate::mask::{MaskLayer, Panel};
use png::{BitDepth, ColorType, DecodeOptions, Decoder, DecodingError, Limits, Transformations};
use std::io::{self, Cursor};

/// First bytes of every PNG.
const SIGNATURE: [u8; 8] = [0x89, b'P', b'N', b'G', 0x0D, 0x0A, 0x1A, 0x0A];
/// Longest chunk of data.
const LONGEST_CHUNK: usize = (1 << 31) - 1;
/// Most runs that are read from a layer: 400 MB of them.
pub const MOST_RUNS: usize = 1 << 25;

/// The PNG of a mask. Runs beyond the panel's last pixel are left out.
pub fn encode(mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
    let mut out = Vec::new();
    encode_into(&mut out, mask, panel);
    out
}

/// Appends the PNG of a mask.
pub fn encode_into(out: &mut Vec<u8>, mask: &MaskLayer, panel: &Panel) {
    out.extend_from_slice(&SIGNATURE);
    let mut head = [0; 13];
    head[..4].copy_from_slice(&panel.width.to_be_bytes());
    head[4..8].copy_from_slice(&panel.height.to_be_bytes());
    // 8 bits, grey, the only compression, the only set of filters, not interlaced.
    head[8..].copy_from_slice(&[8, 0, 0, 0, 0]);
    chunk(out, *b"IHDR", |out| out.extend_from_slice(&head));
    let data = out.len();
    let rows = Rows { mask, width: u64::from(panel.width), height: u64::from(panel.height) };
    chunk(out, *b"IDAT", |out| zlib(out, &rows));
    split(out, data, LONGEST_CHUNK);
    chunk(out, *b"IEND", |_| {});
}

/// Splits the last chunk of data, which begins at `at`, where it is longer than chunks may be.
fn split(out: &mut Vec<u8>, at: usize, longest: usize) {
    if out.len() - at - 12 <= longest {
        return;
    }
    let stream = out.split_off(at);
    for part in stream.get(8..stream.len() - 4).unwrap_or(&[]).chunks(longest) {
        chunk(out, *b"IDAT", |out| out.extend_from_slice(part));
    }
}

/// Appends a chunk whose data `write` appends: length, name, data and the check sum of both.
fn chunk(out: &mut Vec<u8>, name: [u8; 4], write: impl FnOnce(&mut Vec<u8>)) {
    let start = out.len();
    out.extend_from_slice(&[0; 4]);
    out.extend_from_slice(&name);
    write(out);
    let length = (out.len() - start - 8) as u32;
    out[start..start + 4].copy_from_slice(&length.to_be_bytes());
    let sum = crc32fast::hash(&out[start + 4..]);
    out.extend_from_slice(&sum.to_be_bytes());
}

/// A mask as the bytes of a PNG's rows: in front of each row its filter, 0, which joins the black pixels
/// around it.
struct Rows<'a> {
    mask: &'a MaskLayer,
    width: u64,
    height: u64,
}

impl Stretches for Rows<'_> {
    #[inline]
    fn visit(&self, mut each: impl FnMut(u64, u8)) {
        if self.width == 0 || self.height == 0 {
            return;
        }
        let pixels = self.width * self.height;
        // The first row's filter.
        let mut zeros = 1;
        let mut row_end = self.width;
        let mut at = 0;
        for run in &self.mask.runs {
            let (mut start, end) = (u64::from(run.start).max(at), u64::from(run.end).min(pixels));
            if start >= end {
                continue;
            }
            zeros += start - at;
            if start >= row_end {
                let rows = (start - row_end) as u32 / self.width as u32 + 1;
                zeros += u64::from(rows);
                row_end += u64::from(rows) * self.width;
            }
            loop {
                if zeros > 0 {
                    each(zeros, 0);
                }
                each(end.min(row_end) - start, run.value);
                if end <= row_end {
                    break;
                }
                start = row_end;
                row_end += self.width;
                zeros = 1;
            }
            zeros = 0;
            at = end;
        }
        zeros += pixels - at + (pixels - row_end) / self.width;
        if zeros > 0 {
            each(zeros, 0);
        }
    }
}

/// The PNG of a preview, scaled.
///
/// # Errors
/// `InvalidInput` where there are no pixels, or too many.
pub fn encode_preview(preview: &Preview, width: u32, height: u32) -> io::Result<Vec<u8>> {
    encode_rgb(&scaled(preview, width, height))
}

/// The PNG of a picture in colours.
fn encode_rgb(preview: &Preview) -> io::Result<Vec<u8>> {
    let mut out = Vec::new();
    let mut encoder = png::Encoder::new(&mut out, preview.width, preview.height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    let wrong = |error: png::EncodingError| io::Error::new(io::ErrorKind::InvalidInput, error.to_string());
    let mut writer = encoder.write_header().map_err(wrong)?;
    writer.write_image_data(&preview.rgb).map_err(wrong)?;
    writer.finish().map_err(wrong)?;
    Ok(out)
}

/// Bytes that a PNG of this many bytes of pixels has at most.
pub fn longest_file(row: u64, rows: u64) -> u64 {
    let plain = row.saturating_add(1).saturating_mul(rows);
    plain.saturating_add(plain / 64).saturating_add(1 << 20)
}

/// How the pixels of a layer lie in the rows of its PNG.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Packing {
    /// Grey; or three pixels in red, green and blue where the picture is a third as wide.
    GreyOrThree,
    /// Grey.
    Grey,
}

/// Names what is being read, for errors.
#[derive(Clone, Copy, Debug)]
pub struct Place<'a> {
    /// The container's format.
    pub format: &'static str,
    /// The member.
    pub name: &'a str,
}

impl Place<'_> {
    /// A field that contradicts the format.
    pub fn damaged(
        &self,
        what: &str,
        value: impl std::fmt::Display,
        expected: impl std::fmt::Display,
    ) -> ReadError {
        ReadError::Damaged {
            format: self.format,
            what: format!("{what} of {}", self.name),
            value: value.to_string(),
            expected: expected.to_string(),
        }
    }

    fn decoding(&self, error: DecodingError, length: usize) -> ReadError {
        match error {
            DecodingError::IoError(error) if error.kind() == io::ErrorKind::UnexpectedEof => {
                ReadError::Truncated { format: self.format, what: self.name.to_owned(), end: length as u64 }
            }
            other => self.damaged("the picture", format!("not readable ({other})"), "a PNG"),
        }
    }
}

/// Width and height that a PNG says it has.
///
/// # Errors
/// [`ReadError`] where it is none.
pub fn size(bytes: &[u8], place: Place<'_>) -> Result<[u32; 2], ReadError> {
    let mut decoder = Decoder::new_with_limits(Cursor::new(bytes), Limits { bytes: 1 << 20 });
    let info = decoder.read_header_info().map_err(|e| place.decoding(e, bytes.len()))?;
    Ok([info.width, info.height])
}

/// The mask in a PNG of `width` by `height` pixels of grey, 1 to 8 bits deep, not interlaced. Never holds
/// more than a few rows of pixels.
///
/// # Errors
/// [`ReadError`] where the PNG is damaged, of another size or kind, or has more than [`MOST_RUNS`] runs.
pub fn decode(
    bytes: &[u8],
    width: u32,
    height: u32,
    packing: Packing,
    place: Place<'_>,
) -> Result<MaskLayer, ReadError> {
    let mut options = DecodeOptions::default();
    options.set_ignore_adler32(false);
    options.set_ignore_text_chunk(true);
    options.set_ignore_iccp_chunk(true);
    let mut decoder = Decoder::new_with_options(Cursor::new(bytes), options);
    decoder.set_limits(Limits { bytes: 1 << 24 });
    decoder.set_transformations(Transformations::EXPAND);
    let failed = |error: DecodingError| place.decoding(error, bytes.len());
    let info = decoder.read_header_info().map_err(failed)?;
    let kind = (info.color_type, info.bit_depth);
    let three = packing == Packing::GreyOrThree && kind == (ColorType::Rgb, BitDepth::Eight);
    let expected = if three { width.div_ceil(3) } else { width };
    if (info.width, info.height) != (expected, height) {
        let value = format!("{} x {}", info.width, info.height);
        return Err(place.damaged("the size", value, format!("{expected} x {height} pixels")));
    }
    let grey = info.color_type == ColorType::Grayscale && info.bit_depth != BitDepth::Sixteen;
    if !(grey || three) || info.interlaced {
        let interlaced = if info.interlaced { ", interlaced" } else { "" };
        let value = format!("{:?}, {} bits{interlaced}", info.color_type, info.bit_depth as u8);
        return Err(place.damaged("the kind of pixels", value, "8 bits of grey, not interlaced"));
    }
    let mut reader = decoder.read_info().map_err(failed)?;
    let length = expected as usize * if three { 3 } else { 1 };
    if reader.output_line_size(expected) != Some(length) {
        return Err(place.damaged("the transparency", "present", "none"));
    }
    let mut mask = MaskLayer::default();
    let mut row = vec![0; length];
    for y in 0..height {
        if reader.read_row(&mut row).map_err(failed)?.is_none() {
            return Err(place.damaged("the number of rows", y, height));
        }
        push_row(&mut mask, y * width, row.get(..width as usize).unwrap_or(&row));
        if mask.runs.len() > MOST_RUNS {
            return Err(place.damaged("the number of runs", format!("above {MOST_RUNS}"), "a mask"));
        }
    }
    reader.finish().map_err(failed)?;
    Ok(mask)
}

/// Appends a row of pixels that begins at pixel `at`.
fn push_row(mask: &mut MaskLayer, at: u32, row: &[u8]) {
    let mut x = 0;
    while let Some(value) = row.get(x) {
        // Whole words first: most pixels are like their neighbours.
        let word = u64::from_ne_bytes([*value; 8]);
        let rest = row.get(x..).unwrap_or(&[]);
        let words = rest.chunks_exact(8).take_while(|c| u64::from_ne_bytes(eight(c)) == word).count();
        let bytes = rest.iter().skip(8 * words).take_while(|v| *v == value).count();
        let end = x + 8 * words + bytes;
        mask.push(at + x as u32, at + end as u32, *value);
        x = end;
    }
}

/// Eight bytes of a slice of eight.
#[inline]
fn eight(bytes: &[u8]) -> [u8; 8] {
    bytes.try_into().unwrap_or([0; 8])
}

#[cfg(test)]
mod tests;
