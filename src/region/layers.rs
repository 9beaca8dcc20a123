//! Walls of all layers of an object, each with the layers that touch it.

use super::Island;
use super::perimeters::{Neighbours, WallPlan, walls};
use crate::contour::ExPolygon;
use rayon::prelude::*;

/// The walls of every layer, lowest first; `plans` is as long as `areas`.
pub fn all_walls(areas: Vec<Vec<ExPolygon>>, plans: &[WallPlan]) -> Vec<Vec<Island>> {
    areas
        .par_iter()
        .zip(plans)
        .enumerate()
        .map(|(i, (own, plan))| {
            let neighbours = Neighbours {
                below: i.checked_sub(1).and_then(|j| areas.get(j)).map(Vec::as_slice),
                above: areas.get(i + 1).map(Vec::as_slice),
            };
            walls(own.clone(), &neighbours, plan)
        })
        .collect()
}
