//! Heights that are given → the layers of all columns.

use super::contacts::Hanging;
use crate::span::Rows;
use crate::span::algebra::{and, erode, or, sub};
use crate::support::{Part, SupportPlan};
use std::sync::Arc;

/// A layer of support from `bottom` to `top` \[nm above the bed\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Step {
    /// Lower side.
    pub bottom: i32,
    /// Upper side.
    pub top: i32,
}

/// The layers of all columns, lowest first, each upon the one before: as few as fit between the heights at
/// which columns must end and, where there is room, those at which they may begin on the part; or the part's.
pub fn layers(part: Part, hanging: &[Hanging], plan: &SupportPlan) -> Vec<Step> {
    let mut tops: Vec<i32> = hanging.iter().map(|h| h.top).collect();
    tops.sort_unstable();
    tops.dedup();
    let Some(&highest) = tops.last() else { return Vec::new() };
    if plan.synchronized {
        return synchronized(part, highest, plan);
    }
    let fixed = fixed(&tops, &landings(part, hanging, plan), plan);
    let first = (plan.base_z == 0 && highest >= plan.first_height)
        .then_some(Step { bottom: 0, top: plan.first_height });
    let between = fixed.windows(2).flat_map(|pair| evenly(pair[0], pair[1], plan.heights[1]));
    first.into_iter().chain(between).collect()
}

/// The part's own layers up to `highest`.
fn synchronized(part: Part, highest: i32, plan: &SupportPlan) -> Vec<Step> {
    let Some(first) = part.levels.first() else { return Vec::new() };
    let step = |bottom: i64, top: i64| Step { bottom: bottom as i32, top: top as i32 };
    // On a raft the part's first layer begins above it.
    let own = part.levels[1..].iter().map(|l| step(l.bottom, l.top));
    let most = plan.heights[1].max((first.top - first.bottom) as i32);
    let lowest = evenly(plan.base_z, first.top as i32, most);
    lowest.chain(own).take_while(|s| s.top <= highest).collect()
}

/// Layers between two heights: as few as are at most `most` thick, evenly thick.
fn evenly(from: i32, to: i32, most: i32) -> impl Iterator<Item = Step> {
    let (height, n) = (i64::from(to - from), i64::from(count(to - from, most)));
    let at = move |i: i64| (i64::from(from) + height * i / n.max(1)) as i32;
    (0..n).map(move |i| Step { bottom: at(i), top: at(i + 1) })
}

/// The least number of layers at most `most` thick.
fn count(height: i32, most: i32) -> i32 {
    let most = most.max(1);
    height / most + i32::from(height % most > 0)
}

/// The heights at which layers end, the lowest one being where the second layer begins: the tops, those that
/// lie too near to others lowered, so that gaps only grow; and of the bottoms those that have room.
fn fixed(tops: &[i32], bottoms: &[i32], plan: &SupportPlan) -> Vec<i32> {
    let [least, most] = [plan.heights[0].min(plan.heights[1]), plan.heights[1].max(1)];
    let fits = |height: i32| i64::from(count(height, most)) * i64::from(least) <= i64::from(height);
    let mut last = if plan.base_z == 0 { plan.first_height } else { plan.base_z };
    let mut fixed = vec![last];
    for &top in tops {
        let height = top.saturating_sub(last);
        if height <= 0 {
            continue;
        }
        let to = if fits(height) { top } else { last + (count(height, most) - 1) * most };
        if to > last {
            fixed.push(to);
            last = to;
        }
    }
    for &bottom in bottoms {
        let above = fixed.partition_point(|&z| z < bottom);
        if let (Some(&low), Some(&high)) = (above.checked_sub(1).and_then(|i| fixed.get(i)), fixed.get(above))
            && bottom < high
            && fits(bottom - low)
            && fits(high - bottom)
        {
            fixed.insert(above, bottom);
        }
    }
    fixed
}

/// The heights at which something that falls from `hanging` comes to lie on the part, the gap included,
/// ascending.
fn landings(part: Part, hanging: &[Hanging], plan: &SupportPlan) -> Vec<i32> {
    let frame = part.frame;
    // Beside a wall that goes on upwards nothing stands.
    let along = frame.units(plan.xy_gap.max(plan.width));
    let across = (along / frame.pitch().max(1)) as u32 + 1;
    let mut shadow = Rows::default();
    let mut heights = Vec::new();
    let mut next = hanging.len();
    for i in (0..part.outlines.len()).rev() {
        let (own, top) = (&part.outlines[i], part.levels[i].top);
        while let Some(h) = next.checked_sub(1).map(|n| &hanging[n]).filter(|h| i64::from(h.top) >= top) {
            shadow = or(&shadow, &h.area);
            next -= 1;
        }
        let same = part.outlines.get(i + 1).is_some_and(|above| Arc::ptr_eq(own, above));
        if same || shadow.is_empty() {
            continue;
        }
        let landed = and(&shadow, own);
        if landed.is_empty() {
            continue;
        }
        let open = part.outlines.get(i + 1).map(|above| sub(&landed, above));
        if !erode(open.as_ref().unwrap_or(&landed), across, along as i32).is_empty() {
            heights.push((top as i32).saturating_add(plan.bottom_gap));
        }
        shadow = sub(&shadow, &landed);
    }
    heights.reverse();
    heights
}
