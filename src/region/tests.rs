//! Areas, offsets and walls on shapes of known size and on random ones, against a second library.

use super::areas::areas;
use super::boolean::{self, Winding};
use super::gaps::BeadPlan;
use super::offset::{self, Join};
use super::perimeters::{self, Neighbours, WallPlan};
use super::wavefront;
use crate::contour::{ExPolygon, Ring, nest};
use crate::lattice::Point2;
use crate::settings::OnePerimeter;
use clipper2_rust::{EndType, JoinType, Paths64, Point64};

const MM: i32 = 1_000_000;

fn ring(points: &[(i32, i32)]) -> Ring {
    points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
}

fn square(x: i32, y: i32, side: i32) -> Ring {
    ring(&[(x, y), (x + side, y), (x + side, y + side), (x, y + side)])
}

fn reversed(mut r: Ring) -> Ring {
    r.reverse();
    r
}

fn area(polygons: &[ExPolygon]) -> f64 {
    polygons.iter().map(ExPolygon::area_mm2).sum()
}

fn map(polygons: &[ExPolygon], f: impl Fn(&Ring) -> Ring) -> Vec<ExPolygon> {
    let one = |p: &ExPolygon| ExPolygon { contour: f(&p.contour), holes: p.holes.iter().map(&f).collect() };
    polygons.iter().map(one).collect()
}

fn shifted(r: &Ring, dx: i32, dy: i32) -> Ring {
    r.iter().map(|p| Point2::new(p.x + dx, p.y + dy)).collect()
}

/// Marsaglia's xorshift64.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn below(&mut self, n: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0 % n
    }

    pub(super) fn range(&mut self, low: i32, high: i32) -> i32 {
        low + self.below((high - low) as u64) as i32
    }

    /// A few rings that cross themselves and each other, some on a coarse grid so that they touch.
    fn mess(&mut self) -> Vec<Ring> {
        let grid = [1, 1, 7, MM / 4][self.below(4) as usize];
        (0..1 + self.below(3))
            .map(|_| {
                let n = 3 + self.below(12);
                (0..n)
                    .map(|_| {
                        let mut coordinate = || {
                            let fine = self.range(0, MM);
                            (self.range(-5, 5) * MM + fine) / grid * grid
                        };
                        Point2::new(coordinate(), coordinate())
                    })
                    .collect()
            })
            .collect()
    }

    /// A round blob with ripples, mostly simple, of many short edges.
    fn blob(&mut self) -> Ring {
        let n = 20 + self.below(150) as i32;
        let (a, k, b) = (self.range(1, 5), self.range(2, 9), self.range(0, 90));
        (0..n)
            .map(|i| {
                let t = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
                let r = f64::from(a) * (1.0 + 0.01 * f64::from(b) * libm::sin(t * f64::from(k)));
                Point2::new((1e6 * r * libm::cos(t)) as i32, (1e6 * r * libm::sin(t)) as i32)
            })
            .collect()
    }

    fn shapes(&mut self) -> Vec<ExPolygon> {
        if self.below(2) == 0 {
            areas(&[self.blob()])
        } else {
            boolean::union(&self.mess(), Winding::NonZero)
        }
    }
}

fn clipper(polygons: &[ExPolygon]) -> Paths64 {
    let point = |p: &Point2| Point64::new(i64::from(p.x), i64::from(p.y));
    polygons.iter().flat_map(ExPolygon::rings).map(|r| r.iter().map(point).collect()).collect()
}

fn clipper_offset(polygons: &[ExPolygon], delta: f64, join: JoinType) -> f64 {
    let paths = clipper2_rust::inflate_paths_64(
        &clipper(polygons),
        delta,
        join,
        EndType::Polygon,
        offset::MITER_LIMIT,
        offset::ARC_TOLERANCE,
    );
    paths.iter().map(clipper2_rust::area).sum::<f64>() * 1e-12
}

#[test]
fn rings_nest_by_winding() {
    let (outer, hole, inner) =
        (square(0, 0, 10 * MM), square(MM, MM, 8 * MM), square(2 * MM, 2 * MM, 6 * MM));
    let nested = areas(&[inner.clone(), reversed(hole.clone()), outer.clone()]);
    assert_eq!(nested.len(), 2);
    assert_eq!(nested[0].holes.len(), 1);
    assert_eq!(area(&nested), 100.0 - 64.0 + 36.0);
    // A shell inside a solid one vanishes, a hole without a shell is nothing.
    assert_eq!(areas(&[outer.clone(), inner]), areas(std::slice::from_ref(&outer)));
    assert!(areas(&[reversed(outer.clone())]).is_empty());
    // Two shells with a common void inside only one of them: the other one fills it.
    assert_eq!(area(&areas(&[outer.clone(), square(-MM, -MM, 12 * MM), reversed(hole)])), 144.0);
}

#[test]
fn rings_that_touch_are_united() {
    let a = square(0, 0, 2 * MM);
    for (what, other, expected) in [
        ("twice the same", a.clone(), 4.0),
        ("overlapping", square(MM, MM, 2 * MM), 7.0),
        ("sharing an edge", square(2 * MM, 0, 2 * MM), 8.0),
        ("sharing a corner", square(2 * MM, 2 * MM, 2 * MM), 8.0),
        ("a corner on an edge", ring(&[(2 * MM, MM), (4 * MM, 0), (4 * MM, 2 * MM)]), 6.0),
    ] {
        let both = vec![a.clone(), other];
        assert!(nest::nest(both.clone()).is_err(), "{what}");
        assert_eq!(area(&areas(&both)), expected, "{what}");
    }
    // A zero-width bridge between two squares, and a needle without width.
    let bridge = ring(&[
        (0, 0),
        (MM, 0),
        (MM, MM / 2),
        (2 * MM, MM / 2),
        (2 * MM, 0),
        (3 * MM, 0),
        (3 * MM, MM),
        (2 * MM, MM),
        (2 * MM, MM / 2),
        (MM, MM / 2),
        (MM, MM),
        (0, MM),
    ]);
    assert_eq!(area(&areas(&[bridge])), 2.0);
    assert_eq!(area(&areas(&[ring(&[(0, 0), (MM, 0), (MM, MM), (5 * MM, MM), (0, MM)])])), 1.0);
}

#[test]
fn the_sweep_agrees_with_the_union() {
    let seed = 0x5EED_0001;
    let mut random = Random(seed);
    let mut proven = 0;
    for case in 0..2_000 {
        // Canonical rings of a union never cross; a duplicate of one always touches.
        let shapes = random.shapes();
        let mut rings: Vec<Ring> = shapes.iter().flat_map(ExPolygon::rings).cloned().collect();
        if let Ok(polygons) = nest::nest(rings.clone()) {
            proven += 1;
            assert_eq!(polygons, shapes, "seed {seed:#x}, case {case}");
        }
        let mess = random.mess();
        if let Ok(polygons) = nest::nest(mess.clone()) {
            let error = area(&polygons) - area(&boolean::union(&mess, Winding::Positive));
            assert!(error.abs() < 1e-4, "seed {seed:#x}, case {case}: {error} mm2");
        }
        if let Some(first) = rings.first().cloned() {
            rings.push(first);
            assert!(nest::nest(rings).is_err(), "seed {seed:#x}, case {case}");
        }
    }
    assert!(proven > 1_000, "only {proven} of 2000 were proven");
}

#[test]
fn insets_have_the_area_of_geometry() {
    let one = |contour: Ring, holes: Vec<Ring>| vec![ExPolygon { contour, holes }];
    let plate = one(square(0, 0, 10 * MM), vec![reversed(square(4 * MM, 4 * MM, 2 * MM))]);
    let d = i64::from(MM / 2);
    assert_eq!(area(&offset::inset(&plate, d)), 81.0 - 9.0);
    assert!(offset::inset(&plate, 2 * i64::from(MM)).is_empty(), "the hole reaches the contour exactly");
    let l = one(ring(&[(0, 0), (3 * MM, 0), (3 * MM, MM), (MM, MM), (MM, 3 * MM), (0, 3 * MM)]), vec![]);
    // Arms of 3 x 1 become 2 x 0.
    assert!(area(&offset::inset(&l, d)) < 1e-4);
    assert!((area(&offset::inset(&l, d / 2)) - (0.5 * 2.5 + 0.5 * 2.0)).abs() < 1e-9);
    // A comb loses its teeth and keeps its back; a star's wings retract; a needle vanishes.
    let mut comb = vec![(0, -2 * MM), (20 * MM, -2 * MM), (20 * MM, 0)];
    for k in (0..10).rev() {
        let x = 2 * k * MM;
        comb.extend([(x + 3 * MM / 2, 0), (x + MM, 5 * MM), (x + MM / 2, 0)]);
    }
    comb.push((0, 0));
    let comb = one(ring(&comb), vec![]);
    let raw = offset::raw_inset(&comb[0], 3e5);
    assert!((area(&offset::inset(&comb, 300_000)) - area(&raw)).abs() < 0.01);
    let needle = one(ring(&[(0, 0), (50 * MM, 0), (50 * MM, MM / 10)]), vec![]);
    assert!(offset::inset(&needle, d).is_empty());
    assert!((area(&offset::outset(&plate, d, Join::Miter)) - (121.0 - 1.0)).abs() < 1e-9);
    let round = 100.0 + 20.0 + std::f64::consts::PI / 4.0 - 1.0;
    let grown = area(&offset::outset(&plate, d, Join::Round));
    assert!(grown < round && grown > round - 0.04, "{grown} of {round}");
}

#[test]
fn insets_agree_with_clipper() {
    let seed = 0x5EED_0002;
    let mut random = Random(seed);
    let (mut sum, mut fast) = (0.0, 0);
    let cases = 1_500;
    for case in 0..cases {
        let shapes = random.shapes();
        let d = i64::from(random.range(20_000, 800_000));
        let ours = offset::inset(&shapes, d);
        fast += usize::from(shapes.iter().all(|p| wavefront::inset(p, d).is_some()));
        let error = area(&ours) - clipper_offset(&shapes, -(d as f64), JoinType::Miter);
        assert!(error.abs() < 1.0, "seed {seed:#x}, case {case}, {d} nm: off by {error} mm2");
        sum += error.abs();
    }
    assert!(sum < 0.001 * f64::from(cases), "off by {sum} mm2 in all");
    assert!(fast > 300, "only {fast} of {cases} took the fast route");
}

#[test]
fn outsets_agree_with_clipper() {
    let seed = 0x5EED_0003;
    let mut random = Random(seed);
    for case in 0..300 {
        let shapes = random.shapes();
        let d = i64::from(random.range(20_000, 3_000_000));
        let ours = area(&offset::outset(&shapes, d, Join::Round));
        let theirs = clipper_offset(&shapes, d as f64, JoinType::Round);
        assert!(
            (ours - theirs).abs() < 0.01 * theirs + 0.05,
            "seed {seed:#x}, case {case}: {ours}, {theirs}"
        );
    }
}

#[test]
fn a_wrong_distance_is_noticed() {
    let shapes = areas(&[Random(7).blob()]);
    let error = area(&offset::inset(&shapes, 101_000)) - clipper_offset(&shapes, -1e5, JoinType::Miter);
    assert!(error.abs() > 0.005, "{error}");
}

const PLAN: WallPlan = WallPlan {
    count: 3,
    external_width: 420_000,
    external_spacing: 380_000,
    perimeter_spacing: 410_000,
    solid_spacing: 410_000,
    solid_width: 450_000,
    infill_overlap: 100_000,
    extra: false,
    reach: 0,
    one_wall: OnePerimeter::None,
    beads: BeadPlan { thin_walls: false, gap_fill: false, rounding: 42_920 },
};

fn distance_to(p: Point2, a: Point2, b: Point2) -> f64 {
    let f = |(x, y): (i64, i64)| (x as f64, y as f64);
    let ((ux, uy), (vx, vy)) = (f(b.minus(a)), f(p.minus(a)));
    let t = ((ux * vx + uy * vy) / (ux * ux + uy * uy)).clamp(0.0, 1.0);
    let (wx, wy) = (vx - t * ux, vy - t * uy);
    (wx * wx + wy * wy).sqrt()
}

/// Least distance of a vertex of `a` from an edge of `b` \[nm\].
fn gap(a: &Ring, b: &Ring) -> f64 {
    let to_edges = |&p: &Point2| (0..b.len()).map(move |i| distance_to(p, b[i], b[(i + 1) % b.len()]));
    a.iter().flat_map(to_edges).fold(f64::INFINITY, f64::min)
}

#[test]
fn no_wall_comes_too_near_the_outline() {
    let seed = 0x5EED_0004;
    let mut random = Random(seed);
    for case in 0..150 {
        for island in perimeters::walls(random.shapes(), &Neighbours::default(), &PLAN) {
            for wall in &island.walls {
                let least = 210_000.0 + f64::from(wall.depth) * 390_000.0 - 10_000.0;
                let near = |r: &Ring| gap(r, &wall.ring).min(gap(&wall.ring, r));
                let nearest = island.outline.rings().map(near).fold(f64::INFINITY, f64::min);
                assert!(nearest >= least, "seed {seed:#x}, case {case}, {}: {nearest}", wall.depth);
            }
        }
    }
}

#[test]
fn walls_move_and_mirror_with_their_areas() {
    let seed = 0x5EED_0005;
    let mut random = Random(seed);
    for case in 0..100 {
        let shapes = random.shapes();
        let islands = perimeters::walls(shapes.clone(), &Neighbours::default(), &PLAN);
        let (dx, dy) = (random.range(-9, 9) * 100_000_007, random.range(-9, 9) * 99_999_989);
        let moved = perimeters::walls(map(&shapes, |r| shifted(r, dx, dy)), &Neighbours::default(), &PLAN);
        for (a, b) in islands.iter().zip(&moved) {
            assert_eq!(map(&a.infill, |r| shifted(r, dx, dy)), b.infill, "seed {seed:#x}, case {case}");
            assert_eq!(a.walls.len(), b.walls.len(), "seed {seed:#x}, case {case}");
            for (a, b) in a.walls.iter().zip(&b.walls) {
                assert_eq!(shifted(&a.ring, dx, dy), b.ring, "seed {seed:#x}, case {case}");
            }
        }
        let mirror = |r: &Ring| reversed(r.iter().map(|p| Point2::new(-p.x, p.y)).collect());
        let mirrored = perimeters::walls(map(&shapes, mirror), &Neighbours::default(), &PLAN);
        let sum = |islands: &[super::Island]| islands.iter().map(|i| area(&i.infill)).sum::<f64>();
        let error = sum(&islands) - sum(&mirrored);
        assert!(error.abs() < 0.05, "seed {seed:#x}, case {case}: {error} mm2");
    }
}
