//! The order of loops.

use crate::contour::{ExPolygon, Ring};
use crate::lattice::{Point2, cross};
use crate::region::inside::bounds;

/// The rings of areas on `levels`, each of which holds the next level's: every area's own before those inside
/// it, and all of these before the next area of its level, so that the nozzle stays with one part.
pub(super) fn outside_in(levels: &[Vec<ExPolygon>]) -> Vec<Ring> {
    let box_of = |p: &ExPolygon| bounds(p.contour.iter().copied());
    let boxes: Vec<Vec<(Point2, Point2)>> = levels.iter().map(|l| l.iter().map(box_of).collect()).collect();
    // Per area of a level those of the next that lie in it.
    let mut inside: Vec<Vec<Vec<usize>>> = levels.iter().map(|l| vec![Vec::new(); l.len()]).collect();
    let mut open: Vec<(usize, usize)> = Vec::new();
    for (level, areas) in levels.iter().enumerate() {
        for (i, area) in areas.iter().enumerate() {
            let holds = |k: &usize| {
                let above = level - 1;
                let ((low, high), (l, h)) = (boxes[above][*k], boxes[level][i]);
                let in_box = low.x <= l.x && low.y <= l.y && high.x >= h.x && high.y >= h.y;
                in_box && area.contour.first().is_some_and(|p| is_inside(&levels[above][*k], *p))
            };
            let parent = if level == 0 { None } else { (0..levels[level - 1].len()).find(holds) };
            match parent {
                Some(k) => inside[level - 1][k].push(i),
                None => open.push((level, i)),
            }
        }
    }
    open.reverse();
    let mut rings = Vec::new();
    while let Some((level, i)) = open.pop() {
        rings.extend(levels[level][i].rings().cloned());
        open.extend(inside[level][i].iter().rev().map(|k| (level + 1, *k)));
    }
    rings
}

fn is_inside(area: &ExPolygon, p: Point2) -> bool {
    area.rings().map(|ring| winding(ring, p)).sum::<i32>() > 0
}

/// How often a ring runs around a point, counter-clockwise.
fn winding(ring: &[Point2], p: Point2) -> i32 {
    let next = ring.iter().cycle().skip(1);
    let turn = |(a, b): (&Point2, &Point2)| match (a.y <= p.y, b.y <= p.y) {
        (true, false) if cross(*a, *b, p) > 0 => 1,
        (false, true) if cross(*a, *b, p) < 0 => -1,
        _ => 0,
    };
    ring.iter().zip(next).map(turn).sum()
}
