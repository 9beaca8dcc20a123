//! Where a loop starts and ends.

use super::nearest::square;
use super::simplify::square_to_segment;
use crate::lattice::Point2;
use crate::settings::SeamPosition;
use std::ops::Range;

/// A place on a ring: on the edge that starts at vertex `edge`, often at that vertex itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seam {
    /// The vertex from which the edge starts.
    pub edge: usize,
    /// The place \[nm\].
    pub at: Point2,
}

/// A wall that needs a seam.
#[derive(Clone, Copy, Debug)]
pub struct Loop<'a> {
    /// Its centre line.
    pub ring: &'a [Point2],
    /// True when it runs around a hole.
    pub hole: bool,
    /// Per edge, true where it runs over air; empty where no edge does.
    pub overhang: &'a [bool],
}

impl Loop<'_> {
    /// True when an edge runs over air.
    fn hangs(&self, edge: usize) -> bool {
        self.overhang.get(edge).is_some_and(|over_air| *over_air)
    }

    /// How well a corner suits a seam: see [`merit`]; worse where it hangs in air.
    fn merit(&self, i: usize) -> f64 {
        let own = merit(self.ring, i);
        let before = if i == 0 { self.ring.len() } else { i } - 1;
        if self.hangs(i) || self.hangs(before) { own - OVER_AIR } else { own }
    }
}

/// Chooses the seams of external walls and remembers those of the layer below.
///
/// Loops are to be offered in their order in the layer, which makes the choice independent of the
/// order in which they are printed.
#[derive(Clone, Debug, Default)]
pub struct SeamPlacer {
    position: SeamPosition,
    below: Vec<Mark>,
    here: Vec<Mark>,
    /// The rings of the marks, one after the other.
    rings_below: Vec<Point2>,
    rings_here: Vec<Point2>,
    /// Indices into `below`, by x; filled when first needed.
    by_x: Vec<u32>,
    /// Where in `below` the next loop's seam is expected.
    expected: usize,
}

#[derive(Clone, Debug)]
struct Mark {
    at: Point2,
    hole: bool,
    /// The edge that it is on.
    edge: usize,
    /// Its ring in [`SeamPlacer::rings_here`], if a ring like it on the next layer has the same seam: because
    /// the seam below it was at the same place.
    settled: Option<Range<usize>>,
}

/// A loop this near to the expected seam of the layer below continues it without a search \[nm\].
const SAME_PLACE: f64 = 0.5e6;
/// A loop continues a seam of the layer below that is at most this far away \[nm\].
const REACH: i64 = 3_000_000;
/// An aligned seam leaves its line for a corner at most this far away \[nm\].
const SNAP: f64 = 1e6;
/// Corners are judged between points this far before and behind them \[nm\], so that neither the
/// facets of a curve nor a rounding of the tip count.
const ARM: i64 = 400_000;
/// What a corner over air loses: more than any corner can have.
const OVER_AIR: f64 = 3.0;
/// Cosine of the least turn that hides a seam, 40 degrees.
const FLAT: f64 = 0.766;

impl SeamPlacer {
    /// A placer that knows no layer yet.
    pub fn new(position: SeamPosition) -> Self {
        Self { position, ..Self::default() }
    }

    /// The seams chosen since the last call become those of the layer below.
    pub fn next_layer(&mut self) {
        std::mem::swap(&mut self.below, &mut self.here);
        std::mem::swap(&mut self.rings_below, &mut self.rings_here);
        self.here.clear();
        self.rings_here.clear();
        self.by_x.clear();
        self.expected = 0;
    }

    /// The seam of an external wall on layer `layer`; `nozzle` is where the nozzle comes from, which
    /// only [`SeamPosition::Nearest`] heeds. `None` for a ring without points.
    pub fn place(&mut self, around: Loop<'_>, nozzle: Point2, layer: usize) -> Option<Seam> {
        let ring = around.ring;
        match self.position {
            SeamPosition::Rear => rearmost(ring),
            SeamPosition::Random => scattered(ring, layer),
            SeamPosition::Nearest => {
                let (low, high) = bounds(ring)?;
                let scale = low.distance(high).max(1.0);
                best_vertex(ring, |i| around.merit(i) - 2.0 * ring[i].distance(nozzle) / scale)
            }
            SeamPosition::Aligned => {
                if let Some(seam) = self.repeated(around) {
                    return Some(seam);
                }
                let (seam, below) = match self.continued(around) {
                    Some((seam, below)) => (seam, Some(below)),
                    None => (fresh(around)?, None),
                };
                let settled = below == Some(seam.at) && around.overhang.is_empty();
                self.mark(around, seam, settled);
                Some(seam)
            }
        }
    }

    /// Remembers a seam for the layer above.
    fn mark(&mut self, around: Loop<'_>, seam: Seam, settled: bool) {
        let first = self.rings_here.len();
        if settled {
            self.rings_here.extend_from_slice(around.ring);
        }
        let settled = settled.then_some(first..self.rings_here.len());
        self.here.push(Mark { at: seam.at, hole: around.hole, edge: seam.edge, settled });
    }

    /// The seam of a ring that is the same as the one expected below and whose search would end the same:
    /// upright walls.
    fn repeated(&mut self, around: Loop<'_>) -> Option<Seam> {
        let mark = self.below.get(self.expected).filter(|m| m.hole == around.hole)?;
        let ring = self.rings_below.get(mark.settled.clone()?)?;
        if !around.overhang.is_empty() || ring != around.ring {
            return None;
        }
        let seam = Seam { edge: mark.edge, at: mark.at };
        self.expected += 1;
        self.mark(around, seam, true);
        Some(seam)
    }

    /// The continuation of a seam of the layer below, if one is near, and where that one is.
    fn continued(&mut self, around: Loop<'_>) -> Option<(Seam, Point2)> {
        let Loop { ring, hole, .. } = around;
        if let Some(mark) = self.below.get(self.expected).filter(|m| m.hole == hole) {
            let near = nearest_on(ring, mark.at)?;
            if near.1 <= SAME_PLACE * SAME_PLACE {
                self.expected += 1;
                return Some((snapped(around, mark.at, near.0), mark.at));
            }
        }
        if self.below.is_empty() {
            return None;
        }
        if self.by_x.is_empty() {
            self.by_x.extend(0..self.below.len() as u32);
            let below = &self.below;
            self.by_x.sort_unstable_by_key(|&i| (below[i as usize].at, i));
        }
        let (low, high) = bounds(ring)?;
        let within = |v: i32, low: i32, high: i32| {
            (i64::from(low) - REACH..=i64::from(high) + REACH).contains(&i64::from(v))
        };
        let first =
            self.by_x.partition_point(|&i| i64::from(self.below[i as usize].at.x) < i64::from(low.x) - REACH);
        let mut best: Option<(f64, u32, Seam)> = None;
        for &i in &self.by_x[first..] {
            let mark = &self.below[i as usize];
            if !within(mark.at.x, low.x, high.x) {
                break;
            }
            if mark.hole != hole || !within(mark.at.y, low.y, high.y) {
                continue;
            }
            let (seam, d) = nearest_on(ring, mark.at)?;
            if best.is_none_or(|b| d < b.0 || (d == b.0 && i < b.1)) {
                best = Some((d, i, seam));
            }
        }
        let (_, i, seam) = best.filter(|b| b.0 <= (REACH * REACH) as f64)?;
        self.expected = i as usize + 1;
        let below = self.below[i as usize].at;
        Some((snapped(around, below, seam), below))
    }
}

/// The point of the ring nearest to `target`, and its squared distance \[nm²\].
///
/// `None` for a ring without points.
pub fn nearest_on(ring: &[Point2], target: Point2) -> Option<(Seam, f64)> {
    let mut best = (f64::INFINITY, 0);
    let mut a = *ring.last()?;
    // Edge i ends in vertex i here.
    for (i, &b) in ring.iter().enumerate() {
        let d = square_to_segment(target, a, b);
        if d < best.0 {
            best = (d, i);
        }
        a = b;
    }
    let edge = (best.1 + ring.len() - 1) % ring.len();
    let (a, b) = (ring[edge], ring[best.1]);
    let (ux, uy) = b.minus(a);
    let (vx, vy) = target.minus(a);
    let (along, length) = (ux * vx + uy * vy, ux * ux + uy * uy);
    let seam = if along <= 0 {
        Seam { edge, at: a }
    } else if along >= length {
        Seam { edge: best.1, at: b }
    } else {
        on_edge(a, b, along as f64 / length as f64, edge)
    };
    Some((seam, best.0))
}

/// The place a share `t` of the way along an edge.
fn on_edge(a: Point2, b: Point2, t: f64, edge: usize) -> Seam {
    let (ux, uy) = b.minus(a);
    let at = |from: i32, by: i64| (i64::from(from) + (by as f64 * t).round() as i64) as i32;
    Seam { edge, at: Point2::new(at(a.x, ux), at(a.y, uy)) }
}

/// `seam`, or a good corner within reach of `target`.
fn snapped(around: Loop<'_>, target: Point2, seam: Seam) -> Seam {
    let mut best = (if around.hangs(seam.edge) { -OVER_AIR } else { 0.0 }, seam);
    for (edge, &at) in around.ring.iter().enumerate() {
        let d = square(at, target) as f64;
        if d <= SNAP * SNAP {
            let score = around.merit(edge) - 0.2 * d.sqrt() / SNAP;
            if score > best.0 {
                best = (score, Seam { edge, at });
            }
        }
    }
    best.1
}

/// The best corner of a loop that continues nothing; towards the rear where several are alike.
fn fresh(around: Loop<'_>) -> Option<Seam> {
    let ring = around.ring;
    let (low, high) = bounds(ring)?;
    let height = (f64::from(high.y) - f64::from(low.y)).max(1.0);
    best_vertex(ring, |i| around.merit(i) + 0.2 * (f64::from(ring[i].y) - f64::from(low.y)) / height)
}

/// The vertex with the highest score, the first of several.
fn best_vertex(ring: &[Point2], score: impl Fn(usize) -> f64) -> Option<Seam> {
    let mut best = (f64::NEG_INFINITY, None);
    for (edge, &at) in ring.iter().enumerate() {
        let s = score(edge);
        if s > best.0 {
            best = (s, Some(Seam { edge, at }));
        }
    }
    best.1
}

/// How well a corner hides a seam: 0 for a flat one, up to 2 for a sharp concave one, 1.2 for a
/// sharp convex one.
fn merit(ring: &[Point2], i: usize) -> f64 {
    let n = ring.len();
    let arm = |step: usize| {
        let mut j = (i + step) % n;
        while square(ring[j], ring[i]) < ARM * ARM {
            let next = (j + step) % n;
            if next == i {
                break;
            }
            j = next;
        }
        ring[j]
    };
    if n < 3 {
        return 0.0;
    }
    let (before, behind) = (arm(n - 1), arm(1));
    let (ux, uy) = ring[i].minus(before);
    let (vx, vy) = behind.minus(ring[i]);
    let lengths = ((ux * ux + uy * uy) as f64).sqrt() * ((vx * vx + vy * vy) as f64).sqrt();
    if lengths <= 0.0 {
        return 0.0;
    }
    let cosine = (ux * vx + uy * vy) as f64 / lengths;
    let sharp = (FLAT - cosine).max(0.0) / (FLAT + 1.0);
    // Solid is on the left, so a turn to the right is a concave corner.
    if ux * vy - uy * vx < 0 { 2.0 * sharp } else { 1.2 * sharp }
}

/// The vertex furthest back; of several the leftmost, then the first.
fn rearmost(ring: &[Point2]) -> Option<Seam> {
    let key = |p: Point2| (-i64::from(p.y), p.x);
    ring.iter().enumerate().min_by_key(|(i, p)| (key(**p), *i)).map(|(edge, &at)| Seam { edge, at })
}

/// A place anywhere along the ring, drawn from a hash of the ring and its layer.
fn scattered(ring: &[Point2], layer: usize) -> Option<Seam> {
    let mix = |h: u64, v: u64| {
        // The finaliser of SplitMix64 (Steele, Lea and Flood 2014).
        let h = (h ^ v).wrapping_add(0x9e37_79b9_7f4a_7c15);
        let h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        h ^ (h >> 31)
    };
    let word = |p: &Point2| u64::from(p.x as u32) << 32 | u64::from(p.y as u32);
    let hash = ring.iter().fold(layer as u64, |h, p| mix(h, word(p)));
    let mut left = (hash >> 11) as f64 / (1u64 << 53) as f64 * length(ring);
    for (edge, (&a, &b)) in ring.iter().zip(ring.iter().cycle().skip(1)).enumerate() {
        let d = a.distance(b);
        if left < d {
            return Some(on_edge(a, b, left / d, edge));
        }
        left -= d;
    }
    ring.first().map(|&at| Seam { edge: 0, at })
}

/// Length of a closed ring \[nm\].
pub(super) fn length(ring: &[Point2]) -> f64 {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum()
}

/// Lower left and upper right corner of the ring's box.
fn bounds(ring: &[Point2]) -> Option<(Point2, Point2)> {
    let first = *ring.first()?;
    Some(ring.iter().fold((first, first), |(low, high), p| {
        (Point2::new(low.x.min(p.x), low.y.min(p.y)), Point2::new(high.x.max(p.x), high.y.max(p.y)))
    }))
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Random, circle, rectangle};
    use super::*;

    const HOME: Point2 = Point2::new(0, 0);

    fn solid(ring: &[Point2]) -> Loop<'_> {
        Loop { ring, hole: false, overhang: &[] }
    }

    fn at(placer: &mut SeamPlacer, ring: &[Point2], layer: usize) -> Point2 {
        placer.place(solid(ring), HOME, layer).map(|s| s.at).unwrap_or_default()
    }

    #[test]
    fn the_seams_of_a_cylinder_stay_in_line() {
        let mut placer = SeamPlacer::new(SeamPosition::Aligned);
        let first = at(&mut placer, &circle(0, 0, 10_000_000, 97, 0.0), 0);
        for layer in 1..200 {
            placer.next_layer();
            // Every layer has its vertices elsewhere.
            let ring = circle(0, 0, 10_000_000, 97 + layer % 5, layer as f64 * 0.7);
            let here = at(&mut placer, &ring, layer);
            assert!(here.distance(first) < 50_000.0, "layer {layer}: {here:?} and {first:?}");
        }
    }

    #[test]
    fn a_corner_of_the_layer_below_is_followed_up_a_slope() {
        let mut placer = SeamPlacer::new(SeamPosition::Aligned);
        for layer in 0..40 {
            let inset = 200_000 * layer as i32;
            let ring = rectangle(inset, inset, 20_000_000 - inset, 30_000_000 - inset);
            let here = at(&mut placer, &ring, layer);
            assert_eq!(here, ring[2], "layer {layer}: the rear corner found first");
            placer.next_layer();
        }
    }

    #[test]
    fn each_of_many_loops_keeps_its_seam_when_one_ends() {
        let mut placer = SeamPlacer::new(SeamPosition::Aligned);
        let rings: Vec<_> = (0..50).map(|i| circle(i * 3_000_000, 0, 1_000_000, 24, 0.3)).collect();
        let before: Vec<_> = rings.iter().map(|r| at(&mut placer, r, 0)).collect();
        placer.next_layer();
        for (i, ring) in rings.iter().enumerate().filter(|(i, _)| i % 7 != 3) {
            assert_eq!(at(&mut placer, ring, 1), before[i], "loop {i}");
        }
    }

    #[test]
    fn concave_corners_come_first() {
        // An L: the inner corner at (10, 10) mm.
        let l = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)];
        let ring: Vec<_> = l.iter().map(|&(x, y)| Point2::new(x * 1_000_000, y * 1_000_000)).collect();
        let mut placer = SeamPlacer::new(SeamPosition::Aligned);
        assert_eq!(at(&mut placer, &ring, 0), ring[3]);
        // From afar every seam is as good as its corner, so the nozzle's side does not matter here.
        let mut placer = SeamPlacer::new(SeamPosition::Nearest);
        let seam = placer.place(solid(&ring), Point2::new(9_000_000, 21_000_000), 0);
        assert_eq!(seam.map(|s| s.at), Some(ring[4]));
    }

    #[test]
    fn upright_walls_have_the_seam_that_a_search_would_find() {
        for seed in 0..40 {
            let mut random = Random::new(seed);
            let [mut quick, mut plain] = [(); 2].map(|()| SeamPlacer::new(SeamPosition::Aligned));
            let rings = |random: &mut Random| -> Vec<_> {
                let one = |i: i32| {
                    let (r, n) = (500_000 + random.below(3_000_000) as i32, 3 + random.below(9) as usize);
                    circle(i * 5_000_000, 0, r, n, random.below(7) as f64)
                };
                (0..12).map(one).collect()
            };
            let mut layer = rings(&mut random);
            for z in 0..12 {
                match random.below(6) {
                    0 => layer = rings(&mut random),
                    1 => drop(layer.remove(random.below(layer.len() as u64) as usize)),
                    2 => layer.swap(0, 3),
                    _ => {}
                }
                for ring in &layer {
                    let hole = ring.len() % 3 == 0;
                    let around = Loop { ring, hole, overhang: &[] };
                    for mark in &mut plain.below {
                        mark.settled = None;
                    }
                    assert_eq!(
                        quick.place(around, HOME, z),
                        plain.place(around, HOME, z),
                        "seed {seed}, layer {z}"
                    );
                }
                quick.next_layer();
                plain.next_layer();
            }
        }
    }

    #[test]
    fn seams_keep_away_from_air() {
        // The corner that is best, at the rear right, hangs in air; the one to its left does not.
        let ring = rectangle(0, 0, 20_000_000, 30_000_000);
        let overhang = [false, true, false, false];
        let around = Loop { ring: &ring, hole: false, overhang: &overhang };
        for (position, nozzle) in [(SeamPosition::Aligned, HOME), (SeamPosition::Nearest, ring[2])] {
            let mut placer = SeamPlacer::new(position);
            let free = placer.place(solid(&ring), nozzle, 0).map(|s| s.at);
            let mut placer = SeamPlacer::new(position);
            let held = placer.place(around, nozzle, 0).map(|s| s.at);
            assert_eq!((free, held), (Some(ring[2]), Some(ring[3])), "{position:?}");
        }
        // A seam in line with those below leaves it for the corner where the air ends.
        let mut placer = SeamPlacer::new(SeamPosition::Aligned);
        let below = Seam { edge: 1, at: Point2::new(20_000_000, 600_000) };
        placer.mark(solid(&ring), below, false);
        placer.next_layer();
        assert_eq!(placer.place(around, HOME, 1).map(|s| s.at), Some(ring[1]));
    }

    #[test]
    fn rear_is_rear() {
        let mut placer = SeamPlacer::new(SeamPosition::Rear);
        for turn in 0..50 {
            let ring = circle(3_000_000, -2_000_000, 5_000_000, 31, f64::from(turn));
            let here = at(&mut placer, &ring, 0);
            assert!(ring.iter().all(|p| p.y <= here.y));
        }
        assert_eq!(at(&mut placer, &rectangle(0, 0, 9, 9), 0), Point2::new(0, 9));
    }

    #[test]
    fn random_seams_are_spread_and_repeatable() {
        let mut placer = SeamPlacer::new(SeamPosition::Random);
        let ring = rectangle(0, 0, 10_000_000, 10_000_000);
        let seams: Vec<_> = (0..400).map(|layer| at(&mut placer, &ring, layer)).collect();
        let again: Vec<_> = (0..400).map(|layer| at(&mut placer, &ring, layer)).collect();
        assert_eq!(seams, again);
        for side in [
            seams.iter().filter(|p| p.x == 0).count(),
            seams.iter().filter(|p| p.y == 0).count(),
            seams.iter().filter(|p| p.x == 10_000_000).count(),
        ] {
            assert!((60..140).contains(&side), "{side} of 400 on one of four sides");
        }
    }

    #[test]
    fn rings_without_extent_do_not_panic() {
        for position in
            [SeamPosition::Aligned, SeamPosition::Nearest, SeamPosition::Random, SeamPosition::Rear]
        {
            let mut placer = SeamPlacer::new(position);
            assert_eq!(placer.place(solid(&[]), HOME, 0), None);
            for n in 1..4 {
                let ring = vec![Point2::new(4, 4); n];
                assert_eq!(at(&mut placer, &ring, 0), Point2::new(4, 4));
            }
            placer.next_layer();
            assert_eq!(at(&mut placer, &[Point2::new(9, 9)], 1), Point2::new(9, 9));
        }
    }
}
