//! Masks → the files of resin printers, and back.
//!
//! One file per container behind one trait: [`Container`] writes, [`Reader`] reads. What a printer must
//! be told beside the masks is [`Print`] and, per layer, [`LayerInfo`].

pub mod anycubic;
pub mod container;
pub mod error;
pub mod format;
pub mod print;

pub use container::{Container, LayerSink, Reader, WriteSeek};
pub use error::ReadError;
pub use print::{Head, LayerInfo, Motion, Preview, Print, Totals};
