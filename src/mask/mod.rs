//! Spans → pixel runs of a resin printer's panel.
//!
//! Never holds pixels: a layer is the list of its lit runs in raster order.

pub mod check;
pub mod layer;
pub mod morph;
pub mod panel;

pub use layer::{MaskLayer, Run};
pub use panel::Panel;
