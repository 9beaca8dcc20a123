//! Spans on sub-rows → grey pixels by exact coverage.
//!
//! A span covers a part of its first and last pixel and all between. Each of its ends is noted at its
//! pixel alone, and a sweep over the noted pixels sums them: the cost is that of the border, not of the
//! area. All sums are integers, so their order does not matter.

use super::MaskLayer;

/// How the border of an area is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    /// Sub-rows of a row of pixels: 1, black and white by pixel centres; 2, 4, 8 or 16, grey by coverage.
    pub sub_rows: u32,
    /// Exponent of the grey: 1, as covered; 0, black and white at a half; between, lighter borders.
    pub gamma: f64,
    /// Greys that are neither black nor white are raised to this.
    pub minimum_grey: u8,
}

impl Default for Shading {
    fn default() -> Self {
        Self { sub_rows: 1, gamma: 1.0, minimum_grey: 0 }
    }
}

impl Shading {
    /// The grey to be drawn for each grey of coverage.
    pub fn table(&self) -> [u8; 256] {
        let mut table = [0; 256];
        for (covered, grey) in (0u8..=255).zip(&mut table) {
            let share = f64::from(covered) / 255.0;
            let shown = if self.gamma > 0.0 {
                (libm::pow(share, self.gamma) * 255.0 + 0.5) as u8
            } else if share < 0.5 {
                0
            } else {
                255
            };
            *grey = if (1..255).contains(&shown) { shown.max(self.minimum_grey) } else { shown };
        }
        table
    }
}

/// Coverage → grey.
#[derive(Clone, Debug)]
pub(super) struct Greys {
    table: [u8; 256],
    /// Full coverage: sub-rows times pitch, at most 2^26.
    full: u64,
    /// 2^64 over twice that, rounded up.
    inverse: u64,
}

impl Greys {
    pub(super) fn new(shading: &Shading, pitch: i64) -> Self {
        let full = (u64::from(shading.sub_rows) * pitch.unsigned_abs()).clamp(1, 1 << 26);
        Self { table: shading.table(), full, inverse: u64::MAX / (2 * full) + 1 }
    }

    /// The table's entry for 255 · covered / full, rounded, halves up.
    #[inline]
    fn of(&self, covered: i32) -> u8 {
        // Numerator below 2^36, divisor at most 2^27: exact, as their product is below 2^64.
        let twice = 510 * u64::try_from(covered).unwrap_or(0).min(self.full) + self.full;
        let grey = (u128::from(twice) * u128::from(self.inverse)) >> 64;
        self.table[(grey as usize).min(255)]
    }
}

/// The coverage of a row of pixels.
#[derive(Clone, Debug, Default)]
pub(super) struct Coverage {
    /// Per pixel what the ends in it add to its coverage and to that of each pixel behind it \[nm\].
    sums: Vec<[i32; 2]>,
    /// A bit per pixel in which an end lies.
    noted: Vec<u64>,
    /// A bit per word of `noted` that is not zero: rows are long and ends are few.
    words: Vec<u64>,
}

impl Coverage {
    pub(super) fn new(width: u32) -> Self {
        let pixels = width as usize + 1;
        let words = pixels.div_ceil(64);
        Self { sums: vec![[0; 2]; pixels], noted: vec![0; words], words: vec![0; words.div_ceil(64)] }
    }

    /// An end of a span on one of the sub-rows, in a pixel, with this much of the pixel behind it;
    /// `sign` is -1 where the span ends.
    #[inline]
    pub(super) fn note(&mut self, pixel: u32, behind: i32, pitch: i32, sign: i32) {
        let (pixel, word) = (pixel as usize, pixel as usize / 64);
        let (Some(sum), Some(noted), Some(words)) =
            (self.sums.get_mut(pixel), self.noted.get_mut(word), self.words.get_mut(word / 64))
        else {
            return;
        };
        sum[0] += sign * behind;
        sum[1] += sign * pitch;
        *noted |= 1 << (pixel % 64);
        *words |= 1 << (word % 64);
    }

    /// Draws the row, whose first pixel is number `first`, and begins the next.
    pub(super) fn draw(&mut self, first: u32, greys: &Greys, mask: &mut MaskLayer) {
        let Self { sums, noted, words } = self;
        let (mut at, mut covered, mut grey) = (0u32, 0i32, 0u8);
        for (i, word) in words.iter_mut().enumerate() {
            for word in bits(std::mem::take(word)).map(|bit| 64 * i + bit as usize) {
                let Some(noted) = noted.get_mut(word) else { continue };
                for pixel in bits(std::mem::take(noted)).map(|bit| 64 * word as u32 + bit) {
                    let Some(sum) = sums.get_mut(pixel as usize) else { continue };
                    let [own, behind] = std::mem::take(sum);
                    mask.push(first + at, first + pixel, grey);
                    // The last entry is the edge of the panel, no pixel.
                    if own + covered != 0 {
                        mask.push(first + pixel, first + pixel + 1, greys.of(covered + own));
                    }
                    covered += behind;
                    grey = if covered == 0 { 0 } else { greys.of(covered) };
                    at = pixel + 1;
                }
            }
        }
    }
}

/// The places of the bits that are set, ascending.
fn bits(mut word: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let bit = (word != 0).then(|| word.trailing_zeros())?;
        word &= word - 1;
        Some(bit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(gamma: f64, minimum_grey: u8) -> [u8; 256] {
        Shading { sub_rows: 4, gamma, minimum_grey }.table()
    }

    #[test]
    fn tables_keep_black_and_white() {
        assert!((0..=255).eq(table(1.0, 0)));
        let light = table(0.5, 0);
        assert_eq!([0, 1, 64, 128, 255].map(|v| light[v]), [0, 16, 128, 181, 255]);
        let threshold = table(0.0, 90);
        assert_eq!([0, 1, 127, 128, 255].map(|v| threshold[v]), [0, 0, 0, 255, 255]);
        let raised = table(1.0, 90);
        assert_eq!([0, 1, 89, 90, 91, 254, 255].map(|v| raised[v]), [0, 90, 90, 90, 91, 254, 255]);
        for gamma in [0.0, 0.3, 1.0, 2.2] {
            assert!(table(gamma, 30).is_sorted());
        }
    }

    #[test]
    fn grey_is_the_rounded_share() {
        for (sub_rows, pitch) in [(2, 1000), (16, 1 << 22), (8, 19_000), (4, 28_501)] {
            let greys = Greys::new(&Shading { sub_rows, ..Shading::default() }, pitch);
            let full = i64::from(sub_rows) * pitch;
            for i in 0..=3000 {
                let covered = full * i / 3000;
                let expected = (510 * covered + full) / (2 * full);
                assert_eq!(i64::from(greys.of(covered as i32)), expected, "{covered} of {full}");
            }
        }
    }
}
