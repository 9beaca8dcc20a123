//! Branches without kinks.

use super::Stage;
use super::clearance::distance;
use super::grow::{ON_PART, Skeleton};
use rayon::prelude::*;

/// How often each node is drawn towards the middle of its neighbours.
const ROUNDS: usize = 6;

/// Relaxes the skeleton: each node moves half way to the middle between what stands on it and what it stands on,
/// unless it would lean more, come nearer to the part, or is an end.
pub fn smooth(skeleton: &mut Skeleton, stage: &Stage) {
    let frame = &stage.plan.frame;
    let lean = libm::tan(stage.plan.tree.angle.clamp(0.0, 80.0).to_radians());
    // Per layer and node what stands on it: those of the layer above, in order of their node.
    let standing: Vec<(Vec<u32>, Vec<u32>)> = (0..skeleton.len())
        .into_par_iter()
        .map(|j| {
            let mut offset = vec![0u32; skeleton[j].len() + 1];
            let above: &[_] = skeleton.get(j + 1).map_or(&[], |n| &n[..]);
            let on = |n: &super::grow::Node| (n.below != ON_PART).then_some(n.below as usize);
            above.iter().filter_map(on).for_each(|b| offset[b + 1] += 1);
            for i in 0..skeleton[j].len() {
                offset[i + 1] += offset[i];
            }
            let mut order: Vec<u32> =
                (0..above.len() as u32).filter(|&i| on(&above[i as usize]).is_some()).collect();
            order.sort_by_key(|&i| above[i as usize].below);
            (offset, order)
        })
        .collect();
    for _ in 0..ROUNDS {
        for (j, (offset, order)) in standing.iter().enumerate().skip(1) {
            let (lower, upper) = skeleton.split_at_mut(j);
            let Some((own, above)) = upper.split_first_mut() else { continue };
            let (Some(below), Some(above)) = (lower.last(), above.first()) else { continue };
            let steps = [stage.rise(j - 1) * lean, stage.rise(j) * lean];
            own.par_iter_mut().with_min_len(64).enumerate().for_each(|(i, node)| {
                let on = &order[offset[i] as usize..offset[i + 1] as usize];
                let Some(under) = below.get(node.below as usize).filter(|_| !on.is_empty()) else { return };
                let mut middle = [0.0; 2];
                for &k in on {
                    let at = above[k as usize].at;
                    middle = [middle[0] + at[0], middle[1] + at[1]];
                }
                let count = on.len() as f64;
                let to = [0, 1].map(|k| 0.5 * node.at[k] + 0.25 * (middle[k] / count + under.at[k]));
                let leans = |a: [f64; 2], b: [f64; 2], most: f64| {
                    let square = |p: [f64; 2]| (p[0] - b[0]) * (p[0] - b[0]) + (p[1] - b[1]) * (p[1] - b[1]);
                    square(a) > (most * most).max(square(node.at))
                };
                let too_far = leans(to, under.at, steps[0])
                    || on.iter().any(|&k| leans(to, above[k as usize].at, steps[1]));
                let room = |at| distance(&stage.keep_out[j], frame, at, node.r);
                if !too_far && room(to) >= room(node.at) {
                    node.at = to;
                }
            });
        }
    }
}
