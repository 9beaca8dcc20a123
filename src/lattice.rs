//! The integer lattice on which all geometry lives.
//!
//! From load to toolpath every coordinate is an `i32` count of nanometres relative to a recorded
//! origin, with `|c| < 2^30` (about 1.07 m to either side). Floats exist at the two borders only:
//! [`nm_from_mm`] on the way in, [`mm`] on the way out.

use bytemuck::{Pod, Zeroable};
use thiserror::Error;

/// Nanometres per millimetre.
pub const NM_PER_MM: f64 = 1e6;

/// Every lattice coordinate satisfies `|c| < LIMIT` \[nm\].
///
/// The bound leaves one spare bit, so that a difference of two coordinates fits an `i32` and a
/// product of two differences plus rounding fits an `i64`.
pub const LIMIT: i32 = 1 << 30;

/// A point of the XY lattice \[nm\]. Ordered by `x`, then `y`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct Point2 {
    /// X \[nm\].
    pub x: i32,
    /// Y \[nm\].
    pub y: i32,
}

/// A point of the XYZ lattice \[nm\]. Ordered by `x`, then `y`, then `z`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(C)]
pub struct Point3 {
    /// X \[nm\].
    pub x: i32,
    /// Y \[nm\].
    pub y: i32,
    /// Z \[nm\].
    pub z: i32,
}

impl Point2 {
    /// The point (x, y) \[nm\].
    pub const fn new(x: i32, y: i32) -> Self {
        Self { x, y }
    }

    /// `self - other` as 64-bit components \[nm\].
    pub fn minus(self, other: Self) -> (i64, i64) {
        (i64::from(self.x) - i64::from(other.x), i64::from(self.y) - i64::from(other.y))
    }

    /// Distance to `other` \[nm\].
    pub fn distance(self, other: Self) -> f64 {
        let (dx, dy) = self.minus(other);
        // Exact up to 2^62, then one rounding in the conversion and one in the root.
        ((dx * dx + dy * dy) as f64).sqrt()
    }

    /// The point at `share`, 0 to 1, of the way to `to`. The way is rounded before it is added, so that the
    /// result moves with its input.
    pub fn toward(self, to: Self, share: f64) -> Self {
        let (dx, dy) = to.minus(self);
        let part = |c: i32, d: i64| (i64::from(c) + (d as f64 * share).round() as i64) as i32;
        Self::new(part(self.x, dx), part(self.y, dy))
    }
}

impl Point3 {
    /// The point (x, y, z) \[nm\].
    pub const fn new(x: i32, y: i32, z: i32) -> Self {
        Self { x, y, z }
    }

    /// The XY part.
    pub const fn xy(self) -> Point2 {
        Point2 { x: self.x, y: self.y }
    }
}

/// Twice the signed area of the triangle (a, b, c) \[nm²\]; positive when counter-clockwise.
///
/// Exact: differences are below 2^31, each product below 2^62, their difference below 2^63.
pub fn cross(a: Point2, b: Point2, c: Point2) -> i64 {
    let (ux, uy) = b.minus(a);
    let (vx, vy) = c.minus(a);
    ux * vy - uy * vx
}

/// Twice the signed area of a closed polygon \[nm²\]; positive when counter-clockwise.
///
/// The last point is joined to the first; fewer than three points give 0. Exact for any ring.
pub fn area2(ring: &[Point2]) -> i128 {
    let Some(&origin) = ring.first() else { return 0 };
    ring.windows(2).map(|w| i128::from(cross(origin, w[0], w[1]))).sum()
}

/// A coordinate that cannot be put on the lattice.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum LatticeError {
    /// Not a number, or infinite.
    #[error("{0} is not a finite number")]
    NotFinite(f64),
    /// Further from the origin than the lattice reaches.
    #[error("{0} mm is outside the lattice of +-1073 mm about the model's centre")]
    OutOfRange(f64),
}

/// Rounds a length to the lattice, halves away from zero.
///
/// # Errors
/// [`LatticeError`] when the length is not finite or not within ±[`LIMIT`].
pub fn nm_from_mm(mm: f64) -> Result<i32, LatticeError> {
    if !mm.is_finite() {
        return Err(LatticeError::NotFinite(mm));
    }
    let nm = (mm * NM_PER_MM).round();
    if nm.abs() < f64::from(LIMIT) { Ok(nm as i32) } else { Err(LatticeError::OutOfRange(mm)) }
}

/// A lattice length in millimetres.
pub fn mm(nm: impl Into<i64>) -> f64 {
    nm.into() as f64 / NM_PER_MM
}

/// A length in millimetres rounded to nanometres, for lengths already known to be sane
/// (validated settings); saturates at ±2^62 instead of failing.
pub fn nm(mm: f64) -> i64 {
    (mm * NM_PER_MM).round().clamp(-4.6e18, 4.6e18) as i64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_way_move_with_it() {
        let (a, b) = (Point2::new(-LIMIT + 1, 3), Point2::new(LIMIT - 1, 1));
        assert_eq!(a.toward(b, 0.0), a);
        assert_eq!(a.toward(b, 1.0), b);
        assert_eq!(a.toward(b, 0.5), Point2::new(0, 2));
        let (c, d) = (Point2::new(10, 20), Point2::new(107, 5));
        let shifted = |p: Point2| Point2::new(p.x - 1_000_003, p.y + 999);
        assert_eq!(shifted(c).toward(shifted(d), 0.37), shifted(c.toward(d, 0.37)));
    }

    #[test]
    fn the_borders_are_checked() {
        assert_eq!(nm_from_mm(0.2), Ok(200_000));
        assert_eq!(nm_from_mm(-0.000_000_5), Ok(-1));
        assert_eq!(nm_from_mm(1_073.741_823), Ok(LIMIT - 1));
        assert!(matches!(nm_from_mm(1_073.741_824), Err(LatticeError::OutOfRange(_))));
        assert!(matches!(nm_from_mm(f64::NAN), Err(LatticeError::NotFinite(_))));
        assert!(matches!(nm_from_mm(f64::INFINITY), Err(LatticeError::NotFinite(_))));
    }

    #[test]
    fn cross_is_exact_in_the_corners() {
        let m = LIMIT - 1;
        let c = cross(Point2::new(-m, -m), Point2::new(m, -m), Point2::new(-m, m));
        assert_eq!(i128::from(c), 4 * i128::from(m) * i128::from(m));
        let square = [(-m, -m), (m, -m), (m, m), (-m, m)].map(|(x, y)| Point2::new(x, y));
        assert_eq!(area2(&square), 8 * i128::from(m) * i128::from(m));
        assert_eq!(area2(&square[..2]), 0);
    }
}
