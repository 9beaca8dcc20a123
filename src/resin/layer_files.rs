//! A container with one file per layer, opened for reading.

use super::archive::{Folder, Members, Zip, damaged, foreign};
use super::bytes::ReadSeek;
use super::png::{self, Packing, Place};
use super::{Head, LayerInfo, ReadError, Reader, nanodlp, sl1, stack, svg};
use crate::mask::MaskLayer;
use std::path::Path;

/// Most pixels of a panel that are read; 16K panels have 94 million.
const MOST_PIXELS: u64 = 1 << 30;

/// Opens a zip archive of any format that has one file per layer: `.sl1`, `.sl1s`, `.nanodlp`, zips of PNG
/// or SVG layers.
///
/// # Errors
/// [`ReadError`]: `Foreign` where it is none of these.
pub fn open_zip(input: Box<dyn ReadSeek>) -> Result<Box<dyn Reader>, ReadError> {
    let zip = Zip::open(input)?;
    if zip.has(stack::MANIFEST) {
        return Ok(Box::new(stack::open(Box::new(zip))?));
    }
    if zip.has(sl1::CONFIG) {
        return Ok(Box::new(sl1::open(Box::new(zip))?));
    }
    if zip.has(nanodlp::PLATE) {
        return Ok(Box::new(nanodlp::open(Box::new(zip))?));
    }
    Err(foreign(", it is a zip archive without config.ini, plate.json or manifest.json"))
}

/// Opens a folder of PNG or SVG layers with their manifest.
///
/// # Errors
/// [`ReadError`]: `Foreign` where it has no manifest.
pub fn open_folder(path: &Path) -> Result<Box<dyn Reader>, ReadError> {
    let folder = Folder::open(path)?;
    if !folder.has(stack::MANIFEST) {
        return Err(foreign(", it is a folder without manifest.json"));
    }
    Ok(Box::new(stack::open(Box::new(folder))?))
}

/// How a layer is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A PNG.
    Png(Packing),
    /// An SVG.
    Svg,
}

/// A layer's file.
#[derive(Clone, Debug, PartialEq)]
pub struct LayerFile {
    /// Its member.
    pub name: String,
    /// What the container says of the layer.
    pub info: LayerInfo,
}

/// The reader of all these formats.
pub struct LayerFiles {
    head: Head,
    members: Box<dyn Members>,
    files: Vec<LayerFile>,
    kind: Kind,
}

impl LayerFiles {
    /// A reader of `files` in `members`.
    ///
    /// # Errors
    /// [`ReadError`] where the panel is empty or too large.
    pub fn new(
        mut head: Head,
        members: Box<dyn Members>,
        files: Vec<LayerFile>,
        kind: Kind,
    ) -> Result<Self, ReadError> {
        let pixels = u64::from(head.width) * u64::from(head.height);
        if pixels == 0 || pixels > MOST_PIXELS || head.width.max(head.height) > 1 << 20 {
            let value = format!("{} x {}", head.width, head.height);
            return Err(damaged(head.format, "the panel", value, format!("1 to {MOST_PIXELS} pixels")));
        }
        head.layers = files.len() as u32;
        Ok(Self { head, members, files, kind })
    }
}

impl Reader for LayerFiles {
    fn head(&self) -> &Head {
        &self.head
    }

    fn layer(&mut self, index: u32) -> Result<(MaskLayer, LayerInfo), ReadError> {
        let Some(LayerFile { name, info }) = self.files.get(index as usize) else {
            return Err(ReadError::NoLayer { index, layers: self.head.layers });
        };
        let (width, height) = (self.head.width, self.head.height);
        let place = Place { format: self.head.format, name };
        let mask = match self.kind {
            Kind::Png(packing) => {
                let row = u64::from(width.div_ceil(3)) * 3;
                let bytes = self.members.read(name, png::longest_file(row, u64::from(height)))?;
                png::decode(&bytes, width, height, packing, place)?
            }
            Kind::Svg => svg::decode(&self.members.read(name, svg::LONGEST)?, width, height, place)?,
        };
        Ok((mask, *info))
    }
}
