//! Loops cut where something else is printed.

use super::super::{Strand, StrandKind};
use super::closed;
use crate::contour::{ExPolygon, Ring};
use crate::lattice::Point2;
use crate::region::inside::Edges;
use crate::region::offset::{Join, outset};

/// The parts of closed lines at a distance of `reach` \[nm\] and more from `others`; open parts below the
/// length `least` \[nm\] are dropped.
pub(super) fn clear_of(rings: Vec<Ring>, others: &[ExPolygon], reach: i64, least: i64) -> Vec<Strand> {
    if others.is_empty() {
        return rings.into_iter().map(closed).collect();
    }
    let taken = Edges::new(&outset(others, reach, Join::Round));
    let mut strands = Vec::new();
    for ring in rings {
        let mut parts: Vec<Vec<Point2>> = Vec::new();
        let (mut whole, mut runs, mut from_start) = (true, false, false);
        taken.cut(&ring, |edge, from, to, inside| {
            let (a, b) = (ring[edge], ring[if edge + 1 == ring.len() { 0 } else { edge + 1 }]);
            if inside {
                (whole, runs) = (false, false);
                return;
            }
            from_start |= edge == 0 && from == 0.0;
            let end = if to == 1.0 { b } else { a.toward(b, to) };
            match parts.last_mut() {
                Some(part) if runs => part.push(end),
                _ => parts.push(vec![if from == 0.0 { a } else { a.toward(b, from) }, end]),
            }
            runs = true;
        });
        if whole {
            strands.push(closed(ring));
            continue;
        }
        // The ring starts within a part.
        if runs
            && from_start
            && parts.len() > 1
            && let Some(mut last) = parts.pop()
        {
            last.extend(parts[0].iter().skip(1));
            parts[0] = last;
        }
        parts.retain(|p| length(p) >= least as f64);
        strands.extend(parts.into_iter().map(|points| Strand {
            points,
            closed: false,
            kind: StrandKind::Brim,
        }));
    }
    strands
}

fn length(points: &[Point2]) -> f64 {
    points.windows(2).map(|p| p[0].distance(p[1])).sum()
}
