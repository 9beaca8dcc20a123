//! Beads of varying width → pieces of constant width and equal volume.

use super::seam::Seam;
use crate::lattice::Point2;
use crate::region::{Bead, BeadKind};

/// The widths along a piece differ by this much at most \[nm\], so that the edge of a bead moves by about
/// a quarter of it to either side: between walls, and where it shows. PrusaSlicer's is 0.05 mm.
const STEP: f64 = 40e3;
const FINE_STEP: f64 = 10e3;
/// A change of width within less than this is not worth a piece \[nm\]: no nozzle could follow.
const SHORTEST: f64 = 10e3;

/// Where a bead is begun.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Start {
    /// At its first point.
    First,
    /// At its last point.
    Last,
    /// At this place of a closed bead; this much of the way round is left out at the end \[nm\].
    Seam(Seam, f64),
}

/// A place on a bead and the width there \[nm\].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Knot {
    at: Point2,
    width: f64,
}

/// A stretch of a bead whose width hardly changes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// One past its last point in [`Pieces::points`]; the piece before it, if any, ends where it starts.
    pub end: usize,
    /// Mean width along the way \[nm\].
    pub width: f64,
    /// Way \[nm\].
    pub length: f64,
    /// Volume \[nm · mm²\].
    pub volume: f64,
}

/// The pieces of one bead, in buffers that are used again.
#[derive(Clone, Debug, Default)]
pub(super) struct Pieces {
    knots: Vec<Knot>,
    /// The points of all pieces, each piece's first one repeated from the one before.
    pub points: Vec<Point2>,
    /// The pieces in the order of printing.
    pub pieces: Vec<Piece>,
}

impl Pieces {
    /// Cuts a bead into pieces; `section` \[mm²\] is the cross-section of a width \[nm\].
    pub fn cut(&mut self, bead: &Bead, start: Start, section: impl Fn(f64) -> f64) {
        self.points.clear();
        self.pieces.clear();
        self.trace(bead, start);
        let mut piece = Piece { end: 0, width: 0.0, length: 0.0, volume: 0.0 };
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        let most_step = if bead.kind == BeadKind::ThinWall { FINE_STEP } else { STEP };
        let knots = std::mem::take(&mut self.knots);
        for pair in knots.windows(2) {
            let [from, to] = [pair[0], pair[1]];
            let whole = from.at.distance(to.at);
            if whole <= 0.0 {
                continue;
            }
            let steps = ((to.width - from.width).abs() / most_step).ceil().min(whole / SHORTEST) as u32;
            let mut a = from;
            for k in 1..=steps.max(1) {
                let b = if k >= steps { to } else { between(from, to, f64::from(k) / f64::from(steps)) };
                let length = a.at.distance(b.at);
                let (least, most) = (low.min(a.width).min(b.width), high.max(a.width).max(b.width));
                if most - least > most_step && piece.length >= SHORTEST {
                    self.close(&mut piece);
                    (low, high) = (a.width.min(b.width), a.width.max(b.width));
                } else {
                    (low, high) = (least, most);
                }
                if piece.length <= 0.0 {
                    self.points.push(a.at);
                }
                let width = 0.5 * (a.width + b.width);
                piece.length += length;
                piece.width += length * width;
                piece.volume += length * section(width);
                self.points.push(b.at);
                a = b;
            }
        }
        self.close(&mut piece);
        self.knots = knots;
    }

    /// Ends a piece, which becomes empty.
    fn close(&mut self, piece: &mut Piece) {
        if piece.length > 0.0 {
            let width = piece.width / piece.length;
            self.pieces.push(Piece { end: self.points.len(), width, ..*piece });
        }
        *piece = Piece { end: 0, width: 0.0, length: 0.0, volume: 0.0 };
    }

    /// The bead's points and widths in the order of printing.
    fn trace(&mut self, bead: &Bead, start: Start) {
        self.knots.clear();
        let knots = bead.points.iter().zip(&bead.widths);
        let knots = knots.map(|(&at, &width)| Knot { at, width: f64::from(width.max(0)) });
        match start {
            Start::First => self.knots.extend(knots),
            Start::Last => self.knots.extend(knots.rev()),
            Start::Seam(seam, gap) => {
                self.knots.extend(knots);
                self.turn(seam);
                self.clip(gap);
            }
        }
    }

    /// Turns a closed line so that it starts and ends at the seam.
    fn turn(&mut self, seam: Seam) {
        let (Some(&a), Some(&b)) = (self.knots.get(seam.edge), self.knots.get(seam.edge + 1)) else { return };
        let whole = a.at.distance(b.at);
        let share = if whole > 0.0 { (a.at.distance(seam.at) / whole).min(1.0) } else { 0.0 };
        let knot = Knot { at: seam.at, width: a.width + share * (b.width - a.width) };
        // The last knot repeats the first one.
        self.knots.pop();
        let n = self.knots.len().max(1);
        self.knots.rotate_left((seam.edge + 1) % n);
        self.knots.insert(0, knot);
        self.knots.push(knot);
    }

    /// Shortens the line at its end, if it is at least four times as long as that.
    fn clip(&mut self, gap: f64) {
        let length: f64 = self.knots.windows(2).map(|w| w[0].at.distance(w[1].at)).sum();
        if gap <= 0.0 || length <= 4.0 * gap {
            return;
        }
        let mut left = gap;
        while let [.., a, b] = self.knots[..] {
            let d = a.at.distance(b.at);
            self.knots.pop();
            if d > left {
                self.knots.push(between(b, a, left / d));
                return;
            }
            left -= d;
        }
    }
}

/// The knot a share `t` of the way from `a` to `b`.
fn between(a: Knot, b: Knot, t: f64) -> Knot {
    let (dx, dy) = b.at.minus(a.at);
    let at = |from: i32, by: i64| (i64::from(from) + (by as f64 * t).round() as i64) as i32;
    Knot { at: Point2::new(at(a.at.x, dx), at(a.at.y, dy)), width: a.width + t * (b.width - a.width) }
}

/// The points of a bead that ends where it starts, without the repeated one; `None` for an open one.
pub(super) fn ring(bead: &Bead) -> Option<&[Point2]> {
    match bead.points.as_slice() {
        [ring @ .., last] if ring.len() > 2 && ring.first() == Some(last) => Some(ring),
        _ => None,
    }
}

/// Both ends of a bead; the origin for one without points.
pub(super) fn ends(bead: &Bead) -> [Point2; 2] {
    [bead.points.first(), bead.points.last()].map(|p| p.copied().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Random, circle};
    use super::*;

    fn section(width: f64) -> f64 {
        0.2 * (width / 1e6 - 0.0429)
    }

    /// The volume of a bead by the trapezium rule, which is exact for a linear section.
    fn volume(bead: &Bead) -> f64 {
        let ends = bead.points.windows(2).zip(bead.widths.windows(2));
        ends.map(|(p, w)| p[0].distance(p[1]) * section(0.5 * f64::from(w[0] + w[1]))).sum()
    }

    fn random_bead(random: &mut Random) -> Bead {
        let mut bead = Bead::default();
        let (mut x, mut width) = (0, 400_000);
        for _ in 0..2 + random.below(60) {
            x += 1_000 + random.below(900_000) as i32;
            width = (width + random.below(300_000) as i32 - 150_000).clamp(100_000, 900_000);
            bead.points.push(Point2::new(x, random.below(200_000) as i32));
            bead.widths.push(width);
        }
        bead
    }

    #[test]
    fn the_volume_stays_and_the_widths_are_even() {
        let mut cut = Pieces::default();
        for seed in 0..300 {
            let mut random = Random::new(seed);
            let bead = random_bead(&mut random);
            for start in [Start::First, Start::Last] {
                cut.cut(&bead, start, section);
                let sum: f64 = cut.pieces.iter().map(|p| p.volume).sum();
                // New points are rounded to the lattice.
                assert!((sum / volume(&bead) - 1.0).abs() < 1e-5, "seed {seed}");
                let mut first = 0;
                for piece in &cut.pieces {
                    let points = &cut.points[first..piece.end];
                    let way: f64 = points.windows(2).map(|w| w[0].distance(w[1])).sum();
                    assert!((way - piece.length).abs() < 1.0 && points.len() > 1, "seed {seed}");
                    if first > 0 {
                        assert_eq!(cut.points[first], cut.points[first - 1], "seed {seed}");
                    }
                    first = piece.end;
                }
                assert_eq!(first, cut.points.len());
            }
            assert_eq!(cut.points.first(), bead.points.last());
            assert_eq!(cut.points.last(), bead.points.first());
        }
    }

    #[test]
    fn an_even_bead_is_one_piece_and_a_wedge_is_cut_by_its_width() {
        let mut cut = Pieces::default();
        let points: Vec<_> = (0..30).map(|i| Point2::new(i * 300_000, i % 2 * 9_000)).collect();
        let mut bead = Bead { widths: vec![450_000; points.len()], points, ..Bead::default() };
        cut.cut(&bead, Start::First, section);
        assert_eq!((cut.pieces.len(), cut.points.len()), (1, 30));
        assert!((cut.pieces[0].width - 450_000.0).abs() < 1e-6);
        bead.points = vec![Point2::new(0, 0), Point2::new(9_000_000, 0)];
        bead.widths = vec![200_000, 600_000];
        bead.kind = BeadKind::GapFill;
        cut.cut(&bead, Start::First, section);
        let widths: Vec<_> = cut.pieces.iter().map(|p| p.width.round() as i32).collect();
        assert_eq!(
            widths,
            [220_000, 260_000, 300_000, 340_000, 380_000, 420_000, 460_000, 500_000, 540_000, 580_000]
        );
        // Over a fiftieth of a millimetre there is no use in ten widths.
        bead.points[1].x = 20_000;
        cut.cut(&bead, Start::First, section);
        assert_eq!(cut.pieces.len(), 2);
    }

    #[test]
    fn a_closed_bead_is_turned_to_its_seam() {
        let mut points = circle(0, 0, 3_000_000, 40, 0.0);
        points.push(points[0]);
        let widths = (0..points.len()).map(|i| 400_000 + 5_000 * (i as i32 % 40 - 20).abs()).collect();
        let bead = Bead { points, widths, ..Bead::default() };
        assert_eq!(ring(&bead), Some(&bead.points[..40]));
        let mut cut = Pieces::default();
        for (edge, share) in [(0, 0), (7, 0), (7, 3), (39, 9)] {
            let (a, b) = (bead.points[edge], bead.points[edge + 1]);
            let at = Point2::new(a.x + (b.x - a.x) / 10 * share, a.y + (b.y - a.y) / 10 * share);
            cut.cut(&bead, Start::Seam(Seam { edge, at }, 0.0), section);
            let sum: f64 = cut.pieces.iter().map(|p| p.volume).sum();
            assert!((sum / volume(&bead) - 1.0).abs() < 1e-6, "edge {edge}: {sum}");
            assert_eq!((cut.points.first(), cut.points.last()), (Some(&at), Some(&at)));
            cut.cut(&bead, Start::Seam(Seam { edge, at }, 60e3), section);
            let gap = cut.points.last().map_or(0.0, |p| p.distance(at));
            assert!((gap - 60_000.0).abs() < 200.0, "{gap}");
        }
    }

    #[test]
    fn beads_without_extent_have_no_pieces() {
        let mut cut = Pieces::default();
        for n in 0..5 {
            let bead = Bead { points: vec![Point2::new(3, 3); n], widths: vec![9; n], ..Bead::default() };
            let seam = Seam { edge: 0, at: Point2::new(3, 3) };
            for start in [Start::First, Start::Last, Start::Seam(seam, 60e3)] {
                cut.cut(&bead, start, section);
                assert!(cut.pieces.is_empty() && cut.points.is_empty());
            }
        }
    }
}
