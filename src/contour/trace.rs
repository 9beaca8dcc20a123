//! The CPU backend: mesh × planes → contours, without segments in between.
//!
//! There are two routes, for meshes of many planes per triangle and of few. The points are those of
//! [`crate::slice::cpu`] in the same cyclic order, so after the common finish the bytes are those of
//! [`super::walk::contours_of`].

use super::Ring;
use super::chains::OpenReport;
use super::finish::Finish;
use super::front::Front;
use super::layered::Layered;
use super::spans::{self, Span};
use super::surface::Surface;
use crate::lattice::nm;
use crate::mesh::{Adjacency, Mesh};
use crate::settings::SlicingSettings;
use crate::slice::chunk;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Mutex;
use thiserror::Error;

/// How contours are finished.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceOptions {
    /// Tolerance of [`super::simplify::simplify`] \[nm\]; `Some(0)` removes exactly collinear points
    /// only, `None` keeps every point of the walk.
    pub simplify_tolerance: Option<i64>,
    /// Gaps in open contours are closed up to this \[nm\]; see [`super::chains::close`].
    pub match_tolerance: i64,
    /// Bytes for the segments of the runs of planes in hand, and for listing triangles that several runs
    /// meet. Not in it: mesh, adjacency and contours; at most 28 bytes per triangle and 4 per
    /// triangle and thread, which every trace needs; 40 per segment of the single plane in hand. A plane
    /// or a triangle's lists beyond the budget are still worked on, one after the other. A small
    /// budget costs time, never the result.
    pub memory_budget: u64,
}

impl TraceOptions {
    /// The options that the settings ask for: simplification by `resolution`, gaps up to twice
    /// `slice_closing_radius` but at most 1 mm, 256 MiB.
    pub fn new(settings: &SlicingSettings) -> Self {
        Self {
            simplify_tolerance: Some(nm(settings.resolution).max(0)),
            match_tolerance: nm(2.0 * settings.slice_closing_radius).clamp(0, 1_000_000),
            memory_budget: 256 << 20,
        }
    }
}

/// The contours of one layer.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LayerContours {
    /// Closed rings \[nm\], mesh frame, solid on the left. Each starts at its smallest (x, y), and they
    /// are sorted.
    pub rings: Vec<Ring>,
    /// What became of open chains.
    pub open: OpenReport,
    /// What the walk met, before anything was joined or removed.
    pub walked: Walked,
}

/// How many contours a walk met on a plane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Walked {
    /// Closed cycles of successors; those of zero length, which leave no ring, are among them.
    pub closed: u32,
    /// Chains that begin and end at open edges.
    pub open: u32,
}

/// Why a mesh cannot be traced. None of these can come from a mesh and adjacency built by
/// [`crate::mesh`].
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum TraceError {
    /// Adjacency and mesh do not belong together.
    #[error("the adjacency has {found} half-edges, the mesh {expected}; build it from this mesh")]
    Adjacency {
        /// Half-edges of the adjacency.
        found: usize,
        /// Half-edges of the mesh.
        expected: usize,
    },
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} has vertex {vertex}, but there are only {vertices}")]
    Vertex {
        /// Index of the triangle.
        triangle: usize,
        /// Its vertex id.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// More half-edges or planes than 32-bit ids can name.
    #[error("{what} exceed 2^32; split the model")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
    },
    /// The planes are not in ascending order.
    #[error("plane {index} lies below the one before it; sort the planes by height")]
    Order {
        /// Index of the plane.
        index: usize,
    },
}

/// The contours of every plane; `planes` \[nm\], mesh frame, ascending. Length = planes.
///
/// Runs on the threads of the current rayon pool; the result does not depend on their number, nor on
/// the memory budget, nor (on a manifold mesh) on the order of facets and corners.
///
/// # Errors
/// [`TraceError`] when mesh, adjacency and planes do not fit together.
pub fn trace(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    options: &TraceOptions,
) -> Result<Vec<LayerContours>, TraceError> {
    Ok(Prepared::new(mesh, adjacency, planes)?.trace(options))
}

/// A mesh and planes of which is known which triangles meet which planes.
#[derive(Debug)]
pub struct Prepared<'a> {
    mesh: &'a Mesh,
    adjacency: &'a Adjacency,
    planes: &'a [i32],
    spans: Vec<Vec<Span>>,
    /// Number of segments on each plane.
    pub per_plane: Vec<u64>,
}

impl<'a> Prepared<'a> {
    /// For `planes` \[nm\], mesh frame, ascending.
    ///
    /// # Errors
    /// [`TraceError`] when mesh, adjacency and planes do not fit together.
    pub fn new(mesh: &'a Mesh, adjacency: &'a Adjacency, planes: &'a [i32]) -> Result<Self, TraceError> {
        check(mesh, adjacency, planes)?;
        let (spans, per_plane) = spans::spans(mesh, planes, rayon::current_num_threads())?;
        Ok(Self { mesh, adjacency, planes, spans, per_plane })
    }

    /// [`trace`].
    pub fn trace(self, options: &TraceOptions) -> Vec<LayerContours> {
        let Self { mesh, adjacency, planes, spans, per_plane } = self;
        let threads = rayon::current_num_threads();
        let route = Route::of(spans.iter().map(Vec::len).sum(), per_plane.iter().sum());
        let runs = spans::runs(&per_plane, threads, route.segment_bytes(), options.memory_budget);
        trace_runs(mesh, adjacency, planes, options, spans, &runs, route)
    }
}

/// The ways from a run of planes to its contours. They give the same points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Route {
    /// All segments before the walk: [`Layered`].
    Layered,
    /// Contours kept from plane to plane: [`Front`].
    Front,
}

impl Route {
    #[cfg(test)]
    pub(super) const ALL: [Self; 2] = [Self::Layered, Self::Front];

    /// The quicker one for a number of triangles that meet planes, and of segments.
    fn of(triangles: usize, segments: u64) -> Self {
        if segments >= 3 * triangles as u64 { Self::Front } else { Self::Layered }
    }

    /// Bytes that each segment of a run takes while the run is in hand.
    fn segment_bytes(self) -> u64 {
        match self {
            Self::Layered => Layered::SEGMENT_BYTES,
            // Edges of one plane only.
            Self::Front => 0,
        }
    }
}

fn check(mesh: &Mesh, adjacency: &Adjacency, planes: &[i32]) -> Result<(), TraceError> {
    let (found, expected) = (adjacency.twin.len(), 3 * mesh.triangles.len());
    if found != expected {
        return Err(TraceError::Adjacency { found, expected });
    }
    if expected >= u32::MAX as usize {
        return Err(TraceError::TooMany { what: "half-edges" });
    }
    if planes.len() >= u32::MAX as usize {
        return Err(TraceError::TooMany { what: "planes" });
    }
    match planes.windows(2).position(|w| w[0] > w[1]) {
        Some(at) => Err(TraceError::Order { index: at + 1 }),
        None => Ok(()),
    }
}

/// [`trace`] for given runs, which cover all planes in order.
pub(super) fn trace_runs(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    options: &TraceOptions,
    spans: Vec<Vec<Span>>,
    runs: &[Range<usize>],
    route: Route,
) -> Vec<LayerContours> {
    let surface = Surface::new(mesh, adjacency);
    // A word per triangle, left by one run to the next: no more of them than threads.
    let scratch = Mutex::new(Vec::new());
    let trace_run = |lists: &[Vec<Span>], run: &Range<usize>| {
        let mut finish = Finish::new(options);
        let mut layers = Vec::with_capacity(run.len());
        let words = scratch.lock().ok().and_then(|mut free| free.pop());
        let words = words.unwrap_or_else(|| vec![0; mesh.triangles.len()]);
        let words = match route {
            Route::Layered => {
                let mut layered = Layered::new(surface, planes, lists, run.clone(), words);
                for k in run.clone() {
                    layered.plane(k, &mut finish);
                    layers.push(finish.layer());
                }
                layered.into_words()
            }
            Route::Front => {
                let mut front = Front::new(surface, planes, lists, run.clone(), words);
                for k in run.clone() {
                    front.plane(k, &mut finish);
                    layers.push(finish.layer());
                }
                front.into_words()
            }
        };
        if let Ok(mut free) = scratch.lock() {
            free.push(words);
        }
        layers
    };
    if let [run] = runs {
        return trace_run(&spans, run);
    }
    let lists = chunk::by_run(spans, planes.len(), runs, |span: &Span| span.first..span.end);
    let layers: Vec<_> =
        runs.par_iter().zip(lists).with_max_len(1).map(|(run, lists)| trace_run(&lists, run)).collect();
    layers.into_iter().flatten().collect()
}
