//! Writing a `.goo` file.

use super::{SIGNATURE, head};
use crate::resin::per_layer::differs;
use crate::resin::{LayerInfo, LayerSink, Print, Totals, WriteSeek};
use std::io::{self, ErrorKind, SeekFrom};

/// What ends a file: three zero bytes and the latter part of the signature.
pub(super) fn ending() -> [u8; 11] {
    let mut ending = [0; 11];
    for (e, s) in ending.iter_mut().skip(3).zip(SIGNATURE.iter().skip(4)) {
        *e = *s;
    }
    ending
}

pub(super) struct Sink<'a> {
    out: &'a mut dyn WriteSeek,
    print: &'a Print,
    written: u32,
    advance: bool,
}

impl<'a> Sink<'a> {
    pub(super) fn begin(out: &'a mut dyn WriteSeek, print: &'a Print) -> io::Result<Self> {
        let panel = &print.panel;
        if panel.width == 0 || panel.height == 0 || print.layers == 0 {
            let reason = "a goo file needs at least one pixel and one layer";
            return Err(io::Error::new(ErrorKind::InvalidInput, reason));
        }
        let settings = head::settings(print, print.layers, false, &Totals::default())?;
        out.write_all(&head::texts(print)?)?;
        out.write_all(&settings)?;
        Ok(Self { out, print, written: 0, advance: false })
    }
}

impl LayerSink for Sink<'_> {
    fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> io::Result<()> {
        let size = u32::try_from(encoded.len()).map_err(|_| {
            let reason = format!("layer {} takes {} bytes, above 2^32", self.written, encoded.len());
            io::Error::new(ErrorKind::InvalidInput, reason)
        })?;
        self.advance |= differs(self.print, self.written, info);
        self.out.write_all(&head::record(self.print, info, size)?)?;
        self.out.write_all(encoded)?;
        self.out.write_all(&head::DELIMITER)?;
        self.written += 1;
        Ok(())
    }

    fn finish(self: Box<Self>, totals: &Totals) -> io::Result<()> {
        if self.written != self.print.layers {
            let reason = format!("{} layers were written, {} announced", self.written, self.print.layers);
            return Err(io::Error::new(ErrorKind::InvalidInput, reason));
        }
        self.out.write_all(&ending())?;
        self.out.seek(SeekFrom::Start(head::SETTINGS))?;
        self.out.write_all(&head::settings(self.print, self.written, self.advance, totals)?)?;
        self.out.seek(SeekFrom::End(0))?;
        self.out.flush()
    }
}
