//! Masks → the files of resin printers, and back.
//!
//! One file per container behind one trait: [`Container`] writes, [`Reader`] reads. What a printer must
//! be told beside the masks is [`Print`] and, per layer, [`LayerInfo`].

pub mod archive;
pub mod bytes;
pub mod container;
pub mod ctb;
pub mod date;
pub mod deflate;
pub mod error;
pub mod goo;
pub mod layer_files;
pub mod nanodlp;
mod per_layer;
pub mod png;
pub mod preview;
pub mod print;
pub mod sl1;
pub mod stack;
pub mod svg;
#[cfg(test)]
mod testing;
mod words;

pub use container::{Container, LayerSink, Reader, WriteSeek};
pub use error::ReadError;
pub use print::{Head, LayerInfo, Motion, Preview, Print, Totals};
