//! Elegoo's `.goo`, format V3.0.
//!
//! Source: "Goo file format specification" V1.2 (<https://github.com/elegooofficial/GOO>), read together
//! with what UVtools (<https://github.com/sn4k3/UVtools>) and mslicer
//! (<https://github.com/connorslade/mslicer>) say of it. Numbers are big-endian, which the specification
//! leaves open. A header of fixed length is followed by the layers, each a record and its runs, and an
//! ending.
//!
//! Printers decode into a picture that they do not clear, so every pixel is covered by a run.

pub mod decode;
pub mod encode;
mod head;
mod read;
mod write;

#[cfg(test)]
mod tests;

pub use read::open;

use super::{Container, LayerSink, Print, WriteSeek};
use crate::mask::{MaskLayer, Panel};
use std::io;

/// The format's name.
pub const NAME: &str = "goo";

/// What a file begins with: the version, then eight bytes that also end it.
pub const SIGNATURE: [u8; 12] = *b"V3.0\x07\0\0\0DLP\0";

/// Writes `.goo` files of version V3.0.
#[derive(Clone, Copy, Debug, Default)]
pub struct Goo;

impl Container for Goo {
    fn name(&self) -> &'static str {
        NAME
    }

    fn preview_size(&self) -> [u32; 2] {
        [290, 290]
    }

    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
        encode::encode(mask, panel.pixels())
    }

    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>> {
        Ok(Box::new(write::Sink::begin(out, print)?))
    }
}
