//! What an edge that vanished from a moving front still covers.
//!
//! An edge of the front sweeps on no further once it has vanished, but everything within the distance of
//! the source edge is as near to the outline as before. Between two corners that turn towards the material
//! the neighbours run ahead of the vanished edge. Beside a corner that turns away they may not: a tooth that
//! leans over leaves a front behind that is nearer to its flank than it should be.

use super::offset::MITER_LIMIT;
use crate::lattice::Point2;

/// A front may lie this much too near \[nm\].
const TOLERANCE: f64 = 4_000.0;

/// The strip along an edge with its halves of the joints at both ends, in the edge's own coordinates: `s`
/// along it, `t` to the left.
pub(super) struct Shadow {
    from: Point2,
    ux: f64,
    uy: f64,
    length: f64,
    depth: f64,
    /// How much further the strip reaches at its start and at its end, per depth.
    before: f64,
    after: f64,
}

impl Shadow {
    /// Of the edge at vertex `i` of a ring, `depth` \[nm\] deep.
    pub(super) fn new(ring: &[Point2], i: usize, depth: f64) -> Self {
        let n = ring.len();
        let unit = |i: usize| {
            let (dx, dy) = ring[(i + 1) % n].minus(ring[i % n]);
            let (dx, dy) = (dx as f64, dy as f64);
            let length = (dx * dx + dy * dy).sqrt();
            (dx / length, dy / length, length)
        };
        let (a, b, c) = (unit(i + n - 1), unit(i), unit(i + 1));
        Self {
            from: ring[i % n],
            ux: b.0,
            uy: b.1,
            length: b.2,
            depth: depth - TOLERANCE,
            before: reach((a.0, a.1), (b.0, b.1)),
            after: reach((b.0, b.1), (c.0, c.1)),
        }
    }

    /// Whether a course runs through it.
    pub(super) fn meets(&self, course: &Course<'_>) -> bool {
        let bounds = self.bounds();
        course.runs.iter().enumerate().any(|(k, run)| run.meets(&bounds) && self.meets_run(course, k))
    }

    /// Whether edges of run `k` lie within, in part.
    fn meets_run(&self, course: &Course<'_>, k: usize) -> bool {
        let place = |p: Point2| {
            let (x, y) = p.minus(self.from);
            let (x, y) = (x as f64, y as f64);
            (x * self.ux + y * self.uy, y * self.ux - x * self.uy)
        };
        let mut points = course.points(k).map(place);
        let Some(mut a) = points.next() else { return false };
        points.any(|b| {
            let met = self.cuts(a, b);
            a = b;
            met
        })
    }

    /// A box about all that it covers.
    fn bounds(&self) -> Bounds {
        let far = self.depth.max(0.0);
        let corners = [
            (0.0, 0.0),
            (self.length, 0.0),
            (-far * self.before, far),
            (self.length + far * self.after, far),
        ];
        let (x, y) = (f64::from(self.from.x), f64::from(self.from.y));
        let at = |(s, t): (f64, f64)| (x + s * self.ux - t * self.uy, y + s * self.uy + t * self.ux);
        corners.into_iter().map(at).fold(Bounds::NOTHING, Bounds::with)
    }

    /// Whether a part of the segment lies within.
    fn cuts(&self, a: (f64, f64), b: (f64, f64)) -> bool {
        let (mut low, mut high) = (0.0f64, 1.0f64);
        // Within is where all of these are positive.
        let sides = |(s, t): (f64, f64)| {
            [self.depth - t, t - TOLERANCE, s + t * self.before, self.length + t * self.after - s]
        };
        for (p, q) in sides(a).into_iter().zip(sides(b)) {
            if p <= 0.0 && q <= 0.0 {
                return false;
            }
            if p < 0.0 {
                low = low.max(p / (p - q));
            } else if q < 0.0 {
                high = high.min(p / (p - q));
            }
        }
        low < high
    }
}

/// A box; its borders belong to it \[nm\].
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: (f64, f64),
    high: (f64, f64),
}

impl Bounds {
    const NOTHING: Self =
        Self { low: (f64::INFINITY, f64::INFINITY), high: (f64::NEG_INFINITY, f64::NEG_INFINITY) };

    fn with(self, (x, y): (f64, f64)) -> Self {
        Self { low: (self.low.0.min(x), self.low.1.min(y)), high: (self.high.0.max(x), self.high.1.max(y)) }
    }

    fn meets(&self, other: &Self) -> bool {
        self.low.0 <= other.high.0
            && other.low.0 <= self.high.0
            && self.low.1 <= other.high.1
            && other.low.1 <= self.high.1
    }
}

/// A closed ring in runs of edges with a box about each, so that most of it is passed over at once.
pub(super) struct Course<'a> {
    ring: &'a [Point2],
    runs: Vec<Bounds>,
}

impl<'a> Course<'a> {
    /// Edges in a run.
    const RUN: usize = 16;

    pub(super) fn new(ring: &'a [Point2]) -> Self {
        let mut course = Self { ring, runs: Vec::new() };
        let bounds = |k: usize| {
            let places = course.points(k).map(|p| (f64::from(p.x), f64::from(p.y)));
            places.fold(Bounds::NOTHING, Bounds::with)
        };
        course.runs = (0..ring.len().div_ceil(Self::RUN)).map(bounds).collect();
        course
    }

    /// Number of its runs.
    pub(super) fn len(&self) -> usize {
        self.runs.len()
    }

    /// The vertices of the edges of run `k`.
    fn points(&self, k: usize) -> impl Iterator<Item = Point2> {
        let (n, first) = (self.ring.len(), k * Self::RUN);
        let last = (first + Self::RUN).min(n);
        (first..=last).map(move |i| self.ring[if i == n { 0 } else { i }])
    }
}

/// How far the joint between two edges reaches along either of them per depth: the tangent of half the turn,
/// of a quarter where the corner is cut off; 0 where the turn is to the left.
fn reach((ax, ay): (f64, f64), (bx, by): (f64, f64)) -> f64 {
    let (turn, dot) = (ax * by - ay * bx, ax * bx + ay * by);
    if turn > 0.0 {
        0.0
    } else if (1.0 + dot) * MITER_LIMIT * MITER_LIMIT < 2.0 {
        let (sine, cosine) = ((0.5 * (1.0 - dot)).sqrt(), (0.5 * (1.0 + dot)).max(0.0).sqrt());
        sine / (1.0 + cosine)
    } else {
        -turn / (1.0 + dot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::region::tests::Random;

    #[test]
    fn runs_pass_over_nothing_that_is_met() {
        let mut random = Random(7);
        let mut found = [0; 2];
        for case in 0..4000 {
            let mut point = |reach: i32| {
                let mut along = || random.range(-reach, reach);
                Point2::new(along(), along())
            };
            let centre = point(3_000_000);
            let ring: Vec<Point2> = (0..3 + case % 60)
                .map(|_| point(900_000))
                .map(|p| Point2::new(p.x + centre.x, p.y + centre.y))
                .collect();
            let source: Vec<Point2> = (0..3).map(|_| point(3_000_000)).collect();
            let shadow = Shadow::new(&source, 0, 400_000.0);
            // The whole ring as one run without a box.
            let all: Vec<Point2> = ring.iter().chain(&ring[..1]).copied().collect();
            let place = |p: &Point2| {
                let (x, y) = p.minus(shadow.from);
                let (x, y) = (x as f64, y as f64);
                (x * shadow.ux + y * shadow.uy, y * shadow.ux - x * shadow.uy)
            };
            let met = all.windows(2).any(|e| shadow.cuts(place(&e[0]), place(&e[1])));
            assert_eq!(shadow.meets(&Course::new(&ring)), met, "{ring:?} {source:?}");
            found[usize::from(met)] += 1;
        }
        assert!(found[0] > 200 && found[1] > 200, "{found:?}");
    }
}
