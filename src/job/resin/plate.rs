//! Models side by side on the plate, as one mesh.

use crate::job::JobError;
use crate::job::part::{self, MeshOptions, Part, PartOptions};
use crate::job::progress::Progress;
use crate::job::summary::{MeshSummary, Stopwatch};
use crate::lattice::mm;
use crate::mask::Panel;
use crate::mesh::{self, Adjacency, Mesh, PlaceError, Placement, Transform, plate};
use crate::settings::PrinterSettings;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// One model on the plate.
#[derive(Clone, Debug, Serialize)]
pub struct ModelSummary {
    /// The file.
    pub model: String,
    /// The lowest corner of its bounding box on the plate \[mm\].
    pub at_mm: [f64; 3],
    /// The audit's findings.
    pub mesh: MeshSummary,
}

/// All models.
#[derive(Debug)]
pub(super) struct Plate {
    /// World position = its origin + vertex; the plate's corner is the world's zero.
    pub mesh: Mesh,
    pub adjacency: Adjacency,
    /// Some edge of it has no partner, so that its sections may not be closed.
    pub open: bool,
    pub models: Vec<ModelSummary>,
    pub warnings: Vec<String>,
}

/// How models come onto the plate.
#[derive(Clone, Debug)]
pub struct PlateOptions {
    /// What is done to each before it is placed.
    pub transform: Transform,
    /// Whether they are placed or keep their coordinates.
    pub placement: Placement,
    /// Least distance between two models \[nm\].
    pub spacing: i64,
    /// How faults are dealt with.
    pub mesh: MeshOptions,
}

/// Loads, turns, audits, places and joins models.
///
/// # Errors
/// [`JobError::Mesh`], [`JobError::Place`] with the model, [`JobError::Plate`].
pub(super) fn prepare(
    paths: &[PathBuf],
    options: &PlateOptions,
    panel: &Panel,
    build_height: f64,
    progress: &dyn Progress,
    watch: &mut Stopwatch,
) -> Result<Plate, JobError> {
    let size = panel.plate();
    let [x, y] = size.map(mm);
    let printer = PrinterSettings {
        bed_shape: vec![[0.0, 0.0], [x, 0.0], [x, y], [0.0, y]],
        max_print_height: build_height,
        ..PrinterSettings::default()
    };
    let mut parts = Vec::with_capacity(paths.len());
    let mut warnings = Vec::new();
    for path in paths {
        let name = path.display().to_string();
        progress.stage("reading");
        watch.stage("load");
        let mut loaded = mesh::load(path)?;
        let place = |error| JobError::Place { model: name.clone(), error };
        options.transform.apply(&mut loaded.mesh).map_err(place)?;
        let file: Option<&Path> = Some(path);
        let part_options = PartOptions {
            printer: &printer,
            placement: options.placement,
            must_fit: false,
            mesh: &options.mesh,
            file,
        };
        let Part { mesh, adjacency, summary, warnings: found } =
            part::prepare(loaded, &name, &part_options, progress, watch)?;
        warnings.extend(found);
        parts.push((name, mesh, adjacency, summary));
    }
    watch.stage("plate");
    if parts.len() > 1 && options.placement == Placement::DropAndCentre {
        let boxes: Vec<_> =
            parts.iter().map(|(_, mesh, ..)| mesh.world_bounds().unwrap_or_default()).collect();
        let sizes: Vec<_> = boxes.iter().map(|[lo, hi]| [hi[0] - lo[0], hi[1] - lo[1]]).collect();
        let corners = plate::arrange(&sizes, size, options.spacing).map_err(JobError::Plate)?;
        for (((_, mesh, ..), [lo, _]), to) in parts.iter_mut().zip(boxes).zip(corners) {
            for axis in 0..2 {
                // Whole micrometres, as a single part is placed.
                mesh.origin[axis] += (to[axis] - lo[axis] + 500).div_euclid(1000) * 1000;
            }
        }
    }
    let mut models = Vec::with_capacity(parts.len());
    let mut meshes = Vec::with_capacity(parts.len());
    for (model, mesh, adjacency, summary) in parts {
        mesh::fits(&mesh, &printer.bed_shape, build_height).map_err(|error| unfit(&model, error))?;
        let [lo, _] = mesh.world_bounds().unwrap_or_default();
        models.push(ModelSummary { model, at_mm: lo.map(mm), mesh: summary });
        meshes.push((mesh, adjacency));
    }
    let (mesh, adjacency) = plate::join(meshes).map_err(JobError::Plate)?;
    let open = models.iter().any(|m| m.mesh.open_edges > 0);
    Ok(Plate { mesh, adjacency, open, models, warnings })
}

/// The same in a resin printer's words.
fn unfit(model: &str, error: PlaceError) -> JobError {
    let model = model.to_owned();
    match error {
        PlaceError::TooLarge { size, bed } => JobError::OffPanel {
            problem: format!(
                "the part is {:.2} x {:.2} mm, the panel lights {:.2} x {:.2} mm",
                size[0], size[1], bed[0], bed[1]
            ),
            model,
        },
        PlaceError::OffBed { part: [lo, hi], bed } => JobError::OffPanel {
            problem: format!(
                "the part reaches from {:.2}, {:.2} to {:.2}, {:.2} mm, the panel lights 0, 0 to {:.2}, {:.2} mm",
                lo[0], lo[1], hi[0], hi[1], bed[1][0], bed[1][1]
            ),
            model,
        },
        PlaceError::TooHigh { height, limit } => JobError::OffPanel {
            problem: format!("the part is {height:.2} mm high, the printer builds {limit:.2} mm"),
            model,
        },
        error => JobError::Place { model, error },
    }
}
