//! A model made ready to be sliced: placed, joined and audited.

use super::JobError;
use super::progress::Progress;
use super::summary::{MeshSummary, Stopwatch};
use crate::lattice;
use crate::mesh::{self, Adjacency, Loaded, Mesh, Placement};
use crate::settings::PrinterSettings;

/// A mesh on the bed with what the stages after it need.
#[derive(Debug)]
pub struct Part {
    /// The mesh, outside out.
    pub mesh: Mesh,
    /// Its half-edges paired.
    pub adjacency: Adjacency,
    /// The audit's findings.
    pub summary: MeshSummary,
    /// What a user must know, one line each.
    pub warnings: Vec<String>,
}

/// Turns, places, joins and audits a mesh to be printed; `name` stands for it in messages.
///
/// # Errors
/// [`JobError::Place`] when it does not fit the printer.
pub fn prepare(
    loaded: Loaded,
    name: &str,
    printer: &PrinterSettings,
    placement: Placement,
    progress: &dyn Progress,
    watch: &mut Stopwatch,
) -> Result<Part, JobError> {
    let part = prepare_any_size(loaded, name, printer, placement, progress, watch)?;
    mesh::fits(&part.mesh, &printer.bed_shape, printer.max_print_height)
        .map_err(|error| JobError::Place { model: name.to_owned(), error })?;
    Ok(part)
}

/// [`prepare`] for a mesh that need not fit the printer.
///
/// # Errors
/// [`JobError::Place`] when the mesh is empty or the bed has no area to be placed on.
pub fn prepare_any_size(
    loaded: Loaded,
    name: &str,
    printer: &PrinterSettings,
    placement: Placement,
    progress: &dyn Progress,
    watch: &mut Stopwatch,
) -> Result<Part, JobError> {
    let Loaded { mut mesh, facets, collapsed, warnings } = loaded;
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    if mesh::flip_if_inside_out(&mut mesh) {
        warnings.push(format!("{name}: the mesh is inside out; all its facets were turned"));
    }
    mesh::place(&mut mesh, &printer.bed_shape, placement)
        .map_err(|error| JobError::Place { model: name.to_owned(), error })?;
    progress.stage("joining facets");
    watch.stage("adjacency");
    let adjacency = Adjacency::build(&mesh);
    watch.stage("audit");
    let summary = audit(&mesh, &adjacency, facets, collapsed, name, &mut warnings);
    Ok(Part { mesh, adjacency, summary, warnings })
}

/// Audits the mesh and puts what a user must know into words.
fn audit(
    mesh: &Mesh,
    adjacency: &Adjacency,
    facets: u64,
    collapsed: u64,
    name: &str,
    warnings: &mut Vec<String>,
) -> MeshSummary {
    let found = mesh::audit(mesh, adjacency);
    let mut note = |n: u64, what: &str| {
        if n > 0 {
            warnings.push(format!("{name}: {n} {what}"));
        }
    };
    note(found.open_edges, "open edges: the surface has holes; contours there are closed by guess");
    note(found.flipped_edges, "edges whose two facets disagree about the outside");
    note(found.over_shared_edges, "edges shared by more than two facets");
    note(found.duplicate_triangles, "duplicate facets");
    let [lo, hi] = found.bounds;
    let size = [0, 1, 2].map(|axis| hi[axis] - lo[axis]);
    MeshSummary {
        facets,
        collapsed,
        open_edges: found.open_edges,
        over_shared_edges: found.over_shared_edges,
        flipped_edges: found.flipped_edges,
        duplicate_triangles: found.duplicate_triangles,
        shells: found.shells,
        volume_mm3: found.volume_mm3,
        size_mm: size.map(lattice::mm),
    }
}
