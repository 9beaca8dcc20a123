//! A run of planes, one after the other: which triangles the plane meets, and the walk through them.

use super::finish::Finish;
use super::surface::{Crossing, Surface};
use crate::lattice::{Point2, Point3};
use std::ops::Range;

/// The planes that a triangle meets, `first..end`, not empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Span {
    pub(super) triangle: u32,
    pub(super) first: u32,
    pub(super) end: u32,
}

/// The state of a sweep over a run of planes.
pub(super) struct Sweep<'a> {
    surface: Surface<'a>,
    planes: &'a [i32],
    run: Range<usize>,
    /// Triangles by the plane where they begin, and by that where they end.
    begin: Buckets,
    end: Buckets,
    /// Triangles that the current plane meets.
    active: BitSet,
    /// Those of them not yet walked: empty between planes.
    todo: Vec<u64>,
    /// Points in front of the place where the walk of an open chain began.
    before: Vec<Point2>,
}

impl<'a> Sweep<'a> {
    /// `lists` hold the spans that meet the run, and maybe others.
    pub(super) fn new(
        surface: Surface<'a>,
        planes: &'a [i32],
        lists: &[Vec<Span>],
        run: Range<usize>,
    ) -> Self {
        let (from, to) = (run.start as u32, run.end as u32);
        let spans = || lists.iter().flatten().filter(|s| s.first < to && s.end > from);
        let words = (surface.corners.len() / 3).div_ceil(64);
        Self {
            surface,
            planes,
            begin: Buckets::new(run.len(), || spans().map(|s| (s.first.max(from) - from, s.triangle))),
            end: Buckets::new(run.len(), || {
                spans().filter(|s| s.end < to).map(|s| (s.end - from, s.triangle))
            }),
            run,
            active: BitSet { words: vec![0; words], summary: vec![0; words.div_ceil(64)] },
            todo: vec![0; words],
            before: Vec::new(),
        }
    }

    /// Hands the contours of plane `k` to `finish`; to be called for all planes of the run in order.
    pub(super) fn plane(&mut self, k: usize, finish: &mut Finish<'_>) {
        let here = k - self.run.start;
        for &t in self.end.of(here) {
            self.active.remove(t as usize);
        }
        for &t in self.begin.of(here) {
            self.active.insert(t as usize);
        }
        self.touch(here);
        let z = self.planes[k];
        for s in 0..self.active.summary.len() {
            let mut bits = self.active.summary[s];
            while bits != 0 {
                let w = 64 * s + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                self.todo[w] = self.active.words[w];
            }
        }
        for s in 0..self.active.summary.len() {
            let mut bits = self.active.summary[s];
            while bits != 0 {
                let w = 64 * s + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                while self.todo[w] != 0 {
                    self.walk(64 * w + self.todo[w].trailing_zeros() as usize, z, finish);
                }
            }
        }
    }

    /// Reads what the walk will need of the triangles that begin here. The walk waits for each read
    /// before it knows the next; these wait for none, so the caches fill several times faster.
    fn touch(&self, here: usize) {
        let mut sum = 0;
        for &t in self.begin.of(here) {
            let edge = 3 * t as usize;
            sum ^= self.surface.twin[edge];
            for &vertex in &self.surface.corners[edge..edge + 3] {
                sum ^= self.surface.vertices[vertex as usize].x as u32;
            }
        }
        std::hint::black_box(sum);
    }

    /// Follows the contour through triangle `start` around, or to both of its ends.
    fn walk(&mut self, start: usize, z: i32, finish: &mut Finish<'_>) {
        let surface = self.surface;
        let first = surface.entry(start, z);
        let (mut at, mut t) = (first, start);
        loop {
            self.todo[t / 64] &= !(1 << (t % 64));
            finish.point(point(at.below, at.above, z));
            surface.forward(&mut at, z);
            t = at.edge / 3;
            let unwalked = self.todo.get(t / 64).is_some_and(|word| word >> (t % 64) & 1 == 1);
            if !unwalked {
                break;
            }
        }
        if t == start {
            finish.close();
            return;
        }
        finish.point(point(at.below, at.above, z));
        self.walk_back(first, z);
        finish.leave_open(&self.before);
    }

    /// Collects the points in front of a crossing, against the direction of the contour.
    fn walk_back(&mut self, first: Crossing, z: i32) {
        self.before.clear();
        let mut at = first;
        loop {
            at.edge = self.surface.twin[at.edge] as usize;
            let t = at.edge / 3;
            let unwalked = self.todo.get(t / 64).is_some_and(|word| word >> (t % 64) & 1 == 1);
            if !unwalked {
                break;
            }
            self.todo[t / 64] &= !(1 << (t % 64));
            self.surface.backward(&mut at, z);
            self.before.push(point(at.below, at.above, z));
        }
    }
}

/// 2^52, the least float whose neighbours are whole numbers, and its bits.
const TWO_52: f64 = 4_503_599_627_370_496.0;
const TWO_52_BITS: i64 = 0x4330_0000_0000_0000;

/// [`crate::slice::crossing::point`] by a float estimate that is set right exactly: the same bits for
/// less than a division of integers, and no panic on an edge that does not cross the plane.
#[inline]
fn point(below: Point3, above: Point3, z: i32) -> Point2 {
    let dz = i64::from(above.z) - i64::from(below.z);
    let rise = i64::from(z) - i64::from(below.z);
    let inverse = 1.0 / dz as f64;
    let along = |from: i32, to: i32| {
        let run = i64::from(to) - i64::from(from);
        let product = run.abs() * rise + dz / 2;
        // Below 2^31 with a relative error of about 2^-52: off by one at most.
        // Adding 2^52 leaves the integer in the low bits: cheaper than a saturating conversion.
        let estimate = ((product as f64 * inverse + TWO_52).to_bits() as i64).wrapping_sub(TWO_52_BITS);
        let rest = product.wrapping_sub(estimate.wrapping_mul(dz));
        let step = estimate.wrapping_add(i64::from(rest >= dz) - i64::from(rest < 0));
        i64::from(from).wrapping_add(if run < 0 { step.wrapping_neg() } else { step }) as i32
    };
    Point2::new(along(below.x, above.x), along(below.y, above.y))
}

/// Triangles sorted by a plane of the run.
pub(super) struct Buckets {
    base: Vec<u32>,
    triangles: Vec<u32>,
}

impl Buckets {
    /// Counting sort of (plane, triangle) pairs, each plane below `planes`.
    pub(super) fn new<I: Iterator<Item = (u32, u32)>>(planes: usize, pairs: impl Fn() -> I) -> Self {
        let mut base = vec![0u32; planes + 2];
        for (plane, _) in pairs() {
            base[plane as usize + 2] += 1;
        }
        for k in 2..base.len() {
            base[k] += base[k - 1];
        }
        let mut triangles = vec![0; base[planes + 1] as usize];
        for (plane, triangle) in pairs() {
            let cursor = &mut base[plane as usize + 1];
            triangles[*cursor as usize] = triangle;
            *cursor += 1;
        }
        Self { base, triangles }
    }

    /// Those of a plane.
    pub(super) fn of(&self, plane: usize) -> &[u32] {
        &self.triangles[self.range(plane)]
    }

    /// Where those of a plane are.
    pub(super) fn range(&self, plane: usize) -> Range<usize> {
        self.base[plane] as usize..self.base[plane + 1] as usize
    }

    /// One of them.
    pub(super) fn triangle(&self, at: usize) -> u32 {
        self.triangles[at]
    }
}

/// A set of triangle ids with a second level that marks its words in use.
struct BitSet {
    words: Vec<u64>,
    summary: Vec<u64>,
}

impl BitSet {
    fn insert(&mut self, t: usize) {
        self.words[t / 64] |= 1 << (t % 64);
        self.summary[t / 4096] |= 1 << (t / 64 % 64);
    }

    fn remove(&mut self, t: usize) {
        self.words[t / 64] &= !(1 << (t % 64));
        if self.words[t / 64] == 0 {
            self.summary[t / 4096] &= !(1 << (t / 64 % 64));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::LIMIT;
    use crate::slice::crossing;

    #[test]
    fn the_quick_crossing_has_the_bits_of_the_exact_one() {
        let mut state = 0x9E37_79B9_7F4A_7C15u64;
        let mut random = |bits: u32| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            let c = (state >> 20) as i32 & ((1i64 << bits) - 1) as i32;
            if state & 1 == 0 { c } else { -c }
        };
        let mut compared = 0;
        for i in 0..300_000 {
            let bits = [30, 30, 20, 8, 3][i % 5];
            let a = Point3::new(random(30), random(bits), random(bits));
            let b = Point3::new(random(bits), random(30), random(30));
            let (below, above) = if a.z < b.z { (a, b) } else { (b, a) };
            let z = [random(30), below.z + 1, above.z, (below.z + above.z) / 2][i % 4];
            if below.z < z && z <= above.z {
                compared += 1;
                assert_eq!(
                    point(below, above, z),
                    crossing::point(below, above, z),
                    "{below:?} {above:?} {z}"
                );
            }
        }
        assert!(compared > 100_000);
        let m = LIMIT - 1;
        let (low, high) = (Point3::new(-m, m, -m), Point3::new(m, -m, m));
        for z in [1 - m, -1, 0, 1, 7, m] {
            assert_eq!(point(low, high, z), crossing::point(low, high, z));
        }
    }

    #[test]
    fn buckets_keep_the_order_of_their_pairs() {
        let pairs = [(2, 7), (0, 1), (2, 3), (3, 9)];
        let buckets = Buckets::new(4, || pairs.iter().copied());
        assert_eq!(buckets.of(0), [1]);
        assert!(buckets.of(1).is_empty());
        assert_eq!(buckets.of(2), [7, 3]);
        assert_eq!(buckets.of(3), [9]);
    }
}
