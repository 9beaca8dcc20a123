//! Fewer corners on a ring, within a tolerance.

use super::outline::St;

/// Drops points of a ring, whose first one stays: each dropped point lies within `tolerance` \[units\] of the
/// edge that replaces it.
///
/// From the last kept point an edge grows as long as one direction leads past all points since, within the
/// tolerance: the directions that do so are a sector that narrows with every point (Williams, "An efficient
/// algorithm for the piecewise linear approximation of planar curves", 1978).
pub fn straighten(ring: &mut Vec<St>, tolerance: f64) {
    let n = ring.len();
    if n < 4 || tolerance <= 0.0 {
        return;
    }
    let (mut kept, mut anchor) = (0, ring[0]);
    let mut sector = Sector::new(anchor, tolerance);
    sector.pass(ring[1]);
    let mut last = ring[1];
    for i in 2..=n {
        let next = ring[if i == n { 0 } else { i }];
        let goes_on = sector.holds(next) && sector.pass(next);
        // The first point is still in its place: only what was read is written over.
        if !goes_on {
            kept += 1;
            ring[kept] = last;
            anchor = last;
            sector = Sector::new(anchor, tolerance);
            sector.pass(next);
        }
        last = next;
    }
    ring.truncate(kept + 1);
}

/// The directions from a point that lead past others.
struct Sector {
    from: St,
    tolerance: f64,
    /// Bounds, clockwise and counter-clockwise; `None` = any direction.
    bounds: Option<[[f64; 2]; 2]>,
    /// Farthest way so far.
    far: f64,
}

impl Sector {
    fn new(from: St, tolerance: f64) -> Self {
        Self { from, tolerance, bounds: None, far: 0.0 }
    }

    fn way(&self, p: St) -> [f64; 2] {
        [(p.0 - self.from.0) as f64, (p.1 - self.from.1) as f64]
    }

    /// Whether an edge to `p` leads past all points.
    fn holds(&self, p: St) -> bool {
        let way = self.way(p);
        // An edge must reach as far as what it replaces.
        way[0] * way[0] + way[1] * way[1] >= self.far * self.far
            && self.bounds.is_none_or(|[right, left]| cross(right, way) >= 0.0 && cross(way, left) >= 0.0)
    }

    /// Narrows the sector so that edges lead past `p`; false when none does.
    fn pass(&mut self, p: St) -> bool {
        let [x, y] = self.way(p);
        let length = (x * x + y * y).sqrt();
        self.far = self.far.max(length);
        if length <= self.tolerance {
            return true;
        }
        let sine = self.tolerance / length;
        let cosine = (1.0 - sine * sine).sqrt();
        let turned = |sine: f64| [x * cosine - y * sine, y * cosine + x * sine];
        let [right, left] = [turned(-sine), turned(sine)];
        let [right, left] = match self.bounds {
            None => [right, left],
            Some([r, l]) => {
                [if cross(r, right) > 0.0 { right } else { r }, if cross(left, l) > 0.0 { left } else { l }]
            }
        };
        self.bounds = Some([right, left]);
        cross(right, left) > 0.0
    }
}

fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}
