//! Whether the values of the header hold for all layers.

use super::{LayerInfo, Print};

/// Whether layer `index` (from 0) is to be printed otherwise than the header alone says. Printers must
/// then be told to follow the layer records.
pub(super) fn differs(print: &Print, index: u32, info: &LayerInfo) -> bool {
    let bottom = index < print.bottom_layers;
    let (exposure, motion, light) = if bottom {
        (print.bottom_exposure, &print.bottom_motion, print.bottom_light)
    } else {
        (print.exposure, &print.motion, print.light)
    };
    let z = (f64::from(index) + 1.0) * print.layer_height;
    // Half a micrometre is below any printer's step.
    info.exposure != exposure || info.motion != *motion || info.light != light || (info.z - z).abs() > 5e-4
}
