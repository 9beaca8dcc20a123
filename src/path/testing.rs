//! Shapes and numbers for the tests of this module and of those above it.

use crate::contour::Ring;
use crate::lattice::Point2;

/// A small generator of the tests' own (SplitMix64, Steele, Lea and Flood 2014).
pub(crate) struct Random {
    pub seed: u64,
    state: u64,
}

impl Random {
    pub fn new(seed: u64) -> Self {
        Self { seed, state: seed }
    }

    pub fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.state ^ (self.state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A number below `n`.
    pub fn below(&mut self, n: u64) -> u64 {
        self.next() % n.max(1)
    }
}

/// A counter-clockwise circle of `n` vertices, the first at `turn` radians.
pub(crate) fn circle(x: i32, y: i32, radius: i32, n: usize, turn: f64) -> Ring {
    (0..n)
        .map(|i| {
            let angle = turn + i as f64 / n as f64 * std::f64::consts::TAU;
            let (sin, cos) = libm::sincos(angle);
            let r = f64::from(radius);
            Point2::new(x + (r * cos).round() as i32, y + (r * sin).round() as i32)
        })
        .collect()
}

/// A counter-clockwise rectangle from its lower left corner.
pub(crate) fn rectangle(x0: i32, y0: i32, x1: i32, y1: i32) -> Ring {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(x, y)).to_vec()
}
