//! Discs at sharp corners, where prints begin to lift.

use super::Free;
use crate::contour::{ExPolygon, Ring};
use crate::lattice::{Point2, nm};
use crate::region::boolean::{self, Winding};
use crate::region::offset::{Join, inset, outset};
use crate::settings::AdhesionSettings;
use crate::support::skirt::grown;

/// A corner's angle is that between the outline's points this far to either side \[nm\], so that small
/// facets and roundings do not matter.
const LEG: f64 = 1e6;

/// The areas of ears: discs with the radius `brim_width` about the corners, where a brim is wanted.
pub(super) fn ears(first: &[ExPolygon], free: &Free, settings: &AdhesionSettings) -> Vec<ExPolygon> {
    let discs: Vec<Ring> = first
        .iter()
        .flat_map(ExPolygon::rings)
        .flat_map(|ring| corners(ring, settings.brim_ears_max_angle))
        .filter_map(|corner| grown(&[corner], settings.brim_width))
        .collect();
    let discs = boolean::union(&discs, Winding::Positive);
    let separation = nm(settings.brim_separation);
    let mut area = Vec::new();
    if !free.solid.is_empty() {
        area = boolean::difference(&discs, &outset(&free.solid, separation, Join::Round));
    }
    if !free.holes.is_empty() {
        area.extend(boolean::intersection(&discs, &inset(&free.holes, separation)));
    }
    area
}

/// The corners of a ring where the material on its left has an angle of at most `degrees`; the sharpest of
/// those that are nearer than [`LEG`] to each other along the ring.
fn corners(ring: &[Point2], degrees: f64) -> Vec<Point2> {
    let n = ring.len();
    // Way along the ring to each point.
    let mut way = vec![0.0];
    for i in 0..n {
        way.push(way[i] + ring[i].distance(ring[(i + 1) % n]));
    }
    let whole = way[n];
    if n < 3 || whole <= 0.0 {
        return Vec::new();
    }
    let leg = LEG.min(whole / 4.0);
    let at = |s: f64| {
        let s = if s < 0.0 {
            s + whole
        } else if s >= whole {
            s - whole
        } else {
            s
        };
        let i = (way.partition_point(|w| *w <= s) - 1).min(n - 1);
        let length = way[i + 1] - way[i];
        let share = if length > 0.0 { (s - way[i]) / length } else { 0.0 };
        let (dx, dy) = ring[(i + 1) % n].minus(ring[i]);
        (ring[i], dx as f64 * share, dy as f64 * share)
    };
    let sharp = |i: usize| {
        let from = |(q, x, y): (Point2, f64, f64)| {
            let (dx, dy) = q.minus(ring[i]);
            (dx as f64 + x, dy as f64 + y)
        };
        let (ax, ay) = from(at(way[i] - leg));
        let (bx, by) = from(at(way[i] + leg));
        // To the left of the way from a over the corner to b.
        let convex = ay * bx - ax * by > 0.0;
        let lengths = ((ax * ax + ay * ay) * (bx * bx + by * by)).sqrt();
        let cosine = (ax * bx + ay * by) / lengths.max(1.0);
        (convex && cosine >= libm::cos(degrees.to_radians()) - 1e-9).then_some((i, cosine))
    };
    let found: Vec<(usize, f64)> = (0..n).filter_map(sharp).collect();
    let beats = |(i, x): (usize, f64), (j, y): (usize, f64)| {
        let apart = (way[i] - way[j]).abs();
        i != j && apart.min(whole - apart) < leg && (y > x || (y == x && j < i))
    };
    found.iter().filter(|a| !found.iter().any(|b| beats(**a, *b))).map(|(i, _)| ring[*i]).collect()
}
