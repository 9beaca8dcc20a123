//! Loops around the whole print, which prime the nozzle and show the extents.

use crate::contour::Ring;
use crate::lattice::{LIMIT, NM_PER_MM, Point2, cross};
use crate::settings::flow::Flow;
use crate::settings::{AdhesionSettings, DraftShield};
use std::f64::consts::{PI, TAU};

/// Largest distance of a rounded corner's chords from its arc \[mm\].
pub const ARC_TOLERANCE: f64 = 0.01;

/// No skirt has more loops than this, however much filament `min_skirt_length` asks for.
pub const MOST_LOOPS: u32 = 1000;

/// Centre lines of the skirt's loops \[nm\], counter-clockwise, in printing order: from the outermost
/// inwards.
///
/// The loops run around the convex hull of `outlines`, which are those of all objects on the layers
/// that have a skirt: the i-th at a distance of `skirt_distance` + (i + 1/2) x spacing, so that
/// `skirt_distance` is left free between the print and the innermost bead (PrusaSlicer's rule). Corners
/// are arcs within [`ARC_TOLERANCE`]. Loops are added until `min_skirt_length` of filament is used;
/// `filament_per_mm` is the filament for each mm of line \[mm\]. All layers with a skirt have these loops.
/// Loops that would leave the lattice are left out, and none are made around nothing or without
/// [`is_wanted`].
pub fn skirt<'a>(
    outlines: impl IntoIterator<Item = &'a Ring>,
    flow: Flow,
    filament_per_mm: f64,
    settings: &AdhesionSettings,
) -> Vec<Ring> {
    let mut loops = Vec::new();
    let hull = convex_hull(outlines.into_iter().flatten().copied().collect());
    if !is_wanted(settings) || hull.is_empty() {
        return loops;
    }
    let mut filament = 0.0;
    for i in 0..MOST_LOOPS {
        if i >= settings.skirts && filament >= settings.min_skirt_length {
            break;
        }
        let distance = settings.skirt_distance + (f64::from(i) + 0.5) * flow.spacing();
        let Some(ring) = grown(&hull, distance) else { break };
        filament += length(&ring) * filament_per_mm;
        loops.push(ring);
    }
    loops.reverse();
    loops
}

/// Whether there is a skirt: `skirts` is not 0, and neither is its height.
pub fn is_wanted(settings: &AdhesionSettings) -> bool {
    settings.skirts > 0 && (settings.skirt_height > 0 || settings.draft_shield == DraftShield::Enabled)
}

/// The hull of lines of a `width` \[mm\] \[nm\]; `None` without any, or where it would leave the lattice.
pub fn hull_of_lines<'a>(lines: impl IntoIterator<Item = &'a [Point2]>, width: f64) -> Option<Ring> {
    let hull = convex_hull(lines.into_iter().flatten().copied().collect());
    if hull.is_empty() { None } else { grown(&hull, 0.5 * width) }
}

/// The corners of the convex hull, counter-clockwise from the lowest (x, y), without points on its
/// sides: Andrew's monotone chain (1979), exact.
pub fn convex_hull(mut points: Vec<Point2>) -> Ring {
    points.sort_unstable();
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let mut hull: Ring = Vec::new();
    let mut chain = |points: &mut dyn Iterator<Item = &Point2>| {
        let from = hull.len();
        for &p in points {
            while let [.., a, b] = hull[from..]
                && cross(a, b, p) <= 0
            {
                hull.pop();
            }
            hull.push(p);
        }
        // The last point starts the other chain.
        hull.pop();
    };
    chain(&mut points.iter());
    chain(&mut points.iter().rev());
    hull
}

/// A convex ring, moved outwards by `distance` \[mm\] with round corners; `None` when it would leave
/// the lattice.
pub(super) fn grown(hull: &[Point2], distance: f64) -> Option<Ring> {
    let radius = distance * NM_PER_MM;
    // A chord of angle a is r (1 - cos(a / 2)) from its arc.
    let share = 1.0 - (ARC_TOLERANCE / distance).clamp(0.0, 1.0);
    let largest = (2.0 * libm::acos(share)).clamp(0.01, PI / 2.0);
    let n = hull.len();
    let direction = |i: usize| {
        let (dx, dy) = hull[(i + 1) % n].minus(hull[i % n]);
        libm::atan2(dy as f64, dx as f64)
    };
    let mut ring = Vec::new();
    for (i, corner) in hull.iter().enumerate() {
        // The outward normal is a quarter turn to the right of the side's direction.
        let before = if n == 1 { 0.0 } else { direction(i + n - 1) - PI / 2.0 };
        let turn = match n {
            1 => TAU,
            _ => {
                let turn = direction(i) - PI / 2.0 - before;
                if turn < 0.0 { turn + TAU } else { turn }
            }
        };
        let steps = (turn / largest).ceil().max(1.0);
        let last = if n == 1 { steps as usize - 1 } else { steps as usize };
        for k in 0..=last {
            let (sin, cos) = libm::sincos(before + turn * k as f64 / steps);
            let x = (f64::from(corner.x) + radius * cos).round();
            let y = (f64::from(corner.y) + radius * sin).round();
            if x.abs().max(y.abs()) >= f64::from(LIMIT) {
                return None;
            }
            ring.push(Point2::new(x as i32, y as i32));
        }
    }
    ring.dedup();
    if ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    Some(ring)
}

/// Length of a closed ring \[mm\].
fn length(ring: &[Point2]) -> f64 {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).sum::<f64>() / NM_PER_MM
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::area2;
    use crate::settings::flow::Section;

    const FLOW: Flow = Flow { width: 0.45, height: 0.2, section: Section::Rounded };

    /// Distance of a point to a segment \[mm\].
    fn to_segment(p: Point2, a: Point2, b: Point2) -> f64 {
        let ((ux, uy), (vx, vy)) = (b.minus(a), p.minus(a));
        let (ux, uy, vx, vy) = (ux as f64, uy as f64, vx as f64, vy as f64);
        let t = ((ux * vx + uy * vy) / (ux * ux + uy * uy).max(1.0)).clamp(0.0, 1.0);
        (vx - t * ux).hypot(vy - t * uy) / NM_PER_MM
    }

    /// Least distance of `p` to a ring's outline \[mm\].
    fn to_ring(p: Point2, ring: &[Point2]) -> f64 {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| to_segment(p, *a, *b)).fold(f64::INFINITY, f64::min)
    }

    fn shapes() -> Vec<Ring> {
        let point = |x, y| Point2::new(x, y);
        vec![
            vec![point(0, 0), point(20_000_000, 0), point(20_000_000, 10_000_000), point(0, 10_000_000)],
            vec![point(-5_000_000, 3_000_000), point(30_000_000, 5_000_000), point(2_000_000, 40_000_000)],
        ]
    }

    #[test]
    fn every_loop_keeps_its_distance_from_the_hull() {
        let settings = AdhesionSettings { skirts: 3, ..AdhesionSettings::default() };
        for outlines in [shapes(), vec![vec![Point2::new(7, 7)]], vec![shapes()[0][..2].to_vec()]] {
            let hull = convex_hull(outlines.concat());
            let loops = skirt(&outlines, FLOW, 0.03, &settings);
            assert_eq!(loops.len(), 3);
            for (i, ring) in loops.iter().rev().enumerate() {
                let wanted = 6.0 + (i as f64 + 0.5) * FLOW.spacing();
                assert!(area2(ring) > 0);
                for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                    let middle = Point2::new(a.x.midpoint(b.x), a.y.midpoint(b.y));
                    let (corner, chord) = (to_ring(*a, &hull), to_ring(middle, &hull));
                    assert!((corner - wanted).abs() < 3e-6, "{corner} for {wanted}");
                    assert!(chord > wanted - ARC_TOLERANCE - 3e-6 && chord < wanted + 3e-6, "{chord}");
                }
            }
        }
    }

    #[test]
    fn loops_are_added_until_the_length_is_reached() {
        let outlines = shapes();
        let one = length(&skirt(&outlines, FLOW, 0.03, &AdhesionSettings::default())[0]) * 0.03;
        let settings = AdhesionSettings { min_skirt_length: 4.1 * one, ..AdhesionSettings::default() };
        let loops = skirt(&outlines, FLOW, 0.03, &settings);
        let total: f64 = loops.iter().map(|r| length(r) * 0.03).sum();
        let inner: f64 = loops[1..].iter().map(|r| length(r) * 0.03).sum();
        assert!(total >= settings.min_skirt_length && inner < settings.min_skirt_length);
    }

    #[test]
    fn no_skirt_where_none_is_wanted_or_possible() {
        let none = AdhesionSettings { skirts: 0, ..AdhesionSettings::default() };
        assert!(skirt(&shapes(), FLOW, 0.03, &none).is_empty());
        let flat = AdhesionSettings { skirt_height: 0, ..AdhesionSettings::default() };
        assert!(skirt(&shapes(), FLOW, 0.03, &flat).is_empty());
        let limited = AdhesionSettings { draft_shield: DraftShield::Limited, ..flat.clone() };
        assert!(skirt(&shapes(), FLOW, 0.03, &limited).is_empty());
        let shield = AdhesionSettings { draft_shield: DraftShield::Enabled, ..flat };
        assert_eq!(skirt(&shapes(), FLOW, 0.03, &shield).len(), 1);
        assert!(skirt(&[], FLOW, 0.03, &AdhesionSettings::default()).is_empty());
        let edge = vec![vec![Point2::new(LIMIT - 1, 0), Point2::new(0, 5), Point2::new(0, 0)]];
        assert!(skirt(&edge, FLOW, 0.03, &AdhesionSettings::default()).is_empty());
        let endless = AdhesionSettings { min_skirt_length: 1e300, ..AdhesionSettings::default() };
        assert!(skirt(&shapes(), FLOW, 0.0, &endless).len() <= MOST_LOOPS as usize);
    }

    #[test]
    fn the_hull_holds_every_point_and_has_only_corners() {
        let mut state = 9u64;
        for _ in 0..200 {
            let mut next = || {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 40) as i32 % 40 - 20
            };
            let points: Vec<_> = (0..30).map(|_| Point2::new(next(), next())).collect();
            let hull = convex_hull(points.clone());
            let n = hull.len();
            for i in 0..n {
                let (a, b, c) = (hull[i], hull[(i + 1) % n], hull[(i + 2) % n]);
                assert!(cross(a, b, c) > 0);
                assert!(points.iter().all(|p| cross(a, b, *p) >= 0));
            }
        }
    }
}
