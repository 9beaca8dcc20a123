//! Strands, lines that wind from side to side, cut to an area.
//!
//! Every crossing is found by exact tests on the lattice. The area counts as moved by an infinitely
//! small step, farther in x than in y (simulation of simplicity, Edelsbrunner and Mücke, 1990), so that
//! no corner lies on a line: a strand enters as often as it leaves.

use super::join::Piece;
use crate::infill::anchor::Place;
use crate::infill::regions::Regions;
use crate::lattice::{self, Point2, cross};
use std::f64::consts::PI;

/// A family of strands. Strand `j` runs about the line `v = (j + 1/2) pitch`, where `u` and `v` are the
/// coordinates along and across the family's direction: straight for `straight` about every multiple of
/// `step`, `swing` to one side of that line where `j` plus the multiple is even and to the other where it
/// is odd, and slanting from one to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strands {
    cos: f64,
    sin: f64,
    /// Mean distance between strands \[nm\].
    pitch: f64,
    /// How far they swing out to either side \[nm\].
    swing: f64,
    /// Distance between the middles of straight parts \[nm\].
    step: f64,
    /// Length of a straight part \[nm\].
    straight: f64,
}

/// Corners are rounded to the lattice: crossings are looked for this much around the strands \[nm\].
const MARGIN: f64 = 4.0;

impl Strands {
    /// Strands at `degrees` counter-clockwise from +x; lengths in nanometres.
    pub fn new(degrees: f64, pitch: f64, swing: f64, step: f64, straight: f64) -> Self {
        let (sin, cos) = libm::sincos(degrees.rem_euclid(360.0) * PI / 180.0);
        let step = step.max(1000.0);
        Self { cos, sin, pitch: pitch.max(1000.0), swing, step, straight: straight.clamp(0.0, step) }
    }

    /// Corner `m` of strand `j`.
    fn corner(&self, j: i64, m: i64) -> Point2 {
        let part = m.div_euclid(2);
        let half = if m.rem_euclid(2) == 0 { -0.5 } else { 0.5 } * self.straight;
        let out = if (j + part).rem_euclid(2) == 0 { self.swing } else { -self.swing };
        let (u, v) = (part as f64 * self.step + half, (j as f64 + 0.5) * self.pitch + out);
        let limit = f64::from(lattice::LIMIT - 1);
        let on_lattice = |c: f64| c.round().clamp(-limit, limit) as i32;
        Point2::new(on_lattice(self.cos * u - self.sin * v), on_lattice(self.sin * u + self.cos * v))
    }

    /// The last corner at or before `u`.
    fn corner_before(&self, u: f64) -> i64 {
        let part = ((u + 0.5 * self.straight) / self.step).floor();
        let behind = u - (part * self.step + 0.5 * self.straight) >= 0.0;
        2 * part as i64 + i64::from(behind)
    }

    fn uv(&self, p: Point2) -> [f64; 2] {
        let (x, y) = (f64::from(p.x), f64::from(p.y));
        [self.cos * x + self.sin * y, self.cos * y - self.sin * x]
    }

    /// Hands over the number of a strand and those of its corners between which the edge from `a` to `b`
    /// may cross it.
    fn near(&self, a: Point2, b: Point2, mut part: impl FnMut(i64, i64)) {
        let (a, b) = (self.uv(a), self.uv(b));
        let [low, high] = if a[1] <= b[1] { [a, b] } else { [b, a] };
        let reach = self.swing + MARGIN;
        let first = ((low[1] - reach) / self.pitch - 0.5).ceil() as i64;
        let last = ((high[1] + reach) / self.pitch - 0.5).floor() as i64;
        let rise = high[1] - low[1];
        for j in first..=last {
            let middle = (j as f64 + 0.5) * self.pitch;
            // The part of the edge in the strand's band.
            let u = |v: f64| {
                let f = if rise > 0.0 { ((v - low[1]) / rise).clamp(0.0, 1.0) } else { 0.0 };
                low[0] + f * (high[0] - low[0])
            };
            let level = rise <= 2.0 * MARGIN;
            let (from, to) = if level { (low[0], high[0]) } else { (u(middle - reach), u(middle + reach)) };
            let from_corner = self.corner_before(from.min(to) - MARGIN);
            for m in from_corner..=self.corner_before(from.max(to) + MARGIN) {
                part(j, m);
            }
        }
    }
}

/// Where a strand crosses an edge.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    strand: i64,
    /// The corner before it, and how far it is from there to the next.
    corner: i64,
    fraction: f64,
    /// The strand goes to the left of the edge, inwards.
    enters: bool,
    /// Ring and edge; `None` for an edge of the area inside the regions.
    border: Option<(u32, u32)>,
}

/// The parts of the strands inside the regions, and inside `within` if it is given: directed edges with
/// the inside on their left. Region by region; parts shorter than `least` \[nm\] are left out.
pub fn clip(strands: &Strands, regions: &Regions, within: Option<&[[Point2; 2]]>, least: f64) -> Vec<Piece> {
    let mut found = Vec::new();
    for (r, ring) in (0..).zip(&regions.rings) {
        for (i, &a) in ring.iter().enumerate() {
            let b = ring[if i + 1 < ring.len() { i + 1 } else { 0 }];
            cut(strands, a, b, Some((r, i as u32)), &mut found);
        }
    }
    for &[a, b] in within.into_iter().flatten() {
        cut(strands, a, b, None, &mut found);
    }
    found.sort_unstable_by(|a, b| {
        (a.strand, a.corner)
            .cmp(&(b.strand, b.corner))
            .then(a.fraction.total_cmp(&b.fraction))
            .then(a.border.cmp(&b.border))
    });
    let mut pieces = Vec::new();
    for strand in found.chunk_by(|a, b| a.strand == b.strand) {
        parts(strands, strand, regions, within.is_none(), least, &mut pieces);
    }
    pieces.sort_by_key(|p| p.region);
    pieces
}

/// The crossings of all strands with one edge.
fn cut(strands: &Strands, a: Point2, b: Point2, border: Option<(u32, u32)>, found: &mut Vec<Crossing>) {
    strands.near(a, b, |strand, corner| {
        let (p, q) = (strands.corner(strand, corner), strands.corner(strand, corner + 1));
        let enters = is_left(p, q, a, 1);
        if enters == is_left(p, q, b, 1) {
            return;
        }
        if is_left(a, b, p, -1) == is_left(a, b, q, -1) {
            return;
        }
        let (from, to) = (cross(a, b, p) as f64, cross(a, b, q) as f64);
        let fraction = if from == to { 0.0 } else { (from / (from - to)).clamp(0.0, 1.0) };
        found.push(Crossing { strand, corner, fraction, enters, border });
    });
}

/// Whether `c`, moved by an infinitely small step (`sign` 1) or against it (-1), lies left of a-b.
fn is_left(a: Point2, b: Point2, c: Point2, sign: i64) -> bool {
    let side = cross(a, b, c);
    if side != 0 {
        return side > 0;
    }
    let (dx, dy) = b.minus(a);
    sign * if dy == 0 { dx } else { -dy } > 0
}

/// The parts of one strand, from its crossings in order.
fn parts(
    strands: &Strands,
    crossings: &[Crossing],
    regions: &Regions,
    all: bool,
    least: f64,
    pieces: &mut Vec<Piece>,
) {
    // Windings of the regions and of the area within.
    let mut winding = [0i32, i32::from(all)];
    let mut region = 0;
    let mut begun: Option<&Crossing> = None;
    for c in crossings {
        let step = if c.enters { 1 } else { -1 };
        match c.border {
            Some((ring, _)) => {
                winding[0] += step;
                region = regions.region_of_ring[ring as usize];
            }
            None => winding[1] += step,
        }
        let inside = winding[0] != 0 && winding[1] != 0;
        match begun {
            None if inside => begun = Some(c),
            Some(from) if !inside => {
                begun = None;
                let piece = piece(strands, from, c, regions, region);
                let length = piece.points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
                if length >= least {
                    pieces.push(piece);
                }
            }
            _ => {}
        }
    }
}

fn piece(strands: &Strands, from: &Crossing, to: &Crossing, regions: &Regions, region: u32) -> Piece {
    let at = |c: &Crossing| {
        let corner = |m| strands.corner(c.strand, m);
        corner(c.corner).toward(corner(c.corner + 1), c.fraction)
    };
    let place = |c: &Crossing| c.border.map(|(ring, edge)| Place::new(&regions.rings, ring, edge, at(c)));
    let mut points = vec![at(from)];
    points.extend((from.corner + 1..=to.corner).map(|m| strands.corner(from.strand, m)));
    points.push(at(to));
    points.dedup();
    Piece { region, points, ends: [place(from), place(to)] }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contour::{ExPolygon, Ring};
    use crate::region::Island;
    use crate::span::tests::Random;

    const ANGLES: [f64; 4] = [0.0, 17.0, 90.0, 45.0];

    fn strands(degrees: f64) -> Strands {
        Strands::new(degrees, 1e6, 0.3e6, 1.5e6, 0.7e6)
    }

    fn islands(contour: Ring) -> Vec<Island> {
        let area = ExPolygon { contour, holes: vec![] };
        vec![Island { infill: vec![area.clone()], outline: area, ..Island::default() }]
    }

    /// Length of the strands in a ring, and the number of parts.
    fn inside(strands: &Strands, ring: &Ring) -> (f64, usize) {
        let islands = islands(ring.clone());
        let pieces = clip(strands, &Regions::new(&islands), None, 0.0);
        let of = |p: &Piece| p.points.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>();
        (pieces.iter().map(of).sum(), pieces.len())
    }

    /// A ring whose corners are corners of strands and lattice points right beside them.
    fn on_corners(random: &mut Random, strands: &Strands, beside: i64) -> Ring {
        let mut ring: Ring = (0..3 + random.below(6))
            .map(|_| {
                let p = strands.corner(random.within(-4, 5), random.within(-6, 7));
                let mut off = || random.within(-beside, beside + 1) as i32;
                Point2::new(p.x + off(), p.y + off())
            })
            .collect();
        // Around their middle, so that the ring does not cross itself.
        let n = ring.len() as i64;
        let sum = ring.iter().fold([0i64; 2], |s, p| [s[0] + i64::from(p.x), s[1] + i64::from(p.y)]);
        let (x, y) = ((sum[0] / n) as f64 + 0.3, (sum[1] / n) as f64 + 0.4);
        ring.sort_by(|a, b| {
            let angle = |p: &Point2| libm::atan2(f64::from(p.y) - y, f64::from(p.x) - x);
            angle(a).total_cmp(&angle(b))
        });
        ring.dedup();
        ring
    }

    /// The same by asking of many points on every strand whether they are inside.
    fn sampled(strands: &Strands, ring: &Ring) -> f64 {
        let mut sum = 0.0;
        for j in -8..9 {
            for m in -14..15 {
                let (a, b) = (strands.corner(j, m), strands.corner(j, m + 1));
                let hits = (0..200).filter(|i| {
                    let f = (f64::from(*i) + 0.5) / 200.0;
                    let p = [
                        f64::from(a.x) + f * (f64::from(b.x) - f64::from(a.x)),
                        f64::from(a.y) + f * (f64::from(b.y) - f64::from(a.y)),
                    ];
                    let mut odd = false;
                    for i in 0..ring.len() {
                        let (q, r) = (ring[i], ring[(i + 1) % ring.len()]);
                        let (qx, qy) = (f64::from(q.x), f64::from(q.y));
                        let (rx, ry) = (f64::from(r.x), f64::from(r.y));
                        if (qy > p[1]) != (ry > p[1]) && p[0] < qx + (p[1] - qy) / (ry - qy) * (rx - qx) {
                            odd = !odd;
                        }
                    }
                    odd
                });
                sum += a.distance(b) * hits.count() as f64 / 200.0;
            }
        }
        sum
    }

    #[test]
    fn nothing_is_lost_and_nothing_is_added() {
        let mut random = Random(5);
        for i in 0..60 {
            let strands = strands(ANGLES[i % 4]);
            // Ten micrometres from the corners: nothing lies along an edge.
            let ring = on_corners(&mut random, &strands, 10_000);
            let (found, truth) = (inside(&strands, &ring).0, sampled(&strands, &ring));
            assert!((found - truth).abs() < 0.05e6 + 0.01 * truth, "case {i}: {found} for {truth}");
        }
    }

    #[test]
    fn corners_on_strands_count_as_beside_them() {
        let mut random = Random(9);
        let mut parts = 0;
        for i in 0..400 {
            let strands = strands(ANGLES[i % 4]);
            let ring = on_corners(&mut random, &strands, (i % 2) as i64);
            let (found, count) = inside(&strands, &ring);
            // The infinitely small step is one to the right and upwards, as this one is.
            let moved: Ring = ring.iter().map(|p| Point2::new(p.x + 1000, p.y + 30)).collect();
            let (beside, _) = inside(&strands, &moved);
            parts += count;
            // At 0 and 90 degrees corners are not rounded: they lie on each other's lines exactly.
            if i % 2 == 0 {
                assert!((found - beside).abs() < 1e5, "case {i}: {found} and {beside} beside");
            }
        }
        assert!(parts > 1000);
    }
}
