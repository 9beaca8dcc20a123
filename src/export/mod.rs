//! Contours as files for other programs: SVG, JSON, WKT, Common Layer Interface, pictures.
//!
//! Coordinates are written in millimetres with as many decimals as a nanometre needs, so that a
//! reader gets back exactly what was found.

pub mod cli;
mod decimal;
pub mod format;
pub mod json;
pub mod png;
pub mod svg;
pub mod wkt;

pub use format::{Format, UnknownFormat};

use crate::contour::Ring;
use crate::contour::chains::OpenReport;
use crate::lattice::area2;
use rayon::prelude::*;
use std::io::{self, Write};

/// The contours of a part, plane by plane.
#[derive(Clone, Debug)]
pub struct Drawing<'a> {
    /// Name of the model.
    pub model: &'a str,
    /// One per plane, ascending.
    pub sheets: Vec<Sheet<'a>>,
    /// Added to every point of the rings \[nm\].
    pub offset: [i64; 2],
    /// Where the planes lie in the model file.
    pub frame: Frame,
}

/// The contours on one plane.
#[derive(Clone, Copy, Debug)]
pub struct Sheet<'a> {
    /// Height of the plane \[nm\].
    pub z: i64,
    /// Height of the top of its layer \[nm\].
    pub top: i64,
    /// Thickness of its layer \[nm\].
    pub height: i64,
    /// Closed contours \[nm\] before [`Drawing::offset`], solid on the left.
    pub rings: &'a [Ring],
    /// What became of open contours.
    pub open: OpenReport,
}

impl Sheet<'_> {
    /// Area by the signed sum of all contours \[mm²\]: where shells overlap, it counts twice.
    pub fn area_mm2(&self) -> f64 {
        let twice: i128 = self.rings.iter().map(|r| area2(r)).sum();
        twice as f64 * 0.5e-12
    }
}

/// From a plane's own coordinates to the model file's: `origin + x u + y v + z n` \[mm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// First axis in the planes, unit length.
    pub u: [f64; 3],
    /// Second axis in the planes, unit length.
    pub v: [f64; 3],
    /// Normal of the planes, unit length.
    pub n: [f64; 3],
    /// Where (0, 0) at height 0 lies in the model file \[mm\].
    pub origin: [f64; 3],
}

impl Drawing<'_> {
    /// Lowest and highest x and y of all contours, offset included \[nm\]; `None` without contours.
    pub fn bounds(&self) -> Option<[[i64; 2]; 2]> {
        let of_sheet = |sheet: &Sheet<'_>| {
            let mut points = sheet.rings.iter().flatten();
            let first = points.next()?;
            let start = ([first.x, first.y], [first.x, first.y]);
            Some(points.fold(start, |(lo, hi), p| {
                ([lo[0].min(p.x), lo[1].min(p.y)], [hi[0].max(p.x), hi[1].max(p.y)])
            }))
        };
        let (lo, hi) = self.sheets.par_iter().filter_map(of_sheet).reduce_with(|a, b| {
            let pick = |f: fn(i32, i32) -> i32, a: [i32; 2], b: [i32; 2]| [f(a[0], b[0]), f(a[1], b[1])];
            (pick(i32::min, a.0, b.0), pick(i32::max, a.1, b.1))
        })?;
        Some([lo, hi].map(|p| [0, 1].map(|axis| i64::from(p[axis]) + self.offset[axis])))
    }
}

/// Sheets turned into text at once; bounds the memory that the text takes.
const BATCH: usize = 64;

/// Writes the text of every sheet in order; `text` gets the sheet's index too.
fn write_sheets(
    drawing: &Drawing<'_>,
    out: &mut impl Write,
    text: impl Fn(usize, &Sheet<'_>, &mut Vec<u8>) + Sync,
) -> io::Result<()> {
    for (batch, sheets) in drawing.sheets.chunks(BATCH).enumerate() {
        let texts: Vec<Vec<u8>> = sheets
            .par_iter()
            .enumerate()
            .map(|(i, sheet)| {
                let mut bytes = Vec::new();
                text(batch * BATCH + i, sheet, &mut bytes);
                bytes
            })
            .collect();
        texts.iter().try_for_each(|bytes| out.write_all(bytes))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests;
