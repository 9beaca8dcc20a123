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
#[inline]
pub fn point(a: Point3, b: Point3, z: i32) -> Point2 {
    // By index: a jump here goes either way as good as at random.
    let ends = [a, b];
    let low = usize::from(a.z >= z);
    point_between(ends[low], ends[1 - low], z)
}

/// [`point`] where the lower vertex is known: for one division of floats. The estimate is off by less
/// than decides any rounding but a near tie, and those are computed exactly.
#[inline(always)]
pub fn point_between(low: Point3, high: Point3, z: i32) -> Point2 {
    // Below 2^31, as coordinates are below 2^30.
    let difference = |to: i32, from: i32| f64::from(to.wrapping_sub(from));
    let part = difference(z, low.z) / difference(high.z, low.z);
    let (x, certain_x) = moved(low.x, part * difference(high.x, low.x));
    let (y, certain_y) = moved(low.y, part * difference(high.y, low.y));
    if certain_x & certain_y { Point2::new(x, y) } else { exact_point(low, high, z) }
}

/// 1.5 · 2^52: adding it leaves a number below 2^31 rounded to an integer, in two's complement in the
/// low 32 bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Nearer to the middle between two integers than this, the estimate may round the wrong way. Quotient
/// and product err by 2^-53 of a value below 2^31 each: 2^-21 in all.
const DOUBT: f64 = 0.5 - 1.0 / (1 << 20) as f64;

/// A coordinate moved by an estimate, and whether it is certain: then it is that of [`exact_point`], where
/// every rounding is to the nearest integer; only ties, which are never certain, need a rule.
#[inline(always)]
pub fn moved(from: i32, estimate: f64) -> (i32, bool) {
    let lifted = estimate + ROUND;
    let off = (estimate - (lifted - ROUND)).abs();
    (from.wrapping_add(lifted.to_bits() as i32), off < DOUBT)
}

/// [`point`] in integers alone: the rule itself, by which the quick ways are measured.
#[cold]
pub fn exact_point(low: Point3, high: Point3, z: i32) -> Point2 {
    // Differences of lattice coordinates are below 2^31, products below 2^62.
    let dz = (i64::from(high.z) - i64::from(low.z)) as u64;
    let rise = (i64::from(z) - i64::from(low.z)) as u64;
    let along = |from: i32, to: i32| {
        let run = u64::from(from.abs_diff(to));
        let step = ((run * rise + dz / 2) / dz) as i32;
        if to >= from { from + step } else { from - step }
    };
    Point2::new(along(low.x, high.x), along(low.y, high.y))
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
    fn the_quick_crossing_has_the_bits_of_the_rule() {
        let seed = 0x9E37_79B9_7F4A_7C15u64;
        let mut state = seed;
        let mut random = |bits: u32| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let c = (state >> 20) as i32 & ((1i64 << bits) - 1) as i32;
            if state & 1 == 0 { c } else { -c }
        };
        let (mut compared, mut ties) = (0, 0);
        for i in 0..500_000 {
            let bits = [30, 20, 8, 3, 2][i % 5];
            let a = Point3::new(random(30), random(bits), random(bits));
            let b = Point3::new(random(bits), random(30), random(30));
            let b = if i % 2 == 0 { b } else { Point3::new(a.x + random(8), b.y, a.z + random(4)) };
            let (low, high) = if a.z < b.z { (a, b) } else { (b, a) };
            let z = [random(30), low.z + 1, high.z, (low.z + high.z) / 2][i % 4];
            if low.z < z && z <= high.z {
                compared += 1;
                let (rise, dz) = (i64::from(z - low.z), i64::from(high.z - low.z));
                ties += i32::from(2 * (i64::from(high.x - low.x).abs() * rise % dz) == dz);
                let exact = exact_point(low, high, z);
                assert_eq!((point(a, b, z), point(b, a, z)), (exact, exact), "seed {seed}: {a:?} {b:?} {z}");
            }
        }
        assert!(compared > 100_000 && ties > 1_000, "{ties} ties of {compared}");
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
