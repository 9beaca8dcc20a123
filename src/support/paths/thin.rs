//! Lines where there is no room for a loop.

use super::shrink::shrink;
use crate::contour::ExPolygon;
use crate::region::gaps::thin_walls;
use crate::support::{Strand, StrandKind};
use std::f64::consts::PI;

/// How far inside a spot its loop runs, as shares of a line's width; the first one that has room.
const INSIDE: [f64; 2] = [0.25, 0.125];

/// The lines of an area in which a loop of lines `width` \[nm\] wide has no room: along its middle, or around
/// the spot that it is. Slivers narrower than half a line have none.
pub fn strands(area: &ExPolygon, width: f64, kind: StrandKind) -> Vec<Strand> {
    let along: Vec<Strand> = thin_walls(area, width)
        .into_iter()
        .map(|bead| {
            let mut points = bead.points;
            let closed = points.len() > 3 && points.first() == points.last();
            if closed {
                points.pop();
            }
            Strand { points, closed, kind }
        })
        .filter(|s| s.points.len() > 1)
        .collect();
    if !along.is_empty() {
        return along;
    }
    let inner = |share: f64| {
        let inner = shrink(area, (share * width).round() as i64);
        inner.into_iter().map(|p| p.contour).max_by_key(|ring| crate::lattice::area2(ring))
    };
    let spot = INSIDE.into_iter().find_map(inner).filter(|ring| {
        let next = ring.iter().cycle().skip(1);
        ring.iter().zip(next).map(|(a, b)| a.distance(*b)).sum::<f64>() < 2.0 * PI * width
    });
    spot.map(|points| Strand { points, closed: true, kind }).into_iter().collect()
}
