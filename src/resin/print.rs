//! What a printer is told beside the masks.

use crate::mask::Panel;
use std::sync::Arc;

/// How the plate moves between two exposures.
///
/// Lengths \[mm\], speeds \[mm/min\], times \[s\]. A lift of `lift + lift2` is taken back by a retract
/// of the same length, of which `retract2` at the second speed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Motion {
    /// First stage of the lift.
    pub lift: f64,
    /// Its speed.
    pub lift_speed: f64,
    /// Second stage of the lift; 0 = none.
    pub lift2: f64,
    /// Its speed.
    pub lift2_speed: f64,
    /// Speed of the first stage of the retract.
    pub retract_speed: f64,
    /// Second stage of the retract; 0 = none.
    pub retract2: f64,
    /// Its speed.
    pub retract2_speed: f64,
    /// Rest after the exposure, before the lift.
    pub rest_before_lift: f64,
    /// Rest at the top.
    pub rest_after_lift: f64,
    /// Rest after the retract, before the exposure.
    pub rest_after_retract: f64,
}

impl Motion {
    /// Length of the first stage of the retract \[mm\].
    pub fn retract(&self) -> f64 {
        (self.lift + self.lift2 - self.retract2).max(0.0)
    }
}

/// A picture of the part, straight from the top left, rows of red, green, blue.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Preview {
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `3 * width * height` bytes.
    pub rgb: Vec<u8>,
}

/// What holds for a whole print. Lengths \[mm\], times \[s\].
#[derive(Clone, Debug)]
pub struct Print {
    /// The model's name without folder and extension; ASCII letters, digits, `-` and `_` only.
    pub name: String,
    /// Seconds since 1970-01-01 UTC that dates in the file are made of.
    pub date: i64,
    /// The printer's full name, such as `ELEGOO Saturn 3 Ultra`, or empty.
    pub machine: String,
    /// `printer_model` that a Prusa compares, such as `SL1S`, or empty.
    pub printer_model: String,
    /// The resin's name, or empty.
    pub material: String,
    /// The panel.
    pub panel: Panel,
    /// Height of the build volume.
    pub build_height: f64,
    /// Number of layers.
    pub layers: u32,
    /// Thickness of all layers but the first.
    pub layer_height: f64,
    /// Thickness of the first layer.
    pub first_layer_height: f64,
    /// Exposure of normal layers.
    pub exposure: f64,
    /// Exposure of bottom layers.
    pub bottom_exposure: f64,
    /// Number of bottom layers.
    pub bottom_layers: u32,
    /// Number of layers behind them whose exposure falls linearly to the normal one.
    pub transition_layers: u32,
    /// Motion behind normal layers.
    pub motion: Motion,
    /// Motion behind bottom layers.
    pub bottom_motion: Motion,
    /// Light of normal layers, 0..=255.
    pub light: u8,
    /// Light of bottom layers, 0..=255.
    pub bottom_light: u8,
    /// Sub-rows of anti-aliasing; 1 = none.
    pub anti_aliasing: u32,
    /// Density of the resin \[g/ml\]; 0 = unknown.
    pub density: f64,
    /// Price of the resin \[money/l\]; 0 = unknown.
    pub cost: f64,
    /// Every setting as `key = value` lines, sorted by key, in PrusaSlicer's syntax.
    pub config: String,
    /// The part, large; containers scale it to the sizes that they store ([`Preview`]).
    pub preview: Arc<Preview>,
}

/// What holds for one layer. Lengths \[mm\], times \[s\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LayerInfo {
    /// Counted from 0.
    pub index: u32,
    /// Height of its upper side over the plate.
    pub z: f64,
    /// Thickness.
    pub height: f64,
    /// Exposure.
    pub exposure: f64,
    /// Motion behind it.
    pub motion: Motion,
    /// Light, 0..=255.
    pub light: u8,
    /// Lit pixels, of any grey.
    pub lit: u64,
    /// Lit area \[mm²\].
    pub area_mm2: f64,
}

/// What is known when all layers are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Totals {
    /// Print time \[s\].
    pub time: f64,
    /// Resin \[ml\].
    pub volume_ml: f64,
    /// Resin \[g\]; 0 where the density is unknown.
    pub weight_g: f64,
    /// Price; 0 where unknown.
    pub cost: f64,
}

/// What a container says of itself, as far as its format does. Lengths \[mm\], times \[s\].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Head {
    /// The format, such as `goo`.
    pub format: &'static str,
    /// The printer's name.
    pub machine: String,
    /// Pixels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Lit area along rows and across them.
    pub display: Option<[f64; 2]>,
    /// The image is stored mirrored along rows, across them.
    pub mirror: Option<[bool; 2]>,
    /// Number of layers.
    pub layers: u32,
    /// Thickness of layers.
    pub layer_height: f64,
    /// Exposure of normal layers.
    pub exposure: f64,
    /// Exposure of bottom layers.
    pub bottom_exposure: f64,
    /// Number of bottom layers.
    pub bottom_layers: u32,
    /// Print time.
    pub time: Option<f64>,
    /// Resin \[ml\].
    pub volume_ml: Option<f64>,
}
