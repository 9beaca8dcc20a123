//! Writing.

use super::machines::{Machine, machine};
use super::{FORMAT, runs, tables};
use crate::mask::{MaskLayer, Panel};
use crate::resin::{Container, LayerInfo, LayerSink, Print, Totals, WriteSeek};
use std::io::{self, SeekFrom};
use tables::{Addresses, RECORD, TABLE_HEAD};

/// Anycubic's binary format, for one machine.
#[derive(Clone, Copy, Debug)]
pub struct Anycubic {
    machine: &'static Machine,
    version: u32,
}

impl Anycubic {
    /// The format of an extension (without the dot, in any case); `None` where it is not of the family or can
    /// only be read.
    pub fn new(extension: &str) -> Option<Self> {
        let machine = machine(extension)?;
        Some(Self { machine, version: machine.writes? })
    }

    /// The file version that is written.
    pub fn version(&self) -> u32 {
        self.version
    }
}

impl Container for Anycubic {
    fn name(&self) -> &'static str {
        FORMAT
    }

    fn preview_size(&self) -> [u32; 2] {
        [224, 168]
    }

    fn losses(&self, print: &Print) -> Vec<String> {
        let mut losses = Vec::new();
        let motions = [print.motion, print.bottom_motion];
        if motions.iter().any(|m| m.rest_before_lift > 0.0 || m.rest_after_lift > 0.0) {
            losses.push(format!("{}: holds no rests but the one before the exposure", self.name()));
        }
        if [print.light, print.bottom_light] != [u8::MAX; 2] {
            losses.push(format!("{}: holds no light; the printer uses its own", self.name()));
        }
        losses
    }

    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
        runs::encode(mask, panel.width, panel.pixels())
    }

    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>> {
        let version = self.version;
        // Counts, volume and the layers' places are filled in at the end; their length is known now.
        let mut head = vec![0; tables::mark_length(version)];
        let mut at = Addresses::default();
        let mut append = |bytes: &[u8]| -> io::Result<u32> {
            let address = address(head.len() as u64)?;
            head.extend_from_slice(bytes);
            Ok(address)
        };
        at.header = append(&tables::header(version, print, &Totals::default()))?;
        at.preview = append(&tables::preview(version, print))?;
        if version >= 516 {
            at.greys = append(&tables::greys())?;
        }
        at.layers = append(&layer_table(print.layers)?)?;
        append(&vec![0; print.layers as usize * RECORD])?;
        if version >= 516 {
            at.extra = append(&tables::extra(print))?;
            at.machine = append(&tables::machine(version, self.machine, print))?;
        }
        if version >= 517 {
            at.software = append(&tables::software())?;
            at.model = append(&tables::model(print, [0; 4], 0.0))?;
        }
        at.data = address(head.len() as u64)?;
        let mark = tables::mark(version, &at);
        head[..mark.len()].copy_from_slice(&mark);
        let start = out.stream_position()?;
        out.write_all(&head)?;
        let end = head.len() as u64;
        Ok(Box::new(Sink {
            out,
            print,
            version,
            at,
            start,
            end,
            records: Vec::new(),
            bounds: None,
            top: 0.0,
        }))
    }
}

/// A file being written. Holds 32 bytes a layer.
struct Sink<'a> {
    out: &'a mut dyn WriteSeek,
    print: &'a Print,
    version: u32,
    at: Addresses,
    /// Where the file begins in the stream.
    start: u64,
    /// Where the next layer begins in the file.
    end: u64,
    records: Vec<u8>,
    /// First column and row of all lit pixels, and those behind the last.
    bounds: Option<[u32; 4]>,
    top: f64,
}

impl LayerSink for Sink<'_> {
    fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> io::Result<()> {
        if self.records.len() / RECORD >= self.print.layers as usize {
            return Err(invalid(format!("more than the {} layers announced", self.print.layers)));
        }
        let Some((data, trailer)) = encoded.split_last_chunk::<{ runs::TRAILER }>() else {
            return Err(invalid("layer data that this format has not encoded".to_owned()));
        };
        let (words, _) = trailer.as_chunks::<4>();
        let number = |i: usize| words.get(i).map_or(0, |w| u32::from_le_bytes(*w));
        let lit = number(0);
        if lit > 0 {
            let [left, top, right, bottom] = self.bounds.unwrap_or([u32::MAX, u32::MAX, 0, 0]);
            self.bounds = Some([
                left.min(number(1)),
                top.min(number(2)),
                right.max(number(3) + 1),
                bottom.max(number(4) + 1),
            ]);
        }
        let length = address(data.len() as u64)?;
        let place = address(self.end)?;
        tables::record(&mut self.records, [place, length, lit], &info.motion, [info.exposure, info.height]);
        self.top = info.z;
        self.end += u64::from(length);
        self.out.write_all(data)
    }

    fn finish(self: Box<Self>, totals: &Totals) -> io::Result<()> {
        let written = self.records.len() / RECORD;
        if written != self.print.layers as usize {
            return Err(invalid(format!("{written} layers instead of the {} announced", self.print.layers)));
        }
        let mut patch = |address: u32, bytes: &[u8]| {
            self.out.seek(SeekFrom::Start(self.start + u64::from(address)))?;
            self.out.write_all(bytes)
        };
        patch(self.at.header, &tables::header(self.version, self.print, totals))?;
        patch(self.at.layers + TABLE_HEAD as u32 + 4, &self.records)?;
        if self.version >= 517 {
            let bounds = self.bounds.unwrap_or_default();
            patch(self.at.model, &tables::model(self.print, bounds, self.top))?;
        }
        self.out.seek(SeekFrom::Start(self.start + self.end))?;
        self.out.flush()
    }
}

/// Name, length and count of the layer table; the records follow.
fn layer_table(layers: u32) -> io::Result<Vec<u8>> {
    let length = address(u64::from(layers) * RECORD as u64 + 4)?;
    let mut out = tables::table("LAYERDEF", 0);
    out.truncate(TABLE_HEAD - 4);
    out.extend_from_slice(&length.to_le_bytes());
    out.extend_from_slice(&layers.to_le_bytes());
    Ok(out)
}

/// A place in the file; they are stored in 32 bits.
fn address(place: u64) -> io::Result<u32> {
    u32::try_from(place).map_err(|_| {
        invalid("more than 4 GiB, which this format cannot hold; print fewer or thicker layers".to_owned())
    })
}

fn invalid(what: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, format!("{FORMAT}: {what}"))
}
