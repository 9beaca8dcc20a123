//! Walls of all layers of an object, each with the layers that touch it.

use super::Island;
use super::perimeters::{Neighbours, WallPlan, walls};
use crate::contour::ExPolygon;
use rayon::prelude::*;

/// The walls of every layer, lowest first; `plans` is as long as `areas`.
///
/// Where a layer, its neighbours and its plan equal those of the layer below it, so do its walls, which
/// are computed once for all layers of such a run.
pub fn all_walls(areas: Vec<Vec<ExPolygon>>, plans: &[WallPlan]) -> Vec<Vec<Island>> {
    let layers = areas.len().min(plans.len());
    let starts: Vec<usize> = (0..layers).filter(|&i| !repeats(&areas, plans, i)).collect();
    let ends = starts.iter().skip(1).copied().chain([layers]);
    let runs: Vec<(usize, usize)> = starts.iter().copied().zip(ends).collect();
    let of_run = |(start, end): (usize, usize)| {
        let first = of_layer(&areas, plans, start);
        rayon::iter::repeat_n(first, end - start)
    };
    runs.into_par_iter().flat_map(of_run).collect()
}

fn of_layer(areas: &[Vec<ExPolygon>], plans: &[WallPlan], i: usize) -> Vec<Island> {
    let neighbours = Neighbours {
        below: i.checked_sub(1).and_then(|j| areas.get(j)).map(Vec::as_slice),
        above: areas.get(i + 1).map(Vec::as_slice),
    };
    walls(areas[i].clone(), &neighbours, &plans[i])
}

/// Whether layer `i` has all that decides on its walls in common with the layer below.
fn repeats(areas: &[Vec<ExPolygon>], plans: &[WallPlan], i: usize) -> bool {
    let same = |j: usize| areas.get(j).is_some_and(|above| *above == areas[j - 1]);
    i > 1 && plans[i] == plans[i - 1] && same(i) && same(i - 1) && same(i + 1)
}
