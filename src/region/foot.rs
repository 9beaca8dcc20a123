//! Elephant foot compensation: the first layer made smaller by what the bed squeezes out of it.

use super::boolean;
use super::offset::{self, Join};
use super::wavefront;
use crate::contour::ExPolygon;

/// Thin parts shrink by as many eighths of the compensation as they have room for.
const STEPS: i64 = 8;

/// The areas moved inwards by `distance` > 0 \[nm\], but nowhere to less than `least` in width \[nm\]:
/// parts that are too thin shrink to that width, thinner ones stay as they are.
pub fn compensate(areas: &[ExPolygon], distance: i64, least: i64) -> Vec<ExPolygon> {
    let mut result: Vec<ExPolygon> = areas.iter().flat_map(|area| one(area, distance, least)).collect();
    result.sort_unstable_by(|a, b| a.contour.cmp(&b.contour));
    result
}

fn one(area: &ExPolygon, distance: i64, least: i64) -> Vec<ExPolygon> {
    let half = least / 2;
    let source = std::slice::from_ref(area);
    // Mostly the core is in one piece with all its holes, and nothing is thin.
    if let Some([core]) = wavefront::inset(area, distance + half).as_deref()
        && core.holes.len() == area.holes.len()
    {
        return offset::inset(source, distance);
    }
    let mut result = Vec::new();
    let mut left = source.to_vec();
    for step in (0..=STEPS).rev() {
        let by = distance * step / STEPS;
        let shrunk = offset::inset(source, by);
        let part = if step == 0 {
            shrunk
        } else {
            let core = offset::inset(&shrunk, half);
            boolean::intersection(&offset::outset(&core, half, Join::Miter), &shrunk)
        };
        // Thin parts reach into what is done already, so that both become one.
        let reach = offset::outset(&left, distance + 4 * CREVICE, Join::Miter);
        let part = boolean::intersection(&part, &reach);
        if part.is_empty() {
            continue;
        }
        left = boolean::difference(&left, &offset::outset(&part, by + CREVICE, Join::Miter));
        left.retain(|p| !offset::inset(std::slice::from_ref(p), CREVICE).is_empty());
        result = merged(&result, &part);
        if left.is_empty() {
            break;
        }
    }
    result
}

/// Left-overs narrower than twice this are rounding \[nm\].
const CREVICE: i64 = 5_000;

fn merged(a: &[ExPolygon], b: &[ExPolygon]) -> Vec<ExPolygon> {
    boolean::union(a.iter().chain(b).flat_map(ExPolygon::rings), boolean::Winding::Positive)
}
