//! Single walls around top surfaces, with skin up to the external wall.

use super::boolean;
use super::inside::Cover;
use super::offset::{self, Join};
use super::perimeters::WallPlan;
use crate::contour::ExPolygon;

/// Open areas narrower than this many walls keep their walls: skin in strips looks no better.
const LEAST_WALLS: i64 = 3;

/// An area inside the external wall's centre line, of which the layer above leaves a part open.
pub struct Top {
    /// The whole area.
    whole: ExPolygon,
    /// The part that further walls are laid in. Where it ends on the open part, the next wall's outer
    /// edge lies under the outline of the layer above.
    pub covered: Vec<ExPolygon>,
}

/// What the layer above leaves open of an area inside the external wall's centre line; `None` where
/// that is not worth the while.
pub fn split(line: &ExPolygon, above: &Cover, plan: &WallPlan) -> Option<Top> {
    if above.holds(&line.rings().collect::<Vec<_>>()) {
        return None;
    }
    let whole = std::slice::from_ref(line);
    let bare = boolean::difference(whole, above.areas());
    let radius = LEAST_WALLS * plan.perimeter_spacing / 2;
    let core = offset::inset(&bare, radius);
    if core.is_empty() {
        return None;
    }
    let open = boolean::intersection(&offset::outset(&core, radius, Join::Miter), &bare);
    let covered = boolean::difference(whole, &open);
    let covered = offset::outset(&covered, plan.external_spacing / 2, Join::Miter);
    Some(Top { whole: line.clone(), covered: boolean::intersection(&covered, whole) })
}

/// The infill of the open parts; `second` are the areas inside the centre lines of the second walls.
pub fn infill(tops: &[Top], second: &[ExPolygon], plan: &WallPlan) -> Vec<ExPolygon> {
    let whole: Vec<ExPolygon> = tops.iter().map(|t| t.whole.clone()).collect();
    let inside = offset::inset(&whole, WallPlan { count: 1, ..*plan }.infill_inset());
    let walls = offset::outset(second, plan.infill_inset(), Join::Miter);
    let free = boolean::difference(&inside, &walls);
    // No slivers between walls that take different ways.
    let half = plan.solid_spacing / 2;
    boolean::intersection(&offset::outset(&offset::inset(&free, half), half, Join::Miter), &free)
}
