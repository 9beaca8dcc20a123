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

    /// Whether a closed ring runs through it.
    pub(super) fn meets(&self, ring: &[Point2]) -> bool {
        let place = |p: Point2| {
            let (x, y) = p.minus(self.from);
            let (x, y) = (x as f64, y as f64);
            (x * self.ux + y * self.uy, y * self.ux - x * self.uy)
        };
        let Some(&last) = ring.last() else { return false };
        let mut a = place(last);
        ring.iter().any(|&p| {
            let b = place(p);
            let met = self.cuts(a, b);
            a = b;
            met
        })
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
