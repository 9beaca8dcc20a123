//! Copies of a part side by side on the bed.

use crate::lattice::nm;
use crate::mesh::{self, Adjacency, Mesh, PlaceError, plate};
use crate::settings::PrinterSettings;

/// Parts on the bed as one mesh.
#[derive(Debug)]
pub struct Copies {
    /// All of them, in the lattice of the first.
    pub mesh: Mesh,
    /// Its half-edges paired.
    pub adjacency: Adjacency,
    /// Where each lies, seen from the first \[nm\].
    pub shifts: Vec<[i64; 2]>,
}

/// Lays copies of a part out, centred on the box around the bed and `spacing` mm apart; their heights stay. A
/// single one stays where it is. Rows are as long as the box allows, also on a bed that is not a rectangle.
///
/// # Errors
/// [`PlaceError::Crowded`] when the box does not hold them, [`PlaceError::OffBed`] or
/// [`PlaceError::TooLarge`] when a bed of another shape does not, [`PlaceError::TooMany`],
/// [`PlaceError::TooFar`].
pub fn lay_out(
    mesh: Mesh,
    adjacency: Adjacency,
    copies: u32,
    spacing: f64,
    printer: &PrinterSettings,
) -> Result<Copies, PlaceError> {
    if copies <= 1 {
        return Ok(Copies { mesh, adjacency, shifts: vec![[0; 2]] });
    }
    let [lo, hi] = mesh.world_bounds().ok_or(PlaceError::Empty)?;
    let size = [hi[0] - lo[0], hi[1] - lo[1]];
    let [low, high] = mesh::place::bed_bounds(&printer.bed_shape)?.map(|corner| corner.map(nm));
    let plate = [high[0] - low[0], high[1] - low[1]];
    let corners = plate::arrange(&vec![size; copies as usize], plate, nm(spacing))?;
    // Whole micrometres, as a single part is placed, so that each is sliced like any other.
    let move_by = |axis: usize, to: i64| (low[axis] + to - lo[axis] + 500).div_euclid(1000) * 1000;
    let moves: Vec<[i64; 2]> = corners.iter().map(|c| [move_by(0, c[0]), move_by(1, c[1])]).collect();
    let first = moves.first().copied().unwrap_or_default();
    let mut parts = Vec::with_capacity(moves.len());
    for [x, y] in &moves {
        let mut part = mesh.clone();
        part.origin[0] += x;
        part.origin[1] += y;
        mesh::fits(&part, &printer.bed_shape, printer.max_print_height)?;
        parts.push((part, adjacency.clone()));
    }
    let (mesh, adjacency) = plate::join(parts)?;
    let shifts = moves.iter().map(|[x, y]| [x - first[0], y - first[1]]).collect();
    Ok(Copies { mesh, adjacency, shifts })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::{Placement, shapes};

    fn laid(size: [f64; 2], copies: u32, printer: &PrinterSettings) -> Result<Copies, PlaceError> {
        let mut mesh = shapes::cuboid([0.0; 3], [size[0], size[1], 2.0]);
        mesh::place(&mut mesh, &printer.bed_shape, Placement::DropAndCentre).unwrap();
        let adjacency = Adjacency::build(&mesh);
        lay_out(mesh, adjacency, copies, 6.0, printer)
    }

    fn bed(x: f64, y: f64, width: f64, depth: f64) -> PrinterSettings {
        PrinterSettings {
            bed_shape: vec![[x, y], [x + width, y], [x + width, y + depth], [x, y + depth]],
            ..PrinterSettings::default()
        }
    }

    #[test]
    fn one_stays_and_several_stand_apart() {
        let printer = bed(-30.0, 10.0, 50.0, 50.0);
        let one = laid([10.0, 20.0], 1, &printer).unwrap();
        assert_eq!(one.shifts, [[0, 0]]);
        assert_eq!(one.mesh.triangles.len(), 12);
        let three = laid([10.0, 20.0], 3, &printer).unwrap();
        let mm = |x: f64, y: f64| [nm(x), nm(y)];
        assert_eq!(three.shifts, [mm(0.0, 0.0), mm(16.0, 0.0), mm(32.0, 0.0)]);
        assert_eq!((three.mesh.triangles.len(), three.adjacency.twin.len()), (36, 108));
        // Centred: 42 x 20 mm on 50 x 50 mm.
        let [lo, hi] = three.mesh.world_bounds().unwrap();
        assert_eq!([lo[0], lo[1], lo[2]], [nm(-26.0), nm(25.0), 0]);
        assert_eq!([hi[0], hi[1]], mm(16.0, 45.0));
        // The next one begins a row.
        let four = laid([10.0, 20.0], 4, &printer).unwrap();
        assert_eq!(four.shifts[3], mm(0.0, 26.0));
    }

    #[test]
    fn what_does_not_fit_is_refused() {
        let crowded = laid([10.0, 20.0], 7, &bed(0.0, 0.0, 50.0, 50.0)).unwrap_err();
        assert!(matches!(crowded, PlaceError::Crowded { parts: 7, .. }), "{crowded}");
        // A round bed has no corners, and rows are laid out as if it had.
        let round = (0..36).map(|k| f64::from(k) * 10f64.to_radians());
        let round = round.map(|a| [25.0 * a.cos(), 25.0 * a.sin()]).collect();
        let printer = PrinterSettings { bed_shape: round, ..PrinterSettings::default() };
        assert!(laid([10.0, 10.0], 2, &printer).is_ok());
        let corners = laid([10.0, 10.0], 9, &printer).unwrap_err();
        assert!(matches!(corners, PlaceError::TooLarge { .. } | PlaceError::OffBed { .. }), "{corners}");
    }
}
