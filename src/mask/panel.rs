//! The pixels of a panel, and how they lie on the build plate.

/// A panel: its pixels as stored in a file, and how they lie on the plate.
///
/// The plate is the rectangle from (0, 0) to [`Self::plate`]; it is covered by the lit pixels exactly.
/// Without mirrors and in landscape, the first row of the image is the one at the plate's greatest y,
/// and its first pixel the one at the smallest x: seen from above, as on paper. In portrait the plate's
/// x and y are exchanged before anything else: rows of the image run along the plate's y.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Panel {
    /// Pixels in a row of the stored image.
    pub width: u32,
    /// Rows of the stored image. `width * height` is below 2^32.
    pub height: u32,
    /// Distance of pixel centres along a row \[nm\].
    pub pitch_x: i64,
    /// Distance of rows \[nm\].
    pub pitch_y: i64,
    /// Left and right of the stored image are exchanged.
    pub mirror_x: bool,
    /// Top and bottom of the stored image are exchanged.
    pub mirror_y: bool,
    /// Rows of the image run along the plate's y axis.
    pub portrait: bool,
}

impl Panel {
    /// Number of pixels.
    pub fn pixels(&self) -> u32 {
        self.width.saturating_mul(self.height)
    }

    /// Size of the stored image's lit area along its rows and across them \[nm\].
    pub fn image_nm(&self) -> [i64; 2] {
        [i64::from(self.width) * self.pitch_x, i64::from(self.height) * self.pitch_y]
    }

    /// Size of the plate along its x and y \[nm\].
    pub fn plate(&self) -> [i64; 2] {
        let [x, y] = self.image_nm();
        if self.portrait { [y, x] } else { [x, y] }
    }

    /// Area of a pixel \[mm²\].
    pub fn pixel_mm2(&self) -> f64 {
        self.pitch_x as f64 * self.pitch_y as f64 * 1e-12
    }

    /// Where a point of the stored image lies on the plate \[mm\]. Points are counted in pixels from the
    /// upper left corner of the image: the centre of pixel (x, y) is (x + 0.5, y + 0.5).
    pub fn on_plate(&self, point: [f64; 2]) -> [f64; 2] {
        let [width, height] = self.image_nm().map(|nm| nm as f64 * 1e-6);
        let x = point[0] * self.pitch_x as f64 * 1e-6;
        let y = point[1] * self.pitch_y as f64 * 1e-6;
        let along = if self.mirror_x { width - x } else { x };
        let up = if self.mirror_y { y } else { height - y };
        if self.portrait { [up, along] } else { [along, up] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_of_the_image_are_corners_of_the_plate() {
        let plain = Panel {
            width: 4,
            height: 2,
            pitch_x: 1_000_000,
            pitch_y: 2_000_000,
            mirror_x: false,
            mirror_y: false,
            portrait: false,
        };
        let first = |panel: Panel| panel.on_plate([0.5, 0.5]);
        assert_eq!(first(plain), [0.5, 3.0]);
        assert_eq!(first(Panel { mirror_x: true, ..plain }), [3.5, 3.0]);
        assert_eq!(first(Panel { mirror_y: true, ..plain }), [0.5, 1.0]);
        assert_eq!(first(Panel { portrait: true, ..plain }), [3.0, 0.5]);
        assert_eq!(first(Panel { portrait: true, mirror_x: true, mirror_y: true, ..plain }), [1.0, 3.5]);
        assert_eq!(plain.on_plate([4.0, 0.0]), [4.0, 4.0]);
    }
}
