//! A model made ready to be sliced: snapped, oriented, placed, joined and audited.

use super::JobError;
use super::progress::Progress;
use super::summary::{MeshSummary, OrientationSummary, Stopwatch};
use crate::contour::TraceOptions;
use crate::lattice;
use crate::mesh::orient::{Audited, Orient, Oriented, orient};
use crate::mesh::{self, Adjacency, Audit, Loaded, Mesh, Placement, facing, snap};
use crate::settings::{PrinterSettings, SlicingSettings};
use std::path::Path;

/// How faulty meshes are dealt with.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshOptions {
    /// Where the outside is taken from.
    pub orient: Orient,
    /// Gaps in open contours are closed up to this \[nm\]; `None` = after `slice_closing_radius`.
    pub match_tolerance: Option<i64>,
    /// Vertices are rounded to multiples of this \[nm\] before they are joined; `None` = they are not.
    pub snap_grid: Option<i64>,
}

impl MeshOptions {
    /// The options of tracing that the settings and these options ask for.
    pub fn trace_options(&self, settings: &SlicingSettings) -> TraceOptions {
        let asked = TraceOptions::new(settings);
        TraceOptions { match_tolerance: self.match_tolerance.unwrap_or(asked.match_tolerance), ..asked }
    }
}

/// How a part is prepared.
#[derive(Clone, Copy, Debug)]
pub struct PartOptions<'a> {
    /// Bed and height of the printer.
    pub printer: &'a PrinterSettings,
    /// Where the part goes on the bed.
    pub placement: Placement,
    /// Whether a part that the printer cannot hold is refused.
    pub must_fit: bool,
    /// How faults are dealt with.
    pub mesh: &'a MeshOptions,
    /// The file that the part was loaded from, to read stored normals from if they are needed.
    pub file: Option<&'a Path>,
}

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

/// Snaps, places, joins, audits and orients a mesh; `name` stands for it in messages.
///
/// # Errors
/// [`JobError::Place`] when it does not fit the printer.
pub fn prepare(
    loaded: Loaded,
    name: &str,
    options: &PartOptions<'_>,
    progress: &dyn Progress,
    watch: &mut Stopwatch,
) -> Result<Part, JobError> {
    let Loaded { mut mesh, facets, mut collapsed, warnings } = loaded;
    let mut warnings: Vec<String> = warnings.iter().map(ToString::to_string).collect();
    let snapped = snap::snap(&mut mesh, options.mesh.snap_grid.unwrap_or(0));
    collapsed += snapped.dropped.len() as u64;
    let PartOptions { printer, placement, must_fit, .. } = *options;
    mesh::place(&mut mesh, &printer.bed_shape, placement)
        .and_then(|()| match must_fit {
            true => mesh::fits(&mesh, &printer.bed_shape, printer.max_print_height),
            false => Ok(()),
        })
        .map_err(|error| JobError::Place { model: name.to_owned(), error })?;
    progress.stage("joining facets");
    watch.stage("adjacency");
    let adjacency = Adjacency::build(&mesh);
    watch.stage("audit");
    let mut audited = Audited::of(mesh, adjacency);
    let oriented = orient(&mut audited, options.mesh.orient, || {
        let signs = facing::facing(options.file?).ok()?;
        let mut dropped = snapped.dropped.iter().peekable();
        Some((0..).zip(signs).filter(|(t, _)| dropped.next_if_eq(&t).is_none()).map(|(_, s)| s).collect())
    });
    let Audited { mesh, adjacency, audit, .. } = audited;
    say(&oriented, &audit, options.mesh.orient, name, &mut warnings);
    let [lo, hi] = audit.bounds;
    let size = [0, 1, 2].map(|axis| hi[axis] - lo[axis]);
    let summary = MeshSummary {
        facets,
        collapsed,
        snapped: snapped.merged,
        open_edges: audit.open_edges,
        over_shared_edges: audit.over_shared_edges,
        flipped_edges: audit.flipped_edges,
        duplicate_triangles: audit.duplicate_triangles,
        shells: audit.shells,
        volume_mm3: audit.volume_mm3,
        size_mm: size.map(lattice::mm),
        orientation: OrientationSummary {
            flipped_edges_before: oriented.flipped_edges[0],
            inside_out: oriented.inside_out,
            turned_by_normals: oriented.by_normals,
            turned_by_neighbours: oriented.by_neighbours,
            duplicates_dropped: oriented.duplicates_dropped,
            shells_turned: oriented.shells_turned,
        },
    };
    Ok(Part { mesh, adjacency, summary, warnings })
}

/// Puts into words what was done to a mesh and what is still wrong with it.
fn say(done: &Oriented, found: &Audit, wish: Orient, name: &str, warnings: &mut Vec<String>) {
    if done.inside_out {
        warnings.push(format!("{name}: the mesh is inside out; all its facets were turned"));
    }
    if wish == Orient::Winding && found.volume_mm3 < 0.0 {
        warnings.push(format!("{name}: the mesh is inside out, and stays so by --orient winding"));
    }
    if done.no_normals {
        warnings.push(format!(
            "{name}: the file holds no usable normals; facets face as their corners run, --orient repair asks their neighbours"
        ));
    }
    let mut note = |n: u64, what: &str| {
        if n > 0 {
            warnings.push(format!("{name}: {n} {what}"));
        }
    };
    note(done.by_normals, "facets were turned after the normals in the file");
    note(done.by_neighbours, "facets were turned to agree with their neighbours and face outwards");
    note(done.duplicates_dropped, "duplicate facets were dropped");
    note(done.shells_turned, "shells among others were inside out and were turned");
    note(found.open_edges, "open edges: the surface has holes; contours there are closed by guess");
    note(found.flipped_edges, "edges whose two facets disagree about the outside");
    note(found.over_shared_edges, "edges shared by more than two facets");
    note(found.duplicate_triangles, "duplicate facets");
}
