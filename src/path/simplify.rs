//! Fewer points on a path, within a tolerance.

use super::nearest::square;
use crate::lattice::Point2;

/// A run of dropped points is at most this long, which bounds the work to O(n).
const LONGEST_RUN: usize = 48;

/// Drops points of the polyline `points[from..]` in place; every dropped point lies within
/// `tolerance` \[nm\] of the segment that replaces it. Both ends stay.
///
/// A greedy pass: a segment from the last kept point grows as long as every point it skips is near
/// enough, which is checked for each of them, so that the bound holds by construction.
pub(super) fn simplify(points: &mut Vec<Point2>, from: usize, tolerance: f64) {
    let n = points.len();
    if tolerance <= 0.0 || n < from + 3 {
        return;
    }
    let limit = tolerance * tolerance;
    let (mut kept, mut anchor) = (from, from);
    // Kept points are written behind the anchor's slot only, so what lies between is still there.
    for end in from + 2..n {
        let a = points[kept];
        let b = points[end];
        let near = end - anchor <= LONGEST_RUN
            && points[anchor + 1..end].iter().all(|p| square_to_segment(*p, a, b) <= limit);
        if !near {
            kept += 1;
            anchor = end - 1;
            points[kept] = points[anchor];
        }
    }
    kept += 1;
    points[kept] = points[n - 1];
    points.truncate(kept + 1);
}

/// Squared distance of `p` to the segment from `a` to `b` \[nm²\].
#[inline]
pub(super) fn square_to_segment(p: Point2, a: Point2, b: Point2) -> f64 {
    let (ux, uy) = b.minus(a);
    let (vx, vy) = p.minus(a);
    let along = ux * vx + uy * vy;
    if along <= 0 {
        return square(p, a) as f64;
    }
    let length = ux * ux + uy * uy;
    if along >= length {
        return square(p, b) as f64;
    }
    let across = (ux * vy - uy * vx) as f64;
    across * across / length as f64
}

#[cfg(test)]
mod tests {
    use super::super::testing::Random;
    use super::*;

    /// True when every point of `before` is within `tolerance` of `after`, in order.
    fn covers(before: &[Point2], after: &[Point2], tolerance: f64) -> bool {
        let mut edge = 0;
        before.iter().all(|p| {
            while edge + 2 < after.len()
                && square_to_segment(*p, after[edge], after[edge + 1]).sqrt() > tolerance * (1.0 + 1e-9)
            {
                edge += 1;
            }
            square_to_segment(*p, after[edge], after[edge + 1]).sqrt() <= tolerance * (1.0 + 1e-9)
        })
    }

    #[test]
    fn dropped_points_are_within_the_tolerance() {
        for seed in 0..200 {
            let mut random = Random::new(seed);
            let n = 2 + random.below(300) as usize;
            let step = 1 + random.below(400_000);
            let (mut x, mut y) = (0, 0);
            let before: Vec<_> = (0..n)
                .map(|_| {
                    x += random.below(step) as i32 - step as i32 / 4;
                    y += random.below(step / 8 + 1) as i32 - step as i32 / 16;
                    Point2::new(x, y)
                })
                .collect();
            let tolerance = random.below(30_000) as f64;
            let mut after = before.clone();
            simplify(&mut after, 0, tolerance);
            assert_eq!((after[0], after.last()), (before[0], before.last()), "seed {seed}");
            assert!(covers(&before, &after, tolerance.max(1e-6)), "seed {seed}");
        }
    }

    #[test]
    fn a_lost_corner_is_noticed() {
        let corner = [(0, 0), (10_000, 0), (10_000, 10_000)].map(|(x, y)| Point2::new(x, y));
        assert!(covers(&corner, &corner, 1.0));
        assert!(!covers(&corner, &[corner[0], corner[2]], 7_000.0));
        assert!(covers(&corner, &[corner[0], corner[2]], 7_100.0));
    }

    #[test]
    fn a_straight_run_becomes_one_segment() {
        let mut line: Vec<_> = (0..40).map(|i| Point2::new(i * 1000, i % 2)).collect();
        line.insert(0, Point2::new(-7, 9_000));
        simplify(&mut line, 1, 5.0);
        assert_eq!(line, [Point2::new(-7, 9_000), Point2::new(0, 0), Point2::new(39_000, 1)]);
    }

    #[test]
    fn a_spur_is_kept() {
        // There and back again: the tip is on the line, but beyond the segment.
        let mut spur = [(0, 0), (5_000_000, 0), (1_000, 0)].map(|(x, y)| Point2::new(x, y)).to_vec();
        simplify(&mut spur, 0, 12_500.0);
        assert_eq!(spur.len(), 3);
    }
}
