//! Reading.

use super::runs::{self, Fault};
use super::tables::{RECORD, TABLE_HEAD, mark_length};
use super::{FORMAT, MAGIC, bits, machine};
use crate::mask::MaskLayer;
use crate::resin::bytes::plain;
use crate::resin::{Head, LayerInfo, Motion, ReadError, Reader};
use std::io::{Read, Seek, SeekFrom};

/// No machine has room for so many layers.
const MOST_LAYERS: u32 = 1_000_000;

/// Opens a file. `extension` (without the dot, in any case) names machines in files that do not name theirs
/// and tells one bit a pixel (`pws`) from sixteen greys.
///
/// # Errors
/// [`ReadError`]; layers are looked at when they are read.
pub fn open<R: Read + Seek + Send + 'static>(
    source: R,
    extension: &str,
) -> Result<Box<dyn Reader>, ReadError> {
    let mut source = Source::new(source)?;
    let mark = source.bytes(0, 24, "the file mark")?;
    if !mark.starts_with(MAGIC) {
        return Err(damaged("the file mark", mark[..8].escape_ascii(), "ANYCUBIC"));
    }
    let version = word(&mark, 12);
    if ![1, 515, 516, 517, 518].contains(&version) {
        return Err(damaged("the file version", version, "1, 515, 516, 517 or 518"));
    }
    let machine_at = (version >= 516).then_some(44);
    let addresses = source.bytes(0, mark_length(version), "the addresses of the tables")?;
    let header = source.table(word(&addresses, 20), "HEADER", 80)?;
    let layers_at = word(&addresses, 36);
    let layers = source.table(layers_at, "LAYERDEF", 4)?;
    let named = match machine_at.map(|at| word(&addresses, at)) {
        Some(at) if at > 0 => Some(source.table(at, "MACHINE", 140)?),
        _ => None,
    };

    let width = word(&header, 44);
    let height = word(&header, 48);
    let pixels = width.checked_mul(height).filter(|p| *p > 0).ok_or_else(|| {
        damaged("the resolution", format!("{width} x {height}"), "less than 2^32 pixels, and at least one")
    })?;
    let count = word(&layers, 0);
    if count > MOST_LAYERS {
        return Err(damaged("the number of layers", count, "at most a million"));
    }
    let (stated, expected) =
        (word(&source.bytes(layers_at, TABLE_HEAD, "table LAYERDEF")?, 12), 4 + RECORD as u32 * count);
    if stated != expected {
        return Err(damaged(
            "table LAYERDEF",
            format!("{stated} bytes long"),
            &format!("{expected} for {count} layers"),
        ));
    }
    let records = source.records(layers_at, count)?;

    let known = machine(extension);
    let name = named.as_ref().map(|m| string(m, 0, 96)).filter(|n| !n.is_empty());
    let kind = named.as_ref().map_or(String::new(), |m| string(m, 96, 16).to_ascii_lowercase());
    let one_bit = kind.starts_with("pws") || (kind.is_empty() && extension.eq_ignore_ascii_case("pws"));
    let anti_aliasing = word(&header, 40);
    if one_bit && !(1..=16).contains(&anti_aliasing) {
        return Err(damaged("the anti-aliasing", anti_aliasing, "1 to 16"));
    }
    let value = |at: usize, what: &str| number(&header, at, what);
    let display = match &named {
        Some(m) => Some([number(m, 120, "the panel's width")?, number(m, 124, "the panel's height")?]),
        None => None,
    };
    let head = Head {
        format: FORMAT,
        machine: name.or(known.map(|m| m.name.to_owned())).unwrap_or_default(),
        width,
        height,
        display,
        mirror: None,
        layers: count,
        layer_height: value(4, "the layer height")?,
        exposure: value(8, "the exposure")?,
        bottom_exposure: value(16, "the bottom exposure")?,
        bottom_layers: value(20, "the number of bottom layers")?.clamp(0.0, f64::from(count)) as u32,
        time: Some(word(&header, 68).into()),
        volume_ml: Some(value(36, "the volume")?),
    };
    let rest = value(12, "the rest before the exposure")?;
    let retract_speed = value(32, "the speed of the retract")? * 60.0;
    let planes = if one_bit { anti_aliasing as u8 } else { 0 };
    Ok(Box::new(File { source, head, pixels, planes, rest, retract_speed, records }))
}

/// A layer's record.
#[derive(Clone, Copy, Debug)]
struct Record {
    address: u32,
    length: u32,
    lift: f32,
    lift_speed: f32,
    exposure: f32,
    height: f32,
    lit: u32,
    /// Upper side over the plate \[mm\].
    top: f64,
}

struct File<R> {
    source: Source<R>,
    head: Head,
    pixels: u32,
    /// Images a layer of one bit a pixel; 0 = sixteen greys.
    planes: u8,
    rest: f64,
    retract_speed: f64,
    records: Vec<Record>,
}

impl<R: Read + Seek + Send> Reader for File<R> {
    fn head(&self) -> &Head {
        &self.head
    }

    fn layer(&mut self, index: u32) -> Result<(MaskLayer, LayerInfo), ReadError> {
        let Some(&r) = self.records.get(index as usize) else {
            return Err(ReadError::NoLayer { index, layers: self.head.layers });
        };
        let finite = |value: f32, what: &str| {
            let name = format!("layer {index}, {what}");
            if value.is_finite() { Ok(plain(value)) } else { Err(damaged(&name, value, "a number")) }
        };
        let info = LayerInfo {
            index,
            z: r.top,
            height: finite(r.height, "its height")?,
            exposure: finite(r.exposure, "its exposure")?,
            motion: Motion {
                lift: finite(r.lift, "its lift")?,
                lift_speed: finite(r.lift_speed, "its lift speed")? * 60.0,
                retract_speed: self.retract_speed,
                rest_after_retract: self.rest,
                ..Motion::default()
            },
            light: 0,
            lit: r.lit.into(),
            area_mm2: 0.0,
        };
        // A run is at most two bytes of one pixel, in each image.
        let most = 2 * u64::from(self.pixels) * u64::from(self.planes.max(1)) + 2;
        if u64::from(r.length) > most {
            let what = format!("layer {index}, the length of its data");
            return Err(damaged(&what, r.length, &format!("at most {most} bytes")));
        }
        let data = self.source.bytes(r.address, r.length as usize, &format!("layer {index}"))?;
        let mask = match self.planes {
            0 => runs::decode(&data, self.pixels),
            planes => bits::decode(&data, self.pixels, planes),
        };
        let mask = mask.map_err(|fault| {
            let what = format!("layer {index} at byte {}", r.address);
            match fault {
                Fault::Short(n) | Fault::Long(n) => {
                    let value =
                        format!("{}{n} pixels long", if n < self.pixels.into() { "" } else { "at least " });
                    damaged(&what, value, &format!("{} pixels", self.pixels))
                }
                Fault::Rest(n) => {
                    damaged(&what, format!("followed by {n} bytes"), "none behind the last pixel")
                }
            }
        })?;
        Ok((mask, info))
    }
}

/// A file of known length. Nothing is read, and no memory taken, before it is clear that the file has it.
struct Source<R> {
    inner: R,
    length: u64,
}

impl<R: Read + Seek> Source<R> {
    fn new(mut inner: R) -> Result<Self, ReadError> {
        let length = inner.seek(SeekFrom::End(0))?;
        Ok(Self { inner, length })
    }

    fn bytes(&mut self, at: u32, length: usize, what: &str) -> Result<Vec<u8>, ReadError> {
        if u64::from(at) + length as u64 > self.length {
            return Err(ReadError::Truncated { format: FORMAT, what: what.to_owned(), end: self.length });
        }
        let mut out = vec![0; length];
        self.inner.seek(SeekFrom::Start(at.into()))?;
        self.inner.read_exact(&mut out)?;
        Ok(out)
    }

    /// The first `length` bytes behind the head of a table.
    fn table(&mut self, at: u32, name: &str, length: usize) -> Result<Vec<u8>, ReadError> {
        let what = format!("table {name}");
        let mut bytes = self.bytes(at, TABLE_HEAD + length, &what)?;
        let found = string(&bytes, 0, 12);
        if found != name {
            return Err(damaged(&format!("the table at byte {at}"), format!("{found:?}"), name));
        }
        let stated = word(&bytes, 12);
        if (stated as usize) < length {
            return Err(damaged(&what, format!("{stated} bytes long"), &format!("at least {length}")));
        }
        bytes.drain(..TABLE_HEAD);
        Ok(bytes)
    }

    fn records(&mut self, table: u32, count: u32) -> Result<Vec<Record>, ReadError> {
        let first = table.saturating_add(TABLE_HEAD as u32 + 4);
        let bytes = self.bytes(first, count as usize * RECORD, "the layer table")?;
        let mut top = 0.0;
        let record = |bytes: &[u8]| {
            let float = |at: usize| f32::from_bits(word(bytes, at));
            let height = float(20);
            if height.is_finite() {
                // To whole nanometres: what was meant before it became an f32.
                top += (f64::from(height) * 1e6).round();
            }
            Record {
                address: word(bytes, 0),
                length: word(bytes, 4),
                lift: float(8),
                lift_speed: float(12),
                exposure: float(16),
                height,
                lit: word(bytes, 24),
                top: top * 1e-6,
            }
        };
        Ok(bytes.chunks_exact(RECORD).map(record).collect())
    }
}

/// The u32 at a place; 0 behind the end, which callers have ruled out.
fn word(bytes: &[u8], at: usize) -> u32 {
    bytes.get(at..).and_then(<[u8]>::first_chunk).map_or(0, |w| u32::from_le_bytes(*w))
}

fn number(bytes: &[u8], at: usize, what: &str) -> Result<f64, ReadError> {
    let value = f32::from_bits(word(bytes, at));
    if value.is_finite() { Ok(plain(value)) } else { Err(damaged(what, value, "a number")) }
}

/// Text up to the first zero.
fn string(bytes: &[u8], at: usize, length: usize) -> String {
    let field = bytes.get(at..at + length).unwrap_or_default();
    let end = field.iter().position(|b| *b == 0).unwrap_or(field.len());
    String::from_utf8_lossy(&field[..end]).chars().filter(|c| !c.is_control()).collect()
}

fn damaged(what: &str, value: impl ToString, expected: &str) -> ReadError {
    ReadError::Damaged {
        format: FORMAT,
        what: what.to_owned(),
        value: value.to_string(),
        expected: expected.to_owned(),
    }
}
