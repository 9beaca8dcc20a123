//! The checks against searches pixel by pixel, and on shapes that one can think through.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod oracle;
mod shapes;

use super::*;
use crate::mask::{MaskLayer, Panel};
use std::sync::Arc;

/// A stack of small images: `grey(x, y, z)`.
struct Stack {
    panel: Panel,
    /// Per layer the greys, row by row.
    layers: Vec<Vec<u8>>,
}

fn panel(width: u32, height: u32) -> Panel {
    let (pitch_x, pitch_y) = (30_000, 50_000);
    Panel { width, height, pitch_x, pitch_y, mirror_x: false, mirror_y: false, portrait: false }
}

const HEIGHT: f64 = 0.05;

impl Stack {
    fn new(panel: Panel, layers: u32, grey: impl Fn(i32, i32, i32) -> u8) -> Self {
        let image = |z: u32| {
            let pixels = (0..panel.height).flat_map(|y| (0..panel.width).map(move |x| (x, y)));
            pixels.map(|(x, y)| grey(x as i32, y as i32, z as i32)).collect()
        };
        Self { panel, layers: (0..layers).map(image).collect() }
    }

    fn solid(panel: Panel, layers: u32, is_solid: impl Fn(i32, i32, i32) -> bool) -> Self {
        Self::new(panel, layers, |x, y, z| if is_solid(x, y, z) { 255 } else { 0 })
    }

    fn mask(&self, layer: usize) -> MaskLayer {
        let mut mask = MaskLayer::default();
        for (at, &grey) in (0u32..).zip(&self.layers[layer]) {
            mask.push(at, at + 1, grey);
        }
        mask
    }

    /// All layers, checked `batch` at a time.
    fn check(&self, settings: CheckSettings, batch: usize) -> Findings {
        let layer = |i: usize| CheckLayer {
            mask: Arc::new(self.mask(i)),
            z: (i + 1) as f64 * HEIGHT,
            height: HEIGHT,
        };
        let layers: Vec<CheckLayer> = (0..self.layers.len()).map(layer).collect();
        let mut checker = Checker::new(self.panel, settings);
        for some in layers.chunks(batch.max(1)) {
            checker.push(some);
        }
        checker.finish()
    }
}
