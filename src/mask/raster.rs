//! A panel placed in a mesh's frame: edges or spans → pixels.
//!
//! Without anti-aliasing a pixel is lit if and only if its centre lies in a span `start..end` of the row
//! through the pixels' centres. Centre `i` of a row lies at `left + i * pitch + pitch / 2`; a half is
//! rounded up once, towards +s along a row and towards +t across rows ([`RowFrame::strips`]). Crossings
//! of rows are rounded as in [`crate::span::scan()`].

use super::antialias::{Coverage, Greys, Shading};
use super::{MaskLayer, Panel};
use crate::lattice::Point2;
use crate::span::{Axis, EdgeScan, RowFrame, Rows};
use std::ops::Range;
use thiserror::Error;

/// Why a panel cannot be drawn on.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum RasterError {
    /// A pixel pitch that no panel has.
    #[error("the pixel pitch is {x} x {y} nm; panels have between 1000 and 4194304 nm, check the printer")]
    Pitch {
        /// Along rows \[nm\].
        x: i64,
        /// Across rows \[nm\].
        y: i64,
    },
    /// No pixels, or more than 32-bit numbers count.
    #[error(
        "the panel has {width} x {height} pixels; there must be at least one and fewer than 2^32, check the printer"
    )]
    Pixels {
        /// Pixels in a row.
        width: u32,
        /// Rows.
        height: u32,
    },
    /// Longer than the lattice can hold a part.
    #[error("the panel is {x} x {y} nm large, more than 2^32 nm (4.29 m); check printer and pixel pitch")]
    Size {
        /// Along rows \[nm\].
        x: i64,
        /// Across rows \[nm\].
        y: i64,
    },
    /// A number of sub-rows that is not offered.
    #[error("anti-aliasing by {0} sub-rows is not offered; choose 1 (off), 2, 4, 8 or 16")]
    SubRows(u32),
    /// The part cannot be on the plate.
    #[error("the part's frame lies {x}, {y} nm from the plate's corner, beyond 2^34 nm; centre it")]
    Far {
        /// Along x \[nm\].
        x: i64,
        /// Along y \[nm\].
        y: i64,
    },
}

/// A panel as the sections of a mesh meet it.
#[derive(Clone, Debug)]
pub struct Raster {
    panel: Panel,
    frame: RowFrame,
    shading: Shading,
    greys: Greys,
    /// The image's left edge along rows \[units of the frame\], before mirroring.
    left: i64,
    /// 2^64 over the pitch along rows, rounded up.
    inverse: u64,
    /// Rows of the image run against those of the frame.
    downwards: bool,
}

impl Raster {
    /// Places a panel in the frame of a mesh whose lattice has its zero at `origin` \[nm\] on the plate
    /// (x and y of [`crate::mesh::Mesh::origin`]).
    ///
    /// # Errors
    /// [`RasterError`] for a panel that cannot be, sub-rows that are not offered, or a mesh far away.
    pub fn new(panel: Panel, origin: [i64; 2], shading: &Shading) -> Result<Self, RasterError> {
        let Panel { width, height, pitch_x, pitch_y, mirror_y, portrait, .. } = panel;
        if ![1, 2, 4, 8, 16].contains(&shading.sub_rows) {
            return Err(RasterError::SubRows(shading.sub_rows));
        }
        if [pitch_x, pitch_y].iter().any(|pitch| !(1000..=1 << 22).contains(pitch)) {
            return Err(RasterError::Pitch { x: pitch_x, y: pitch_y });
        }
        if width == 0 || height == 0 || width.checked_mul(height).is_none() {
            return Err(RasterError::Pixels { width, height });
        }
        let [x, y] = panel.image_nm();
        if x > 1 << 32 || y > 1 << 32 {
            return Err(RasterError::Size { x, y });
        }
        if origin.iter().any(|c| c.unsigned_abs() > 1 << 34) {
            return Err(RasterError::Far { x: origin[0], y: origin[1] });
        }
        let (axis, left, base) = if portrait {
            // t = -x: the strips begin at the plate's greatest x.
            (Axis::Y, -origin[1], origin[0] - y)
        } else {
            (Axis::X, -origin[0], -origin[1])
        };
        Ok(Self {
            panel,
            frame: RowFrame::strips(axis, base, pitch_y, shading.sub_rows),
            shading: *shading,
            greys: Greys::new(shading, pitch_x),
            left,
            inverse: u64::MAX / pitch_x.unsigned_abs() + 1,
            downwards: mirror_y == portrait,
        })
    }

    /// The panel.
    pub fn panel(&self) -> &Panel {
        &self.panel
    }

    /// The rows to scan sections with: row `k` is sub-row `k % sub_rows` of the panel's `k / sub_rows`-th
    /// row of pixels, counted upwards along t.
    pub fn frame(&self) -> &RowFrame {
        &self.frame
    }

    /// The rows of the frame that lie on the panel.
    pub fn rows(&self) -> Range<i32> {
        // Below 2^23 rows of at most 16.
        0..(self.panel.height * self.shading.sub_rows) as i32
    }

    /// The mask of an area on rows of [`Self::frame`]. What lies beyond the panel is left out.
    pub fn mask(&self, area: &Rows) -> MaskLayer {
        let mut mask = MaskLayer::default();
        Pen::new(self).draw(area.first()..area.end(), &mut &*area, &mut mask);
        mask
    }

    /// The pixel in which a distance from the left edge lies, and how much of the pixel lies behind it:
    /// `0 <= from_left <= width * pitch`, and the width for the right edge.
    #[inline(always)]
    fn pixel(&self, from_left: i64) -> (u32, i32) {
        // Exact: distance times pitch is below 2^55.
        let pixel = (u128::from(from_left as u64) * u128::from(self.inverse)) >> 64;
        (pixel as u32, ((pixel as i64 + 1) * self.panel.pitch_x - from_left) as i32)
    }

    /// The first pixel whose centre does not lie before `s`; the width if there is none.
    #[inline(always)]
    fn column(&self, s: i32) -> u32 {
        let pitch = self.panel.pitch_x;
        // The centre of pixel 0, and one pixel less one: division rounds down.
        let zero = self.left + (pitch + 1) / 2 - (pitch - 1);
        let from_zero = (i64::from(s) - zero).clamp(0, i64::from(self.panel.width) * pitch);
        self.pixel(from_zero).0
    }
}

/// Draws the sections of a mesh one after another; its memory is used again.
#[derive(Clone, Debug)]
pub struct Painter<'a> {
    pen: Pen<'a>,
    scan: EdgeScan,
    /// Runs of the last mask.
    runs: usize,
}

impl<'a> Painter<'a> {
    /// For a raster.
    pub fn new(raster: &'a Raster) -> Self {
        Self { pen: Pen::new(raster), scan: EdgeScan::new(&raster.frame), runs: 0 }
    }

    /// The mask of the non-zero winding interior of directed edges \[nm, mesh frame\]: that of their
    /// [`EdgeScan::scan`].
    pub fn mask(&mut self, edges: &[[Point2; 2]]) -> MaskLayer {
        let rows = self.scan.load(edges, self.pen.raster.rows());
        let mut mask = MaskLayer { runs: Vec::with_capacity(self.runs + self.runs / 8) };
        self.pen.draw(rows, &mut self.scan, &mut mask);
        self.runs = mask.runs.len();
        mask
    }
}

/// Rows of spans, in any order.
trait SpanRows {
    /// Hands over the spans of row `k` in ascending order; they may touch or be empty.
    fn row(&mut self, k: i32, span: impl FnMut(i32, i32));
}

impl SpanRows for &Rows {
    fn row(&mut self, k: i32, mut span: impl FnMut(i32, i32)) {
        Rows::row(self, k).iter().for_each(|s| span(s.start, s.end));
    }
}

impl SpanRows for EdgeScan {
    #[inline(always)]
    fn row(&mut self, k: i32, span: impl FnMut(i32, i32)) {
        Self::row(self, k, span);
    }
}

/// What drawing needs beside the raster.
#[derive(Clone, Debug)]
struct Pen<'a> {
    raster: &'a Raster,
    coverage: Coverage,
    /// Pixels of a row that is to be mirrored.
    mirrored: Vec<[u32; 2]>,
}

impl<'a> Pen<'a> {
    fn new(raster: &'a Raster) -> Self {
        let coverage =
            if raster.shading.sub_rows > 1 { Coverage::new(raster.panel.width) } else { Coverage::default() };
        Self { raster, coverage, mirrored: Vec::new() }
    }

    /// Draws rows of the frame in the order of the image.
    fn draw(&mut self, rows: Range<i32>, spans: &mut impl SpanRows, mask: &mut MaskLayer) {
        let Panel { width, height, .. } = self.raster.panel;
        let n = self.raster.shading.sub_rows as i32;
        let on_panel = self.raster.rows();
        let (first, end) = (rows.start.max(on_panel.start) / n, (rows.end.min(on_panel.end) + n - 1) / n);
        for i in first..end {
            let k = if self.raster.downwards { first + end - 1 - i } else { i };
            let image_row = if self.raster.downwards { height - 1 - k as u32 } else { k as u32 };
            let start = image_row * width;
            if n > 1 {
                (k * n..(k + 1) * n).for_each(|j| self.cover(j, spans));
                self.coverage.draw(start, &self.raster.greys, mask);
            } else if self.raster.panel.mirror_x {
                self.mirrored.clear();
                spans.row(k, |s, e| self.mirrored.push([self.raster.column(s), self.raster.column(e)]));
                for &[from, to] in self.mirrored.iter().rev() {
                    mask.push(start + (width - to), start + (width - from), 255);
                }
            } else {
                spans.row(k, |s, e| {
                    mask.push(start + self.raster.column(s), start + self.raster.column(e), 255);
                });
            }
        }
    }

    /// Notes the ends of a sub-row's spans.
    fn cover(&mut self, k: i32, spans: &mut impl SpanRows) {
        let Raster { left, panel: Panel { width, pitch_x, mirror_x, .. }, .. } = *self.raster;
        let right = i64::from(width) * pitch_x;
        let from_left = |s: i32| (i64::from(s) - left).clamp(0, right);
        spans.row(k, |start, end| {
            let (start, end) = (from_left(start), from_left(end));
            if start < end {
                let (start, end) = if mirror_x { (right - end, right - start) } else { (start, end) };
                for (at, sign) in [(start, 1), (end, -1)] {
                    let (pixel, behind) = self.raster.pixel(at);
                    self.coverage.note(pixel, behind, pitch_x as i32, sign);
                }
            }
        });
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::span::RowsBuilder;

    const PANEL: Panel = Panel {
        width: 6,
        height: 4,
        pitch_x: 1000,
        pitch_y: 2001,
        mirror_x: false,
        mirror_y: false,
        portrait: false,
    };

    /// The edges of a triangle that covers the centres of the pixels 1 and 2 of the lowest row and 1 of
    /// the next; x and y exchanged in portrait.
    fn corner(portrait: bool, origin: [i64; 2]) -> Vec<[Point2; 2]> {
        let ring = [(1400, 900), (2600, 900), (1400, 4000)].map(|(x, y)| {
            let [x, y] = if portrait { [y, x] } else { [x, y] };
            Point2::new((x - origin[0]) as i32, (y - origin[1]) as i32)
        });
        (0..3).map(|i| [ring[i], ring[(i + 1) % 3]]).collect()
    }

    fn drawn(panel: Panel, shading: &Shading) -> Vec<[u32; 3]> {
        let origin = [123, -77];
        let raster = Raster::new(panel, origin, shading).unwrap();
        let mask = Painter::new(&raster).mask(&corner(panel.portrait, origin));
        mask.runs.iter().map(|r| [r.start, r.end, r.value.into()]).collect()
    }

    #[test]
    fn images_lie_as_the_panel_says() {
        let off = Shading::default();
        for portrait in [false, true] {
            let panel = Panel { portrait, ..PANEL };
            // Six pixels a row; the lowest row of the plate is the last of the image.
            assert_eq!(drawn(panel, &off), [[13, 14, 255], [19, 21, 255]]);
            assert_eq!(drawn(Panel { mirror_y: true, ..panel }, &off), [[1, 3, 255], [7, 8, 255]]);
            assert_eq!(drawn(Panel { mirror_x: true, ..panel }, &off), [[16, 17, 255], [21, 23, 255]]);
        }
    }

    #[test]
    fn centres_are_rounded_once_and_spans_are_half_open() {
        let raster = Raster::new(Panel { pitch_x: 1001, ..PANEL }, [0, 0], &Shading::default()).unwrap();
        assert_eq!((raster.rows(), raster.frame().t(0), raster.frame().t(1)), (0..4, 1001, 3002));
        // Centres at 501 and 1502.
        let columns = [-5000, 0, 501, 502, 1502, 1503, 5506, 5507, i32::MAX].map(|s| raster.column(s));
        assert_eq!(columns, [0, 0, 0, 1, 1, 2, 5, 6, 6]);
        let mut rows = RowsBuilder::new(-1);
        for spans in [&[(0, 9000)][..], &[(0, 501), (501, 502), (1503, 9000)], &[(-9, -1), (1502, 1503)]] {
            spans.iter().for_each(|&(start, end)| rows.push(start, end));
            rows.end_row();
        }
        let runs: Vec<_> = raster.mask(&rows.finish()).runs.iter().map(|r| [r.start, r.end]).collect();
        assert_eq!(runs, [[13, 14], [18, 19], [20, 24]]);
    }

    #[test]
    fn coverage_is_exact() {
        let shading = Shading { sub_rows: 2, ..Shading::default() };
        let raster = Raster::new(PANEL, [0, 0], &shading).unwrap();
        let mut rows = RowsBuilder::new(0);
        for spans in [&[(250, 2100)][..], &[(250, 500), (1000, 2100)], &[(-50, 0), (3000, 7000)]] {
            spans.iter().for_each(|&(start, end)| rows.push(start, end));
            rows.end_row();
        }
        let runs: Vec<_> =
            raster.mask(&rows.finish()).runs.iter().map(|r| [r.start, r.end, r.value.into()]).collect();
        // Of 2000 nm: a half in three pixels, then 750 + 250, 1000 + 1000 and 100 + 100.
        assert_eq!(runs, [[15, 19, 128], [19, 20, 255], [20, 21, 26]]);
    }

    #[test]
    fn what_cannot_be_drawn_is_refused() {
        let error = |panel: Panel, origin, sub_rows| {
            let shading = Shading { sub_rows, ..Shading::default() };
            let error = Raster::new(panel, origin, &shading).unwrap_err();
            assert!(!error.to_string().contains('\n'));
            error
        };
        assert_eq!(error(PANEL, [0, 0], 3), RasterError::SubRows(3));
        assert!(matches!(error(Panel { pitch_y: 0, ..PANEL }, [0, 0], 1), RasterError::Pitch { .. }));
        assert!(matches!(error(Panel { width: 0, ..PANEL }, [0, 0], 1), RasterError::Pixels { .. }));
        let wide = Panel { width: 1 << 16, height: 1 << 16, ..PANEL };
        assert!(matches!(error(wide, [0, 0], 1), RasterError::Pixels { .. }));
        let long = Panel { width: 1 << 23, height: 1, ..PANEL };
        assert!(matches!(error(long, [0, 0], 1), RasterError::Size { .. }));
        assert!(matches!(error(PANEL, [i64::MIN, 0], 1), RasterError::Far { .. }));
    }
}
