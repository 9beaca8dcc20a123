//! One closed contour, one sequence of points: where a ring starts.

use crate::lattice::Point2;

/// Merges consecutive equal points of a closed contour, also across its end.
pub fn merge_repeats(ring: &mut Vec<Point2>) {
    // Repeats are rare, and looking for them is quicker than moving every point.
    if ring.windows(2).fold(false, |any, w| any | (w[0] == w[1])) {
        ring.dedup();
    }
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
}

/// Rotates a ring to its canonical start: the lexicographically smallest of its rotations, which
/// begins at the smallest (x, y).
pub fn canonicalise(ring: &mut [Point2]) {
    let start = start(ring);
    ring.rotate_left(start);
}

/// A key that orders points like [`Point2`] does, by x, then y.
pub fn key(p: Point2) -> u64 {
    let lift = |c: i32| u64::from(c as u32 ^ 0x8000_0000);
    lift(p.x) << 32 | lift(p.y)
}

/// The index at which the lexicographically smallest rotation begins.
pub(super) fn start(ring: &[Point2]) -> usize {
    // Two simple passes are quicker than one that compares whole points.
    let x = ring.iter().fold(i32::MAX, |x, p| x.min(p.x));
    let (mut at, mut y, mut repeated) = (0, i64::MAX, false);
    for (i, p) in ring.iter().enumerate() {
        if p.x == x {
            let own = i64::from(p.y);
            repeated = own == y || repeated && own > y;
            if own < y {
                (at, y) = (i, own);
            }
        }
    }
    if repeated { least_rotation(ring) } else { at }
}

/// Least rotation by two candidates that race each other: when they differ after `k` equal points,
/// the loser's start and the `k` after it are all beaten. Linear time, no memory.
fn least_rotation(ring: &[Point2]) -> usize {
    let n = ring.len();
    let wrap = |i: usize| if i < n { i } else { i - n };
    let (mut a, mut b, mut k) = (0, 1, 0);
    while a < n && b < n && k < n {
        match ring[wrap(a + k)].cmp(&ring[wrap(b + k)]) {
            std::cmp::Ordering::Equal => k += 1,
            order => {
                if order.is_gt() {
                    a += k + 1;
                } else {
                    b += k + 1;
                }
                if a == b {
                    b += 1;
                }
                k = 0;
            }
        }
    }
    a.min(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(x: &[i32]) -> Vec<Point2> {
        x.iter().map(|&x| Point2::new(x / 10, -(x % 10))).collect()
    }

    #[test]
    fn every_rotation_gives_the_same_ring() {
        for points in [
            &[31, 10, 20][..],
            &[10, 20, 10, 21, 10, 20, 10, 22],
            &[10, 20, 10, 20, 10, 20],
            &[10, 10, 10],
            &[30, 10, 10, 30, 10, 10, 10, 40],
            &[50],
        ] {
            let plain = ring(points);
            let expected =
                (0..plain.len()).map(|i| [&plain[i..], &plain[..i]].concat()).min().unwrap_or_default();
            for i in 0..plain.len() {
                let mut turned = plain.clone();
                turned.rotate_left(i);
                canonicalise(&mut turned);
                assert_eq!(turned, expected);
            }
        }
        canonicalise(&mut []);
    }

    #[test]
    fn repeats_merge_across_the_end() {
        let mut r = ring(&[10, 10, 20, 30, 30, 30, 10, 10]);
        merge_repeats(&mut r);
        assert_eq!(r, ring(&[10, 20, 30]));
        let mut point = ring(&[10, 10, 10]);
        merge_repeats(&mut point);
        assert_eq!(point.len(), 1);
    }

    #[test]
    fn keys_order_as_points_do() {
        let m = crate::lattice::LIMIT - 1;
        let points = [(-m, m), (-1, -m), (-1, 0), (0, -1), (0, 0), (0, m), (m, -m)];
        assert!(points.windows(2).all(|w| {
            let [a, b] = [w[0], w[1]].map(|(x, y)| Point2::new(x, y));
            a < b && key(a) < key(b)
        }));
    }
}
