//! Fewer points within a stated tolerance.
//!
//! One pass of cone intersection (the "sleeve" or "cone" family: Sklansky & Gonzalez 1980, "Fast
//! polygonal approximation", Pattern Recognition 12). From an anchor every point passed over leaves
//! a cone of directions that keep it within the tolerance; the chord goes to the last point that lies
//! in all of them. Linear time, and every removed point stays within the tolerance of its chord.
//!
//! Chords between points of an arc lie on its inner side, all of them, by two thirds of their sagitta in the
//! mean: a round part would come out too small. So each chord is then moved until it has as much area on one
//! side as on the other, and the corners with them.

use super::ring;
use crate::lattice::{LIMIT, Point2, area2, cross};

/// Simplifies a closed ring in place; `scratch` is working memory to be reused between calls.
///
/// Every point of the old ring lies within `tolerance` \[nm\] of the new one, whose edges have equal areas of
/// the old one's inside and outside on either side, as far as the tolerance allows. The orientation is
/// kept, and so are at least three points. Then, and for a tolerance of 0 only this: exactly collinear
/// points, repeated points and spikes without area vanish. A ring without any area ends up empty.
///
/// The result starts at its smallest (x, y) and does not depend on where the given ring started.
pub fn simplify(points: &mut Vec<Point2>, scratch: &mut Vec<Point2>, tolerance: i64) {
    ring::canonicalise(points);
    if tolerance > 0 && points.len() > 3 {
        chords(points, scratch, tolerance);
        let kept = scratch.len() >= 3 && area2(points).signum() == area2(scratch).signum();
        if kept && scratch.len() < points.len() {
            std::mem::swap(points, scratch);
        }
    }
    remove_collinear(points);
    ring::canonicalise(points);
}

/// Writes to `out` the ends of the chords that replace the ring, beginning with its first point.
fn chords(ring: &[Point2], out: &mut Vec<Point2>, tolerance: i64) {
    out.clear();
    // A thousandth of a nanometre off pays for all rounding below.
    let reach = tolerance as f64 - 0.001;
    let mut balance = Balance { reach: tolerance as f64 - ROUNDING, shifts: Vec::new() };
    let mut from = 0;
    let mut anchor = ring[0];
    out.push(anchor);
    let mut cone = Cone::open();
    for (i, &p) in ring.iter().enumerate().skip(1) {
        if !cone.admits(anchor, p, reach) {
            // The point before this one is the last that sees all it passes over.
            balance.chord(out.len(), &ring[from..i], ring[i - 1]);
            from = i - 1;
            anchor = ring[from];
            out.push(anchor);
            cone = Cone::open();
            cone.admits(anchor, p, reach);
        }
    }
    if let Some(&last) = ring.last()
        && last != anchor
        && !cone.admits(anchor, ring[0], reach)
    {
        balance.chord(out.len(), &ring[from..], last);
        out.push(last);
        from = ring.len() - 1;
    }
    balance.chord(out.len(), &ring[from..], ring[0]);
    balance.move_corners(out);
}

/// Corners are rounded to the lattice, by up to this \[nm\].
const ROUNDING: f64 = 0.75;

/// How far each chord is to be moved to have equal areas on both sides.
struct Balance {
    /// Most that a point may be off \[nm\].
    reach: f64,
    /// Per chord the way to its right \[nm\]; empty while there is none.
    shifts: Vec<f64>,
}

impl Balance {
    /// Takes in the `number`-th chord, counted from 1, which stands for `run` and then `end`.
    fn chord(&mut self, number: usize, run: &[Point2], end: Point2) {
        let [anchor, passed @ ..] = run else { return };
        let (x, y) = end.minus(*anchor);
        let (x, y) = (x as f64, y as f64);
        let length = (x * x + y * y).sqrt();
        if passed.is_empty() || length <= 0.0 {
            return;
        }
        // Offsets to the right, times the length, and twice the area between the run and the chord.
        let (mut low, mut high, mut area) = (0.0f64, 0.0f64, 0.0);
        let mut before = (0.0, 0.0);
        for p in passed {
            let (px, py) = p.minus(*anchor);
            let at = (px as f64, py as f64);
            let right = side(at, (x, y));
            (low, high) = (low.min(right), high.max(right));
            area += side(before, at);
            before = at;
        }
        area += side(before, (x, y));
        let limits = (high / length - self.reach, low / length + self.reach);
        // Rounding aside, a chord that stays put is within the limits.
        let shift = (0.5 * area / length).min(limits.1.max(0.0)).max(limits.0.min(0.0));
        if shift != 0.0 {
            self.shifts.resize(number, 0.0);
            self.shifts[number - 1] = shift;
        }
    }

    /// Moves the corners of the ring to where its moved edges meet.
    fn move_corners(&mut self, ring: &mut [Point2]) {
        let n = ring.len();
        if self.shifts.is_empty() || n < 3 {
            return;
        }
        self.shifts.resize(n, 0.0);
        let unit = |a: Point2, b: Point2| {
            let (x, y) = b.minus(a);
            let (x, y) = (x as f64, y as f64);
            let length = (x * x + y * y).sqrt();
            (x / length, y / length, length)
        };
        let (first, mut before) = (ring[0], unit(ring[n - 1], ring[0]));
        for i in 0..n {
            let after = unit(ring[i], if i + 1 == n { first } else { ring[i + 1] });
            let shifts = (self.shifts[if i == 0 { n - 1 } else { i - 1 }], self.shifts[i]);
            if shifts != (0.0, 0.0) && before.2 > 0.0 && after.2 > 0.0 {
                let (x, y) = self.corner(before, after, shifts);
                let place = |c: i32, by: f64| (i64::from(c) + by.round() as i64).clamp(-MOST, MOST) as i32;
                ring[i] = Point2::new(place(ring[i].x, x), place(ring[i].y, y));
            }
            before = after;
        }
    }

    /// The way of the corner between two edges, given by direction and length.
    fn corner(
        &self,
        (ux, uy, before): (f64, f64, f64),
        (vx, vy, after): (f64, f64, f64),
        (one, two): (f64, f64),
    ) -> (f64, f64) {
        let (turn, dot) = (ux * vy - uy * vx, ux * vx + uy * vy);
        // Along either edge, times the turn.
        let (along, back) = ((two - one * dot).abs(), (two * dot - one).abs());
        let room = 0.25 * turn.abs();
        // A corner that is one may leave its place by no more than any point may.
        let size2 = one * one + two * two - 2.0 * one * two * dot;
        let blunt = dot > 0.7 || size2 <= self.reach * self.reach * turn * turn;
        if blunt && along < room * before && back < room * after {
            return ((two * ux - one * vx) / turn, (two * uy - one * vy) / turn);
        }
        // Both edges tilt. Each end of them is still moved by no more than it may be.
        let least = if one * two > 0.0 { one.signum() * one.abs().min(two.abs()) } else { 0.0 };
        (least * uy, -least * ux)
    }
}

/// Beyond this there is no lattice.
const MOST: i64 = LIMIT as i64 - 1;

/// The directions from an anchor along which a chord passes all points so far.
struct Cone {
    /// Directions of its right and left border; both zero while every direction is open.
    right: (f64, f64),
    left: (f64, f64),
    /// Square of the largest distance from the anchor so far: a chord must reach as far.
    furthest: f64,
}

impl Cone {
    fn open() -> Self {
        Self { right: (0.0, 0.0), left: (0.0, 0.0), furthest: 0.0 }
    }

    /// Whether the chord from `anchor` may end at `p`; if so, narrows the cone for the next one.
    fn admits(&mut self, anchor: Point2, p: Point2, reach: f64) -> bool {
        let (dx, dy) = p.minus(anchor);
        let d = (dx as f64, dy as f64);
        let square = d.0 * d.0 + d.1 * d.1;
        // An open cone has zero borders, whose products pass both tests.
        if square < self.furthest || side(self.right, d) < 0.0 || side(d, self.left) < 0.0 {
            return false;
        }
        if square > reach * reach {
            self.furthest = square;
            // Perpendicular offset by the tolerance, scaled by the distance: atan in place of asin,
            // which errs on the narrow side and needs no division.
            let length = square.sqrt();
            let (along, across) = ((d.0 * length, d.1 * length), (d.0 * reach, d.1 * reach));
            let right = (along.0 + across.1, along.1 - across.0);
            let left = (along.0 - across.1, along.1 + across.0);
            // The comparisons also hold while the borders are still zero.
            if self.right == (0.0, 0.0) || side(self.right, right) > 0.0 {
                self.right = right;
            }
            if self.left == (0.0, 0.0) || side(left, self.left) > 0.0 {
                self.left = left;
            }
        }
        true
    }
}

/// Positive when `v` lies to the left of `u`.
fn side(u: (f64, f64), v: (f64, f64)) -> f64 {
    u.0 * v.1 - u.1 * v.0
}

/// Removes repeated and exactly collinear points and spikes without area, in place; fewer than three
/// points left mean no area, and the ring becomes empty.
fn remove_collinear(ring: &mut Vec<Point2>) {
    // The kept points form a stack in the front part of the same memory.
    let mut kept = 0;
    for i in 0..ring.len() {
        let p = ring[i];
        kept = pop_behind(ring, kept, p);
        if kept == 0 || ring[kept - 1] != p {
            ring[kept] = p;
            kept += 1;
        }
    }
    ring.truncate(kept);
    // Across the end: a corner at either side of the seam may turn out flat, which may free the next.
    let mut from = 0;
    while ring.len() - from >= 3 {
        let n = ring.len();
        let (first, second, last, before) = (ring[from], ring[from + 1], ring[n - 1], ring[n - 2]);
        if last == first || cross(before, last, first) == 0 {
            ring.pop();
        } else if cross(last, first, second) == 0 {
            from += 1;
        } else {
            break;
        }
    }
    if ring.len() - from < 3 {
        ring.clear();
    } else {
        ring.drain(..from);
    }
}

/// Takes flat corners off a stack of `kept` points before `p` goes onto it; returns its new height.
fn pop_behind(stack: &[Point2], mut kept: usize, p: Point2) -> usize {
    while kept >= 2 && cross(stack[kept - 2], stack[kept - 1], p) == 0 {
        kept -= 1;
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Marsaglia's xorshift64.
    struct Random(u64);
    impl Random {
        fn below(&mut self, n: u64) -> i32 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 % n) as i32
        }
    }

    fn simplified(ring: &[Point2], tolerance: i64) -> Vec<Point2> {
        let mut points = ring.to_vec();
        simplify(&mut points, &mut Vec::new(), tolerance);
        points
    }

    fn ring(points: &[(i32, i32)]) -> Vec<Point2> {
        points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    /// Distance of `p` from the nearest edge of the ring.
    fn distance(p: Point2, ring: &[Point2]) -> f64 {
        (0..ring.len())
            .map(|i| {
                let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
                let (ux, uy) = b.minus(a);
                let (px, py) = p.minus(a);
                let (ux, uy, px, py) = (ux as f64, uy as f64, px as f64, py as f64);
                let t = ((px * ux + py * uy) / (ux * ux + uy * uy)).clamp(0.0, 1.0);
                ((px - t * ux).powi(2) + (py - t * uy).powi(2)).sqrt()
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// A ring that wobbles about a circle, with steps back, clusters and long edges.
    fn wobbly(random: &mut Random, points: u64) -> Vec<Point2> {
        let radius = 1 + random.below(1 << 20);
        let noise = 1 + random.below(1 + radius as u64 / 8) as u64;
        (0..points)
            .map(|i| {
                let angle =
                    (i as f64 + f64::from(random.below(3)) * 0.6) * std::f64::consts::TAU / points as f64;
                let wobble = |c: f64, random: &mut Random| {
                    (c * f64::from(radius)) as i32 + random.below(noise) - noise as i32 / 2
                };
                Point2::new(wobble(angle.cos(), random), wobble(angle.sin(), random))
            })
            .collect()
    }

    #[test]
    fn removed_points_stay_within_the_tolerance() {
        let mut removed = 0;
        for seed in 1..400 {
            let mut random = Random(0x9E37_79B9_7F4A_7C15u64.wrapping_mul(seed));
            let count = 3 + random.below(80) as u64;
            let old = wobbly(&mut random, count);
            let bits = random.below(18);
            let tolerance = i64::from(random.below(1 << bits));
            let new = simplified(&old, tolerance);
            if new.is_empty() {
                assert_eq!(area2(&old), 0, "seed {seed}");
                continue;
            }
            assert!(new.len() >= 3 && new.len() <= old.len(), "seed {seed}");
            assert_eq!(area2(&new).signum(), area2(&old).signum(), "seed {seed}");
            removed += old.len() - new.len();
            for &p in &old {
                let off = distance(p, &new);
                assert!(off <= tolerance as f64 + 1e-6, "seed {seed}: {off} > {tolerance}");
            }
            if tolerance == 0 {
                assert_eq!(area2(&new), area2(&old), "seed {seed}");
            }
        }
        assert!(removed > 1000, "the test removes points: {removed}");
    }

    #[test]
    fn a_checker_of_distances_sees_a_point_too_far_away() {
        let square = ring(&[(0, 0), (100, 0), (100, 100), (0, 100)]);
        assert!(distance(Point2::new(50, -6), &square) > 5.0);
        assert!(distance(Point2::new(107, 107), &square) > 9.0);
    }

    #[test]
    fn the_start_does_not_matter() {
        for seed in 1..100 {
            let mut random = Random(0x9E37_79B9_7F4A_7C15u64.wrapping_mul(seed));
            let mut old = wobbly(&mut random, 50);
            let tolerance = i64::from(random.below(1 << 14));
            let new = simplified(&old, tolerance);
            old.rotate_left(random.below(50) as usize);
            assert_eq!(simplified(&old, tolerance), new, "seed {seed}");
        }
    }

    #[test]
    fn a_fine_circle_needs_few_points() {
        let circle: Vec<_> = (0..50_000)
            .map(|i| f64::from(i) * std::f64::consts::TAU / 50_000.0)
            .map(|a| Point2::new((a.cos() * 2e7) as i32, (a.sin() * 2e7) as i32))
            .collect();
        let new = simplified(&circle, 5_000);
        // The fewest chords with a sagitta of 5 um on a radius of 20 mm are 141.
        assert!((141..180).contains(&new.len()), "{}", new.len());
    }

    #[test]
    fn round_parts_keep_their_area() {
        let arc = |from: i32, to: i32, radius: f64| -> Vec<Point2> {
            let at = |i| f64::from(i) * std::f64::consts::TAU / 8_000.0;
            (from..to)
                .map(|i| Point2::new((at(i).cos() * radius) as i32, (at(i).sin() * radius) as i32))
                .collect()
        };
        let mut bay = arc(0, 2_000, 2e7);
        bay.extend(arc(0, 2_000, 1e7).into_iter().rev());
        for (old, length) in [(arc(0, 8_000, 2e7), 125e6), (bay, 67e6)] {
            let new = simplified(&old, 5_000);
            assert!(new.len() * 10 < old.len(), "{}", new.len());
            let off = (area2(&new) - area2(&old)).abs() as f64 / 2.0 / length;
            // Without the balance it is two thirds of the tolerance.
            assert!(off < 300.0, "{off} nm in the mean");
        }
    }

    #[test]
    fn without_tolerance_only_flat_corners_go() {
        let square = ring(&[(0, 0), (100, 0), (100, 100), (0, 100)]);
        let flat =
            ring(&[(50, 100), (0, 100), (0, 50), (0, 0), (0, 0), (30, 0), (60, 0), (100, 0), (100, 100)]);
        assert_eq!(simplified(&flat, 0), square);
        let spiked = ring(&[
            (-50, 0),
            (0, 0),
            (100, 0),
            (100, 50),
            (180, 50),
            (100, 50),
            (100, 100),
            (0, 100),
            (0, 0),
        ]);
        assert_eq!(simplified(&spiked, 0), square);
        let bent = ring(&[(0, 0), (50, 1), (100, 0), (100, 100), (0, 100)]);
        assert_eq!(simplified(&bent, 0), bent);
        // Half a nanometre of the bend is above the new edge, half below.
        assert_eq!(simplified(&bent, 2), ring(&[(0, 1), (100, 1), (100, 100), (0, 100)]));
    }

    #[test]
    fn rings_without_area_vanish_and_thin_ones_stay() {
        for tolerance in [0, 10, 1_000_000] {
            assert!(simplified(&ring(&[(0, 0), (10, 10), (20, 20), (10, 10)]), tolerance).is_empty());
            assert!(simplified(&ring(&[(0, 0), (10, 0)]), tolerance).is_empty());
            assert!(simplified(&ring(&[(5, 5)]), tolerance).is_empty());
            assert!(simplified(&[], tolerance).is_empty());
            let sliver = ring(&[(0, 0), (1000, 0), (1000, 3), (500, 4), (0, 3)]);
            let mut hole = sliver.clone();
            hole.reverse();
            assert!(area2(&simplified(&sliver, tolerance)) > 0);
            assert!(area2(&simplified(&hole, tolerance)) < 0);
        }
    }
}
