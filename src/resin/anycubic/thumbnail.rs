//! The picture in a file.

use crate::resin::Preview;

/// Size of the picture that machines show.
pub(super) const SIZE: [u32; 2] = [224, 168];

/// The picture scaled to fit into [`SIZE`], the rest in the colour of its upper left corner: rows from the
/// top, red in the upper five bits, blue in the lower five.
pub(super) fn rgb565(preview: &Preview) -> Vec<u8> {
    let [width, height] = SIZE;
    let (from_w, from_h) = (u64::from(preview.width), u64::from(preview.height));
    let whole = from_w > 0 && from_h > 0 && preview.rgb.len() as u64 == 3 * from_w * from_h;
    let mut out = Vec::with_capacity((2 * width * height) as usize);
    // The scaled picture keeps its proportions.
    let (w, h) = if !whole || from_w * u64::from(height) > from_h * u64::from(width) {
        (width, (from_h * u64::from(width) / from_w.max(1)).clamp(1, height.into()) as u32)
    } else {
        ((from_w * u64::from(height) / from_h).clamp(1, width.into()) as u32, height)
    };
    let (left, top) = ((width - w) / 2, (height - h) / 2);
    for y in 0..height {
        for x in 0..width {
            let inside = x.checked_sub(left).filter(|x| *x < w).zip(y.checked_sub(top).filter(|y| *y < h));
            let [r, g, b] = match inside {
                _ if !whole => [0; 3],
                Some((x, y)) => average(preview, [x, y], [w, h]),
                None => [preview.rgb[0], preview.rgb[1], preview.rgb[2]],
            };
            let pixel = u16::from(r >> 3) << 11 | u16::from(g >> 2) << 5 | u16::from(b >> 3);
            out.extend_from_slice(&pixel.to_le_bytes());
        }
    }
    out
}

/// The mean colour of the block of pixels that becomes one pixel; where the picture grows, its one pixel.
fn average(preview: &Preview, at: [u32; 2], size: [u32; 2]) -> [u8; 3] {
    let border = |i: u32, n: u32, full: u32| (u64::from(i) * u64::from(full) / u64::from(n)) as usize;
    let range = |i: u32, n: u32, full: u32| {
        let first = border(i, n, full);
        first..border(i + 1, n, full).max(first + 1)
    };
    let (columns, rows) = (range(at[0], size[0], preview.width), range(at[1], size[1], preview.height));
    let mut sum = [0u64; 3];
    for y in rows.clone() {
        for x in columns.clone() {
            let first = 3 * (y * preview.width as usize + x);
            for (s, c) in sum.iter_mut().zip(&preview.rgb[first..first + 3]) {
                *s += u64::from(*c);
            }
        }
    }
    let count = (columns.len() * rows.len()) as u64;
    sum.map(|s| ((s + count / 2) / count) as u8)
}
