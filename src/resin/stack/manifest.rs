//! The manifest of a stack of layers, as it stands in JSON.

use super::{Head, LayerFile, LayerInfo, Motion, Print, Totals};
use crate::resin::archive::day_and_time;
use serde::{Deserialize, Serialize};

/// Name of the format.
pub const FORMAT: &str = "microtome layers";
/// Version of the format.
pub const VERSION: u32 = 1;

/// The whole manifest. Lengths \[mm\], times \[s\], unless the name says otherwise.
#[derive(Serialize, Deserialize)]
pub struct Manifest {
    pub format: String,
    pub version: u32,
    /// `png` or `svg`.
    pub layer_format: String,
    generator: String,
    name: String,
    /// UTC.
    date: String,
    machine: String,
    material: String,
    panel: Panel,
    build_height: f64,
    layer_height: f64,
    first_layer_height: f64,
    exposure: f64,
    bottom_exposure: f64,
    bottom_layers: u32,
    transition_layers: u32,
    motion: Moves,
    bottom_motion: Moves,
    totals: Sums,
    pub layers: Vec<Layer>,
}

#[derive(Serialize, Deserialize)]
struct Panel {
    width_px: u32,
    height_px: u32,
    pitch_nm: [i64; 2],
    size: [f64; 2],
    /// Along rows, across them: how the images are stored.
    mirror: [bool; 2],
    /// Rows run along the plate's y.
    portrait: bool,
}

/// Speeds \[mm/min\].
#[derive(Serialize, Deserialize)]
struct Moves {
    lift: [f64; 2],
    lift_speed: [f64; 2],
    retract: [f64; 2],
    retract_speed: [f64; 2],
    rest_before_lift: f64,
    rest_after_lift: f64,
    rest_after_retract: f64,
}

#[derive(Serialize, Deserialize)]
struct Sums {
    time: f64,
    volume_ml: f64,
    weight_g: f64,
    cost: f64,
}

/// One layer.
#[derive(Serialize, Deserialize)]
pub struct Layer {
    pub file: String,
    z: f64,
    height: f64,
    exposure: f64,
    light: u8,
    lit_pixels: u64,
    area_mm2: f64,
}

impl Moves {
    fn new(m: &Motion) -> Self {
        Self {
            lift: [m.lift, m.lift2],
            lift_speed: [m.lift_speed, m.lift2_speed],
            retract: [m.retract(), m.retract2],
            retract_speed: [m.retract_speed, m.retract2_speed],
            rest_before_lift: m.rest_before_lift,
            rest_after_lift: m.rest_after_lift,
            rest_after_retract: m.rest_after_retract,
        }
    }
}

impl Layer {
    /// The layer in `file`.
    pub fn new(file: String, info: &LayerInfo) -> Self {
        Self {
            file,
            z: info.z,
            height: info.height,
            exposure: info.exposure,
            light: info.light,
            lit_pixels: info.lit,
            area_mm2: info.area_mm2,
        }
    }

    /// The layer as it was described.
    pub fn into_file(self, index: u32) -> LayerFile {
        let info = LayerInfo {
            index,
            z: self.z,
            height: self.height,
            exposure: self.exposure,
            motion: Motion::default(),
            light: self.light,
            lit: self.lit_pixels,
            area_mm2: self.area_mm2,
        };
        LayerFile { name: self.file, info }
    }
}

impl Manifest {
    /// The manifest of a finished print.
    pub fn new(print: &Print, svg: bool, totals: &Totals, layers: Vec<Layer>) -> Self {
        let [day, time] = day_and_time(print.date);
        let panel = &print.panel;
        Self {
            format: FORMAT.to_owned(),
            version: VERSION,
            layer_format: if svg { "svg" } else { "png" }.to_owned(),
            generator: concat!("microtome ", env!("CARGO_PKG_VERSION")).to_owned(),
            name: print.name.clone(),
            date: format!("{day}T{time}Z"),
            machine: print.machine.clone(),
            material: print.material.clone(),
            panel: Panel {
                width_px: panel.width,
                height_px: panel.height,
                pitch_nm: [panel.pitch_x, panel.pitch_y],
                size: panel.image_nm().map(|nm| nm as f64 * 1e-6),
                mirror: [panel.mirror_x, panel.mirror_y],
                portrait: panel.portrait,
            },
            build_height: print.build_height,
            layer_height: print.layer_height,
            first_layer_height: print.first_layer_height,
            exposure: print.exposure,
            bottom_exposure: print.bottom_exposure,
            bottom_layers: print.bottom_layers,
            transition_layers: print.transition_layers,
            motion: Moves::new(&print.motion),
            bottom_motion: Moves::new(&print.bottom_motion),
            totals: Sums {
                time: totals.time,
                volume_ml: totals.volume_ml,
                weight_g: totals.weight_g,
                cost: totals.cost,
            },
            layers,
        }
    }

    /// What it says of the container.
    pub fn head(&self, format: &'static str) -> Head {
        Head {
            format,
            machine: self.machine.clone(),
            width: self.panel.width_px,
            height: self.panel.height_px,
            display: Some(self.panel.size),
            mirror: Some(self.panel.mirror),
            layers: self.layers.len() as u32,
            layer_height: self.layer_height,
            exposure: self.exposure,
            bottom_exposure: self.bottom_exposure,
            bottom_layers: self.bottom_layers,
            time: Some(self.totals.time),
            volume_ml: Some(self.totals.volume_ml),
        }
    }
}
