//! Directed integer edges and a row frame → sorted spans per row; interval algebra.
//!
//! Knows rows and spans, neither pixels nor what a span is for.

pub mod algebra;
pub mod components;
pub mod frame;
pub mod morph;
pub mod rows;
pub mod scan;

pub use frame::RowFrame;
pub use rows::{Rows, RowsBuilder, Span};
pub use scan::{Hit, Trace, scan, trace};

#[cfg(test)]
pub(crate) mod tests;
