//! Several parts on one plate.

use super::{Adjacency, Mesh, OPEN, PlaceError};
use crate::lattice::{LIMIT, Point3, mm};
use rayon::prelude::*;

/// Where parts of given sizes go on a plate, `spacing` apart: the lower left corner of each. All \[nm\].
///
/// Rows of parts, the deepest parts first, the whole centred on the plate (next-fit decreasing height;
/// Coffman, Garey, Johnson, Tarjan 1980). The order of parts of equal size is kept.
///
/// # Errors
/// [`PlaceError::Crowded`] when they do not fit.
pub fn arrange(sizes: &[[i64; 2]], plate: [i64; 2], spacing: i64) -> Result<Vec<[i64; 2]>, PlaceError> {
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(sizes[i][1]), std::cmp::Reverse(sizes[i][0]), i));
    let mut corners = vec![[0; 2]; sizes.len()];
    let (mut x, mut y, mut row, mut right) = (0, 0, 0i64, 0i64);
    for i in order {
        let [width, depth] = sizes[i];
        if x > 0 && x + width > plate[0] {
            (x, y, row) = (0, y + row + spacing, 0);
        }
        corners[i] = [x, y];
        right = right.max(x + width);
        row = row.max(depth);
        x += width + spacing;
    }
    if right > plate[0] || y + row > plate[1] {
        return Err(PlaceError::Crowded {
            parts: sizes.len(),
            plate: plate.map(mm),
            needs: [right, y + row].map(mm),
        });
    }
    // Whole micrometres, as a single part is placed.
    let shift = |plate: i64, used: i64| ((plate - used) / 2 + 500).div_euclid(1000) * 1000;
    let (dx, dy) = (shift(plate[0], right), shift(plate[1], y + row));
    corners.iter_mut().for_each(|c| *c = [c[0] + dx, c[1] + dy]);
    Ok(corners)
}

/// Parts as one mesh, in the lattice of the first, with the pairing of its half-edges.
///
/// # Errors
/// [`PlaceError::TooFar`] when a part lies too far from the first, [`PlaceError::TooMany`].
pub fn join(parts: Vec<(Mesh, Adjacency)>) -> Result<(Mesh, Adjacency), PlaceError> {
    let mut parts = parts.into_iter();
    let (mut mesh, mut adjacency) = parts.next().ok_or(PlaceError::Empty)?;
    for (part, pairs) in parts {
        let (vertices, half_edges) = (mesh.vertices.len(), adjacency.twin.len());
        if half_edges + pairs.twin.len() >= OPEN as usize {
            return Err(PlaceError::TooMany);
        }
        let shift = [0, 1, 2].map(|a| part.origin[a] - mesh.origin[a]);
        let moved = |c: i32, axis: usize| i64::from(c) + shift[axis];
        let inside = |v: &Point3| {
            [moved(v.x, 0), moved(v.y, 1), moved(v.z, 2)].iter().all(|c| c.abs() < i64::from(LIMIT))
        };
        if !part.vertices.par_iter().all(inside) {
            let reach = shift.into_iter().map(i64::abs).max().unwrap_or(0);
            return Err(PlaceError::TooFar { reach: mm(reach) });
        }
        mesh.vertices.par_extend(
            part.vertices
                .par_iter()
                .map(|v| Point3::new(moved(v.x, 0) as i32, moved(v.y, 1) as i32, moved(v.z, 2) as i32)),
        );
        mesh.triangles.par_extend(part.triangles.par_iter().map(|t| t.map(|v| v + vertices as u32)));
        adjacency
            .twin
            .par_extend(pairs.twin.par_iter().map(|&t| if t == OPEN { OPEN } else { t + half_edges as u32 }));
    }
    Ok((mesh, adjacency))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::mesh::{audit, shapes};

    #[test]
    fn parts_keep_apart_and_inside() {
        let plate = [100_000_000, 60_000_000];
        let sizes = [[30_000_000, 20_000_000], [50_000_000, 25_000_000], [40_000_000, 10_000_000]];
        let spacing = 3_000_000;
        let at = arrange(&sizes, plate, spacing).unwrap();
        for (i, (a, s)) in at.iter().zip(&sizes).enumerate() {
            assert!((0..2).all(|k| a[k] >= 0 && a[k] + s[k] <= plate[k]), "{at:?}");
            for (b, t) in at.iter().zip(&sizes).skip(i + 1) {
                let apart = |k: usize| a[k] + s[k] + spacing <= b[k] || b[k] + t[k] + spacing <= a[k];
                assert!(apart(0) || apart(1), "{at:?}");
            }
        }
        assert_eq!(arrange(&[[10_000_000, 10_000_000]], plate, 0).unwrap(), [[45_000_000, 25_000_000]]);
        let error = arrange(&[sizes[0]; 9], plate, spacing).unwrap_err().to_string();
        assert!(error.contains("9 parts") && error.contains("100.00 x 60.00"), "{error}");
    }

    #[test]
    fn joined_parts_are_both_there() {
        let (a, b) = (shapes::cuboid([0.0; 3], [1.0; 3]), shapes::moved(shapes::sphere(2.0, 9, 6), [9.0; 3]));
        let mut b = b;
        b.origin = [5_000_000, -1_000_000, 0];
        let volume = |m: &Mesh| audit(m, &Adjacency::build(m)).volume_mm3;
        let sum = volume(&a) + volume(&b);
        let faces = a.triangles.len() + b.triangles.len();
        let high = b.world_bounds().unwrap()[1].map(|c| c.max(1_000_000));
        let pair = |m: Mesh| {
            let adjacency = Adjacency::build(&m);
            (m, adjacency)
        };
        let (mesh, adjacency) = join(vec![pair(a), pair(b)]).unwrap();
        assert_eq!(mesh.triangles.len(), faces);
        assert_eq!(mesh.world_bounds().unwrap()[1], high);
        assert_eq!(adjacency, Adjacency::build(&mesh));
        let found = audit(&mesh, &adjacency);
        assert!((found.volume_mm3 - sum).abs() < 1e-9 && found.shells == 2);
    }

    #[test]
    fn what_lies_too_far_away_is_refused() {
        let pair = |x: i64| {
            let mut m = shapes::cuboid([0.0; 3], [1.0; 3]);
            m.origin[0] = x;
            let adjacency = Adjacency::build(&m);
            (m, adjacency)
        };
        assert!(matches!(join(vec![pair(0), pair(2_000_000_000)]), Err(PlaceError::TooFar { .. })));
        assert_eq!(join(Vec::new()), Err(PlaceError::Empty));
    }
}
