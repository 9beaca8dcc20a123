//! Masks → the files of resin printers, and back.
//!
//! One file per container behind one trait: [`Container`] writes, [`Reader`] reads. What a printer must
//! be told beside the masks is [`Print`] and, per layer, [`LayerInfo`].

pub mod bytes;
pub mod anycubic;
pub mod container;
pub mod ctb;
pub mod date;
pub mod error;
pub mod machine;
pub mod format;
pub mod print;
pub mod schedule;
pub mod goo;
mod per_layer;
pub mod preview;
#[cfg(test)]
mod testing;
mod words;
pub mod archive;
pub mod deflate;
pub mod layer_files;
pub mod nanodlp;
pub mod png;
pub mod sl1;
pub mod stack;
pub mod svg;

pub use container::{Container, LayerSink, Reader, WriteSeek};
pub use error::ReadError;
pub use print::{Head, LayerInfo, Motion, Preview, Print, Totals};
