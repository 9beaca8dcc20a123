//! The inset by its definition, on dense rows: what of an area neither a strip along an edge nor a joint
//! at a corner covers.
//!
//! Each strip and each joint is convex, so that a row meets it in one interval; no curve is built, nothing
//! is united, and no case is special. Rows lie in the middles of strips of equal height.

use microtome::contour::ExPolygon;
use microtome::lattice::Point2;

type Place = (f64, f64);

/// Corners that reach further than this many distances are cut off square.
const MITER_LIMIT: f64 = 2.0;

/// Area \[mm²\] of what lies at least `distance` \[nm\] inside, with mitred corners, on about `rows` rows.
pub fn inset_area(areas: &[ExPolygon], distance: f64, rows: u32) -> f64 {
    areas.iter().map(|area| one(area, distance, rows)).sum()
}

/// Length of all borders \[mm\].
pub fn length(areas: &[ExPolygon]) -> f64 {
    let rings = areas.iter().flat_map(ExPolygon::rings);
    rings.flat_map(|r| sides(r)).map(|[a, b]| (b.0 - a.0).hypot(b.1 - a.1)).sum::<f64>() * 1e-6
}

fn sides(ring: &[Point2]) -> Vec<[Place; 2]> {
    let at = |i: usize| (f64::from(ring[i % ring.len()].x), f64::from(ring[i % ring.len()].y));
    (0..ring.len()).map(|i| [at(i), at(i + 1)]).filter(|[a, b]| a != b).collect()
}

fn one(area: &ExPolygon, distance: f64, rows: u32) -> f64 {
    let mut edges = Vec::new();
    let mut covers = Vec::new();
    for ring in area.rings() {
        let sides = sides(ring);
        let before = sides.iter().cycle().skip(sides.len().saturating_sub(1));
        for (side, before) in sides.iter().zip(before) {
            covers.push(strip(side, distance));
            covers.extend(joint(before, side, distance));
        }
        edges.extend(sides);
    }
    let y = || edges.iter().map(|e| e[0].1);
    let (low, high) = (y().fold(f64::INFINITY, f64::min), y().fold(f64::NEG_INFINITY, f64::max));
    let step = (high - low) / f64::from(rows);
    if edges.len() < 3 || step <= 0.0 {
        return 0.0;
    }
    let at = |k: usize| low + (k as f64 + 0.5) * step;
    // Per row the ends of the area's spans, and what is covered.
    let mut inside = vec![Vec::new(); rows as usize];
    let mut covered = vec![Vec::new(); rows as usize];
    let meets = |low_y: f64, high_y: f64| {
        let row = |y: f64| ((y - low) / step - 0.5).ceil().clamp(0.0, f64::from(rows)) as usize;
        row(low_y)..row(high_y)
    };
    for [a, b] in edges {
        for k in meets(a.1.min(b.1), a.1.max(b.1)) {
            inside[k].push(a.0 + (at(k) - a.1) / (b.1 - a.1) * (b.0 - a.0));
        }
    }
    for cover in &covers {
        let y = || cover.iter().map(|p| p.1);
        let range = meets(y().fold(f64::INFINITY, f64::min), y().fold(f64::NEG_INFINITY, f64::max));
        for k in range {
            let (mut from, mut to) = (f64::INFINITY, f64::NEG_INFINITY);
            for (a, b) in cover.iter().zip(cover.iter().cycle().skip(1)) {
                if (a.1 < at(k)) != (b.1 < at(k)) {
                    let x = a.0 + (at(k) - a.1) / (b.1 - a.1) * (b.0 - a.0);
                    (from, to) = (from.min(x), to.max(x));
                }
            }
            if from < to {
                covered[k].push((from, to));
            }
        }
    }
    let free = |(mut ends, mut covers): (Vec<f64>, Vec<Place>)| {
        ends.sort_by(f64::total_cmp);
        covers.sort_by(|a, b| a.0.total_cmp(&b.0));
        ends.chunks_exact(2).map(|span| uncovered(span[0], span[1], &covers)).sum::<f64>()
    };
    inside.into_iter().zip(covered).map(free).sum::<f64>() * step * 1e-12
}

/// Length of a span without what sorted intervals cover.
fn uncovered(mut from: f64, to: f64, covers: &[Place]) -> f64 {
    let mut free = 0.0;
    for &(begin, end) in covers {
        if begin >= to {
            break;
        }
        free += (begin - from).max(0.0);
        from = from.max(end);
    }
    free + (to - from).max(0.0)
}

fn direction([a, b]: &[Place; 2]) -> Place {
    let length = (b.0 - a.0).hypot(b.1 - a.1);
    ((b.0 - a.0) / length, (b.1 - a.1) / length)
}

fn plus(p: Place, u: Place, by: f64) -> Place {
    (p.0 + by * u.0, p.1 + by * u.1)
}

fn left(u: Place) -> Place {
    (-u.1, u.0)
}

/// What an edge covers.
fn strip(side: &[Place; 2], d: f64) -> Vec<Place> {
    let normal = left(direction(side));
    vec![side[0], side[1], plus(side[1], normal, d), plus(side[0], normal, d)]
}

/// What the corner between two edges covers, where the border turns away from the inside.
fn joint(before: &[Place; 2], after: &[Place; 2], d: f64) -> Option<Vec<Place>> {
    let (u, v, corner) = (direction(before), direction(after), after[0]);
    let turn = (u.0 * v.1 - u.1 * v.0).atan2(u.0 * v.0 + u.1 * v.1);
    // A fold all the way back counts as a turn away.
    if (0.0..std::f64::consts::PI - 1e-6).contains(&turn) {
        return None;
    }
    let turn = turn.abs();
    let (begin, end) = (plus(corner, left(u), d), plus(corner, left(v), d));
    if 1.0 / (turn / 2.0).cos() <= MITER_LIMIT {
        let reach = d * (turn / 2.0).tan();
        return Some(vec![corner, begin, plus(begin, u, reach), end]);
    }
    // Half of the turn at each end of the cap.
    let reach = d * (turn / 4.0).tan();
    Some(vec![corner, begin, plus(begin, u, reach), plus(end, v, -reach), end])
}
