//! A family of parallel rows: direction, phase and pitch.

use crate::lattice::Point2;
use std::f64::consts::{PI, SQRT_2};

/// Rows are never closer than this \[units\], sub-rows a sixteenth of it, so that row indices fit an
/// `i32`.
pub const MIN_PITCH: i64 = 1000;

/// Most sub-rows that a row can have.
pub const MAX_SUB_ROWS: usize = 16;

/// A family of parallel rows in the XY plane.
///
/// A frame has two coordinates in *units*: `s` along the rows and `t` across them, turned
/// counter-clockwise from x and y by the angle. Row `k` is the line `t = base + k * pitch`.
///
/// A row may be divided into `n` sub-rows, which are then what is counted: with `k = row * n + j`, row
/// `k` is the line `t = base + row * pitch + offset(j)`, `offset(j) = (2 j + 1) * pitch / (2 n)` rounded
/// to whole units, halves up: the middles of `n` equal strips of the row from `base` on.
///
/// For multiples of 45 degrees the coordinates are exact integers: at 0 and 90 degrees a unit is a
/// nanometre, on the diagonals `s = x + y`, `t = y - x` and a unit is 1/√2 nm. For other angles
/// points are rotated and rounded, which moves them by up to 0.71 nm.
///
/// The base belongs to the mesh frame: the same geometry on two layers meets the same rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowFrame {
    axes: Axes,
    base: i64,
    pitch: i64,
    sub_rows: u32,
    /// Those of the sub-rows; zeros behind.
    offset: [i64; MAX_SUB_ROWS],
}

/// The direction of rows whose coordinates are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Along x: `s = x`, `t = y`.
    X,
    /// Along x + y: `s = x + y`, `t = y - x`.
    Diagonal,
    /// Along y: `s = y`, `t = -x`.
    Y,
    /// Along y - x: `s = y - x`, `t = -x - y`.
    AntiDiagonal,
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
            Axes::of(Axis::X)
        } else if turn == 45.0 {
            Axes::of(Axis::Diagonal)
        } else if turn == 90.0 {
            Axes::of(Axis::Y)
        } else if turn == 135.0 {
            Axes::of(Axis::AntiDiagonal)
        } else {
            let (b, a) = libm::sincos(turn * PI / 180.0);
            Axes::Rotated { a, b }
        };
        let frame = Self { axes, base: 0, pitch: MIN_PITCH, sub_rows: 1, offset: [0; MAX_SUB_ROWS] };
        let pitch = frame.units(pitch).clamp(MIN_PITCH, 1 << 40);
        Self { base: frame.units(phase).rem_euclid(pitch), pitch, ..frame }
    }

    /// Exact rows in the middles of strips: row `r` is the strip from `base + r * pitch` to the next
    /// \[units, `|base|` at most 2^36\], divided into `sub_rows` (1 to [`MAX_SUB_ROWS`]) of which each is
    /// one line.
    pub fn strips(axis: Axis, base: i64, pitch: i64, sub_rows: u32) -> Self {
        let (base, pitch) = (base.clamp(-(1 << 36), 1 << 36), pitch.clamp(MIN_PITCH, 1 << 40));
        let sub_rows = sub_rows.clamp(1, MAX_SUB_ROWS as u32);
        let n = i64::from(sub_rows);
        let mut offset = [0; MAX_SUB_ROWS];
        for (j, offset) in (0..n).zip(&mut offset) {
            *offset = ((2 * j + 1) * pitch + n) / (2 * n);
        }
        Self { axes: Axes::of(axis), base, pitch, sub_rows, offset }
    }

    /// The direction (a, b) of the rows, each in -1..=1, where it is exact: `s = a x + b y`,
    /// `t = a y - b x`.
    pub fn direction(&self) -> Option<[i64; 2]> {
        match self.axes {
            Axes::Exact { a, b } => Some([a, b]),
            Axes::Rotated { .. } => None,
        }
    }

    /// Where the strip of row 0 begins \[units\].
    pub fn base(&self) -> i64 {
        self.base
    }

    /// Number of sub-rows, 1 where rows are not divided.
    pub fn sub_rows(&self) -> u32 {
        self.sub_rows
    }

    /// The sub-rows' distances from the beginning of their row \[units\], ascending, below the pitch.
    /// Length = sub-rows.
    pub fn offsets(&self) -> &[i64] {
        self.offset.get(..self.sub_rows as usize).unwrap_or_default()
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

    /// Distance between undivided rows \[units\].
    #[inline]
    pub fn pitch(&self) -> i64 {
        self.pitch
    }

    /// Area of a unit of span, as wide as the pitch, or the sub-row's share of it \[mm²\].
    pub fn mm2_per_unit(&self) -> f64 {
        self.pitch as f64 / f64::from(self.sub_rows) / (self.scale() * self.scale()) * 1e-12
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
        if self.sub_rows == 1 {
            return self.base + self.offset[0] + i64::from(k) * self.pitch;
        }
        let n = self.sub_rows as i32;
        let offset = self.offset.get(k.rem_euclid(n) as usize).copied().unwrap_or(0);
        self.base + i64::from(k.div_euclid(n)) * self.pitch + offset
    }

    /// The highest row at or below `t` \[units\].
    #[inline]
    pub fn row_below(&self, t: i64) -> i32 {
        if self.sub_rows == 1 {
            return (t - self.base - self.offset[0]).div_euclid(self.pitch) as i32;
        }
        let from_base = t - self.base;
        let (row, rest) = (from_base.div_euclid(self.pitch), from_base.rem_euclid(self.pitch));
        let below = self.offsets().iter().filter(|&&offset| offset <= rest).count() as i32;
        row as i32 * self.sub_rows as i32 + below - 1
    }

    /// The row nearest to `t` \[units\]; the upper one of two.
    #[inline]
    pub fn nearest_row(&self, t: i64) -> i32 {
        if self.sub_rows == 1 {
            return self.row_below(t + self.pitch / 2);
        }
        let below = self.row_below(t);
        if self.t(below + 1) - t <= t - self.t(below) { below + 1 } else { below }
    }
}

impl Axes {
    const fn of(axis: Axis) -> Self {
        match axis {
            Axis::X => Self::Exact { a: 1, b: 0 },
            Axis::Diagonal => Self::Exact { a: 1, b: 1 },
            Axis::Y => Self::Exact { a: 0, b: 1 },
            Axis::AntiDiagonal => Self::Exact { a: -1, b: 1 },
        }
    }
}
