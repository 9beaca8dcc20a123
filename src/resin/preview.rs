//! Previews in the sizes and encodings that containers store.

use super::Preview;
use super::bytes::Order;

/// Colour beside a preview whose shape is another than the one asked for: dark, but not black, which
/// some firmwares take for "no preview".
pub const BACKGROUND: [u8; 3] = [40, 42, 46];

/// Scales a preview to `width` x `height` pixels: as large as fits without changing its shape, centred
/// on [`BACKGROUND`]. Every pixel is the exact mean of the area that it covers, rounded; integers only,
/// so that all machines agree. A preview whose length contradicts its size gives only background.
pub fn scaled(preview: &Preview, width: u32, height: u32) -> Preview {
    let (source_width, source_height) = (preview.width as usize, preview.height as usize);
    let (width_px, height_px) = (width as usize, height as usize);
    let mut rgb = BACKGROUND.repeat(width_px * height_px);
    let right_length = source_width.checked_mul(source_height).and_then(|n| n.checked_mul(3));
    if preview.rgb.is_empty() || right_length != Some(preview.rgb.len()) {
        return Preview { width, height, rgb };
    }
    let [inner_width, inner_height] = fitted([source_width, source_height], [width_px, height_px]);
    let (left, top) = ((width_px - inner_width) / 2, (height_px - inner_height) / 2);
    let across = Shares::new(source_width, inner_width);
    let down = Shares::new(source_height, inner_height);
    // The shares of one output pixel add up to the source's size along each axis.
    let whole = (source_width * source_height) as u64;

    let mut sums = vec![0u64; 3 * inner_width];
    for y in 0..inner_height {
        sums.fill(0);
        for (source_y, share_y) in down.of(y) {
            let row = preview.rgb.get(3 * source_y * source_width..).unwrap_or_default();
            for (x, sum) in sums.chunks_exact_mut(3).enumerate() {
                for (source_x, share_x) in across.of(x) {
                    let pixel = row.get(3 * source_x..3 * source_x + 3).unwrap_or_default();
                    for (s, c) in sum.iter_mut().zip(pixel) {
                        *s += share_x * share_y * u64::from(*c);
                    }
                }
            }
        }
        let start = 3 * ((top + y) * width_px + left);
        let target = rgb.get_mut(start..start + sums.len()).unwrap_or_default();
        for (t, s) in target.iter_mut().zip(&sums) {
            *t = ((s + whole / 2) / whole) as u8;
        }
    }
    Preview { width, height, rgb }
}

/// The largest size of the shape of `source` that fits into `target`; none is 0 unless the target's is.
fn fitted(source: [usize; 2], target: [usize; 2]) -> [usize; 2] {
    let scale = |to: usize, by: usize, of: usize| ((to * by + of / 2) / of).max(1);
    if target[0] * source[1] <= target[1] * source[0] {
        [target[0], scale(source[1], target[0], source[0]).min(target[1])]
    } else {
        [scale(source[0], target[1], source[1]).min(target[0]), target[1]]
    }
}

/// How `to` pixels in a row share those of a row of `from`.
struct Shares {
    from: usize,
    to: usize,
}

impl Shares {
    fn new(from: usize, to: usize) -> Self {
        Self { from, to }
    }

    /// The source pixels under pixel `i` and their shares, in units of 1/to of a source pixel; they add
    /// up to `from`.
    fn of(&self, i: usize) -> impl Iterator<Item = (usize, u64)> + use<> {
        let (from, to) = (self.from, self.to);
        let (start, end) = (i * from, (i + 1) * from);
        (start / to..end.div_ceil(to))
            .map(move |s| (s, (end.min((s + 1) * to).saturating_sub(start.max(s * to))) as u64))
    }
}

/// A byte as a number of `bits` bits, rounded.
fn reduced(value: u8, bits: u32) -> u16 {
    let most = (1u32 << bits) - 1;
    ((u32::from(value) * most + 127) / 255) as u16
}

fn pixels(preview: &Preview) -> impl Iterator<Item = [u8; 3]> + '_ {
    preview.rgb.chunks_exact(3).map(|p| [p[0], p[1], p[2]])
}

/// RGB565: rows of two bytes a pixel, red in the upper five bits, then six of green, five of blue.
pub fn rgb565(preview: &Preview, order: Order) -> Vec<u8> {
    pixels(preview)
        .flat_map(|[r, g, b]| {
            let pixel = reduced(r, 5) << 11 | reduced(g, 6) << 5 | reduced(b, 5);
            if order == Order::Big { pixel.to_be_bytes() } else { pixel.to_le_bytes() }
        })
        .collect()
}

/// Chitubox's runs of 15-bit pixels, little-endian: red in the upper five bits, five of green, bit 5,
/// five of blue. With bit 5 set, the pixel is followed by 0x3000 + number of its repetitions, of which
/// the vendor's slicer writes at most 0xFFE.
///
/// Source: catibo, `doc/cbddlp-ctb.adoc` (<https://github.com/cbiffle/catibo>).
pub fn rle15(preview: &Preview) -> Vec<u8> {
    const MOST: u16 = 0xFFE;
    let mut out = Vec::new();
    let mut append = |pixel: u16, repetitions: u16| match repetitions {
        0 => out.extend(pixel.to_le_bytes()),
        1 => out.extend([pixel.to_le_bytes(), pixel.to_le_bytes()].as_flattened()),
        n => out.extend([(pixel | 0x20).to_le_bytes(), (0x3000 | n).to_le_bytes()].as_flattened()),
    };
    let mut run: Option<(u16, u16)> = None;
    for [r, g, b] in pixels(preview) {
        let pixel = reduced(r, 5) << 11 | reduced(g, 5) << 6 | reduced(b, 5);
        run = Some(match run {
            Some((last, n)) if last == pixel && n < MOST => (last, n + 1),
            Some((last, n)) => {
                append(last, n);
                (pixel, 0)
            }
            None => (pixel, 0),
        });
    }
    if let Some((last, n)) = run {
        append(last, n);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(width: u32, height: u32, colour: [u8; 3]) -> Preview {
        Preview { width, height, rgb: colour.repeat((width * height) as usize) }
    }

    fn at(p: &Preview, x: usize, y: usize) -> [u8; 3] {
        let i = 3 * (y * p.width as usize + x);
        [p.rgb[i], p.rgb[i + 1], p.rgb[i + 2]]
    }

    #[test]
    fn one_colour_stays_one_colour_and_the_shape_is_kept() {
        for (w, h) in [(1, 1), (7, 5), (800, 480), (3, 1000), (1000, 3), (116, 116)] {
            for (to_w, to_h) in [(1, 1), (116, 116), (290, 290), (400, 300), (200, 125)] {
                let out = scaled(&plain(w, h, [9, 200, 77]), to_w, to_h);
                assert_eq!(out.rgb.len(), (3 * to_w * to_h) as usize);
                assert!(pixels(&out).any(|p| p == [9, 200, 77]), "{w}x{h} to {to_w}x{to_h}");
                assert!(pixels(&out).all(|p| p == [9, 200, 77] || p == BACKGROUND));
                if w * to_h == h * to_w {
                    assert!(pixels(&out).all(|p| p == [9, 200, 77]), "fills all");
                }
            }
        }
        let out = scaled(&plain(200, 100, [255; 3]), 100, 100);
        assert_eq!([at(&out, 0, 24), at(&out, 0, 25)], [BACKGROUND, [255; 3]]);
        assert_eq!([at(&out, 99, 74), at(&out, 99, 75)], [[255; 3], BACKGROUND]);
    }

    #[test]
    fn pixels_are_exact_means() {
        let row = Preview { width: 3, height: 1, rgb: vec![0, 0, 0, 90, 90, 90, 255, 255, 255] };
        // The second of two pixels covers half of the middle one and the last.
        assert_eq!(scaled(&row, 2, 1).rgb[3..], [200; 3]);
        assert_eq!(scaled(&row, 3, 1), row);
        assert_eq!(scaled(&row, 6, 2).rgb[..18], [0, 0, 90, 90, 255, 255].map(|v| [v; 3]).concat());
    }

    #[test]
    fn broken_previews_give_background() {
        for (width, height, length) in [(0, 0, 0), (2, 2, 11), (u32::MAX, u32::MAX, 3), (0, 5, 3)] {
            let out = scaled(&Preview { width, height, rgb: vec![255; length] }, 4, 2);
            assert_eq!(out.rgb, BACKGROUND.repeat(8));
        }
    }

    #[test]
    fn colours_are_packed() {
        let p = Preview { width: 4, height: 1, rgb: vec![255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255] };
        assert_eq!(rgb565(&p, Order::Big), [0xF8, 0, 0x07, 0xE0, 0, 0x1F, 0xFF, 0xFF]);
        assert_eq!(rgb565(&p, Order::Little), [0, 0xF8, 0xE0, 0x07, 0x1F, 0, 0xFF, 0xFF]);
        assert_eq!(rle15(&p), [0, 0xF8, 0xC0, 0x07, 0x1F, 0, 0xDF, 0xFF]);
    }

    #[test]
    fn runs_of_colours_have_their_limits() {
        let red = |n: u32| rle15(&plain(n, 1, [255, 0, 0]));
        assert!(red(0).is_empty());
        assert_eq!(red(1), [0, 0xF8]);
        assert_eq!(red(2), [0, 0xF8, 0, 0xF8]);
        assert_eq!(red(3), [0x20, 0xF8, 0x02, 0x30]);
        assert_eq!(red(0xFFF), [0x20, 0xF8, 0xFE, 0x3F]);
        assert_eq!(red(0x1000), [0x20, 0xF8, 0xFE, 0x3F, 0, 0xF8]);
        assert_eq!(red(0x1002), [0x20, 0xF8, 0xFE, 0x3F, 0x20, 0xF8, 0x02, 0x30]);
    }
}
