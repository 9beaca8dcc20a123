//! Beads in shapes of known thickness and in random ones.

use super::*;
use crate::lattice::Point2;
use crate::region::Island;
use crate::region::areas::areas;
use crate::region::perimeters::{Neighbours, walls};
use crate::region::tests::Random;

const MM: f64 = 1e6;
const HEIGHT: f64 = 0.2 * MM;
const WIDTH: f64 = 0.45 * MM;
const ROUNDING: f64 = HEIGHT * (1.0 - PI / 4.0);

fn plan(count: u32) -> WallPlan {
    let mut settings = Settings::default();
    let widths = &mut settings.widths;
    for width in [
        &mut widths.perimeter_extrusion_width,
        &mut widths.external_perimeter_extrusion_width,
        &mut widths.solid_infill_extrusion_width,
    ] {
        *width = crate::settings::FloatOrPercent::Float(WIDTH / MM);
    }
    settings.perimeters.perimeters = count;
    WallPlan::new(&settings, HEIGHT / MM, false)
}

fn islands(areas: Vec<ExPolygon>, plan: &WallPlan) -> Vec<Island> {
    walls(areas, &Neighbours::default(), plan)
}

fn ring(points: &[(f64, f64)]) -> Ring {
    points.iter().map(|&(x, y)| Point2::new((x * MM) as i32, (y * MM) as i32)).collect()
}

/// A turned rectangle.
fn bar(length: f64, thickness: f64, turn: f64) -> Vec<ExPolygon> {
    let (sine, cosine) = (libm::sin(turn), libm::cos(turn));
    let corners = [(0.0, 0.0), (length, 0.0), (length, thickness), (0.0, thickness)];
    areas(&[ring(&corners.map(|(x, y)| (x * cosine - y * sine, x * sine + y * cosine)))])
}

fn circle(radius: f64, backwards: bool) -> Ring {
    let n = 180;
    let angle = |i: i32| f64::from(if backwards { -i } else { i }) / f64::from(n) * 2.0 * PI;
    let points: Vec<_> =
        (0..n).map(|i| (radius * libm::cos(angle(i)), radius * libm::sin(angle(i)))).collect();
    ring(&points)
}

fn tube(radius: f64, thickness: f64) -> Vec<ExPolygon> {
    areas(&[circle(radius, false), circle(radius - thickness, true)])
}

/// Volume of the walls and of the beads \[mm³\].
fn volume(islands: &[Island]) -> (f64, f64) {
    let section = |width: f64| HEIGHT * (width - ROUNDING) / MM / MM;
    let (mut loops, mut beads) = (0.0, 0.0);
    for island in islands {
        for wall in &island.walls {
            let ends = wall.ring.iter().cycle().skip(1);
            loops +=
                wall.ring.iter().zip(ends).map(|(a, b)| a.distance(*b)).sum::<f64>() / MM * section(WIDTH);
        }
        for bead in &island.beads {
            assert_eq!(bead.points.len(), bead.widths.len());
            for (p, w) in bead.points.windows(2).zip(bead.widths.windows(2)) {
                beads += p[0].distance(p[1]) / MM * section(0.5 * f64::from(w[0] + w[1]));
            }
        }
    }
    (loops, beads)
}

fn distance(p: (f64, f64), ring: &[Point2]) -> f64 {
    let f = |p: Point2| (f64::from(p.x), f64::from(p.y));
    let to = |i: usize| {
        let (a, b) = (f(ring[i]), f(ring[(i + 1) % ring.len()]));
        let ((ux, uy), (vx, vy)) = ((b.0 - a.0, b.1 - a.1), (p.0 - a.0, p.1 - a.1));
        let t = ((ux * vx + uy * vy) / (ux * ux + uy * uy)).clamp(0.0, 1.0);
        libm::hypot(vx - t * ux, vy - t * uy)
    };
    (0..ring.len()).map(to).fold(f64::INFINITY, f64::min)
}

/// Places along a bead, with the width there.
fn places(bead: &Bead) -> impl Iterator<Item = ((f64, f64), f64)> {
    bead.points.windows(2).zip(bead.widths.windows(2)).flat_map(|(p, w)| {
        let mix = |a: i32, b: i32, t: f64| f64::from(a) + t * f64::from(b - a);
        [0.0, 0.25, 0.5, 0.75, 1.0]
            .map(|t| ((mix(p[0].x, p[1].x, t), mix(p[0].y, p[1].y, t)), mix(w[0], w[1], t)))
    })
}

/// How far the edge of a bead lies outside the outline at worst \[nm\].
fn spill(island: &Island) -> f64 {
    let room = |p| island.outline.rings().map(|r| distance(p, r)).fold(f64::INFINITY, f64::min);
    island.beads.iter().flat_map(places).map(|(p, w)| 0.5 * w - room(p)).fold(f64::NEG_INFINITY, f64::max)
}

#[test]
fn walls_of_any_thickness_are_solid() {
    for thickness in [0.3, 0.4, 0.45, 0.6, 0.8, 0.9, 1.0, 1.2, 1.7, 2.1] {
        let shapes = [
            ("bar", bar(40.0, thickness, 0.0), 40.0),
            ("turned bar", bar(40.0, thickness, 0.7), 40.0),
            ("tube", tube(8.0, thickness), 2.0 * PI * (8.0 - 0.5 * thickness)),
        ];
        for (name, shape, length) in shapes {
            let islands = islands(shape, &plan(3));
            let (loops, beads) = volume(&islands);
            // The round flanks of the outermost beads are missing.
            let whole = length * (thickness - ROUNDING / MM) * HEIGHT / MM;
            let share = (loops + beads) / whole;
            // Two loops may overlap by two fifths.
            let most = if thickness == 0.8 { 1.08 } else { 1.02 };
            assert!((0.97..most).contains(&share), "{name} of {thickness}: {share} ({loops} + {beads})");
            let worst = islands.iter().map(spill).fold(f64::NEG_INFINITY, f64::max);
            assert!(worst < 10_000.0, "{name} of {thickness}: {worst} nm outside");
        }
    }
}

#[test]
fn a_bead_twice_as_wide_is_noticed() {
    let mut islands = islands(bar(40.0, 0.6, 0.0), &plan(3));
    assert_eq!(islands[0].beads.len(), 1);
    islands[0].beads[0].widths.iter_mut().for_each(|w| *w *= 2);
    assert!(spill(&islands[0]) > 200_000.0);
}

#[test]
fn a_thin_wall_runs_to_half_its_width_from_the_ends() {
    let islands = islands(bar(20.0, 0.6, 0.0), &plan(3));
    let [bead] = islands[0].beads.as_slice() else { panic!("{:?}", islands[0].beads) };
    assert_eq!(bead.kind, BeadKind::ThinWall);
    assert!(bead.widths.iter().all(|w| (w - 600_000).abs() < 10), "{:?}", bead.widths);
    let mut x: Vec<i32> = bead.points.iter().map(|p| p.x).collect();
    x.sort_unstable();
    assert!(bead.points.iter().all(|p| (p.y - 300_000).abs() < 10), "{:?}", bead.points);
    assert!((x[0] - 300_000).abs() < 20_000 && (x[x.len() - 1] - 19_700_000).abs() < 20_000, "{x:?}");
}

#[test]
fn a_tube_is_one_closed_bead() {
    let islands = islands(tube(8.0, 0.5), &plan(3));
    let [bead] = islands[0].beads.as_slice() else { panic!("{:?}", islands[0].beads.len()) };
    assert_eq!(bead.points.first(), bead.points.last());
    for (p, w) in places(bead) {
        assert!((libm::hypot(p.0, p.1) - 7.75 * MM).abs() < 20_000.0 && (w - 0.5 * MM).abs() < 20_000.0);
    }
}

#[test]
fn a_wedge_is_filled_from_half_a_line_to_a_loop() {
    let wedge = areas(&[ring(&[(0.0, 0.0), (40.0, -0.6), (40.0, 0.6)])]);
    let islands = islands(wedge, &plan(1));
    let thin: Vec<&Bead> = islands[0].beads.iter().filter(|b| b.kind == BeadKind::ThinWall).collect();
    let [bead] = thin.as_slice() else { panic!("{thin:?}") };
    let (least, most) = (bead.widths.iter().min().copied(), bead.widths.iter().max().copied());
    // The loop runs into the tip as far as it can.
    assert!((225_000..227_000).contains(&least.unwrap_or(0)), "{least:?}");
    assert!((420_000..450_000).contains(&most.unwrap_or(0)), "{most:?}");
}

#[test]
fn corners_get_no_spurs_and_wide_areas_nothing() {
    let square = areas(&[ring(&[(0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)])]);
    let plan = plan(3);
    let islands = islands(square, &plan);
    assert!(islands[0].beads.is_empty());
    let infill = islands[0].infill[0].area_mm2();
    let off = WallPlan { beads: BeadPlan::default(), ..plan };
    let without = walls(vec![islands[0].outline.clone()], &Neighbours::default(), &off);
    assert_eq!(infill, without[0].infill[0].area_mm2());
}

#[test]
fn narrow_infill_becomes_gap_fill() {
    // Three walls on each side cover 0.225 + 2.5 * 0.407 of it.
    let walled = 2.0 * (0.225 + 2.5 * (0.45 - ROUNDING / MM));
    for (gap, filled) in [(0.02, false), (0.1, true), (0.5, true), (0.64, true), (0.7, false)] {
        let islands = islands(bar(30.0, walled + gap, 0.3), &plan(3));
        let [island] = islands.as_slice() else { panic!("{}", islands.len()) };
        assert_eq!(island.beads.len(), usize::from(filled), "{gap}");
        assert_eq!(island.infill.is_empty(), gap < 0.65 && (filled || island.infill.is_empty()), "{gap}");
        for width in island.beads.iter().flat_map(|b| &b.widths) {
            assert!((f64::from(*width) - gap * MM - ROUNDING).abs() < 10_000.0, "{gap}: {width}");
        }
    }
}

impl Random {
    fn unit(&mut self) -> f64 {
        self.below(1 << 40) as f64 / (1u64 << 40) as f64
    }

    /// Bars, blobs and rings over each other, a few line widths thick.
    fn thin_shapes(&mut self) -> Vec<ExPolygon> {
        let mut rings = Vec::new();
        for _ in 0..1 + self.below(4) {
            let (x, y) = (4.0 * self.unit(), 4.0 * self.unit());
            let moved = |ring: &Ring| -> Ring {
                let by = |c: i32, by: f64| c + (by * MM) as i32;
                ring.iter().map(|p| Point2::new(by(p.x, x), by(p.y, y))).collect()
            };
            match self.below(3) {
                0 => {
                    let (length, turn) = (1.0 + 8.0 * self.unit(), 6.3 * self.unit());
                    rings
                        .extend(bar(length, 0.2 + 2.0 * self.unit(), turn).iter().map(|p| moved(&p.contour)));
                }
                1 => {
                    let n = 8 + self.below(120);
                    let (size, lobes, wave) = (1.0 + 2.0 * self.unit(), 2 + self.below(7), 0.9 * self.unit());
                    let points = (0..n).map(|i| {
                        let t = i as f64 / n as f64 * 2.0 * PI;
                        let r = size * (1.0 + wave * libm::sin(t * lobes as f64));
                        (r * libm::cos(t), r * libm::sin(t))
                    });
                    rings.push(moved(&ring(&points.collect::<Vec<_>>())));
                }
                _ => rings.push(moved(&ring(&[
                    (0.0, 0.0),
                    (8.0 * self.unit(), self.unit()),
                    (3.0 * self.unit(), 4.0 * self.unit()),
                ]))),
            }
        }
        areas(&rings)
    }
}

/// Whether two segments cross properly.
fn cross(a: Point2, b: Point2, c: Point2, d: Point2) -> bool {
    let side = |a, b, c| lattice::cross(a, b, c).signum();
    side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0
}

#[test]
fn beads_keep_inside_in_range_and_off_the_walls() {
    let seed = 0x5EED_0101;
    let mut random = Random(seed);
    let (mut beads, mut crossings) = (0, 0);
    for case in 0..400 {
        let plan = plan(1 + random.below(4) as u32);
        for island in islands(random.thin_shapes(), &plan) {
            let worst = spill(&island);
            assert!(worst < 10_000.0, "seed {seed:#x}, case {case}: {worst} nm outside");
            for bead in &island.beads {
                beads += 1;
                let spacing = WIDTH - ROUNDING;
                let (least, most) = match bead.kind {
                    BeadKind::ThinWall => (THINNEST * WIDTH, WIDTH + 0.6 * spacing),
                    BeadKind::GapFill => {
                        (NARROWEST_GAP * spacing + ROUNDING, WIDEST_GAP * spacing + ROUNDING)
                    }
                };
                for &w in &bead.widths {
                    let w = f64::from(w);
                    assert!(w > least - 10.0 && w < most + 10.0, "seed {seed:#x}, case {case}: {w}");
                }
                for p in bead.points.windows(2) {
                    for wall in &island.walls {
                        let ends = wall.ring.iter().cycle().skip(1);
                        crossings +=
                            wall.ring.iter().zip(ends).filter(|(a, b)| cross(p[0], p[1], **a, **b)).count();
                        assert_eq!(crossings, 0, "seed {seed:#x}, case {case}: {p:?}");
                    }
                }
            }
        }
    }
    assert!(beads > 300, "only {beads} beads");
}

#[test]
fn beads_move_with_their_areas() {
    let seed = 0x5EED_0102;
    let mut random = Random(seed);
    for case in 0..150 {
        let (shapes, plan) = (random.thin_shapes(), plan(1 + random.below(3) as u32));
        let by = Point2::new(
            100_000_007 * (random.below(9) as i32 - 4),
            99_999_989 * (random.below(9) as i32 - 4),
        );
        let moved = |r: &Ring| -> Ring { r.iter().map(|p| Point2::new(p.x + by.x, p.y + by.y)).collect() };
        let there: Vec<ExPolygon> = shapes
            .iter()
            .map(|p| ExPolygon { contour: moved(&p.contour), holes: p.holes.iter().map(moved).collect() })
            .collect();
        for (a, b) in islands(shapes, &plan).iter().zip(&islands(there, &plan)) {
            let expected: Vec<Bead> =
                a.beads.iter().map(|b| Bead { points: moved(&b.points), ..b.clone() }).collect();
            assert_eq!(expected, b.beads, "seed {seed:#x}, case {case}");
        }
    }
}
