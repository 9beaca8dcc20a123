//! One mesh and its planes.

use super::machine::{self, Time};
use super::models::{self, Model};
use super::{BenchError, Options};
use crate::job::JobError;
use crate::lattice::nm;
use crate::mesh::{self, Adjacency, Mesh, OPEN};
use crate::slice::chunk;
use crate::slice::planes::MAX_LAYERS;
use std::path::PathBuf;

/// Where a mesh comes from.
pub(super) enum Source {
    File(PathBuf),
    Built(&'static Model),
}

/// What is to be measured.
pub(super) fn sources(options: &Options) -> Vec<Source> {
    if options.models.is_empty() {
        models::ALL.iter().map(Source::Built).collect()
    } else {
        options.models.iter().cloned().map(Source::File).collect()
    }
}

/// A mesh in memory and the planes to cut it by.
pub(super) struct Case {
    pub(super) name: String,
    pub(super) mesh: Mesh,
    pub(super) adjacency: Adjacency,
    pub(super) planes: Vec<i32>,
    pub(super) per_plane: Vec<u64>,
    /// Every edge has a partner.
    pub(super) closed: bool,
}

impl Case {
    /// Loads or builds a mesh; for a file also the time that took.
    pub(super) fn new(source: &Source, options: &Options) -> Result<(Self, Option<Time>), BenchError> {
        let (name, mesh, load, own) = match source {
            Source::File(path) => {
                let (time, loaded) = machine::median(options.runs, || mesh::load(path));
                let name = path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
                (name, loaded.map_err(JobError::from)?.mesh, Some(time), models::Planes::Height(0.2))
            }
            Source::Built(model) => {
                let (mesh, planes) = model.build(options.quick);
                (model.name.to_owned(), mesh, None, planes)
            }
        };
        let wish = match (options.planes_count, options.layer_height) {
            (Some(count), _) => models::Planes::Count(count),
            (None, Some(height)) => models::Planes::Height(height),
            (None, None) => own,
        };
        let planes = planes(&mesh, wish);
        let adjacency = Adjacency::build(&mesh);
        let per_plane = chunk::segments_per_plane(&mesh, &planes);
        let closed = !adjacency.twin.contains(&OPEN);
        Ok((Self { name, mesh, adjacency, planes, per_plane, closed }, load))
    }

    pub(super) fn segments(&self) -> u64 {
        self.per_plane.iter().sum()
    }

    /// Triangles × planes.
    pub(super) fn work(&self) -> u64 {
        (self.mesh.triangles.len() as u64).saturating_mul(self.planes.len() as u64)
    }
}

/// The middles of layers between the lowest and the highest vertex \[nm\], mesh frame.
fn planes(mesh: &Mesh, wish: models::Planes) -> Vec<i32> {
    let zs = || mesh.vertices.iter().map(|v| v.z);
    let (Some(low), Some(high)) = (zs().min(), zs().max()) else { return Vec::new() };
    let extent = f64::from(high) - f64::from(low);
    let (count, height) = match wish {
        models::Planes::Count(count) => (u64::from(count), extent / f64::from(count.max(1))),
        models::Planes::Height(mm) => {
            let height = mm * crate::lattice::NM_PER_MM;
            // As many as have their middle below the top.
            ((extent / height + 0.5).ceil() as u64 - 1, height)
        }
    };
    let middle = |i: u64| nm((i as f64 + 0.5) * height / crate::lattice::NM_PER_MM);
    (0..count.min(MAX_LAYERS)).map(|i| (i64::from(low) + middle(i)).min(i64::from(high)) as i32).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn planes_are_the_middles_of_layers() {
        let mesh = shapes::cuboid([0.0; 3], [1.0, 1.0, 1.0]);
        assert_eq!(planes(&mesh, models::Planes::Height(0.2)), [-400_000, -200_000, 0, 200_000, 400_000]);
        assert_eq!(planes(&mesh, models::Planes::Height(0.3)), [-350_000, -50_000, 250_000]);
        assert_eq!(planes(&mesh, models::Planes::Count(2)), [-250_000, 250_000]);
        assert!(planes(&mesh, models::Planes::Height(10.0)).is_empty());
        assert!(planes(&Mesh::default(), models::Planes::Count(2)).is_empty());
    }
}
