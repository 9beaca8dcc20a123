//! The layers of branches.

use super::contacts::Wanted;
use super::{Layer, Part, SupportPlan};

/// Lower contacts share a layer rather than to lie closer than this \[nm\].
pub const THINNEST: i32 = 40_000;

/// Layers from the bed to the highest contact: one ends at each contact, with as few between as are no thicker
/// than allowed; or the part's own. Sets the contacts' layers and leaves out those that lie too low for any.
pub fn heights(part: Part, wanted: &mut Vec<Wanted>, plan: &SupportPlan) -> Vec<Layer> {
    let first = plan.base_z + plan.first_height;
    let mut fixed: Vec<i32> = wanted.iter().map(|w| w.top).filter(|&z| z >= first - THINNEST).collect();
    fixed.sort_unstable();
    fixed.dedup();
    let Some(&highest) = fixed.last() else { return Vec::new() };
    let mut layers = Vec::new();
    if plan.synchronized {
        let mut below = plan.base_z;
        for level in part.levels {
            let top = i32::try_from(level.top).unwrap_or(i32::MAX);
            if top > highest {
                break;
            }
            if top - below >= THINNEST {
                layers.push(Layer { top, height: top - below });
                below = top;
            }
        }
    } else {
        layers.push(Layer { top: first, height: plan.first_height });
        let mut z = first;
        for to in fixed {
            let rise = to - z;
            if rise < THINNEST {
                continue;
            }
            let most = plan.heights[1].max(THINNEST);
            let count = (rise + most - 1) / most;
            for k in 1..=count {
                let top = z + (i64::from(rise) * i64::from(k) / i64::from(count)) as i32;
                layers.push(Layer { top, height: top - layers.last().map_or(0, |l: &Layer| l.top) });
            }
            z = to;
        }
    }
    // The highest layer that ends at or below the contact.
    wanted.retain_mut(|w| {
        let above = layers.partition_point(|l| l.top <= w.top);
        w.layer = above.saturating_sub(1);
        above > 0
    });
    layers.truncate(wanted.iter().map(|w| w.layer + 1).max().unwrap_or(0));
    layers
}
