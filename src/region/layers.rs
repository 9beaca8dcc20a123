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
    let same = |j: usize| areas.get(j).is_some_and(|above| *above == areas[j - 1]);
    // Layers 0 and 1 never have equal neighbours: nothing is below the first.
    let repeats = |i: usize| i > 1 && plans[i] == plans[i - 1] && same(i) && same(i - 1) && same(i + 1);
    let of_layer = |i: usize| {
        let neighbours = Neighbours {
            below: i.checked_sub(1).and_then(|j| areas.get(j)).map(Vec::as_slice),
            above: areas.get(i + 1).map(Vec::as_slice),
        };
        walls(areas[i].clone(), &neighbours, &plans[i])
    };
    once_per_run(areas.len().min(plans.len()), repeats, of_layer)
}

/// `of_layer` for each of so many layers, called once where layers `repeat` the one below them.
pub fn once_per_run<T: Clone + Send>(
    layers: usize,
    repeats: impl Fn(usize) -> bool,
    of_layer: impl Fn(usize) -> T + Sync,
) -> Vec<T> {
    let starts: Vec<usize> = (0..layers).filter(|&i| i == 0 || !repeats(i)).collect();
    let ends = starts.iter().skip(1).copied().chain([layers]);
    let runs: Vec<(usize, usize)> = starts.iter().copied().zip(ends).collect();
    let of_run = |(start, end): (usize, usize)| rayon::iter::repeat_n(of_layer(start), end - start);
    runs.into_par_iter().flat_map(of_run).collect()
}
