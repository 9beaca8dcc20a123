//! Turning and scaling a part before it is placed.

use super::{Mesh, PlaceError};
use crate::lattice::{LIMIT, Point3};
use rayon::prelude::*;

/// What is done to a part, in this order: scaled, then turned about the vertical.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Factors along x, y and z of the file; the middle of the part's bounding box stays where it is in
    /// x and y, its lowest point in z.
    pub scale: [f64; 3],
    /// Turn about the vertical through that middle, counter-clockwise seen from above \[degrees\].
    pub turn: f64,
}

impl Default for Transform {
    fn default() -> Self {
        Self { scale: [1.0; 3], turn: 0.0 }
    }
}

impl Transform {
    /// True when nothing is to be done.
    pub fn is_identity(&self) -> bool {
        self.scale == [1.0; 3] && self.turn.rem_euclid(360.0) == 0.0
    }

    /// Scales and turns. Every coordinate is rounded to the lattice once; by multiples of 90 degrees
    /// without scaling nothing is rounded but the middle.
    ///
    /// # Errors
    /// [`PlaceError::TooFar`] when a vertex leaves the lattice or a factor is not a positive number,
    /// [`PlaceError::Empty`].
    pub fn apply(&self, mesh: &mut Mesh) -> Result<(), PlaceError> {
        if self.is_identity() {
            return Ok(());
        }
        let [lo, hi] = mesh.bounds().ok_or(PlaceError::Empty)?;
        let middle = |a: i32, b: i32| (i64::from(a) + i64::from(b)).div_euclid(2);
        let centre = [middle(lo.x, hi.x), middle(lo.y, hi.y), i64::from(lo.z)];
        let (sin, cos) = sine_cosine(self.turn);
        let [sx, sy, sz] = self.scale;
        let factors_are_usable =
            self.scale.iter().all(|f| f.is_finite() && *f > 0.0) && self.turn.is_finite();
        let off = |c: i32, axis: usize| (i64::from(c) - centre[axis]) as f64;
        let reach = mesh
            .vertices
            .par_iter_mut()
            .map(|v| {
                let (x, y, z) = (off(v.x, 0) * sx, off(v.y, 1) * sy, off(v.z, 2) * sz);
                let to = [cos * x - sin * y, sin * x + cos * y, z].map(f64::round);
                // Out of range saturates here and is refused below.
                *v = Point3::new(to[0] as i32, to[1] as i32, to[2] as i32);
                to.map(f64::abs).into_iter().fold(0.0, f64::max)
            })
            .reduce(|| 0.0, f64::max);
        if reach >= f64::from(LIMIT) || !factors_are_usable {
            return Err(PlaceError::TooFar { reach: reach * 1e-6 });
        }
        for (origin, centre) in mesh.origin.iter_mut().zip(centre) {
            *origin += centre;
        }
        Ok(())
    }
}

/// Sine and cosine of an angle \[degrees\], exact for multiples of 90.
fn sine_cosine(degrees: f64) -> (f64, f64) {
    let turn = degrees.rem_euclid(360.0);
    match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => libm::sincos(turn * std::f64::consts::PI / 180.0),
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::mesh::shapes::cuboid;

    #[test]
    fn quarter_turns_are_exact_and_keep_the_middle() {
        let part = cuboid([10.0, 20.0, 5.0], [14.0, 30.0, 6.0]);
        let mut turned = part.clone();
        Transform { turn: 90.0, ..Transform::default() }.apply(&mut turned).unwrap();
        let [lo, hi] = turned.world_bounds().unwrap();
        assert_eq!((lo, hi), ([7_000_000, 23_000_000, 5_000_000], [17_000_000, 27_000_000, 6_000_000]));
        Transform { turn: -90.0, ..Transform::default() }.apply(&mut turned).unwrap();
        assert_eq!(turned.world_bounds(), part.world_bounds());
    }

    #[test]
    fn scaling_keeps_the_middle_and_the_bottom() {
        let mut part = cuboid([10.0, 20.0, 5.0], [14.0, 30.0, 6.0]);
        Transform { scale: [2.0, 0.5, 3.0], turn: 0.0 }.apply(&mut part).unwrap();
        let [lo, hi] = part.world_bounds().unwrap();
        assert_eq!((lo, hi), ([8_000_000, 22_500_000, 5_000_000], [16_000_000, 27_500_000, 8_000_000]));
    }

    #[test]
    fn leaving_the_lattice_is_refused() {
        let mut part = cuboid([0.0; 3], [10.0, 10.0, 10.0]);
        let error = Transform { scale: [1.0, 1.0, 1e4], turn: 0.0 }.apply(&mut part).unwrap_err();
        assert!(error.to_string().contains("beyond the lattice"), "{error}");
        let mut part = cuboid([0.0; 3], [10.0, 10.0, 10.0]);
        assert!(Transform { scale: [f64::NAN, 1.0, 1.0], turn: 0.0 }.apply(&mut part).is_err());
    }
}
