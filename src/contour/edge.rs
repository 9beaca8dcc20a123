//! An edge prepared to be cut by many planes: the exact crossing for a multiplication per axis.

use crate::lattice::{Point2, Point3};
use crate::slice::crossing;

/// An edge that planes cross, with its slopes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// dx/dz and dy/dz, each rounded once.
    slope: [f64; 2],
    low: Point3,
    /// Height of the upper vertex \[nm\]: the highest plane that crosses the edge.
    pub(super) top: i32,
    /// The half-edge by which the contour enters a triangle.
    pub(super) half_edge: u32,
}

impl Edge {
    pub(super) fn new(low: Point3, high: Point3, half_edge: u32) -> Self {
        // Below 2^31, as coordinates are below 2^30.
        let difference = |to: i32, from: i32| f64::from(to.wrapping_sub(from));
        let dz = difference(high.z, low.z);
        let slope = [difference(high.x, low.x) / dz, difference(high.y, low.y) / dz];
        Self { slope, low, top: high.z, half_edge }
    }

    /// Where plane `z` \[nm\] crosses, and whether that is certain. A certain point is that of
    /// [`crossing::point`]; see [`crossing::moved`].
    #[inline(always)]
    pub(super) fn cut(&self, z: i32) -> (Point2, bool) {
        // Below 2^31 for every plane that crosses the edge.
        let rise = f64::from(z.wrapping_sub(self.low.z));
        let (x, certain_x) = crossing::moved(self.low.x, self.slope[0] * rise);
        let (y, certain_y) = crossing::moved(self.low.y, self.slope[1] * rise);
        (Point2::new(x, y), certain_x & certain_y)
    }

    /// [`Edge::cut`] for a point that was not certain; `high` is the upper vertex.
    #[cold]
    pub(super) fn cut_exactly(&self, high: Point3, z: i32) -> Point2 {
        crossing::exact_point(self.low, high, z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::LIMIT;

    /// The point, and whether the estimate sufficed.
    fn prepared(low: Point3, high: Point3, z: i32) -> (Point2, bool) {
        let edge = Edge::new(low, high, 0);
        let (p, certain) = edge.cut(z);
        if certain { (p, true) } else { (edge.cut_exactly(high, z), false) }
    }

    #[test]
    fn a_prepared_edge_has_the_bits_of_the_exact_crossing() {
        let mut state = 0x9E37_79B9_7F4A_7C15u64;
        let mut random = |bits: u32| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let c = (state >> 20) as i32 & ((1i64 << bits) - 1) as i32;
            if state & 1 == 0 { c } else { -c }
        };
        let (mut compared, mut certain) = (0, 0);
        for i in 0..3_000_000 {
            let bits = [30, 30, 20, 8, 3][i % 5];
            let a = Point3::new(random(30), random(bits), random(bits));
            let b = Point3::new(random(bits), random(30), random(30));
            let (low, high) = if a.z < b.z { (a, b) } else { (b, a) };
            let z = [random(30), low.z + 1, high.z, (low.z + high.z) / 2][i % 4];
            if low.z < z && z <= high.z {
                compared += 1;
                let (p, sure) = prepared(low, high, z);
                certain += i32::from(sure);
                let exact = crossing::exact_point(low, high, z);
                assert_eq!(
                    (p, crossing::point_between(low, high, z)),
                    (exact, exact),
                    "{low:?} {high:?} {z}"
                );
            }
        }
        assert!(compared > 1_000_000 && certain > compared / 2, "{certain} of {compared}");
    }

    #[test]
    fn ties_and_their_neighbours_round_as_the_exact_crossing_does() {
        let m = LIMIT - 1;
        let mut doubtful = 0;
        for dz in [1, 2, 3, 4, 6, 7, 1000, 1001, 65_536, m - 1, m, 2 * (m / 2), 2 * m - 1, 2 * m] {
            for dx in [0, 1, 2, 3, 5, 999, 1000, 32_768, m - 1, m, 2 * m - 1, 2 * m] {
                let rises = (1..=dz.min(40)).chain([dz / 2, dz / 2 + 1, dz - 1, dz]);
                for rise in rises.filter(|&rise| rise > 0 && rise <= dz) {
                    let (low, high) = (Point3::new(-m, dx - m, -m), Point3::new(dx - m, -m, dz - m));
                    let (p, sure) = prepared(low, high, rise - m);
                    doubtful += i32::from(!sure);
                    let exact = crossing::exact_point(low, high, rise - m);
                    assert_eq!(
                        (p, crossing::point_between(low, high, rise - m)),
                        (exact, exact),
                        "{dx} {dz} {rise}"
                    );
                }
            }
        }
        assert!(doubtful > 100, "ties occur: {doubtful}");
    }
}
