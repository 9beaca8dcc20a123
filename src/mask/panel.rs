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
}
