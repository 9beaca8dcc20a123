//! One layer taken apart: its connected parts, and the holes in them.

use super::label;
use crate::mask::{MaskLayer, Panel};
use crate::span::{Rows, RowsBuilder};

/// What the checks need to know of one layer: its solid pixels as spans on the rows of the image
/// (row = pixel row, s = pixel in the row), their connected parts and the holes.
///
/// A pixel is solid when its grey is at least the threshold. Parts are connected across edges of
/// pixels. Their background is connected across edges and corners; what of it does not reach the border
/// of the panel within the layer is a *hole*.
#[derive(Clone, Debug, Default)]
pub struct LayerParts {
    /// Solid pixels.
    pub rows: Rows,
    /// Per span the part it belongs to, counted in raster order of their first pixels.
    pub part: Vec<u32>,
    /// Pixels of each part.
    pub pixels: Vec<u32>,
    /// Pieces of holes between spans, in raster order.
    pub gaps: Vec<Gap>,
    /// The holes, in raster order of their first pixels.
    pub holes: Vec<Region>,
    /// Per span the hole behind it, counted from 1; 0 where the outside follows. Empty without holes.
    pub(super) behind: Vec<u32>,
    /// Sum of all greys over 255, of those below the threshold too: the lit area \[pixels\].
    pub lit: f64,
}

/// The part of a hole that lies in one row, between two spans.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gap {
    /// Row of the image.
    pub row: i32,
    /// First pixel.
    pub start: i32,
    /// Pixel behind the last.
    pub end: i32,
    /// Index in [`LayerParts::holes`].
    pub hole: u32,
    /// The span before it.
    pub(super) span: u32,
}

/// Extent of a set of pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Region {
    /// Number of pixels.
    pub pixels: u64,
    /// Twice the sums of x and of y of their centres, in pixels from the corner of the image.
    pub moments: [u64; 2],
    /// Smallest and greatest corner, the latter behind the last pixel.
    pub bounds: [[i32; 2]; 2],
}

impl Default for Region {
    fn default() -> Self {
        Self { pixels: 0, moments: [0; 2], bounds: [[i32::MAX; 2], [i32::MIN; 2]] }
    }
}

impl Region {
    /// Adds pixels `start..end` of a row; none of them is negative.
    pub fn add(&mut self, row: i32, start: i32, end: i32) {
        let [a, b, y] = [start, end, row].map(|v| v.max(0) as u64);
        self.pixels += b - a;
        self.moments[0] += b * b - a * a;
        self.moments[1] += (2 * y + 1) * (b - a);
        self.bounds[0] = [self.bounds[0][0].min(start), self.bounds[0][1].min(row)];
        self.bounds[1] = [self.bounds[1][0].max(end), self.bounds[1][1].max(row + 1)];
    }

    /// Adds another region.
    pub fn join(&mut self, other: &Self) {
        self.pixels += other.pixels;
        for axis in 0..2 {
            self.moments[axis] += other.moments[axis];
            self.bounds[0][axis] = self.bounds[0][axis].min(other.bounds[0][axis]);
            self.bounds[1][axis] = self.bounds[1][axis].max(other.bounds[1][axis]);
        }
    }

    /// Centroid and bounding box (smallest x and y, greatest x and y) on the plate \[mm\]; zeros
    /// without pixels.
    pub fn on_plate(&self, panel: &Panel) -> ([f64; 2], [f64; 4]) {
        if self.pixels == 0 {
            return ([0.0; 2], [0.0; 4]);
        }
        let centre = self.moments.map(|m| m as f64 / (2.0 * self.pixels as f64));
        let [a, b] = self.bounds.map(|p| panel.on_plate(p.map(f64::from)));
        (panel.on_plate(centre), [a[0].min(b[0]), a[1].min(b[1]), a[0].max(b[0]), a[1].max(b[1])])
    }
}

impl LayerParts {
    /// Takes a mask apart; `threshold` is the least grey of a solid pixel. Depends on its arguments
    /// alone, so layers can be taken apart side by side. Costs by runs.
    pub fn of(mask: &MaskLayer, panel: &Panel, threshold: u8) -> Self {
        let rows = solid(mask, panel.width, threshold);
        let (part, pixels) = label::parts(&rows);
        let (gaps, holes, behind) = label::holes(&rows);
        Self { rows, part, pixels, gaps, holes, behind, lit: mask.area() }
    }

    /// Number of solid pixels.
    pub fn solid(&self) -> u64 {
        self.pixels.iter().map(|&n| u64::from(n)).sum()
    }

    /// Pieces of the background in one row: those that meet `start..end`, each with its hole, counted
    /// from 1, 0 for the outside. `from` is a span to begin with, returned moved on for the next range.
    #[inline]
    pub(super) fn background(
        &self,
        row: std::ops::Range<usize>,
        mut from: usize,
        [start, end]: [i32; 2],
        mut found: impl FnMut(u32),
    ) -> usize {
        let spans = self.rows.spans();
        from = from.max(row.start);
        while from < row.end && spans[from].end <= start {
            from += 1;
        }
        let mut i = from;
        loop {
            let left = if i == row.start { i32::MIN } else { spans[i - 1].end };
            let right = if i == row.end { i32::MAX } else { spans[i].start };
            if left >= end {
                break;
            }
            if right > start {
                let outside = i == row.start || self.behind.is_empty();
                found(if outside { 0 } else { self.behind[i - 1] });
            }
            if i == row.end {
                break;
            }
            i += 1;
        }
        from
    }
}

/// The pixels of at least `threshold` on the rows of the image.
fn solid(mask: &MaskLayer, width: u32, threshold: u8) -> Rows {
    let width = width.max(1);
    let Some(first) = mask.runs.iter().find(|r| r.value >= threshold) else { return Rows::default() };
    let row = first.start / width;
    let rows = mask.runs.last().map_or(0, |r| (r.end - 1) / width).saturating_sub(row) + 1;
    let mut out = RowsBuilder::with_capacity(row as i32, rows as usize, mask.runs.len());
    // In 64 bits, so that the end of the last row does not wrap.
    let mut begin = u64::from(row) * u64::from(width);
    let width = u64::from(width);
    for run in mask.runs.iter().filter(|r| r.value >= threshold) {
        let (mut start, end) = (u64::from(run.start), u64::from(run.end));
        while start < end {
            while start >= begin + width {
                begin += width;
                out.end_row();
            }
            let stop = end.min(begin + width);
            out.push((start - begin) as i32, (stop - begin) as i32);
            start = stop;
        }
    }
    out.end_row();
    out.finish()
}
