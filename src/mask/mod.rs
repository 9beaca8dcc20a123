//! Spans → pixel runs of a resin printer's panel.
//!
//! Never holds pixels: a layer is the list of its lit runs in raster order.

pub mod layer;
pub mod panel;

pub use layer::{MaskLayer, Run};
pub use panel::Panel;
