//! A picture of supports: from the front and from above.

use crate::picture::{BACKGROUND, beside};
use crate::span::{RowFrame, Rows};
use crate::support::check::Print;
use image::{Rgb, RgbImage};

/// Sides of each of the two views \[pixels\].
const VIEW: [u32; 2] = [900, 900];

/// Room around what is drawn \[pixels\].
const MARGIN: f64 = 30.0;

const PART: [f64; 3] = [186.0, 190.0, 196.0];
const HANGS: [f64; 3] = [222.0, 52.0, 40.0];
const COLUMN: [f64; 3] = [70.0, 168.0, 84.0];
const INTERFACE: [f64; 3] = [206.0, 62.0, 176.0];

/// Draws the part grey, what hangs red, columns, branches and raft green, dense layers magenta: on the left
/// from the front, the nearest in front, darker behind; on the right from above, seen through.
pub fn draw(print: &Print) -> RgbImage {
    let Some([low, high]) = bounds(print) else { return RgbImage::from_pixel(8, 8, BACKGROUND) };
    let mut front = Front::new([low[0], low[2]], [high[0], high[2]], [low[1], high[1]]);
    let mut above = Above::new([low[0], low[1]], [high[0], high[1]]);
    let frame = print.part.frame;
    for (outline, level) in print.part.outlines.iter().zip(print.part.levels) {
        let z = [level.bottom as f64, level.top as f64];
        points(outline, frame, front.pixel, |p| front.put(p, z, PART));
        points(outline, frame, above.pixel, |p| above.put(p, 0));
    }
    for layer in print.supports {
        let z = [f64::from(layer.bottom_z()), f64::from(layer.print_z)];
        for (rows, color, bit) in [
            (&layer.base, COLUMN, 1),
            (&layer.interface, INTERFACE, 2),
            (&layer.bottom_interface, INTERFACE, 2),
        ] {
            points(rows, frame, front.pixel, |p| front.put(p, z, color));
            points(rows, frame, above.pixel, |p| above.put(p, bit));
        }
    }
    for (hangs, level) in print.overhangs.iter().zip(print.part.levels) {
        // At least two pixels high, in front of the layer that it is a part of.
        let z = [(level.top as f64 - 2.0 * front.pixel).min(level.bottom as f64), level.top as f64];
        points(&hangs.area, frame, front.pixel, |p| front.put([p[0], p[1] - 1.0], z, HANGS));
        points(&hangs.area, frame, above.pixel, |p| above.put(p, 3));
    }
    beside(&front.image(), &above.image())
}

/// Points of an area that are no more than `step` \[nm\] apart, with x and y \[nm\]; a row is as wide as the
/// rows are apart.
fn points(area: &Rows, frame: &RowFrame, step: f64, mut visit: impl FnMut([f64; 2])) {
    let step = ((step * frame.scale()) as i64).max(1);
    let across = frame.pitch() / step + 1;
    for (k, row) in area.iter() {
        for span in row {
            let steps = span.length() / step + 1;
            for (i, j) in (0..=steps).flat_map(|i| (0..across).map(move |j| (i, j))) {
                let s = i64::from(span.start) + span.length() * i / steps;
                let t = frame.t(k) + frame.pitch() * (2 * j + 1 - across) / (2 * across);
                let p = frame.xy(s as i32, t);
                visit([p.x.into(), p.y.into()]);
            }
        }
    }
}

/// Lowest and highest coordinates of everything \[nm\].
fn bounds(print: &Print) -> Option<[[f64; 3]; 2]> {
    let (mut low, mut high) = ([f64::MAX; 3], [f64::MIN; 3]);
    let mut add = |rows: &Rows, bottom: f64, top: f64| {
        // The ends of spans are enough.
        points(rows, print.part.frame, f64::MAX, |[x, y]| {
            for (axis, c) in [(0, x), (1, y), (2, bottom), (2, top)] {
                low[axis] = low[axis].min(c);
                high[axis] = high[axis].max(c);
            }
        });
    };
    for (outline, level) in print.part.outlines.iter().zip(print.part.levels) {
        add(outline, level.bottom as f64, level.top as f64);
    }
    for layer in print.supports {
        for rows in [&layer.base, &layer.interface, &layer.bottom_interface] {
            add(rows, f64::from(layer.bottom_z()), f64::from(layer.print_z));
        }
    }
    (low[0] <= high[0]).then_some([low, high])
}

/// Nanometres of a pixel at which a rectangle fills a view.
fn pixel(low: [f64; 2], high: [f64; 2]) -> f64 {
    let of = |axis: usize| (high[axis] - low[axis]) / (f64::from(VIEW[axis]) - 2.0 * MARGIN);
    of(0).max(of(1)).max(1000.0)
}

/// Where a point lies in a view.
fn place(p: [f64; 2], low: [f64; 2], pixel: f64) -> Option<usize> {
    let x = (p[0] - low[0]) / pixel + MARGIN;
    let y = f64::from(VIEW[1]) - 1.0 - MARGIN - (p[1] - low[1]) / pixel;
    let fits = (0.0..f64::from(VIEW[0])).contains(&x) && (0.0..f64::from(VIEW[1])).contains(&y);
    fits.then(|| y as usize * VIEW[0] as usize + x as usize)
}

fn image(colors: impl Fn(usize) -> Option<[f64; 3]>) -> RgbImage {
    RgbImage::from_fn(VIEW[0], VIEW[1], |x, y| {
        colors((y * VIEW[0] + x) as usize).map_or(BACKGROUND, |c| Rgb(c.map(|c| c as u8)))
    })
}

/// Seen along +y: x to the right, z up.
struct Front {
    low: [f64; 2],
    /// Nearest and farthest y.
    depth: [f64; 2],
    pixel: f64,
    pixels: Vec<Option<(f64, [f64; 3])>>,
}

impl Front {
    fn new(low: [f64; 2], high: [f64; 2], depth: [f64; 2]) -> Self {
        let pixels = vec![None; (VIEW[0] * VIEW[1]) as usize];
        Self { low, depth, pixel: pixel(low, high), pixels }
    }

    fn put(&mut self, [x, y]: [f64; 2], [bottom, top]: [f64; 2], color: [f64; 3]) {
        let steps = ((top - bottom) / self.pixel).ceil().max(1.0) as u32;
        for i in 0..steps {
            let z = bottom + (top - bottom) * (f64::from(i) + 0.5) / f64::from(steps);
            let own = place([x, z], self.low, self.pixel).and_then(|at| self.pixels.get_mut(at));
            if let Some(own) = own
                && own.is_none_or(|(depth, _)| y < depth)
            {
                *own = Some((y, color));
            }
        }
    }

    fn image(&self) -> RgbImage {
        let [near, far] = self.depth;
        image(|at| {
            let (depth, color) = self.pixels.get(at).copied().flatten()?;
            let share = ((depth - near) / (far - near).max(1.0)).clamp(0.0, 1.0);
            Some(color.map(|c| c * (1.0 - 0.45 * share)))
        })
    }
}

/// Seen from above, through everything: x to the right, y up.
struct Above {
    low: [f64; 2],
    pixel: f64,
    /// One bit for each kind of thing: part, columns, dense layers, what hangs.
    pixels: Vec<u8>,
}

impl Above {
    fn new(low: [f64; 2], high: [f64; 2]) -> Self {
        Self { low, pixel: pixel(low, high), pixels: vec![0; (VIEW[0] * VIEW[1]) as usize] }
    }

    fn put(&mut self, p: [f64; 2], bit: u8) {
        if let Some(own) = place(p, self.low, self.pixel).and_then(|at| self.pixels.get_mut(at)) {
            *own |= 1 << bit;
        }
    }

    fn image(&self) -> RgbImage {
        image(|at| {
            let bits = self.pixels.get(at).copied().filter(|b| *b > 0)?;
            let mut color = [250.0, 250.0, 248.0];
            let layers = [(PART, 1.0), (COLUMN, 0.7), (INTERFACE, 0.35), (HANGS, 0.45)];
            for (bit, (own, share)) in layers.into_iter().enumerate() {
                if bits >> bit & 1 == 1 {
                    color = std::array::from_fn(|i| color[i] * (1.0 - share) + own[i] * share);
                }
            }
            Some(color)
        })
    }
}
