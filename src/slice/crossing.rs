//! The exact arithmetic of a plane crossing a triangle. The shaders repeat it in 32-bit pairs.

use crate::lattice::{Point2, Point3};

/// The half-open range of planes that a triangle with this z extent meets; `planes` ascend.
///
/// A vertex is *above* a plane iff `z_vertex >= z_plane`. A triangle meets the planes that have a
/// vertex on either side by that rule: `z_min < z_plane <= z_max`. A horizontal triangle meets none.
pub fn plane_range(z_min: i32, z_max: i32, planes: &[i32]) -> (usize, usize) {
    (planes.partition_point(|&z| z <= z_min), planes.partition_point(|&z| z <= z_max))
}

/// The corner from which a triangle's half-edge goes *down* through plane `z`, and the one from
/// which its half-edge goes *up*.
///
/// The contour enters the triangle over the down edge and leaves over the up edge; with
/// counter-clockwise facets this keeps solid on the left. Meaningful only for a plane that the
/// triangle meets.
pub fn down_up(corner_z: [i32; 3], z: i32) -> (usize, usize) {
    let above = corner_z.map(|c| c >= z);
    let down = match above {
        [true, false, _] => 0,
        [_, true, false] => 1,
        _ => 2,
    };
    let up = match above {
        [false, true, _] => 0,
        [_, false, true] => 1,
        _ => 2,
    };
    (down, up)
}

/// Where the edge between two vertices crosses plane `z` \[nm\], interpolated from the lower vertex
/// and rounded to the lattice, halves away from it. The order of the arguments does not matter: both
/// triangles at an edge compute the same bits.
///
/// `a` and `b` must lie on different sides of the plane by the rule of [`plane_range`].
pub fn point(a: Point3, b: Point3, z: i32) -> Point2 {
    let (lo, hi) = if a.z < z { (a, b) } else { (b, a) };
    // Differences of lattice coordinates are below 2^31, products below 2^62.
    let dz = (i64::from(hi.z) - i64::from(lo.z)) as u64;
    let rise = (i64::from(z) - i64::from(lo.z)) as u64;
    let along = |from: i32, to: i32| {
        let run = u64::from(from.abs_diff(to));
        let step = ((run * rise + dz / 2) / dz) as i32;
        if to >= from { from + step } else { from - step }
    };
    Point2::new(along(lo.x, hi.x), along(lo.y, hi.y))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vertices_on_a_plane_count_as_above() {
        let planes = [0, 10, 20, 30];
        assert_eq!(plane_range(0, 10, &planes), (1, 2));
        assert_eq!(plane_range(-1, 9, &planes), (0, 1));
        assert_eq!(plane_range(10, 10, &planes), (2, 2));
        assert_eq!(plane_range(31, 50, &planes), (4, 4));
    }

    #[test]
    fn every_split_of_a_triangle_has_one_way_in_and_one_out() {
        for bits in 1..7 {
            let corner_z = [0, 1, 2].map(|i| if bits >> i & 1 == 1 { 5 } else { -5 });
            let (down, up) = down_up(corner_z, 0);
            assert!(corner_z[down] >= 0 && corner_z[(down + 1) % 3] < 0, "{corner_z:?}");
            assert!(corner_z[up] < 0 && corner_z[(up + 1) % 3] >= 0, "{corner_z:?}");
        }
    }

    #[test]
    fn a_crossing_is_exact_and_the_same_from_both_sides() {
        let m = crate::lattice::LIMIT - 1;
        let (a, b) = (Point3::new(-m, m, -m), Point3::new(m, -m, m));
        for z in [1 - m, -1, 0, 1, 7, m] {
            // The edge is the diagonal of a cube, so x = z and y = -z.
            assert_eq!(point(a, b, z), Point2::new(z, -z));
            assert_eq!(point(b, a, z), point(a, b, z));
        }
        let (a, b) = (Point3::new(0, 0, 0), Point3::new(3, -3, 2));
        assert_eq!(point(a, b, 1), Point2::new(2, -2), "halves round away from the lower vertex");
    }
}
