//! A family of parallel rows: direction, phase and pitch.

use crate::lattice::Point2;
use std::f64::consts::{PI, SQRT_2};

/// Rows are never closer than this \[units\], so that row indices fit an `i32`.
pub const MIN_PITCH: i64 = 1000;

/// A family of parallel rows in the XY plane.
///
/// A frame has two coordinates in *units*: `s` along the rows and `t` across them, turned
/// counter-clockwise from x and y by the angle. Row `k` is the line `t = phase + k * pitch`.
///
/// For multiples of 45 degrees the coordinates are exact integers: at 0 and 90 degrees a unit is a
/// nanometre, on the diagonals `s = x + y`, `t = y - x` and a unit is 1/√2 nm. For other angles
/// points are rotated and rounded, which moves them by up to 0.71 nm.
///
/// The phase belongs to the mesh frame: the same geometry on two layers meets the same rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowFrame {
    axes: Axes,
    phase: i64,
    pitch: i64,
}

/// The direction (a, b) of the rows: `s = a x + b y`, `t = a y - b x`.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Axes {
    /// a, b in -1..=1.
    Exact { a: i64, b: i64 },
    /// Cosine and sine.
    Rotated { a: f64, b: f64 },
}

impl RowFrame {
    /// Rows at `degrees` counter-clockwise from +x (modulo 180), `pitch` \[nm\] apart, one of them
    /// `phase` \[nm\] from the zero of the mesh frame.
    pub fn new(degrees: f64, phase: f64, pitch: f64) -> Self {
        let turn = if degrees.is_finite() { degrees.rem_euclid(180.0) } else { 0.0 };
        let axes = if turn == 0.0 || turn == 180.0 {
            Axes::Exact { a: 1, b: 0 }
        } else if turn == 45.0 {
            Axes::Exact { a: 1, b: 1 }
        } else if turn == 90.0 {
            Axes::Exact { a: 0, b: 1 }
        } else if turn == 135.0 {
            Axes::Exact { a: -1, b: 1 }
        } else {
            let (b, a) = libm::sincos(turn * PI / 180.0);
            Axes::Rotated { a, b }
        };
        let frame = Self { axes, phase: 0, pitch: MIN_PITCH };
        let pitch = frame.units(pitch).clamp(MIN_PITCH, 1 << 40);
        Self { axes, phase: frame.units(phase).rem_euclid(pitch), pitch }
    }

    /// Units per nanometre: 1, or √2 on the diagonals.
    #[inline]
    pub fn scale(&self) -> f64 {
        match self.axes {
            Axes::Exact { a, b } if a * b != 0 => SQRT_2,
            _ => 1.0,
        }
    }

    /// A length \[nm\] in units, rounded.
    #[inline]
    pub fn units(&self, nm: f64) -> i64 {
        (nm * self.scale()).round() as i64
    }

    /// Distance between rows \[units\].
    #[inline]
    pub fn pitch(&self) -> i64 {
        self.pitch
    }

    /// Area of a unit of span, as wide as the pitch \[mm²\].
    pub fn mm2_per_unit(&self) -> f64 {
        self.pitch as f64 / (self.scale() * self.scale()) * 1e-12
    }

    /// The frame's coordinates (s, t) of a point. No lattice point overflows: |x| and |y| are below
    /// 2^30, so that |x ± y| is below 2^31.
    #[inline]
    pub fn st(&self, p: Point2) -> (i32, i32) {
        let (x, y) = (i64::from(p.x), i64::from(p.y));
        match self.axes {
            Axes::Exact { a, b } => ((a * x + b * y) as i32, (a * y - b * x) as i32),
            Axes::Rotated { a, b } => {
                let (x, y) = (x as f64, y as f64);
                ((a * x + b * y).round() as i32, (a * y - b * x).round() as i32)
            }
        }
    }

    /// The lattice point nearest to (s, t), off by at most half a nanometre in x and in y.
    #[inline]
    pub fn xy(&self, s: i32, t: i64) -> Point2 {
        let s = i64::from(s);
        match self.axes {
            Axes::Exact { a, b } => {
                let n = a * a + b * b;
                // n is 1 or 2: halves round up.
                let round = |v: i64| ((v + n / 2).div_euclid(n)) as i32;
                Point2::new(round(a * s - b * t), round(b * s + a * t))
            }
            Axes::Rotated { a, b } => {
                let (s, t) = (s as f64, t as f64);
                Point2::new((a * s - b * t).round() as i32, (b * s + a * t).round() as i32)
            }
        }
    }

    /// Position of row `k` across the rows \[units\].
    #[inline]
    pub fn t(&self, k: i32) -> i64 {
        self.phase + i64::from(k) * self.pitch
    }

    /// The highest row at or below `t` \[units\].
    #[inline]
    pub fn row_below(&self, t: i64) -> i32 {
        (t - self.phase).div_euclid(self.pitch) as i32
    }

    /// The row nearest to `t` \[units\]; the upper one of two.
    #[inline]
    pub fn nearest_row(&self, t: i64) -> i32 {
        self.row_below(t + self.pitch / 2)
    }
}
