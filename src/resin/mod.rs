//! Masks → the files of resin printers, and back.
//!
//! One file per container behind one trait: [`Container`] writes, [`Reader`] reads. What a printer must
//! be told beside the masks is [`Print`] and, per layer, [`LayerInfo`].

pub mod archive;
pub mod container;
pub mod deflate;
pub mod error;
pub mod layer_files;
pub mod nanodlp;
pub mod png;
pub mod print;
pub mod sl1;
pub mod stack;
pub mod svg;

pub use container::{Container, LayerSink, Reader, WriteSeek};
pub use error::ReadError;
pub use print::{Head, LayerInfo, Motion, Preview, Print, Totals};
