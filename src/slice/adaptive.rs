//! Layers as thick as the surface's slope allows.
//!
//! A layer of thickness h leaves a step of cusp height h |n_z| on a facet of unit normal n (Dolenc and
//! Mäkelä, "Slicing procedures for layered manufacturing techniques", Computer-Aided Design 26, 1994).
//! Layers are made as thick as keeps that within a bound on every facet they meet.

use super::planes::{LayerZ, MAX_LAYERS, PlaneError};
use crate::lattice::{Point3, mm, nm};
use crate::mesh::Mesh;
use crate::settings::Settings;

/// Heights are whole multiples of this above the first layer \[nm\]: the step of G-code coordinates,
/// so that no rounding of a written height changes a layer.
const STEP: i64 = 1000;

/// Bounds on the thickness of layers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdaptivePlan {
    /// Thickness of the first layer, whatever the slope \[nm\].
    pub first: i64,
    /// Least thickness \[nm\].
    pub min: i64,
    /// Greatest thickness \[nm\].
    pub max: i64,
    /// Greatest cusp height \[nm\].
    pub cusp: f64,
}

impl AdaptivePlan {
    /// The plan that the settings ask for: [`Settings::adaptive_heights`] and `adaptive_cusp_height`;
    /// the maximum is never below the minimum.
    pub fn new(settings: &Settings) -> Self {
        let s = &settings.slicing;
        let [min, max] = settings.adaptive_heights().map(nm);
        Self {
            first: nm(s.first_layer_height.of(s.layer_height)),
            min,
            max: max.max(min),
            cusp: s.adaptive_cusp_height * crate::lattice::NM_PER_MM,
        }
    }
}

/// The layers of a mesh standing on the bed, from z = 0 up.
///
/// Every layer but the first is as thick as possible within `min..=max` so that its thickness times
/// |n_z| is at most `cusp` for every facet that reaches into the layer; a layer may exceed that bound
/// only when it is `min` thick. Exactly horizontal facets bound nothing: they leave no cusp but a
/// displacement, of at most half the thickness of the layer they lie in. `min` is rounded up and `max`
/// down to whole micrometres. The topmost layer ends within a micrometre above the part, or is `min`
/// thick. Layers are cut at their middles, as [`super::planes::layers`] does.
///
/// O(n log h) for n triangles and h micrometres of height, and 8 h bytes.
///
/// # Errors
/// [`PlaneError`] as for uniform layers.
pub fn layers(mesh: &Mesh, plan: &AdaptivePlan) -> Result<Vec<LayerZ>, PlaneError> {
    let [lo, hi] = mesh.world_bounds().unwrap_or_default();
    let (bottom, top) = (lo[2], hi[2]);
    let top_mm = mm(top);
    for (key, height) in [("first_layer_height", plan.first), ("min_layer_height", plan.min)] {
        if height < 1 {
            return Err(PlaneError::Height { key, height_mm: mm(height) });
        }
    }
    if top >= i64::from(i32::MAX) - 2 * plan.max.max(plan.first) {
        return Err(PlaneError::TooHigh { top_mm });
    }
    let thin = || PlaneError::Thin {
        bottom_mm: mm(bottom),
        top_mm,
        first_mm: mm(plan.first),
        layer_mm: mm(plan.max),
    };
    // Half of the first layer, rounded as the uniform layers round it.
    let mut layers = Vec::new();
    let mut push = |bottom: i64, height: i64| {
        let slice_z = bottom + (height + 1) / 2;
        if slice_z < top {
            // All below the limit that was checked above.
            layers.push(LayerZ {
                slice_z: slice_z as i32,
                print_z: (bottom + height) as i32,
                height: height as i32,
            });
        }
        slice_z < top
    };
    if !push(0, plan.first) {
        return Err(thin());
    }
    let (min, max) = ((plan.min + STEP - 1) / STEP, plan.max / STEP);
    let (min, max) = (min as usize, max.max(min) as usize);
    let limits = Limits::new(mesh, plan.first, top, plan.cusp, max);
    let mut at = 0;
    let z = |at: usize| plan.first + at as i64 * STEP;
    while z(at) < top {
        let left = ((top - z(at) + STEP - 1) / STEP) as usize;
        let steps = limits.thickest(at, max).min(left).max(min);
        if !push(z(at), steps as i64 * STEP) {
            break;
        }
        at += steps;
    }
    if layers.len() as u64 > MAX_LAYERS {
        return Err(PlaneError::TooMany { top_mm, layer_mm: mm(plan.min) });
    }
    match layers.last() {
        Some(last) if i64::from(last.slice_z) > bottom => Ok(layers),
        _ => Err(thin()),
    }
}

/// Per micrometre of height the thickest layer \[µm\] that may reach into it.
///
/// Layers are unions of these cells, so a facet reaches into a layer exactly when it reaches into one
/// of the layer's cells: nothing is lost to the grid.
struct Limits {
    cells: Vec<u32>,
}

impl Limits {
    /// Cells from height `base` to `top` \[nm, world\].
    fn new(mesh: &Mesh, base: i64, top: i64, cusp: f64, max: usize) -> Self {
        let n = ((top - base + STEP - 1) / STEP).max(0) as usize;
        // A segment tree: minima are left at the nodes that make up a range and handed down at the end.
        let mut tree = vec![max as u32; 2 * n];
        for triangle in &mesh.triangles {
            let corners = triangle.map(|v| mesh.vertices[v as usize]);
            let Some(limit) = thickest(corners, cusp) else { continue };
            if limit >= max as u32 {
                continue;
            }
            let z = corners.map(|c| i64::from(c.z) + mesh.origin[2] - base);
            let from = z[0].min(z[1]).min(z[2]).max(0) / STEP;
            let to = (z[0].max(z[1]).max(z[2]).max(0) + STEP - 1) / STEP;
            let (mut from, mut to) = (from as usize + n, (to as usize).min(n) + n);
            while from < to {
                if from % 2 == 1 {
                    tree[from] = tree[from].min(limit);
                    from += 1;
                }
                if to % 2 == 1 {
                    to -= 1;
                    tree[to] = tree[to].min(limit);
                }
                from /= 2;
                to /= 2;
            }
        }
        for node in 1..n {
            let limit = tree[node];
            for child in [2 * node, 2 * node + 1] {
                tree[child] = tree[child].min(limit);
            }
        }
        Self { cells: tree.split_off(n) }
    }

    /// The thickest layer \[µm\], at most `max`, that may begin at a cell; 0 when none may.
    fn thickest(&self, from: usize, max: usize) -> usize {
        let mut allowed = max;
        for steps in 0..max {
            let cell = self.cells.get(from + steps).map_or(max, |&limit| limit as usize);
            allowed = allowed.min(cell);
            // A layer of `steps + 1` would reach into this cell.
            if allowed <= steps {
                return steps;
            }
        }
        max
    }
}

/// The thickest layer \[µm, rounded down\] whose cusp height on a triangle is within `cusp` \[nm\];
/// `None` for horizontal and vertical ones, which have no cusp.
fn thickest([a, b, c]: [Point3; 3], cusp: f64) -> Option<u32> {
    // Differences are below 2^31, so the components are exact in 64 bits.
    let minus =
        |p: Point3, q: Point3| [(p.x, q.x), (p.y, q.y), (p.z, q.z)].map(|(p, q)| i64::from(p) - i64::from(q));
    let ([ux, uy, uz], [vx, vy, vz]) = (minus(b, a), minus(c, a));
    let normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    if normal[2] == 0 || (a.z == b.z && b.z == c.z) {
        return None;
    }
    let [x, y, z] = normal.map(|c| c as f64);
    // Some ten roundings of 2^-53 each are on the safe side of this.
    let steepness = (x * x + y * y + z * z).sqrt() / z.abs() * (1.0 - 1e-14);
    Some((cusp * steepness / STEP as f64).min(f64::from(u32::MAX)) as u32)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    const MM: f64 = 1e6;

    fn plan(first: f64, min: f64, max: f64, cusp: f64) -> AdaptivePlan {
        AdaptivePlan { first: nm(first), min: nm(min), max: nm(max), cusp: cusp * MM }
    }

    /// On the bed.
    fn standing(mut mesh: Mesh) -> Mesh {
        mesh.origin[2] = -i64::from(mesh.bounds().unwrap()[0].z);
        mesh
    }

    /// Every triangle against every layer: the largest cusp height of each layer [nm], without a grid.
    fn cusps(mesh: &Mesh, layers: &[LayerZ]) -> Vec<f64> {
        let cusp = |l: &LayerZ| {
            let (bottom, top) = (i64::from(l.print_z - l.height), i64::from(l.print_z));
            let facet = |t: &[u32; 3]| {
                let p = t.map(|v| mesh.vertices[v as usize]);
                let z = p.map(|p| i64::from(p.z) + mesh.origin[2]);
                let (lo, hi) = (z.into_iter().min().unwrap(), z.into_iter().max().unwrap());
                if lo == hi || lo >= top || hi <= bottom {
                    return 0.0;
                }
                let f = p.map(|p| glam::DVec3::new(p.x.into(), p.y.into(), p.z.into()));
                let n = (f[1] - f[0]).cross(f[2] - f[0]);
                f64::from(l.height) * n.z.abs() / n.length()
            };
            mesh.triangles.iter().map(facet).fold(0.0, f64::max)
        };
        layers.iter().map(cusp).collect()
    }

    fn check(mesh: &Mesh, plan: &AdaptivePlan) -> Vec<LayerZ> {
        let list = layers(mesh, plan).unwrap();
        let mut bottom = 0;
        for (i, (l, cusp)) in list.iter().zip(cusps(mesh, &list)).enumerate() {
            assert_eq!(i64::from(l.print_z - l.height), bottom, "layers rest on each other");
            bottom = i64::from(l.print_z);
            assert!((l.slice_z - (l.print_z - l.height / 2)).abs() <= 1);
            if i > 0 {
                let height = i64::from(l.height);
                assert!(height >= plan.min && height <= plan.max, "{height}");
                assert!(cusp <= plan.cusp * (1.0 + 1e-12) || height == plan.min, "layer {i}: {cusp}");
            }
        }
        list
    }

    #[test]
    fn the_cusp_stays_within_the_bound_and_layers_are_no_thinner_than_need_be() {
        for (mesh, cusp) in [
            (shapes::sphere(8.0, 40, 33), 0.05),
            (shapes::cone(9.0, 7.0, 50), 0.1),
            (shapes::torus(8.0, 3.0, 30, 17), 0.03),
            (shapes::knot(3.0, 1.5, 3000), 0.08),
        ] {
            let mesh = standing(mesh);
            let plan = plan(0.2, 0.05, 0.3, cusp);
            let list = check(&mesh, &plan);
            // A micrometre more breaks the bound, except at the top.
            let mut thicker = list.clone();
            thicker.iter_mut().for_each(|l| {
                l.print_z += 1000;
                l.height += 1000;
            });
            let over = cusps(&mesh, &thicker);
            for (i, l) in list.iter().enumerate().skip(1).rev().skip(1) {
                let height = i64::from(l.height);
                assert!(height + 1000 > plan.max || over[i] > plan.cusp * (1.0 - 1e-12), "layer {i}");
            }
        }
    }

    #[test]
    fn steep_walls_get_thick_layers_and_flat_tops_thin_ones() {
        let ball = check(&standing(shapes::sphere(10.0, 64, 64)), &plan(0.2, 0.05, 0.3, 0.05));
        let at = |mm: f64| ball.iter().find(|l| f64::from(l.print_z) > mm * MM).unwrap().height;
        assert!(at(10.0) == 300_000 && at(19.5) < 80_000, "{} {}", at(10.0), at(19.5));
        let block = check(&standing(shapes::cuboid([0.0; 3], [5.0, 5.0, 3.1])), &plan(0.35, 0.07, 0.3, 0.01));
        assert_eq!(block.len(), 11);
        assert_eq!(block.last().unwrap().print_z, 3_120_000, "the last 0.05 mm are a layer of 0.07 mm");
    }

    #[test]
    fn the_check_sees_a_layer_that_is_too_thick() {
        let mesh = standing(shapes::cone(9.0, 7.0, 50));
        let plan = plan(0.2, 0.05, 0.3, 0.1);
        let mut list = layers(&mesh, &plan).unwrap();
        list[5].height += 1000;
        list[5].print_z += 1000;
        let worst = cusps(&mesh, &list).into_iter().skip(1).fold(0.0, f64::max);
        assert!(worst > plan.cusp * (1.0 + 1e-9));
    }

    #[test]
    fn what_cannot_be_layered_is_refused() {
        let flat = standing(shapes::cuboid([0.0; 3], [5.0, 5.0, 0.1]));
        assert!(matches!(layers(&flat, &plan(0.2, 0.05, 0.3, 0.1)), Err(PlaneError::Thin { .. })));
        let bad = plan(0.0, 0.05, 0.3, 0.1);
        assert!(matches!(layers(&flat, &bad), Err(PlaneError::Height { key: "first_layer_height", .. })));
        assert!(layers(&Mesh::default(), &plan(0.2, 0.05, 0.3, 0.1)).is_err());
        let mut high = flat;
        high.origin[2] = 1 << 40;
        assert!(matches!(layers(&high, &plan(0.2, 0.05, 0.3, 0.1)), Err(PlaneError::TooHigh { .. })));
    }
}
