//! Writing a `.ctb` file.

use super::sections::{self, Layout};
use super::{Version, key};
use crate::resin::per_layer::differs;
use crate::resin::{LayerInfo, LayerSink, Print, Totals, WriteSeek};
use sha2::{Digest, Sha256};
use std::io::{self, ErrorKind, Read, SeekFrom};

pub(super) struct Sink<'a> {
    out: &'a mut dyn WriteSeek,
    print: &'a Print,
    layout: Layout,
    /// What the file begins with, until the first layer gives the key.
    content: Sha256,
    key: Option<u32>,
    /// The layer table so far.
    table: Vec<u8>,
    written: u32,
    per_layer: bool,
    /// Where the next layer begins.
    at: u64,
    masked: Vec<u8>,
}

impl<'a> Sink<'a> {
    pub(super) fn begin(out: &'a mut dyn WriteSeek, print: &'a Print, version: Version) -> io::Result<Self> {
        let panel = &print.panel;
        let pixels = u64::from(panel.width) * u64::from(panel.height);
        if pixels == 0 || pixels > u64::from(u32::MAX) || print.layers == 0 {
            let reason = format!(
                "a ctb file of {} x {} pixels and {} layers is not possible; it needs at least one layer and between 1 and 2^32 - 1 pixels",
                panel.width, panel.height, print.layers
            );
            return Err(invalid(reason));
        }
        let layout = Layout::new(version, print)?;
        let header = layout.header(print, 0, &Totals::default())?;
        let settings = layout.settings(print, false, &Totals::default())?;
        let mut content = Sha256::new();
        for part in [&header, &layout.previews, &settings] {
            content.update(part);
            out.write_all(part)?;
        }
        let table = u64::from(print.layers) * u64::from(sections::RECORD);
        io::copy(&mut io::repeat(0).take(table), out)?;
        let at = u64::from(layout.table) + table;
        Ok(Self {
            out,
            print,
            layout,
            content,
            key: None,
            table: Vec::new(),
            written: 0,
            per_layer: false,
            at,
            masked: Vec::new(),
        })
    }
}

#[cfg(test)]
impl Sink<'_> {
    /// Leaves a hole in the file, so that the next layer lies at `at`.
    pub(super) fn jump(&mut self, at: u64) {
        self.at = at;
        self.out.seek(SeekFrom::Start(at)).unwrap_or_default();
    }
}

fn invalid(reason: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidInput, reason)
}

impl LayerSink for Sink<'_> {
    fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> io::Result<()> {
        let index = self.written;
        if index >= self.print.layers {
            return Err(invalid(format!("more layers than the {} announced", self.print.layers)));
        }
        let size = u32::try_from(encoded.len() as u64 + u64::from(sections::EXTENDED))
            .map_err(|_| invalid(format!("layer {index} takes {} bytes, above 2^32", encoded.len())))?
            - sections::EXTENDED;
        let key = *self.key.get_or_insert_with(|| {
            self.content.update(encoded);
            key::from_content(self.content.clone())
        });
        self.per_layer |= differs(self.print, index, info);
        let data = self.at + u64::from(sections::EXTENDED);
        let (record, extended) = self.layout.records(info, data, size)?;
        self.table.extend_from_slice(&record);
        self.masked.clear();
        self.masked.extend_from_slice(encoded);
        key::apply(key, index, &mut self.masked);
        self.out.write_all(&extended)?;
        self.out.write_all(&self.masked)?;
        self.at = data + u64::from(size);
        self.written += 1;
        Ok(())
    }

    fn finish(self: Box<Self>, totals: &Totals) -> io::Result<()> {
        let key = match self.key {
            Some(key) if self.written == self.print.layers => key,
            _ => {
                let (written, announced) = (self.written, self.print.layers);
                return Err(invalid(format!("{written} layers were written, {announced} announced")));
            }
        };
        let Self { out, print, layout, .. } = *self;
        out.seek(SeekFrom::Start(0))?;
        out.write_all(&layout.header(print, key, totals)?)?;
        out.seek(SeekFrom::Start(layout.parameters.into()))?;
        // The layer table follows the settings.
        out.write_all(&layout.settings(print, self.per_layer, totals)?)?;
        out.write_all(&self.table)?;
        out.seek(SeekFrom::End(0))?;
        out.flush()
    }
}
