//! Pictures: one per plane, all of the same part of the plane, white where there is material.

use super::{Drawing, Sheet};
use crate::lattice::NM_PER_MM;
use crate::span::{RowFrame, scan};
use image::{GrayImage, Luma};
use thiserror::Error;

/// Pixels in a picture at most: a quarter of a gigabyte.
pub const MAX_PIXELS: u64 = 1 << 28;

/// A scale at which no picture can be drawn.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum PictureError {
    /// Too many pixels.
    #[error(
        "{width} x {height} pixels are too many for a picture (at most 268 million); choose a smaller --scale"
    )]
    TooLarge {
        /// Width \[pixels\].
        width: u64,
        /// Height \[pixels\].
        height: u64,
    },
    /// Not between 0.001 and 1000.
    #[error("a scale of {0} pixels per millimetre is not supported; give one from 0.001 to 1000")]
    Scale(f64),
}

/// The part of the plane that all pictures show, and the size of their pixels.
///
/// Pixel borders lie at whole multiples of the pixel size, so that pictures of several parts fit
/// together. A pixel is white when its centre lies inside by the non-zero rule; y points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Raster {
    /// Side of a pixel \[nm\].
    pub pixel: i64,
    /// Left and lower border \[pixels\].
    pub low: [i64; 2],
    /// Width and height \[pixels\].
    pub size: [u32; 2],
}

impl Raster {
    /// A raster that holds all contours with `scale` pixels per millimetre; the pixel's side is rounded
    /// to whole nanometres.
    ///
    /// # Errors
    /// [`PictureError`] when the scale or the pictures are beyond reason.
    pub fn new(drawing: &Drawing<'_>, scale: f64) -> Result<Self, PictureError> {
        if !(0.001..=1000.0).contains(&scale) {
            return Err(PictureError::Scale(scale));
        }
        let pixel = (NM_PER_MM / scale).round() as i64;
        let [lo, hi] = drawing.bounds().unwrap_or_default();
        let low = lo.map(|c| c.div_euclid(pixel));
        let [width, height] = [0, 1].map(|axis| {
            let high = -(-hi[axis]).div_euclid(pixel);
            (high - low[axis]).max(1) as u64
        });
        if width.saturating_mul(height) > MAX_PIXELS {
            return Err(PictureError::TooLarge { width, height });
        }
        // Both are at most MAX_PIXELS.
        Ok(Self { pixel, low, size: [width as u32, height as u32] })
    }

    /// Draws a plane; `offset` is that of the drawing.
    pub fn draw(&self, sheet: &Sheet<'_>, offset: [i64; 2]) -> GrayImage {
        let [width, height] = self.size;
        let mut image = GrayImage::new(width, height);
        // Centres of the pixels of row 0, in the frame of the rings.
        let phase = (self.low[1] * self.pixel - offset[1]) as f64 + 0.5 * self.pixel as f64;
        let frame = RowFrame::new(0.0, phase, self.pixel as f64);
        let first = frame.nearest_row(phase.round() as i64);
        let left = self.low[0] * self.pixel - offset[0];
        // The first pixel whose centre lies at or right of s.
        let column = |s: i32| {
            let twice = 2 * (i64::from(s) - left) - self.pixel;
            -(-twice).div_euclid(2 * self.pixel)
        };
        for (k, spans) in scan(sheet.rings.iter().map(|r| &r[..]), &frame).iter() {
            let row = i64::from(k) - i64::from(first);
            if row < 0 || row >= i64::from(height) {
                continue;
            }
            for span in spans {
                let (from, to) = (column(span.start).max(0), column(span.end).min(i64::from(width)));
                for x in from..to {
                    image.put_pixel(x as u32, height - 1 - row as u32, Luma([255]));
                }
            }
        }
        image
    }
}
