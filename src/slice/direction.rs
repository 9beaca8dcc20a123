//! Planes in any direction: the mesh is turned once so that the planes' normal becomes +z.
//!
//! A family of planes is given in Hessian normal form, n·x = d with |n| = 1. In the frame (u, v, n)
//! they are horizontal at the heights d, so everything that cuts horizontally serves them too.

use crate::lattice::{LIMIT, Point3};
use crate::mesh::Mesh;
use glam::DVec3;
use rayon::prelude::*;
use thiserror::Error;

/// Why planes have no direction, or a mesh cannot be turned into it.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
pub enum DirectionError {
    /// No direction at all.
    #[error("the plane normal {},{},{} has no direction; give three finite numbers that are not all 0", .0[0], .0[1], .0[2])]
    NoDirection([f64; 3]),
    /// A long part that leaves the lattice when it is turned.
    #[error(
        "turned to the plane normal, the part reaches {reach_mm:.0} mm from its centre, beyond the lattice's 1073 mm; scale the part down"
    )]
    TooFar {
        /// The furthest coordinate \[mm\].
        reach_mm: f64,
    },
}

/// A right-handed frame whose third axis is the planes' normal.
///
/// `v` is the steepest direction within the planes (z projected onto them) and `u = v × n` is
/// horizontal: seen against the normal, up is up. For n = ±z, `u` is +x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Direction {
    /// First axis in the planes, unit length.
    pub u: DVec3,
    /// Second axis in the planes, unit length.
    pub v: DVec3,
    /// Normal of the planes, unit length.
    pub n: DVec3,
}

impl Direction {
    /// The usual direction, +z.
    pub const UP: Self = Self { u: DVec3::X, v: DVec3::Y, n: DVec3::Z };

    /// The direction of a normal of any length.
    ///
    /// # Errors
    /// [`DirectionError::NoDirection`] when it is zero or not finite.
    pub fn new(normal: [f64; 3]) -> Result<Self, DirectionError> {
        let n = unit(DVec3::from_array(normal)).ok_or(DirectionError::NoDirection(normal))?;
        let u = unit(DVec3::Z.cross(n)).unwrap_or(DVec3::X);
        Ok(Self { u, v: n.cross(u), n })
    }

    /// True for +z, for which nothing need be turned.
    pub fn is_up(&self) -> bool {
        self.n == DVec3::Z
    }

    /// A point's coordinates (u, v, d) in the frame.
    pub fn to_frame(&self, p: DVec3) -> DVec3 {
        DVec3::new(self.u.dot(p), self.v.dot(p), self.n.dot(p))
    }

    /// The point with the coordinates (u, v, d) of the frame.
    pub fn from_frame(&self, p: DVec3) -> DVec3 {
        self.u * p.x + self.v * p.y + self.n * p.z
    }

    /// The mesh in the frame (u, v, n).
    ///
    /// Each coordinate is rounded to the lattice once: a vertex moves by at most √3/2 nm, below
    /// 0.87 nm. Along an axis, whatever its sign, the axes are only exchanged and nothing is rounded;
    /// for +z the mesh is returned as it is.
    ///
    /// # Errors
    /// [`DirectionError::TooFar`] when a vertex leaves the lattice.
    pub fn turn(&self, mut mesh: Mesh) -> Result<Mesh, DirectionError> {
        if self.is_up() {
            return Ok(mesh);
        }
        let reach = mesh
            .vertices
            .par_iter_mut()
            .map(|vertex| {
                let [x, y, z] = [vertex.x, vertex.y, vertex.z].map(f64::from);
                let turned = self.to_frame(DVec3::new(x, y, z)).round();
                // Out of range saturates here and is refused below.
                *vertex = Point3::new(turned.x as i32, turned.y as i32, turned.z as i32);
                turned.abs().max_element()
            })
            .reduce(|| 0.0, f64::max);
        if reach >= f64::from(LIMIT) {
            return Err(DirectionError::TooFar { reach_mm: reach * 1e-6 });
        }
        let [x, y, z] = mesh.origin.map(|c| c as f64);
        mesh.origin = self.to_frame(DVec3::new(x, y, z)).round().to_array().map(|c| c as i64);
        Ok(mesh)
    }
}

/// The vector of length 1 in this direction; `None` for zero and for what is not finite.
fn unit(vector: DVec3) -> Option<DVec3> {
    let largest = vector.abs().max_element();
    if !vector.is_finite() || largest == 0.0 {
        return None;
    }
    // Scaled first, so that no square overflows or vanishes.
    let scaled = vector / largest;
    Some(scaled / scaled.length())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn frames_are_right_handed_and_unit() {
        let normals = [
            [1.0, 2.0, 3.0],
            [-1.0, 1e-9, 5.0],
            [1e300, -1e300, 1e299],
            [5e-324, 0.0, 5e-324],
            [0.3, -0.2, -0.9],
            [1e-200, 0.0, 1.0],
        ];
        for normal in normals {
            let d = Direction::new(normal).unwrap();
            for axis in [d.u, d.v, d.n] {
                assert!((axis.length() - 1.0).abs() < 1e-15, "{normal:?}");
            }
            assert!((d.u.cross(d.v) - d.n).length() < 1e-15, "{normal:?}");
            assert!(d.u.z == 0.0 && d.v.z >= 0.0, "{normal:?}");
        }
    }

    #[test]
    fn along_an_axis_nothing_is_rounded() {
        let part = shapes::moved(shapes::torus(20.0, 7.0, 12, 9), [3.1, -4.7, 11.0]);
        let axes =
            [([0.0, 0.0, -3.0], [0, 1, 2]), ([2.0, 0.0, 0.0], [1, 2, 0]), ([0.0, -1.0, 0.0], [0, 2, 1])];
        for (normal, from) in axes {
            let d = Direction::new(normal).unwrap();
            let turned = d.turn(part.clone()).unwrap();
            for (a, b) in part.vertices.iter().zip(&turned.vertices) {
                let (a, b) = ([a.x, a.y, a.z], [b.x, b.y, b.z]);
                assert!((0..3).all(|i| b[i].abs() == a[from[i]].abs()), "{normal:?}: {a:?} became {b:?}");
            }
            let back =
                Direction { u: d.to_frame(DVec3::X), v: d.to_frame(DVec3::Y), n: d.to_frame(DVec3::Z) };
            assert_eq!(back.turn(turned).unwrap(), part, "{normal:?}");
        }
        let up = Direction::new([0.0, 0.0, 7.5]).unwrap();
        assert_eq!(up, Direction::UP);
        assert_eq!(up.turn(part.clone()).unwrap(), part);
    }

    #[test]
    fn a_vertex_moves_by_less_than_a_nanometre() {
        let part = shapes::sphere(400.0, 60, 40);
        let d = Direction::new([3.0, -2.0, 1.5]).unwrap();
        let turned = d.turn(part.clone()).unwrap();
        for (a, b) in part.vertices.iter().zip(&turned.vertices) {
            let [a, b] = [a, b].map(|p| DVec3::new(p.x.into(), p.y.into(), p.z.into()));
            assert!((d.from_frame(b) - a).length() <= 0.8661, "{a:?} {b:?}");
        }
    }

    #[test]
    fn no_direction_and_too_far_are_refused() {
        for bad in [[0.0; 3], [f64::NAN, 0.0, 1.0], [0.0, f64::INFINITY, 0.0], [-0.0, 0.0, 0.0]] {
            assert!(matches!(Direction::new(bad), Err(DirectionError::NoDirection(_))));
        }
        let long = shapes::cuboid([0.0; 3], [2000.0, 2000.0, 1.0]);
        let error = Direction::new([1.0, 1.0, 0.0]).unwrap().turn(long).unwrap_err();
        assert!(error.to_string().contains("1414 mm"), "{error}");
    }
}
