//! Unions, intersections and differences. The only file that names the polygon library.
//!
//! The library ([i_overlay](https://crates.io/crates/i_overlay), pinned) works on the same `i32`
//! lattice as everything else here; its range -2^30 ..= 2^30 - 1 contains ours. Every result is
//! canonical: rings start at their smallest point, holes and polygons are sorted, so that it depends
//! on the areas alone and not on the order of the input.

use crate::contour::{ExPolygon, Ring};
use crate::lattice::Point2;
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{IntOverlayOptions, Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::core::solver::Solver;
use i_overlay::i_float::int::point::IntPoint;
use std::cell::RefCell;

/// Rings of less area than this are dropped \[nm²\]: 2e-5 mm², hair-thin left-overs of crossings
/// rounded to the lattice. A 0.4 mm nozzle lays nothing below 0.1 mm².
pub const MIN_AREA: u64 = 20_000_000;

/// Which winding numbers count as inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Winding {
    /// All but 0.
    NonZero,
    /// 1 and above.
    Positive,
}

/// The union of closed rings \[nm\] that may cross themselves and each other.
///
/// The result's polygons are disjoint, their contours counter-clockwise, their holes clockwise.
pub fn union<'a>(rings: impl IntoIterator<Item = &'a Ring>, rule: Winding) -> Vec<ExPolygon> {
    run(rings, [], OverlayRule::Subject, rule)
}

/// The areas \[nm\] that lie in both operands.
pub fn intersection(a: &[ExPolygon], b: &[ExPolygon]) -> Vec<ExPolygon> {
    run(rings(a), rings(b), OverlayRule::Intersect, Winding::NonZero)
}

/// The areas \[nm\] of `a` that lie outside `b`.
pub fn difference(a: &[ExPolygon], b: &[ExPolygon]) -> Vec<ExPolygon> {
    run(rings(a), rings(b), OverlayRule::Difference, Winding::NonZero)
}

fn rings(polygons: &[ExPolygon]) -> impl Iterator<Item = &Ring> {
    polygons.iter().flat_map(ExPolygon::rings)
}

thread_local! {
    /// The library's buffers, whose allocation takes a fifth of the time of small operations.
    static OVERLAY: RefCell<Overlay<i32>> = RefCell::new(Overlay::new_custom(
        0,
        IntOverlayOptions { min_output_area: MIN_AREA, ..Default::default() },
        Solver::AUTO,
    ));
}

fn run<'a, 'b>(
    subject: impl IntoIterator<Item = &'a Ring>,
    clip: impl IntoIterator<Item = &'b Ring>,
    operation: OverlayRule,
    rule: Winding,
) -> Vec<ExPolygon> {
    let subject: Vec<&[Point2]> = subject.into_iter().map(Vec::as_slice).collect();
    let clip: Vec<&[Point2]> = clip.into_iter().map(Vec::as_slice).collect();
    let Some(centre) = centre(subject.iter().chain(&clip).copied()) else { return Vec::new() };

    // Working about the centre makes the result move with its input, whatever the library rounds.
    let rule = match rule {
        Winding::NonZero => FillRule::NonZero,
        Winding::Positive => FillRule::Positive,
    };
    let back = |ring: Vec<IntPoint<i32>>| -> Ring {
        ring.into_iter().map(|p| Point2::new(p.x + centre.x, p.y + centre.y)).collect()
    };
    let shapes = OVERLAY.with_borrow_mut(|overlay| {
        overlay.clear();
        for (rings, side) in [(&subject, ShapeType::Subject), (&clip, ShapeType::Clip)] {
            for ring in rings {
                let about = |p: &Point2| IntPoint::new(p.x - centre.x, p.y - centre.y);
                overlay.add_path_iter(ring.iter().map(about), side);
            }
        }
        overlay.overlay(operation, rule)
    });
    let polygons = shapes.into_iter().filter_map(|shape| {
        let mut rings = shape.into_iter().map(back);
        rings.next().map(|contour| ExPolygon { contour, holes: rings.collect() })
    });
    canonical(polygons.collect())
}

/// The middle of the bounding box; `None` without any point.
fn centre<'a>(rings: impl Iterator<Item = &'a [Point2]>) -> Option<Point2> {
    let mut points = rings.flatten();
    let first = *points.next()?;
    let (low, high) = points.fold((first, first), |(low, high), p| {
        (Point2::new(low.x.min(p.x), low.y.min(p.y)), Point2::new(high.x.max(p.x), high.y.max(p.y)))
    });
    // Half of the extent is added to the low corner, so that the rounding moves with the input.
    let middle = |low: i32, high: i32| low + (high.abs_diff(low) / 2) as i32;
    Some(Point2::new(middle(low.x, high.x), middle(low.y, high.y)))
}

/// Rings from their smallest point on, holes and polygons sorted.
pub(super) fn canonical(mut polygons: Vec<ExPolygon>) -> Vec<ExPolygon> {
    for polygon in &mut polygons {
        rotate(&mut polygon.contour);
        polygon.holes.iter_mut().for_each(rotate);
        polygon.holes.sort_unstable();
    }
    polygons.sort_unstable_by(|a, b| a.contour.cmp(&b.contour).then_with(|| a.holes.cmp(&b.holes)));
    polygons
}

/// Starts the ring at its smallest point; where that occurs twice, at the one with the smaller
/// successor.
fn rotate(ring: &mut Ring) {
    let key = |i: usize| (ring[i], ring[(i + 1) % ring.len()]);
    if let Some(start) = (0..ring.len()).min_by_key(|&i| key(i)) {
        ring.rotate_left(start);
    }
}
