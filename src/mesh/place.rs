//! A part onto the bed: only the mesh's origin moves.

use super::Mesh;
use crate::lattice::{NM_PER_MM, nm};
use thiserror::Error;

/// Where a part comes to stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// Lowest point onto the bed, bounding box centred on the bed's bounding box.
    DropAndCentre,
    /// The file's coordinates.
    Keep,
}

/// A part that cannot be printed where it stands. Lengths in millimetres.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "fields say what their message shows")]
pub enum PlaceError {
    /// No vertices.
    #[error("the part is empty; there is nothing to place")]
    Empty,
    /// A bed without an area.
    #[error(
        "bed_shape has {points} points and no usable area; give at least three corners, for example 0x0,200x0,200x200,0x200"
    )]
    BadBed { points: usize },
    /// Wider or deeper than the bed.
    #[error("the part is {:.2} x {:.2} mm, larger than the bed of {:.2} x {:.2} mm; scale, turn or split it, or set bed_shape", size[0], size[1], bed[0], bed[1])]
    TooLarge { size: [f64; 2], bed: [f64; 2] },
    /// Taller than the printer.
    #[error(
        "the part is {height:.2} mm high, max_print_height is {limit:.2} mm; scale, turn or split it, or set max_print_height (0 = unlimited)"
    )]
    TooHigh { height: f64, limit: f64 },
    /// Small enough, but not on the bed.
    #[error("the part reaches from {:.2}, {:.2} to {:.2}, {:.2} mm, beyond the bed ({:.2}, {:.2} to {:.2}, {:.2} mm); let it be centred, or move it", part[0][0], part[0][1], part[1][0], part[1][1], bed[0][0], bed[0][1], bed[1][0], bed[1][1])]
    OffBed { part: [[f64; 2]; 2], bed: [[f64; 2]; 2] },
    /// Several parts that do not fit together.
    #[error("the {parts} parts need {:.2} x {:.2} mm side by side, the plate has {:.2} x {:.2} mm; print fewer at once, turn them, or set a smaller spacing", needs[0], needs[1], plate[0], plate[1])]
    Crowded { parts: usize, plate: [f64; 2], needs: [f64; 2] },
    /// Coordinates beyond the lattice.
    #[error(
        "the part reaches {reach:.0} mm from its middle, beyond the lattice's 1073 mm; scale it down or move it nearer"
    )]
    TooFar { reach: f64 },
    /// More facets on one plate than can be numbered.
    #[error("the parts have more than 1.4 billion facets together; print fewer at once")]
    TooMany,
    /// Part of it would be printed into the bed.
    #[error("the part begins {depth:.3} mm below the bed; let it be dropped onto the bed, or move it")]
    BelowBed { depth: f64 },
}

/// How far a part may reach over an edge of the bed or into it \[mm\]: rounding in files and in the
/// placement must not refuse a part that is as large as the bed.
const SLACK: f64 = 0.01;

/// Places a part. `bed_shape`: corners of the bed \[mm\].
///
/// Centring rounds the origin's x and y to whole micrometres, the step of G-code coordinates, so that
/// a part's coordinates round the same way on every bed. The lowest point comes to z = 0 exactly.
///
/// # Errors
/// [`PlaceError::Empty`] and [`PlaceError::BadBed`].
pub fn place(mesh: &mut Mesh, bed_shape: &[[f64; 2]], mode: Placement) -> Result<(), PlaceError> {
    let [lo, hi] = mesh.bounds().ok_or(PlaceError::Empty)?;
    let bed = bed_bounds(bed_shape)?;
    if mode == Placement::Keep {
        return Ok(());
    }
    let to = |axis: usize, lo: i32, hi: i32| {
        // Twice the middles, so that no half is lost before the one rounding.
        let twice = nm(bed[0][axis]) + nm(bed[1][axis]) - i64::from(lo) - i64::from(hi);
        (twice + 1000).div_euclid(2000) * 1000
    };
    mesh.origin = [to(0, lo.x, hi.x), to(1, lo.y, hi.y), -i64::from(lo.z)];
    Ok(())
}

/// Checks that a part stands on the bed and under the printer's ceiling.
///
/// `bed_shape`: corners of the bed \[mm\], any convex polygon either way round; `max_print_height`
/// \[mm\], 0 = unlimited.
///
/// # Errors
/// [`PlaceError`] names the sizes and what to do.
pub fn fits(mesh: &Mesh, bed_shape: &[[f64; 2]], max_print_height: f64) -> Result<(), PlaceError> {
    let world = mesh.world_bounds().ok_or(PlaceError::Empty)?;
    let bed = bed_bounds(bed_shape)?;
    let [lo, hi] = world.map(|p| p.map(|c| c as f64 / NM_PER_MM));
    if lo[2] < -SLACK {
        return Err(PlaceError::BelowBed { depth: -lo[2] });
    }
    if max_print_height > 0.0 && hi[2] > max_print_height + SLACK {
        return Err(PlaceError::TooHigh { height: hi[2], limit: max_print_height });
    }
    let size = [hi[0] - lo[0], hi[1] - lo[1]];
    let extent = [bed[1][0] - bed[0][0], bed[1][1] - bed[0][1]];
    if size[0] > extent[0] + SLACK || size[1] > extent[1] + SLACK {
        return Err(PlaceError::TooLarge { size, bed: extent });
    }
    let corners = [[lo[0], lo[1]], [hi[0], lo[1]], [hi[0], hi[1]], [lo[0], hi[1]]];
    if corners.iter().all(|&c| inside(bed_shape, c)) {
        return Ok(());
    }
    // A round part on a round bed: its box has corners beyond the bed, the part has not.
    let [x, y, _] = mesh.origin;
    let at = |c: i64| c as f64 / NM_PER_MM;
    let on = |v: &crate::lattice::Point3| inside(bed_shape, [at(x + i64::from(v.x)), at(y + i64::from(v.y))]);
    if mesh.vertices.iter().all(on) {
        return Ok(());
    }
    // Centred already, moving will not help.
    let off = (0..2).any(|a| lo[a] < bed[0][a] - SLACK || hi[a] > bed[1][a] + SLACK);
    if off {
        Err(PlaceError::OffBed { part: [[lo[0], lo[1]], [hi[0], hi[1]]], bed })
    } else {
        Err(PlaceError::TooLarge { size, bed: extent })
    }
}

/// The box around a bed: its lowest and its highest corner \[mm\].
///
/// # Errors
/// [`PlaceError::BadBed`].
pub fn bed_bounds(bed: &[[f64; 2]]) -> Result<[[f64; 2]; 2], PlaceError> {
    let (mut lo, mut hi) = ([f64::MAX; 2], [f64::MIN; 2]);
    for p in bed {
        for axis in 0..2 {
            lo[axis] = lo[axis].min(p[axis]);
            hi[axis] = hi[axis].max(p[axis]);
        }
    }
    let usable = bed.len() > 2
        && bed.as_flattened().iter().all(|c| c.abs() < 1e6)
        && (0..2).all(|axis| hi[axis] - lo[axis] > SLACK);
    if usable { Ok([lo, hi]) } else { Err(PlaceError::BadBed { points: bed.len() }) }
}

/// Whether a point lies in a convex polygon or within [`SLACK`] of it.
fn inside(bed: &[[f64; 2]], p: [f64; 2]) -> bool {
    let twice_area: f64 = (0..bed.len())
        .map(|i| {
            let (a, b) = (bed[i], bed[(i + 1) % bed.len()]);
            a[0] * b[1] - a[1] * b[0]
        })
        .sum();
    let turn = if twice_area < 0.0 { -1.0 } else { 1.0 };
    (0..bed.len()).all(|i| {
        let (a, b) = (bed[i], bed[(i + 1) % bed.len()]);
        let (u, v) = ([b[0] - a[0], b[1] - a[1]], [p[0] - a[0], p[1] - a[1]]);
        let length = (u[0] * u[0] + u[1] * u[1]).sqrt();
        turn * (u[0] * v[1] - u[1] * v[0]) >= -SLACK * length
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes::{cuboid, cylinder, moved};

    const BED: [[f64; 2]; 4] = [[0.0, 0.0], [200.0, 0.0], [200.0, 200.0], [0.0, 200.0]];

    fn round_bed() -> Vec<[f64; 2]> {
        (0..64)
            .map(|i| std::f64::consts::TAU * f64::from(i) / 64.0)
            .map(|a| [100.0 * libm::cos(a), 100.0 * libm::sin(a)])
            .collect()
    }

    #[test]
    fn dropping_centres_and_changes_the_origin_alone() {
        let before = cuboid([1000.0, -7.0, -3.000_001], [1010.0, 13.000_001, 40.0]);
        let mut mesh = before.clone();
        assert_eq!(place(&mut mesh, &BED, Placement::DropAndCentre), Ok(()));
        assert_eq!((&mesh.vertices, &mesh.triangles), (&before.vertices, &before.triangles));
        let bounds = mesh.world_bounds().unwrap_or_default();
        assert_eq!((bounds[0][0], bounds[1][0], bounds[0][2]), (95_000_000, 105_000_000, 0));
        assert_eq!((mesh.origin[0] % 1000, mesh.origin[1] % 1000), (0, 0));
        assert!((bounds[0][1] + bounds[1][1] - 200_000_000).abs() <= 1001);
        let offset = [[-50.0, -20.0], [50.0, -20.0], [50.0, 80.0], [-50.0, 80.0]];
        assert_eq!(place(&mut mesh, &offset, Placement::DropAndCentre), Ok(()));
        assert_eq!(mesh.origin[0], 0);
        let mut kept = before.clone();
        assert_eq!(place(&mut kept, &BED, Placement::Keep), Ok(()));
        assert_eq!(kept, before);
    }

    #[test]
    fn what_does_not_fit_says_why() {
        let check = |mesh: Mesh, bed: &[[f64; 2]], height: f64| fits(&mesh, bed, height);
        let part = |x: f64, y: f64, z: f64| cuboid([0.0; 3], [x, y, z]);
        assert_eq!(check(part(200.0, 200.0, 200.0), &BED, 200.0), Ok(()));
        assert!(matches!(check(part(200.1, 10.0, 9.0), &BED, 0.0), Err(PlaceError::TooLarge { .. })));
        assert!(matches!(check(part(10.0, 10.0, 200.1), &BED, 200.0), Err(PlaceError::TooHigh { .. })));
        assert_eq!(check(part(10.0, 10.0, 1000.0), &BED, 0.0), Ok(()));
        let shifted = moved(part(10.0, 10.0, 9.0), [195.0, 0.0, 0.0]);
        assert!(matches!(check(shifted, &BED, 0.0), Err(PlaceError::OffBed { .. })));
        let sunk = moved(part(10.0, 10.0, 9.0), [0.0, 0.0, -1.0]);
        assert_eq!(check(sunk, &BED, 0.0), Err(PlaceError::BelowBed { depth: 1.0 }));
        assert_eq!(check(Mesh::default(), &BED, 0.0), Err(PlaceError::Empty));
        assert_eq!(check(part(1.0, 1.0, 1.0), &BED[..2], 0.0), Err(PlaceError::BadBed { points: 2 }));
        let nan = [[0.0, f64::NAN], [1.0, 0.0], [1.0, 1.0]];
        assert_eq!(check(part(1.0, 1.0, 1.0), &nan, 0.0), Err(PlaceError::BadBed { points: 3 }));
    }

    #[test]
    fn on_a_round_bed_the_outline_counts_and_not_the_box() {
        let bed = round_bed();
        assert_eq!(fits(&cylinder(99.0, 5.0, 100), &bed, 0.0), Ok(()));
        let square = cuboid([-80.0, -80.0, 0.0], [80.0, 80.0, 5.0]);
        assert!(matches!(fits(&square, &bed, 0.0), Err(PlaceError::TooLarge { .. })));
        let clockwise: Vec<_> = bed.into_iter().rev().collect();
        assert_eq!(fits(&cylinder(99.0, 5.0, 100), &clockwise, 0.0), Ok(()));
        assert!(matches!(fits(&square, &clockwise, 0.0), Err(PlaceError::TooLarge { .. })));
    }
}
