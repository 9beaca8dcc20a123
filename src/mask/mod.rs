//! Spans → pixel runs of a resin printer's panel.
//!
//! Never holds pixels: a layer is the list of its lit runs in raster order.

pub mod antialias;
pub mod layer;
pub mod layers;
pub mod check;
pub mod panel;
pub mod raster;

pub use antialias::Shading;
pub use layer::{MaskLayer, Run};
pub use layers::{Layers, layers};
pub use panel::Panel;
pub use raster::{Painter, Raster, RasterError};
