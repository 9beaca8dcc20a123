//! A picture of one layer with what the checks found in it.

use crate::lattice;
use crate::mask::check::{CheckSettings, Fates, LayerParts, Marks, Reach, Region, Unsupported};
use crate::mask::{MaskLayer, Panel};
use image::{Rgb, RgbImage};

/// Longest side of a picture \[pixels\].
pub const SIDE: u32 = 1200;

/// Room around the lit area \[pixels\].
const MARGIN: u32 = 12;

/// Findings are drawn at least this wide and high, so that single pixels of a large panel are seen
/// \[pixels\].
const LEAST: f64 = 4.0;

const BACKGROUND: Rgb<u8> = Rgb([250, 250, 248]);
const LIT: Rgb<u8> = Rgb([150, 154, 160]);
const OVERHANG: Rgb<u8> = Rgb([240, 200, 40]);
const ISLAND: Rgb<u8> = Rgb([214, 32, 32]);
const CUP: Rgb<u8> = Rgb([48, 110, 220]);
const TRAPPED: Rgb<u8> = Rgb([240, 130, 20]);

/// Draws a layer as it lies on the plate, seen from above, y upwards, cropped to what is lit: solid
/// pixels grey, overhangs yellow, islands red, suction cups blue, trapped resin orange. `below` is the
/// layer beneath, none for layer 0; `marks` and `fates` come from the checks of the whole stack.
pub fn draw(
    mask: &MaskLayer,
    below: Option<&MaskLayer>,
    panel: &Panel,
    settings: &CheckSettings,
    marks: &Marks,
    fates: &Fates,
) -> RgbImage {
    let parts = LayerParts::of(mask, panel, settings.threshold);
    let Some(mut canvas) = Canvas::around(&parts, panel) else {
        return RgbImage::from_pixel(2 * MARGIN, 2 * MARGIN, BACKGROUND);
    };
    for (row, spans) in parts.rows.iter() {
        spans.iter().for_each(|s| canvas.paint(row, [s.start, s.end], LIT, 0.0));
    }
    if let Some(below) = below {
        let below = LayerParts::of(below, panel, settings.threshold);
        let reach = Reach::new(lattice::nm(settings.reach_mm), panel);
        let unsupported = Unsupported::of(&parts, &below, &reach, true);
        for (row, s) in &unsupported.spans {
            canvas.paint(*row, [s.start, s.end], OVERHANG, 0.0);
        }
        let islands: Vec<u32> = unsupported.islands(&parts).collect();
        for (row, _) in parts.rows.iter() {
            for i in parts.rows.range(row) {
                if islands.binary_search(&parts.part[i]).is_ok() {
                    let s = parts.rows.spans()[i];
                    canvas.paint(row, [s.start, s.end], ISLAND, LEAST);
                }
            }
        }
    }
    let mut colors = vec![None; parts.holes.len()];
    for &(hole, void) in &marks.sealed {
        if let Some(color) = colors.get_mut(hole as usize) {
            *color = Some(if fates.is_trapped(void) { TRAPPED } else { CUP });
        }
    }
    for gap in &parts.gaps {
        if let Some(color) = colors[gap.hole as usize] {
            canvas.paint(gap.row, [gap.start, gap.end], color, LEAST);
        }
    }
    canvas.image
}

/// A picture of a rectangle of the plate.
struct Canvas<'a> {
    image: RgbImage,
    panel: &'a Panel,
    /// Left and upper border on the plate \[mm\].
    corner: [f64; 2],
    /// Side of a pixel on the plate \[mm\].
    pixel: f64,
}

impl<'a> Canvas<'a> {
    /// Holds all solid pixels and a margin; none where there are no pixels.
    fn around(parts: &LayerParts, panel: &'a Panel) -> Option<Self> {
        let mut all = Region::default();
        for (row, spans) in parts.rows.iter() {
            spans.iter().for_each(|s| all.add(row, s.start, s.end));
        }
        if all.pixels == 0 {
            return None;
        }
        let (_, [x0, y0, x1, y1]) = all.on_plate(panel);
        let (width, height) = (x1 - x0, y1 - y0);
        let room = f64::from(SIDE - 2 * MARGIN);
        // Not enlarged: a pixel of the panel covers one of the picture at least.
        let least = panel.pitch_x.max(panel.pitch_y) as f64 * 1e-6;
        let pixel = (width.max(height) / room).max(least);
        let side = |mm: f64| ((mm / pixel).ceil() as u32).clamp(1, SIDE - 2 * MARGIN) + 2 * MARGIN;
        let edge = f64::from(MARGIN) * pixel;
        Some(Self {
            image: RgbImage::from_pixel(side(width), side(height), BACKGROUND),
            panel,
            corner: [x0 - edge, y1 + edge],
            pixel,
        })
    }

    /// Fills pixels of the panel, at least `least` pixels of the picture wide and high.
    fn paint(&mut self, row: i32, columns: [i32; 2], color: Rgb<u8>, least: f64) {
        let [y, x0, x1] = [row, columns[0], columns[1]].map(f64::from);
        let (a, b) = (self.panel.on_plate([x0, y]), self.panel.on_plate([x1, y + 1.0]));
        let range = |from: f64, to: f64, size: u32| {
            let more = ((least - (to - from)) / 2.0).max(0.0);
            // A thousandth of a pixel is rounding, not a reason to fill one more.
            let first = (from - more + 1e-3).floor().max(0.0) as u32;
            let end = ((to + more - 1e-3).ceil().max(0.0) as u32).max(first + 1);
            first.min(size)..end.min(size)
        };
        let across = [a[0].min(b[0]), a[0].max(b[0])].map(|x| (x - self.corner[0]) / self.pixel);
        let down = [a[1].max(b[1]), a[1].min(b[1])].map(|y| (self.corner[1] - y) / self.pixel);
        let (width, height) = self.image.dimensions();
        for y in range(down[0], down[1], height) {
            for x in range(across[0], across[1], width) {
                self.image.put_pixel(x, y, color);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;
    use crate::mask::check::{CheckLayer, Checker};
    use std::sync::Arc;

    /// A layer on which everything can be seen, and the one below.
    fn layers(panel: &Panel) -> [MaskLayer; 2] {
        let is_solid = |x: u32, y: u32, z: u32| {
            let block = (10..60).contains(&x) && (10..30).contains(&y) && (z == 1 || x < 40);
            let cup = (15..20).contains(&x) && (15..20).contains(&y) && z == 1;
            let island = z == 1 && [x, y] == [70, 12];
            block && !cup || island
        };
        [0, 1].map(|z| {
            let mut mask = MaskLayer::default();
            for at in (0..panel.pixels()).filter(|at| is_solid(at % panel.width, at / panel.width, z)) {
                mask.push(at, at + 1, 255);
            }
            mask
        })
    }

    fn picture(panel: Panel) -> RgbImage {
        let settings = CheckSettings { reach_mm: 0.0, ..Default::default() };
        let [below, mask] = layers(&panel).map(Arc::new);
        let mut checker = Checker::new(panel, settings);
        let layer = |mask: &Arc<MaskLayer>, z: f64| CheckLayer { mask: mask.clone(), z, height: 0.1 };
        checker.push(&[layer(&below, 0.1), layer(&mask, 0.2)]);
        let found = checker.finish();
        let marks = &found.cups.listed[0].marks;
        draw(&mask, Some(&below), &panel, &settings, marks, &found.fates)
    }

    #[test]
    fn findings_are_seen_where_they_lie() {
        let (pitch_x, pitch_y) = (50_000, 50_000);
        let plain = Panel {
            width: 80,
            height: 40,
            pitch_x,
            pitch_y,
            mirror_x: false,
            mirror_y: false,
            portrait: false,
        };
        let image = picture(plain);
        // From pixel (10, 10) to (71, 30), one to one.
        assert_eq!(image.dimensions(), (61 + 2 * MARGIN, 20 + 2 * MARGIN));
        let at = |image: &RgbImage, x: u32, y: u32| *image.get_pixel(x - 10 + MARGIN, y - 10 + MARGIN);
        assert_eq!(at(&image, 12, 12), LIT);
        assert_eq!(at(&image, 50, 12), OVERHANG);
        assert_eq!(at(&image, 17, 17), CUP);
        assert_eq!(at(&image, 65, 20), BACKGROUND);
        let count = |image: &RgbImage, color| image.pixels().filter(|p| **p == color).count();
        assert_eq!(count(&image, OVERHANG), 20 * 20);
        // The island is a single pixel, drawn larger.
        assert!(at(&image, 70, 12) == ISLAND && count(&image, ISLAND) >= 16);
        // Mirrors are undone, portrait exchanges the axes of the plate.
        let mirrored = picture(Panel { mirror_x: true, ..plain });
        assert_eq!(mirrored, image::imageops::flip_horizontal(&image));
        let mirrored = picture(Panel { mirror_y: true, ..plain });
        assert_eq!(mirrored, image::imageops::flip_vertical(&image));
        let portrait = picture(Panel { portrait: true, ..plain });
        assert_eq!(portrait.dimensions(), (image.height(), image.width()));
        assert_eq!(count(&portrait, CUP), count(&image, CUP));
    }

    #[test]
    fn large_layers_are_scaled_down_and_empty_ones_drawn_too() {
        let panel = Panel {
            width: 11_520,
            height: 5_120,
            pitch_x: 19_000,
            pitch_y: 24_000,
            mirror_x: true,
            mirror_y: false,
            portrait: false,
        };
        let mut mask = MaskLayer::default();
        (1000..3000).for_each(|y| mask.push(y * 11_520 + 100, y * 11_520 + 11_100, 255));
        let settings = CheckSettings::default();
        let image = draw(&mask, None, &panel, &settings, &Marks::default(), &Fates::default());
        assert_eq!(image.width(), SIDE);
        let lit = image.pixels().filter(|p| **p == LIT).count() as f64;
        let pixel = 11_000.0 * 0.019 / f64::from(SIDE - 2 * MARGIN);
        let expected = 11_000.0 * 0.019 * 2000.0 * 0.024 / pixel / pixel;
        assert!((lit / expected - 1.0).abs() < 0.01, "{lit} for {expected}");
        let empty =
            draw(&MaskLayer::default(), None, &panel, &settings, &Marks::default(), &Fates::default());
        assert!(empty.pixels().all(|p| *p == BACKGROUND));
    }
}
