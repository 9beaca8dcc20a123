//! Prusa SL1 archives: `.sl1`, `.sl1s`, `.m1`.
//!
//! A zip of `config.ini` (what the printer reads), `prusaslicer.ini` (what slicers read), a PNG per layer
//! named `<jobDir>NNNNN.png`, and thumbnails. Written and read after what PrusaSlicer 2.5.0 writes, checked
//! against its files, and after the way the printer's firmware (sl1fw) times its layers: the first three
//! get `expTimeFirst`, the next `numFade` fall linearly, all others get `expTime`.

use super::archive::{LONGEST_TEXT, Members, ZipSink, damaged, day_and_time};
use super::layer_files::{Kind, LayerFile, LayerFiles};
use super::png::{self, Packing, Place};
use super::{Container, Head, LayerInfo, LayerSink, Print, ReadError, Totals, WriteSeek};
use crate::mask::{MaskLayer, Panel};
use std::collections::BTreeMap;
use std::io;

/// Member that the printer reads.
pub const CONFIG: &str = "config.ini";
/// Member that slicers read.
const SETTINGS: &str = "prusaslicer.ini";
/// Layers that the firmware exposes for `expTimeFirst`.
const FIRST_LAYERS: u32 = 3;
/// Share of the panel above which a layer is peeled slowly, where the settings do not say \[%\].
const AREA_FILL: f64 = 50.0;

/// The format.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sl1;

impl Container for Sl1 {
    fn name(&self) -> &'static str {
        "sl1"
    }

    fn losses(&self, print: &Print) -> Vec<String> {
        let mut losses = Vec::new();
        if print.bottom_layers != FIRST_LAYERS {
            losses.push(format!(
                "sl1: the printer exposes its first {FIRST_LAYERS} layers in full and lets {} fade; {} bottom layers cannot be told to it",
                fade(print),
                print.bottom_layers
            ));
        }
        losses
    }

    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
        png::encode(mask, panel)
    }

    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>> {
        if print.layers > 100_000 {
            let text = format!("sl1: {} layers, at most 100000; use thicker layers", print.layers);
            return Err(io::Error::new(io::ErrorKind::InvalidInput, text));
        }
        let mut zip = ZipSink::new(out, print.date);
        let settings = settings(print);
        let text: String = settings.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
        zip.put(SETTINGS, text.as_bytes())?;
        for (width, height) in [(400, 400), (800, 480)] {
            let picture = png::encode_preview(&print.preview, width, height)?;
            zip.put(&format!("thumbnail/thumbnail{width}x{height}.png"), &picture)?;
        }
        Ok(Box::new(Sl1Sink { zip, print, settings, slow: 0, layers: 0 }))
    }
}

/// All settings, completed by those that readers of the format need.
fn settings(print: &Print) -> BTreeMap<String, String> {
    let mut settings = parse(&print.config);
    let panel = &print.panel;
    let [wide, high] = panel.plate();
    let (pixels_x, pixels_y) =
        if panel.portrait { (panel.height, panel.width) } else { (panel.width, panel.height) };
    // In portrait, PrusaSlicer's own picture is mirrored once more than its setting says.
    let mirror_x = panel.mirror_x != panel.portrait;
    let (wide, high) = (number(wide as f64 * 1e-6), number(high as f64 * 1e-6));
    let needed = [
        ("bed_shape", format!("0x0,{wide}x0,{wide}x{high},0x{high}")),
        ("display_height", high),
        ("display_mirror_x", u8::from(mirror_x).to_string()),
        ("display_mirror_y", u8::from(panel.mirror_y).to_string()),
        ("display_orientation", if panel.portrait { "portrait" } else { "landscape" }.to_owned()),
        ("display_pixels_x", pixels_x.to_string()),
        ("display_pixels_y", pixels_y.to_string()),
        ("display_width", wide),
        ("exposure_time", number(print.exposure)),
        ("gamma_correction", u8::from(print.anti_aliasing > 1).to_string()),
        ("initial_exposure_time", number(print.bottom_exposure)),
        ("initial_layer_height", number(print.first_layer_height)),
        ("layer_height", number(print.layer_height)),
        ("max_print_height", number(print.build_height)),
        ("printer_model", print.printer_model.clone()),
        ("printer_technology", "SLA".to_owned()),
        ("printer_variant", "default".to_owned()),
        ("sla_archive_format", "SL1".to_owned()),
    ];
    for (key, value) in needed {
        settings.entry(key.to_owned()).or_insert(value);
    }
    // What the printer will do, however the layers were asked for.
    settings.insert("faded_layers".to_owned(), fade(print).to_string());
    if let Some(share) = settings.get_mut("area_fill") {
        // PrusaSlicer has it without the sign.
        *share = share.trim_end_matches('%').to_owned();
    }
    settings
}

/// Layers that fade behind the first three.
fn fade(print: &Print) -> u32 {
    print.bottom_layers.saturating_add(print.transition_layers).saturating_sub(FIRST_LAYERS)
}

/// A number with at most six decimals.
fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Prefix of the layers' names.
fn job(print: &Print) -> &str {
    if print.name.is_empty() { "layer" } else { &print.name }
}

struct Sl1Sink<'a> {
    zip: ZipSink<'a>,
    print: &'a Print,
    settings: BTreeMap<String, String>,
    slow: u32,
    layers: u32,
}

impl Sl1Sink<'_> {
    fn setting(&self, key: &str) -> &str {
        self.settings.get(key).map_or("", String::as_str)
    }
}

impl LayerSink for Sl1Sink<'_> {
    fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> io::Result<()> {
        let [wide, high] = self.print.panel.image_nm().map(|nm| nm as f64 * 1e-6);
        let percent = self.setting("area_fill").parse().unwrap_or(AREA_FILL);
        self.slow += u32::from(info.area_mm2 > wide * high * percent / 100.0);
        let index = self.layers;
        self.layers += 1;
        self.zip.put(&format!("{}{index:05}.png", job(self.print)), encoded)
    }

    fn finish(mut self: Box<Self>, totals: &Totals) -> io::Result<()> {
        let print = self.print;
        let [day, time] = day_and_time(print.date);
        let lines = [
            ("action", "print".to_owned()),
            ("expTime", number(print.exposure)),
            ("expTimeFirst", number(print.bottom_exposure)),
            ("expUserProfile", "0".to_owned()),
            ("fileCreationTimestamp", format!("{day} at {time} UTC")),
            ("hollow", "0".to_owned()),
            ("jobDir", job(print).to_owned()),
            ("layerHeight", number(print.layer_height)),
            ("materialName", line(&print.material)),
            ("numFade", fade(print).to_string()),
            ("numFast", (self.layers - self.slow).to_string()),
            ("numSlow", self.slow.to_string()),
            ("printProfile", self.setting("sla_print_settings_id").to_owned()),
            ("printTime", number(totals.time)),
            ("printerModel", line(&print.printer_model)),
            ("printerProfile", self.setting("printer_settings_id").to_owned()),
            ("printerVariant", self.setting("printer_variant").to_owned()),
            ("prusaSlicerVersion", concat!("microtome ", env!("CARGO_PKG_VERSION")).to_owned()),
            ("usedMaterial", number(totals.volume_ml)),
        ];
        let text: String = lines.iter().map(|(key, value)| format!("{key} = {value}\n")).collect();
        self.zip.put(CONFIG, text.as_bytes())?;
        self.zip.finish()
    }
}

/// Text without line ends.
fn line(text: &str) -> String {
    text.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// Lines of `key = value`.
fn parse(text: &str) -> BTreeMap<String, String> {
    text.lines()
        .filter_map(|line| line.split_once('='))
        .map(|(key, value)| (key.trim().to_owned(), value.trim().to_owned()))
        .collect()
}

/// The text of a member as keys and values.
fn read_keys(members: &mut dyn Members, name: &str) -> Result<BTreeMap<String, String>, ReadError> {
    let bytes = members.read(name, LONGEST_TEXT)?;
    Ok(parse(&String::from_utf8_lossy(&bytes)))
}

/// A number that is not negative, or nothing where the key is missing or empty.
fn value_of(keys: &BTreeMap<String, String>, key: &str) -> Result<Option<f64>, ReadError> {
    let Some(text) = keys.get(key).filter(|t| !t.is_empty()) else { return Ok(None) };
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(Some(value)),
        _ => Err(damaged("sl1", key, text, "a number from 0")),
    }
}

/// The same for whole numbers.
fn count_of(keys: &BTreeMap<String, String>, key: &str) -> Result<Option<u32>, ReadError> {
    let Some(text) = keys.get(key).filter(|t| !t.is_empty()) else { return Ok(None) };
    text.parse().map(Some).map_err(|_| damaged("sl1", key, text, "a whole number from 0"))
}

/// Reads the head of an archive.
///
/// # Errors
/// [`ReadError`] where keys or layers are missing or contradict each other.
pub fn open(mut members: Box<dyn Members>) -> Result<LayerFiles, ReadError> {
    let config = read_keys(members.as_mut(), CONFIG)?;
    let settings =
        if members.has(SETTINGS) { read_keys(members.as_mut(), SETTINGS)? } else { BTreeMap::new() };
    let Some(job) = config.get("jobDir") else {
        return Err(damaged("sl1", "jobDir of config.ini", "missing", "the prefix of the layers"));
    };
    let names = layers(members.as_ref(), job)?;
    if let (Some(fast), Some(slow)) = (count_of(&config, "numFast")?, count_of(&config, "numSlow")?)
        && u64::from(fast) + u64::from(slow) != names.len() as u64
    {
        let expected = format!("{} layers, as numFast and numSlow say", u64::from(fast) + u64::from(slow));
        return Err(damaged("sl1", "the number of pictures", names.len(), expected));
    }
    let layer_height = value_of(&config, "layerHeight")?.unwrap_or_default();
    let exposure = value_of(&config, "expTime")?.unwrap_or_default();
    let first = value_of(&config, "expTimeFirst")?.unwrap_or(exposure);
    let fade = count_of(&config, "numFade")?.unwrap_or_default();
    let mut head = Head {
        format: "sl1",
        machine: config.get("printerModel").cloned().unwrap_or_default(),
        layer_height,
        exposure,
        bottom_exposure: first,
        bottom_layers: FIRST_LAYERS.min(names.len() as u32),
        time: value_of(&config, "printTime")?,
        volume_ml: value_of(&config, "usedMaterial")?,
        ..Head::default()
    };
    read_panel(&mut head, &settings)?;
    if head.width == 0
        && let Some(name) = names.first()
    {
        let bytes = members.read(name, LONGEST_TEXT)?;
        [head.width, head.height] = png::size(&bytes, Place { format: "sl1", name })?;
    }
    let first_height = value_of(&settings, "initial_layer_height")?.unwrap_or(layer_height);
    let step = (first - exposure) / (f64::from(fade) + 1.0);
    let files = names.into_iter().enumerate().map(|(i, name)| {
        let index = i as u32;
        let info = LayerInfo {
            index,
            z: first_height + f64::from(index) * layer_height,
            height: if index == 0 { first_height } else { layer_height },
            exposure: match index.checked_sub(FIRST_LAYERS) {
                None => first,
                Some(behind) if behind < fade => first - (f64::from(behind) + 1.0) * step,
                Some(_) => exposure,
            },
            ..LayerInfo::default()
        };
        LayerFile { name, info }
    });
    LayerFiles::new(head, members, files.collect(), Kind::Png(Packing::Grey))
}

/// Names of the layers' pictures in their order: the prefix, then five digits or more, from 0 without gaps.
fn layers(members: &dyn Members, job: &str) -> Result<Vec<String>, ReadError> {
    let mut found = BTreeMap::new();
    for name in members.names() {
        let digits = name.strip_prefix(job).and_then(|n| n.strip_suffix(".png"));
        if let Some(digits) = digits
            && digits.len() >= 5
            && digits.bytes().all(|b| b.is_ascii_digit())
            && let Ok(number) = digits.parse::<u32>()
        {
            found.insert(number, name);
        }
    }
    if let Some((missing, _)) = (0u32..).zip(found.keys()).find(|(i, k)| i != *k) {
        return Err(damaged("sl1", &format!("picture {job}{missing:05}.png"), "missing", "present"));
    }
    if found.is_empty() {
        return Err(damaged("sl1", "the number of pictures", 0, "at least one layer"));
    }
    Ok(found.into_values().collect())
}

/// The panel, where the settings describe it.
fn read_panel(head: &mut Head, settings: &BTreeMap<String, String>) -> Result<(), ReadError> {
    let portrait = settings.get("display_orientation").is_some_and(|o| o == "portrait");
    let pixels = (count_of(settings, "display_pixels_x")?, count_of(settings, "display_pixels_y")?);
    if let (Some(x), Some(y)) = pixels {
        (head.width, head.height) = if portrait { (y, x) } else { (x, y) };
    }
    let size = (value_of(settings, "display_width")?, value_of(settings, "display_height")?);
    if let (Some(x), Some(y)) = size {
        head.display = Some(if portrait { [y, x] } else { [x, y] });
    }
    let mirror = (count_of(settings, "display_mirror_x")?, count_of(settings, "display_mirror_y")?);
    if let (Some(x), Some(y)) = mirror {
        head.mirror = Some([(x != 0) != portrait, y != 0]);
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_no_needless_zeros() {
        let texts: Vec<_> = [0.05, 8.0, 0.0, 336.272_727_27, 1e-9, 120.0].map(number).into();
        assert_eq!(texts, ["0.05", "8", "0", "336.272727", "0", "120"]);
    }
}
