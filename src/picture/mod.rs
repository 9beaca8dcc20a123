//! Pictures for people: the part in space and a layer from above. Nothing here reaches the G-code.

pub mod mask_png;
pub mod preview;
pub mod strokes;
pub mod toolpaths;

use image::RgbImage;

/// Places two pictures of equal height side by side.
pub fn beside(left: &RgbImage, right: &RgbImage) -> RgbImage {
    let mut out =
        RgbImage::from_pixel(left.width() + right.width(), left.height().max(right.height()), BACKGROUND);
    image::imageops::replace(&mut out, left, 0, 0);
    image::imageops::replace(&mut out, right, i64::from(left.width()), 0);
    out
}

/// A picture made smaller, if need be, to fit into a frame, in whose middle it lies.
pub fn fitted(picture: &RgbImage, width: u32, height: u32) -> RgbImage {
    let (w, h) = picture.dimensions();
    let scale =
        (f64::from(width) / f64::from(w.max(1))).min(f64::from(height) / f64::from(h.max(1))).min(1.0);
    let side = |n: u32| ((f64::from(n) * scale) as u32).max(1);
    let small = image::imageops::thumbnail(picture, side(w), side(h));
    let mut out = RgbImage::from_pixel(width, height, BACKGROUND);
    let corner =
        [(width, small.width()), (height, small.height())].map(|(a, b)| i64::from(a.saturating_sub(b) / 2));
    image::imageops::replace(&mut out, &small, corner[0], corner[1]);
    out
}

/// Colour behind everything.
pub const BACKGROUND: image::Rgb<u8> = image::Rgb([250, 250, 248]);

/// Averages blocks of `n` x `n` pixels: the pictures are drawn larger and scaled down to smooth edges.
fn downsample(big: &RgbImage, n: u32) -> RgbImage {
    RgbImage::from_fn(big.width() / n, big.height() / n, |x, y| {
        let mut sum = [0u32; 3];
        for (dx, dy) in (0..n).flat_map(|dy| (0..n).map(move |dx| (dx, dy))) {
            for (s, c) in sum.iter_mut().zip(big.get_pixel(x * n + dx, y * n + dy).0) {
                *s += u32::from(c);
            }
        }
        image::Rgb(sum.map(|s| (s / (n * n)) as u8))
    })
}
