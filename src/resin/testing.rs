//! Prints and masks for tests of containers.
#![allow(clippy::unwrap_used)]

use super::{Container, LayerInfo, Motion, Preview, Print, Totals};
use crate::mask::{MaskLayer, Panel};
use std::io::Cursor;
use std::sync::Arc;

/// A small generator of random test data (SplitMix64, Steele et al. 2014).
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        x ^ x >> 31
    }

    pub(super) fn below(&mut self, n: u32) -> u32 {
        (self.next() % u64::from(n.max(1))) as u32
    }
}

/// Five masks: black, white, random runs of white, of all greys, of greys near to each other.
pub(super) fn masks(random: &mut Random, pixels: u32) -> Vec<MaskLayer> {
    let mut white = MaskLayer::default();
    white.push(0, pixels, 255);
    let mut out = vec![MaskLayer::default(), white];
    for kind in 0..3 {
        let longest = [3, 40, 600][random.below(3) as usize];
        let mut mask = MaskLayer::default();
        let mut at = random.below(longest);
        while at < pixels {
            let end = pixels.min(at + 1 + random.below(longest));
            let value = match kind {
                0 => 255,
                1 => random.below(256),
                _ => 100 + random.below(20),
            };
            mask.push(at, end, value as u8);
            at = end + if random.below(2) == 0 { 0 } else { random.below(longest) };
        }
        out.push(mask);
    }
    out
}

/// A print with two bottom layers and one transition layer.
pub(super) fn print(panel: Panel, layers: u32) -> Print {
    let motion = Motion {
        lift: 3.0,
        lift_speed: 60.0,
        lift2: 5.0,
        lift2_speed: 180.0,
        retract_speed: 200.0,
        retract2: 2.0,
        retract2_speed: 50.0,
        rest_before_lift: 0.5,
        rest_after_lift: 0.25,
        rest_after_retract: 1.5,
    };
    Print {
        name: "part".to_owned(),
        date: 1_700_000_000,
        machine: "TEST Printer 3".to_owned(),
        printer_model: String::new(),
        material: "Resin".to_owned(),
        panel,
        build_height: 250.0,
        layers,
        layer_height: 0.05,
        first_layer_height: 0.05,
        exposure: 2.3,
        bottom_exposure: 30.0,
        bottom_layers: 2,
        transition_layers: 1,
        motion,
        bottom_motion: Motion { lift: 4.0, rest_after_retract: 3.0, ..motion },
        light: 255,
        bottom_light: 250,
        anti_aliasing: 1,
        density: 1.1,
        cost: 30.0,
        config: String::new(),
        preview: Arc::new(Preview { width: 8, height: 4, rgb: (0..96).map(|i| i * 2).collect() }),
    }
}

/// What `print` says of layer `index`.
pub(super) fn info(print: &Print, index: u32) -> LayerInfo {
    let behind = index.saturating_sub(print.bottom_layers) + 1;
    let share = f64::from(behind) / f64::from(print.transition_layers + 1);
    let bottom = index < print.bottom_layers;
    let exposure = if bottom {
        print.bottom_exposure
    } else if share < 1.0 {
        print.bottom_exposure + (print.exposure - print.bottom_exposure) * share
    } else {
        print.exposure
    };
    LayerInfo {
        index,
        z: print.first_layer_height + f64::from(index) * print.layer_height,
        height: if index == 0 { print.first_layer_height } else { print.layer_height },
        exposure,
        motion: if bottom { print.bottom_motion } else { print.motion },
        light: if bottom { print.bottom_light } else { print.light },
        lit: 0,
        area_mm2: 0.0,
    }
}

/// A file of `layers`, and what it was told of each.
pub(super) fn written(
    container: &dyn Container,
    print: &Print,
    layers: &[MaskLayer],
) -> (Vec<u8>, Vec<LayerInfo>) {
    let mut out = Cursor::new(Vec::new());
    let mut sink = container.begin(&mut out, print).unwrap();
    let mut infos = Vec::new();
    for (index, mask) in layers.iter().enumerate() {
        let info = info(print, index as u32);
        sink.layer(&info, &container.encode(mask, &print.panel)).unwrap();
        infos.push(info);
    }
    sink.finish(&Totals { time: 1234.4, volume_ml: 2.5, weight_g: 2.75, cost: 0.075 }).unwrap();
    (out.into_inner(), infos)
}
