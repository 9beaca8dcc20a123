//! Additional walls on slopes.
//!
//! Where the outline of the layer above runs a little further inside than this layer's walls reach, its
//! walls would stand on sparse infill. Walls are added until they carry it.

use super::inside::{Edges, bounds, ring_edges};
use super::offset;
use super::perimeters::WallPlan;
use crate::contour::{ExPolygon, Ring};
use crate::lattice::Point2;

/// A wall is added while more than this share of the outlines above lies just inside the walls, as in
/// PrusaSlicer.
const SHARE: f64 = 0.3;

/// How far inside the walls outlines above count, in spacings of walls.
const BAND: f64 = 1.5;

/// Most walls that are added; shallower slopes than these are top surfaces.
const MOST: u32 = 100;

/// For each of the areas \[nm\] the number of walls to add to those of the plan, or nothing where none
/// needs any.
pub fn extra_walls(areas: &[ExPolygon], above: &[ExPolygon], plan: &WallPlan) -> Vec<u32> {
    if plan.count == 0 || above.is_empty() || above == areas {
        return Vec::new();
    }
    let (edges, mut hint) = (&Edges::new(areas), 0);
    let depth = plan.walls_depth();
    let rings = above.iter().flat_map(ExPolygon::rings);
    let rings: Vec<Above> = rings.map(|ring| Above::new(ring, edges, depth as f64, &mut hint)).collect();
    if rings.iter().all(|r| r.free <= SHARE * r.length) {
        return Vec::new();
    }
    areas.iter().map(|area| for_area(area, depth, &rings, plan)).collect()
}

/// A ring of the layer above.
struct Above<'a> {
    ring: &'a Ring,
    low: Point2,
    high: Point2,
    length: f64,
    /// Length that was not found to lie over the walls or outside.
    free: f64,
}

impl<'a> Above<'a> {
    /// `free` is at most `SHARE` of the length as soon as that is certain.
    fn new(ring: &'a Ring, edges: &Edges, depth: f64, hint: &mut usize) -> Self {
        let length: f64 = ring_edges(ring).map(|[a, b]| a.distance(b)).sum();
        let (low, high) = bounds(ring.iter().copied());
        let (mut over_walls, mut missed) = (0.0, 0.0);
        for [a, b] in ring_edges(ring) {
            let part = covered(a, b, edges, depth, hint, SPLITS);
            over_walls += part;
            missed += a.distance(b) - part;
            if over_walls >= (1.0 - SHARE) * length || missed > SHARE * length {
                break;
            }
        }
        let free = if over_walls >= (1.0 - SHARE) * length { SHARE * length } else { length - over_walls };
        Self { ring, low, high, length, free }
    }

    /// Whether its bounds meet the other bounds.
    fn meets(&self, low: Point2, high: Point2) -> bool {
        self.low.x <= high.x && low.x <= self.high.x && self.low.y <= high.y && low.y <= self.high.y
    }
}

/// How often an edge is halved in search of parts that lie near one edge of the layer.
const SPLITS: u32 = 5;

/// Length of (a, b) that lies within `depth` of an edge, as far as that is easily seen \[nm\].
fn covered(a: Point2, b: Point2, edges: &Edges, depth: f64, hint: &mut usize, splits: u32) -> f64 {
    let length = a.distance(b);
    if edges.within(a, b, depth, hint) {
        return length;
    }
    if splits == 0 || length < depth {
        return 0.0;
    }
    let middle = a.toward(b, 0.5);
    covered(a, middle, edges, depth, hint, splits - 1) + covered(middle, b, edges, depth, hint, splits - 1)
}

fn for_area(area: &ExPolygon, depth: i64, rings: &[Above], plan: &WallPlan) -> u32 {
    let (low, high) = bounds(area.contour.iter().copied());
    let meets: Vec<&Above> = rings.iter().filter(|r| r.meets(low, high)).collect();
    let least = SHARE * meets.iter().map(|r| r.length).sum::<f64>();
    if meets.iter().map(|r| r.free).sum::<f64>() <= least {
        return 0;
    }
    let length_inside = |depth: i64| {
        let inset = offset::inset(std::slice::from_ref(area), depth);
        if inset.is_empty() { 0.0 } else { Edges::new(&inset).length_inside(meets.iter().map(|r| r.ring)) }
    };
    let band = (BAND * plan.perimeter_spacing as f64) as i64;
    for extra in 0..MOST {
        let outer = depth + i64::from(extra) * plan.perimeter_spacing;
        let beyond = length_inside(outer);
        if beyond <= least || beyond - length_inside(outer + band) <= least {
            return extra;
        }
    }
    MOST
}
