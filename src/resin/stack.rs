//! Layers as files with a manifest: PNGs (or SVGs) in a zip archive or in a folder.
//!
//! `manifest.json` describes the print and every layer, `settings.ini` holds all settings. The archive of
//! PNGs names its layers `1.png`, `2.png` ... and carries `manifest.uvtools`, so that UVtools 3 to 5 opens
//! it as its generic zip; folders and SVGs count from `00000`, so that names sort.

mod manifest;

use super::archive::{Members, Sink, ZipSink, damaged, day_and_time};
use super::layer_files::{Kind, LayerFile, LayerFiles};
use super::png::{self, Packing};
use super::{Container, Head, LayerInfo, LayerSink, Motion, Print, ReadError, Totals, WriteSeek};
use crate::mask::{MaskLayer, Panel};
use manifest::Manifest;
use std::io;
use std::path::Path;

/// Member that describes the others.
pub const MANIFEST: &str = "manifest.json";

/// A zip of PNG layers with a manifest.
#[derive(Clone, Copy, Debug, Default)]
pub struct PngStack;

impl Container for PngStack {
    fn name(&self) -> &'static str {
        "png"
    }

    fn preview_size(&self) -> [u32; 2] {
        [854, 480]
    }

    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
        png::encode(mask, panel)
    }

    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>> {
        let sink = Sink::Zip(Box::new(ZipSink::new(out, print.date)));
        Ok(Box::new(StackSink::begin(sink, print, false)?))
    }
}

impl PngStack {
    /// Begins a folder of PNG layers; `folder` must exist and should be empty.
    ///
    /// # Errors
    /// Those of the folder.
    pub fn begin_folder<'a>(&self, folder: &Path, print: &'a Print) -> io::Result<Box<dyn LayerSink + 'a>> {
        Ok(Box::new(StackSink::begin(Sink::Folder(folder.to_owned()), print, false)?))
    }
}

/// A zip or folder of layers being written.
pub struct StackSink<'a> {
    sink: Sink<'a>,
    print: &'a Print,
    svg: bool,
    layers: Vec<manifest::Layer>,
}

impl<'a> StackSink<'a> {
    /// Writes what is known before the layers.
    ///
    /// # Errors
    /// Those of the stream or folder.
    pub fn begin(mut sink: Sink<'a>, print: &'a Print, svg: bool) -> io::Result<Self> {
        sink.put("settings.ini", print.config.as_bytes())?;
        // The sizes that UVtools gives to its own.
        sink.put("preview.png", &png::encode_preview(&print.preview, 854, 480)?)?;
        if !svg && matches!(sink, Sink::Zip(_)) {
            sink.put("preview_cropping.png", &png::encode_preview(&print.preview, 472, 240)?)?;
            sink.put("manifest.uvtools", uvtools(print).as_bytes())?;
        }
        Ok(Self { sink, print, svg, layers: Vec::new() })
    }

    /// Name of the next layer's file.
    fn file(&self) -> String {
        let index = self.layers.len();
        match (&self.sink, self.svg) {
            (_, true) => format!("{index:05}.svg"),
            (Sink::Folder(_), false) => format!("{index:05}.png"),
            (Sink::Zip(_), false) => format!("{}.png", index + 1),
        }
    }
}

impl LayerSink for StackSink<'_> {
    fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> io::Result<()> {
        let file = self.file();
        self.sink.put(&file, encoded)?;
        self.layers.push(manifest::Layer::new(file, info));
        Ok(())
    }

    fn finish(mut self: Box<Self>, totals: &Totals) -> io::Result<()> {
        let layers = std::mem::take(&mut self.layers);
        let manifest = Manifest::new(self.print, self.svg, totals, layers);
        let mut text = serde_json::to_vec_pretty(&manifest)?;
        text.push(b'\n');
        self.sink.put(MANIFEST, &text)?;
        self.sink.finish()
    }
}

/// The manifest by which UVtools knows its generic zip.
fn uvtools(print: &Print) -> String {
    let [day, time] = day_and_time(print.date);
    let date = format!("{day} {time}Z");
    let program = concat!("microtome ", env!("CARGO_PKG_VERSION"));
    let [wide, high] = print.panel.image_nm().map(|nm| nm as f64 * 1e-6);
    let fields = [
        ("CreatedBy", program.to_owned()),
        ("UpdatedBy", program.to_owned()),
        ("CreatedDate", date.clone()),
        ("LastModifiedDate", date),
        ("LayerHeight", print.layer_height.to_string()),
        ("ResolutionX", print.panel.width.to_string()),
        ("ResolutionY", print.panel.height.to_string()),
        ("DisplayWidth", wide.to_string()),
        ("DisplayHeight", high.to_string()),
        ("MachineZ", print.build_height.to_string()),
    ];
    let fields: String = fields.iter().map(|(key, value)| format!("  <{key}>{value}</{key}>\n")).collect();
    format!("<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<Manifest>\n{fields}</Manifest>\n")
}

/// Reads the manifest of a zip or folder of layers.
///
/// # Errors
/// [`ReadError`] where it is damaged, or names layers that do not exist.
pub fn open(mut members: Box<dyn Members>) -> Result<LayerFiles, ReadError> {
    let text = members.read(MANIFEST, super::archive::LONGEST_TEXT)?;
    let format = "layers";
    let manifest: Manifest = serde_json::from_slice(&text)
        .map_err(|e| damaged(format, MANIFEST, format!("not readable ({e})"), "a manifest of layers"))?;
    if manifest.format != manifest::FORMAT || manifest.version != manifest::VERSION {
        let value = format!("{} version {}", manifest.format, manifest.version);
        let expected = format!("{} version {}", manifest::FORMAT, manifest::VERSION);
        return Err(damaged(format, "the manifest's format", value, expected));
    }
    let kind = match manifest.layer_format.as_str() {
        "png" => Kind::Png(Packing::Grey),
        "svg" => Kind::Svg,
        other => return Err(damaged(format, "layer_format", other, "png or svg")),
    };
    let head = manifest.head(if kind == Kind::Svg { "svg" } else { "png" });
    let mut files = Vec::with_capacity(manifest.layers.len());
    for (index, layer) in manifest.layers.into_iter().enumerate() {
        if !members.has(&layer.file) {
            return Err(damaged(
                format,
                &format!("file {} of layer {index}", layer.file),
                "missing",
                "present",
            ));
        }
        files.push(layer.into_file(index as u32));
    }
    LayerFiles::new(head, members, files, kind)
}
