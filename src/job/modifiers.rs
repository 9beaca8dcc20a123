//! Meshes that say where supports go → rows of the part's layers.

use super::JobError;
use super::filament::ModifierFiles;
use super::open::OpenContours;
use crate::contour::{self, LayerContours, Ring, TraceOptions};
use crate::lattice::{LIMIT, Point2};
use crate::mesh::{self, Adjacency};
use crate::slice::planes::{self, LayerZ};
use crate::span::algebra::or;
use crate::span::{RowFrame, Rows, scan};
use crate::support::overhang::Modifiers;
use rayon::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What modifiers cover on each layer of the part. Each list is empty, or as long as the layers.
#[derive(Clone, Debug, Default)]
pub struct ModifierRows {
    enforced: Vec<Arc<Rows>>,
    blocked: Vec<Arc<Rows>>,
}

/// Where modifiers are cut.
#[derive(Clone, Copy, Debug)]
pub struct Cuts<'a> {
    /// The part's layers.
    pub layers: &'a [LayerZ],
    /// World position of the part's zero on the bed \[nm\].
    pub origin: [i64; 3],
    /// How far the part was moved from its file's coordinates to get there \[nm\]; modifiers go with it.
    pub moved: [i64; 3],
    /// Where copies of the part lie, seen from it; (0, 0) among them \[nm\].
    pub copies: &'a [[i64; 2]],
    /// The rows.
    pub frame: &'a RowFrame,
    /// How contours are finished.
    pub options: &'a TraceOptions,
}

impl ModifierRows {
    /// Reads the files and cuts them at the part's layers. Modifiers may reach beyond the part and the bed;
    /// which way their facets face does not matter. What meets no layer gives a warning.
    ///
    /// # Errors
    /// A file that cannot be read, or whose mesh cannot be cut; the error names it.
    pub fn load(files: &ModifierFiles, cuts: &Cuts, warnings: &mut Vec<String>) -> Result<Self, JobError> {
        Ok(Self {
            enforced: covered(&files.enforcers, cuts, warnings)?,
            blocked: covered(&files.blockers, cuts, warnings)?,
        })
    }

    /// As the support stage takes them.
    pub fn modifiers(&self) -> Modifiers<'_> {
        Modifiers { enforced: &self.enforced, blocked: &self.blocked }
    }
}

/// What the meshes of some files cover together.
fn covered(files: &[PathBuf], cuts: &Cuts, warnings: &mut Vec<String>) -> Result<Vec<Arc<Rows>>, JobError> {
    let mut all: Vec<Arc<Rows>> = Vec::new();
    for file in files {
        let own = cut(file, cuts, warnings)?;
        if own.iter().all(|rows| rows.is_empty()) {
            warnings.push(format!(
                "{}: meets no layer of the part and changes nothing; modifiers take the coordinates of the model's file",
                file.display()
            ));
        }
        join(&mut all, own);
    }
    Ok(all)
}

/// Adds the areas of layers to those found so far.
fn join(all: &mut Vec<Arc<Rows>>, own: Vec<Arc<Rows>>) {
    if all.is_empty() {
        *all = own;
        return;
    }
    for (all, own) in all.iter_mut().zip(own) {
        if !own.is_empty() {
            *all = Arc::new(or(all, &own));
        }
    }
}

/// What one mesh covers.
fn cut(file: &Path, cuts: &Cuts, warnings: &mut Vec<String>) -> Result<Vec<Arc<Rows>>, JobError> {
    let mut loaded = mesh::load(file)?;
    warnings.extend(loaded.warnings.iter().map(ToString::to_string));
    let mesh = &mut loaded.mesh;
    for (zero, by) in mesh.origin.iter_mut().zip(cuts.moved) {
        *zero = zero.saturating_add(by);
    }
    let planes = planes::plane_zs(cuts.layers, mesh.origin[2]);
    let adjacency = Adjacency::build(mesh);
    let layers = contour::trace(mesh, &adjacency, &planes, cuts.options)
        .map_err(|error| JobError::Modifier { file: file.to_owned(), error })?;
    warnings
        .extend(OpenContours::new(&layers, cuts.layers, mesh.origin).warning(&file.display().to_string()));
    let by = [0, 1].map(|axis: usize| mesh.origin[axis].saturating_sub(cuts.origin[axis]));
    let at = |shift: &[i64; 2]| [0, 1].map(|axis: usize| by[axis].saturating_add(shift[axis]));
    let mut all: Vec<Arc<Rows>> = Vec::new();
    for shift in cuts.copies {
        join(&mut all, rows(&layers, at(shift), cuts.frame));
    }
    Ok(all)
}

/// The areas of layers that are moved to the part's frame; neighbours that are equal share theirs.
fn rows(layers: &[LayerContours], by: [i64; 2], frame: &RowFrame) -> Vec<Arc<Rows>> {
    let of = |i: usize| {
        let rings: Vec<Ring> = layers[i].rings.iter().map(|r| moved(r, by)).collect();
        Arc::new(scan(rings.iter().map(|r| &r[..]), frame))
    };
    let is_same = |i: usize| i > 0 && layers[i].rings == layers[i - 1].rings;
    let scanned: Vec<Option<Arc<Rows>>> =
        (0..layers.len()).into_par_iter().map(|i| (!is_same(i)).then(|| of(i))).collect();
    let mut last = Arc::default();
    let keep = |rows: Option<Arc<Rows>>| {
        last = rows.unwrap_or_else(|| Arc::clone(&last));
        Arc::clone(&last)
    };
    scanned.into_iter().map(keep).collect()
}

/// A ring in another frame. What lies beyond the lattice, a metre from the part, moves to its edge.
fn moved(ring: &[Point2], by: [i64; 2]) -> Ring {
    let limit = i64::from(LIMIT) - 1;
    let at = |c: i32, by: i64| i64::from(c).saturating_add(by).clamp(-limit, limit) as i32;
    ring.iter().map(|p| Point2::new(at(p.x, by[0]), at(p.y, by[1]))).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::{Mesh, shapes, stl_write};

    fn layers() -> Vec<LayerZ> {
        (0..20)
            .map(|i| LayerZ {
                slice_z: 500_000 + i * 1_000_000,
                print_z: (i + 1) * 1_000_000,
                height: 1_000_000,
            })
            .collect()
    }

    fn load(meshes: &[Mesh], moved: [i64; 3], origin: [i64; 3]) -> (ModifierRows, Vec<String>) {
        let dir = tempfile::tempdir().unwrap();
        let mut files = ModifierFiles::default();
        for (i, mesh) in meshes.iter().enumerate() {
            let path = dir.path().join(format!("{i}.stl"));
            stl_write::write_stl_binary(mesh, &mut std::fs::File::create(&path).unwrap()).unwrap();
            files.enforcers.push(path);
        }
        let layers = layers();
        let frame = RowFrame::new(0.0, 0.0, 100_000.0);
        let options =
            TraceOptions { simplify_tolerance: Some(0), match_tolerance: 0, memory_budget: 1 << 20 };
        let cuts =
            Cuts { layers: &layers, origin, moved, copies: &[[0; 2]], frame: &frame, options: &options };
        let mut warnings = Vec::new();
        let rows = ModifierRows::load(&files, &cuts, &mut warnings).unwrap();
        (rows, warnings)
    }

    /// Area and bounds along the rows \[mm², mm\].
    fn measure(rows: &Rows) -> (f64, [f64; 2]) {
        let low = rows.spans().iter().map(|s| s.start).min().unwrap_or(0);
        let high = rows.spans().iter().map(|s| s.end).max().unwrap_or(0);
        (rows.length() as f64 * 1e-7, [low, high].map(crate::lattice::mm))
    }

    #[test]
    fn modifiers_go_with_the_part() {
        let mesh = shapes::cuboid([10.0, 20.0, 5.0], [14.0, 23.0, 9.0]);
        // The part's file has its zero elsewhere, and the part was moved by (90, 80, -2) mm.
        let (rows, warnings) =
            load(&[mesh], [90_000_000, 80_000_000, -2_000_000], [100_000_000, 100_000_000, 0]);
        assert!(warnings.is_empty(), "{warnings:?}");
        assert!(rows.blocked.is_empty());
        let filled: Vec<usize> = (0..20).filter(|&i| !rows.enforced[i].is_empty()).collect();
        assert_eq!(filled, [3, 4, 5, 6]);
        assert_eq!(measure(&rows.enforced[4]), (12.0, [0.0, 4.0]));
        assert!(Arc::ptr_eq(&rows.enforced[3], &rows.enforced[6]));
    }

    #[test]
    fn several_files_cover_what_any_of_them_covers() {
        let one = shapes::cuboid([0.0, 0.0, 0.0], [4.0, 4.0, 9.0]);
        let mut inside_out = shapes::cuboid([2.0, 2.0, 0.0], [6.0, 6.0, 3.0]);
        inside_out.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        let (rows, warnings) = load(&[one, inside_out], [0; 3], [0; 3]);
        assert!(warnings.is_empty());
        assert!((measure(&rows.enforced[1]).0 - 28.0).abs() < 1e-6);
        assert!((measure(&rows.enforced[5]).0 - 16.0).abs() < 1e-6);
    }

    #[test]
    fn what_is_far_away_is_said_and_harmless() {
        let far = shapes::moved(shapes::cuboid([0.0; 3], [1500.0, 1.0, 1.0]), [-20_000.0, 0.0, 50.0]);
        let high = shapes::cuboid([0.0, 0.0, 70.0], [4.0, 4.0, 90.0]);
        let (rows, warnings) = load(&[far.clone(), high], [0; 3], [0; 3]);
        assert_eq!(warnings.len(), 2, "{warnings:?}");
        assert!(warnings.iter().all(|w| w.contains("meets no layer")));
        assert!(rows.enforced.iter().all(|r| r.is_empty()));
    }
}
