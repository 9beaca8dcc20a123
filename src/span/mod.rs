//! Directed integer edges and a row frame → sorted spans per row; interval algebra.
//!
//! Knows rows and spans, neither pixels nor what a span is for.

pub mod algebra;
pub mod beyond;
pub mod components;
pub mod edges;
pub mod frame;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod morph;
pub mod rings;
pub mod rows;
pub mod scan;
pub mod twin;
pub mod window;

pub use edges::EdgeScan;
pub use frame::{Axis, RowFrame};
pub use rows::{Rows, RowsBuilder, Span};
pub use scan::{Hit, Trace, scan, scan_layers, trace};
pub use window::{RowWindow, WindowError};

#[cfg(test)]
pub(crate) mod tests;
