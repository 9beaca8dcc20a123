//! Whether a line is held along all its way.

use super::Ground;
use crate::lattice::Point2;

/// A stretch of line over air.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hanging {
    /// Its first point.
    pub from: Point2,
    /// Its last.
    pub to: Point2,
    /// Its length \[nm\].
    pub length: f64,
    /// How far it is from its chord at most \[nm\].
    pub bend: f64,
    /// Its first end is held, its last is held.
    pub anchored: [bool; 2],
}

/// The stretches of a line that nothing holds.
///
/// A stretch over air is held if the line is held before and behind it and it is straight between: no point
/// of it is more than `straight` \[nm\] from its chord. Otherwise all of it hangs. Points are looked at
/// every half pitch of the ground's rows, and corners; shorter stretches may be missed.
pub fn hanging(points: &[Point2], ground: &Ground, straight: f64) -> Vec<Hanging> {
    let mut found = Vec::new();
    let mut air: Vec<Point2> = Vec::new();
    let mut last_held = None;
    let mut visit = |p: Point2| {
        if !ground.holds(p) {
            air.push(p);
            return;
        }
        found.extend(stretch(&air, [last_held, Some(p)], straight));
        air.clear();
        last_held = Some(p);
    };
    let step = ground.step().max(1.0);
    points.first().copied().into_iter().for_each(&mut visit);
    for pair in points.windows(2) {
        let steps = (pair[0].distance(pair[1]) / step).ceil().max(1.0);
        (1..=steps as u64).for_each(|k| visit(pair[0].toward(pair[1], k as f64 / steps)));
    }
    found.extend(stretch(&air, [last_held, None], straight));
    found
}

/// A stretch over air, unless it is a bridge.
fn stretch(air: &[Point2], ends: [Option<Point2>; 2], straight: f64) -> Option<Hanging> {
    let (&first, &last) = (air.first()?, air.last()?);
    let (from, to) = (ends[0].unwrap_or(first), ends[1].unwrap_or(last));
    let bend = air.iter().map(|p| off(*p, from, to)).fold(0.0, f64::max);
    let anchored = ends.map(|e| e.is_some());
    if anchored == [true, true] && bend <= straight {
        return None;
    }
    let length = air.windows(2).map(|w| w[0].distance(w[1])).sum();
    Some(Hanging { from: first, to: last, length, bend, anchored })
}

/// Distance of a point from a segment \[nm\].
fn off(p: Point2, a: Point2, b: Point2) -> f64 {
    let f = |(x, y): (i64, i64)| (x as f64, y as f64);
    let ((ux, uy), (vx, vy)) = (f(b.minus(a)), f(p.minus(a)));
    let along = ((ux * vx + uy * vy) / (ux * ux + uy * uy).max(1.0)).clamp(0.0, 1.0);
    let (x, y) = (vx - along * ux, vy - along * uy);
    (x * x + y * y).sqrt()
}
