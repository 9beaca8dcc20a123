//! Beads in shapes of known thickness and in random ones.

use super::*;
use crate::lattice::Point2;
use crate::region::Island;
use crate::region::areas::areas;
use crate::region::perimeters::{Neighbours, walls};

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
