//! NanoDLP plates: `.nanodlp`, format version 2.
//!
//! A zip of `meta.json`, `plate.json`, `profile.json`, `info.json`, `options.json` (the same as
//! `slicer.json`), the preview `3d.png`, and the layers `1.png` to `N.png` of 8-bit grey. After
//! <https://docs.nanodlp.com/manual/format> and the fields that UVtools 5 reads. Lengths are micrometres
//! in some fields and millimetres in others, as named. Pictures with three pixels in red, green and blue
//! are read as well.

use super::archive::{LONGEST_TEXT, Members, ZipSink, damaged};
use super::layer_files::{Kind, LayerFile, LayerFiles};
use super::png::{self, Packing};
use super::{Container, Head, LayerInfo, LayerSink, Print, ReadError, Totals, WriteSeek};
use crate::mask::{MaskLayer, Panel};
use serde_json::{Value, json};
use std::io;

/// Member that describes the plate.
pub const PLATE: &str = "plate.json";
/// Most layers that are read.
const MOST_LAYERS: u64 = 1 << 20;

/// The format.
#[derive(Clone, Copy, Debug, Default)]
pub struct NanoDlp;

/// Pixels from (left, top) to (right, bottom), these last ones included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Bounds {
    left: u32,
    top: u32,
    right: u32,
    bottom: u32,
}

impl Bounds {
    /// The bounds of a mask's lit pixels.
    fn new(mask: &MaskLayer, width: u32) -> Option<Self> {
        let width = width.max(1);
        let first = mask.runs.first()?;
        let last = mask.runs.last()?;
        let mut bounds = Self {
            left: u32::MAX,
            top: first.start / width,
            right: 0,
            bottom: last.end.saturating_sub(1) / width,
        };
        for run in &mask.runs {
            let (left, right) = (run.start % width, run.end.saturating_sub(1) % width);
            // A run over the end of a row has the row's last pixel and the first of the next.
            let over = right < left || run.end - run.start > width;
            bounds.left = bounds.left.min(if over { 0 } else { left });
            bounds.right = bounds.right.max(if over { width - 1 } else { right });
        }
        Some(bounds)
    }

    fn join(self, other: Option<Self>) -> Self {
        other.map_or(self, |o| Self {
            left: self.left.min(o.left),
            top: self.top.min(o.top),
            right: self.right.max(o.right),
            bottom: self.bottom.max(o.bottom),
        })
    }
}

impl Container for NanoDlp {
    fn name(&self) -> &'static str {
        "nanodlp"
    }

    /// The bounds of what is lit (16 bytes, zeros where nothing is), then the PNG: the description of the
    /// layers needs both.
    fn preview_size(&self) -> [u32; 2] {
        [607, 487]
    }

    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
        let none = Bounds { left: 1, top: 0, right: 0, bottom: 0 };
        let bounds = Bounds::new(mask, panel.width).unwrap_or(none);
        let mut out = Vec::new();
        for value in [bounds.left, bounds.top, bounds.right, bounds.bottom] {
            out.extend_from_slice(&value.to_le_bytes());
        }
        png::encode_into(&mut out, mask, panel);
        out
    }

    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>> {
        let mut zip = ZipSink::new(out, print.date);
        let meta = json!({
            "FormatVersion": 2,
            "Distro": "generic",
            "Program": "microtome",
            "Version": env!("CARGO_PKG_VERSION"),
            "OS": "",
            "Arch": "",
            "Profile": false,
        });
        put(&mut zip, "meta.json", &meta)?;
        put(&mut zip, "profile.json", &profile(print))?;
        let options = options(print);
        put(&mut zip, "options.json", &options)?;
        put(&mut zip, "slicer.json", &options)?;
        zip.put("3d.png", &png::encode_preview(&print.preview, 607, 487)?)?;
        Ok(Box::new(NanoDlpSink { zip, print, layers: Vec::new(), bounds: None, top: 0.0 }))
    }
}

fn put(zip: &mut ZipSink<'_>, name: &str, value: &Value) -> io::Result<()> {
    zip.put(name, &serde_json::to_vec(value)?)
}

/// How the resin is to be cured.
fn profile(print: &Print) -> Value {
    let (motion, bottom) = (&print.motion, &print.bottom_motion);
    json!({
        "ResinID": 0,
        "ProfileID": 0,
        "Title": if print.material.is_empty() { "microtome" } else { &print.material },
        "ResinPrice": print.cost,
        "Depth": micrometres(print.layer_height),
        "SupportDepth": micrometres(print.first_layer_height),
        "CureTime": print.exposure,
        "SupportCureTime": print.bottom_exposure,
        "SupportLayerNumber": print.bottom_layers,
        "TransitionalLayer": print.transition_layers,
        "WaitHeight": motion.lift + motion.lift2,
        "SupportWaitHeight": bottom.lift + bottom.lift2,
        "WaitBeforePrint": motion.rest_after_retract,
        "SupportWaitBeforePrint": bottom.rest_after_retract,
        "WaitAfterPrint": motion.rest_before_lift,
        "SupportWaitAfterPrint": bottom.rest_before_lift,
        "TopWait": motion.rest_after_lift,
        "SupportTopWait": bottom.rest_after_lift,
        "CustomValues": {
            "UvPwmValue": (f64::from(print.light) / 255.0).to_string(),
            "ZLiftDistance": (motion.lift + motion.lift2).to_string(),
        },
        "FillColor": "#ffffff",
        "BlankColor": "#000000",
        "Updated": print.date,
    })
}

/// How the plate was sliced.
fn options(print: &Print) -> Value {
    let panel = &print.panel;
    let [x, y] = [panel.pitch_x, panel.pitch_y].map(|nm| nm as f64 * 1e-6);
    json!({
        "Type": "stl",
        "PWidth": panel.width,
        "PHeight": panel.height,
        "Thickness": micrometres(print.layer_height),
        "SupportDepth": micrometres(print.first_layer_height),
        "SupportLayerNumber": print.bottom_layers,
        "XOffset": f64::from(panel.width) / 2.0,
        "YOffset": f64::from(panel.height) / 2.0,
        "XPixelSize": x,
        "YPixelSize": y,
        "XRes": panel.pitch_x as f64 / 1000.0,
        "YRes": panel.pitch_y as f64 / 1000.0,
        "AntiAlias": print.anti_aliasing,
        "ImageMirror": u8::from(panel.mirror_x || panel.mirror_y),
        "DisplayController": 1,
        "FillColor": "#ffffff",
        "BlankColor": "#000000",
        "LayerCount": print.layers,
    })
}

/// Millimetres as micrometres, to the nanometre.
fn micrometres(mm: f64) -> f64 {
    (mm * 1e6).round() / 1e3
}

struct NanoDlpSink<'a> {
    zip: ZipSink<'a>,
    print: &'a Print,
    layers: Vec<(f64, Option<Bounds>)>,
    bounds: Option<Bounds>,
    top: f64,
}

impl LayerSink for NanoDlpSink<'_> {
    fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> io::Result<()> {
        let Some((head, picture)) = encoded.split_first_chunk::<16>() else {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "nanodlp: a layer without its bounds"));
        };
        let mut fields = head.chunks_exact(4).map(|c| c.try_into().map_or(0, u32::from_le_bytes));
        let mut field = || fields.next().unwrap_or(0);
        let bounds = Bounds { left: field(), top: field(), right: field(), bottom: field() };
        let bounds = Some(bounds).filter(|b| b.left <= b.right);
        self.bounds = bounds.map(|b| b.join(self.bounds)).or(self.bounds);
        self.layers.push((info.area_mm2, bounds));
        self.top = self.top.max(info.z);
        self.zip.put(&format!("{}.png", self.layers.len()), picture)
    }

    fn finish(mut self: Box<Self>, totals: &Totals) -> io::Result<()> {
        let [x, y] = self.bounds.map_or([[0.0; 2]; 2], |b| on_plate(b, &self.print.panel));
        let plate = json!({
            "PlateID": 0,
            "ProfileID": 0,
            "CreatedDate": self.print.date,
            "Updated": self.print.date,
            "Path": self.print.name,
            "LayersCount": self.layers.len(),
            "TotalSolidArea": totals.volume_ml,
            "PrintTime": totals.time.round(),
            "PrintEst": totals.time.round(),
            "XMin": x[0],
            "XMax": x[1],
            "YMin": y[0],
            "YMax": y[1],
            "ZMin": 0.0,
            "ZMax": self.top,
            "Processed": true,
        });
        // The areas of a layer are not told apart: it is described as one.
        let layers = self.layers.iter().map(|(area, bounds)| {
            let edge = |of: fn(&Bounds) -> u32| bounds.as_ref().map_or(0, of);
            json!({
                "TotalSolidArea": area,
                "LargestArea": area,
                "SmallestArea": area,
                "MinX": edge(|b| b.left),
                "MinY": edge(|b| b.top),
                "MaxX": edge(|b| b.right),
                "MaxY": edge(|b| b.bottom),
                "AreaCount": u8::from(bounds.is_some()),
            })
        });
        let info = Value::Array(layers.collect());
        put(&mut self.zip, PLATE, &plate)?;
        put(&mut self.zip, "info.json", &info)?;
        self.zip.finish()
    }
}

/// From and to along the plate's x and y, from its centre \[mm\].
fn on_plate(b: Bounds, panel: &Panel) -> [[f64; 2]; 2] {
    let span = |from: u32, to: u32, size: u32, pitch: i64, turned: bool| {
        let [from, to] = [f64::from(from), f64::from(to) + 1.0]
            .map(|edge| (edge - f64::from(size) / 2.0) * pitch as f64 * 1e-6);
        if turned { [-to, -from] } else { [from, to] }
    };
    let along = span(b.left, b.right, panel.width, panel.pitch_x, panel.mirror_x);
    // Rows begin at the far side, unless mirrored.
    let across = span(b.top, b.bottom, panel.height, panel.pitch_y, !panel.mirror_y);
    if panel.portrait { [across, along] } else { [along, across] }
}

/// Reads the descriptions of an archive.
///
/// # Errors
/// [`ReadError`] where fields or layers are missing or damaged.
pub fn open(mut members: Box<dyn Members>) -> Result<LayerFiles, ReadError> {
    let meta = read_json(members.as_mut(), "meta.json")?;
    let plate = read_json(members.as_mut(), PLATE)?;
    let options = if members.has("slicer.json") { "slicer.json" } else { "options.json" };
    let options = read_json(members.as_mut(), options)?;
    let profile =
        if members.has("profile.json") { read_json(members.as_mut(), "profile.json")? } else { Value::Null };
    let version = number(&meta, "FormatVersion")?;
    if !(1.0..=2.0).contains(&version) {
        return Err(damaged("nanodlp", "FormatVersion", version, "1 or 2"));
    }
    let mut layers = number(&plate, "LayersCount")? as u64;
    if layers == 0 {
        layers = (1..=MOST_LAYERS).take_while(|i| members.has(&format!("{i}.png"))).count() as u64;
    }
    if layers == 0 || layers > MOST_LAYERS {
        return Err(damaged("nanodlp", "LayersCount", layers, format!("1 to {MOST_LAYERS}")));
    }
    let thickness = number(&options, "Thickness")?;
    let layer_height = if thickness > 0.0 { thickness } else { number(&profile, "Depth")? } / 1000.0;
    let [width, height] = [number(&options, "PWidth")?, number(&options, "PHeight")?];
    let pixel = [number(&options, "XPixelSize")?, number(&options, "YPixelSize")?];
    let mut files = Vec::new();
    for index in 0..layers as u32 {
        let name = format!("{}.png", index + 1);
        if !members.has(&name) {
            return Err(damaged("nanodlp", &format!("picture {name}"), "missing", "present"));
        }
        let z = layer_height * (f64::from(index) + 1.0);
        let info = LayerInfo { index, z, height: layer_height, ..LayerInfo::default() };
        files.push(LayerFile { name, info });
    }
    let head = Head {
        format: "nanodlp",
        machine: String::new(),
        width: width as u32,
        height: height as u32,
        display: (pixel[0] > 0.0 && pixel[1] > 0.0).then(|| [width * pixel[0], height * pixel[1]]),
        mirror: None,
        layers: layers as u32,
        layer_height,
        exposure: number(&profile, "CureTime")?,
        bottom_exposure: number(&profile, "SupportCureTime")?,
        bottom_layers: number(&profile, "SupportLayerNumber")? as u32,
        time: Some(number(&plate, "PrintTime")?).filter(|t| *t > 0.0),
        volume_ml: Some(number(&plate, "TotalSolidArea")?).filter(|v| *v > 0.0),
    };
    LayerFiles::new(head, members, files, Kind::Png(Packing::GreyOrThree))
}

fn read_json(members: &mut dyn Members, name: &str) -> Result<Value, ReadError> {
    // A tree takes several times the text's memory.
    let bytes = members.read(name, LONGEST_TEXT / 4)?;
    serde_json::from_slice(&bytes)
        .map_err(|e| damaged("nanodlp", name, format!("not readable ({e})"), "JSON"))
}

/// A number that is not negative; 0 where it is missing.
fn number(of: &Value, key: &str) -> Result<f64, ReadError> {
    match of.get(key) {
        None | Some(Value::Null) => Ok(0.0),
        Some(value) => value
            .as_f64()
            .filter(|v| (0.0..=4294967295.0).contains(v))
            .ok_or_else(|| damaged("nanodlp", key, value, "a number from 0")),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_those_of_the_pixels() {
        let mut mask = MaskLayer::default();
        assert_eq!(Bounds::new(&mask, 10), None);
        mask.push(13, 15, 255);
        mask.push(22, 24, 255);
        assert_eq!(Bounds::new(&mask, 10), Some(Bounds { left: 2, top: 1, right: 4, bottom: 2 }));
        mask.push(38, 42, 9);
        assert_eq!(Bounds::new(&mask, 10), Some(Bounds { left: 0, top: 1, right: 9, bottom: 4 }));
    }

    #[test]
    fn bounds_lie_on_the_plate() {
        let mut panel = Panel {
            width: 10,
            height: 4,
            pitch_x: 1_000_000,
            pitch_y: 2_000_000,
            mirror_x: false,
            mirror_y: false,
            portrait: false,
        };
        let bounds = Bounds { left: 0, top: 0, right: 1, bottom: 0 };
        assert_eq!(on_plate(bounds, &panel), [[-5.0, -3.0], [2.0, 4.0]]);
        panel.mirror_x = true;
        assert_eq!(on_plate(bounds, &panel), [[3.0, 5.0], [2.0, 4.0]]);
        panel.mirror_y = true;
        panel.portrait = true;
        assert_eq!(on_plate(bounds, &panel), [[-4.0, -2.0], [3.0, 5.0]]);
    }
}
