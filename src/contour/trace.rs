//! The CPU backend: mesh × planes → contours, without segments in between.
//!
//! A plane's contours are followed from triangle to triangle through the adjacency; only the set of
//! triangles that the plane meets is kept, and updated from plane to plane. The points are those of
//! [`crate::slice::cpu`] in the same cyclic order, so after the common finish the bytes are those of
//! [`super::walk::contours_of`].

use super::Ring;
use super::chains::OpenReport;
use super::finish::Finish;
use super::front::Front;
use super::surface::Surface;
use super::sweep::{Span, Sweep};
use crate::lattice::nm;
use crate::mesh::{Adjacency, Mesh};
use crate::settings::SlicingSettings;
use crate::slice::chunk;
use rayon::prelude::*;
use std::ops::Range;
use thiserror::Error;

/// How contours are finished.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TraceOptions {
    /// Tolerance of [`super::simplify::simplify`] \[nm\]; `Some(0)` removes exactly collinear points
    /// only, `None` keeps every point of the walk.
    pub simplify_tolerance: Option<i64>,
    /// Gaps in open contours are closed up to this \[nm\]; see [`super::chains::close`].
    pub match_tolerance: i64,
    /// Bytes that listing a triangle in several runs of planes may cost, beyond some 24 per triangle;
    /// a small budget costs parallelism, never the result.
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
    check(mesh, adjacency, planes)?;
    let threads = rayon::current_num_threads();
    let spans = spans(mesh, planes, threads)?;
    let per_plane = per_plane(&spans, planes.len());
    let runs = runs(&per_plane, threads, options.memory_budget);
    let route = Route::of(spans.iter().map(Vec::len).sum(), per_plane.iter().sum());
    Ok(trace_runs(mesh, adjacency, planes, options, spans, &runs, route))
}

/// The ways from a run of planes to its contours. They give the same points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Route {
    /// Every plane from its set of triangles: [`Sweep`].
    Sweep,
    /// Contours kept from plane to plane: [`Front`].
    Front,
}

impl Route {
    #[cfg(test)]
    pub(super) const ALL: [Self; 2] = [Self::Sweep, Self::Front];

    /// The quicker one for a number of triangles that meet planes, and of segments.
    fn of(triangles: usize, segments: u64) -> Self {
        if segments >= 3 * triangles as u64 { Self::Front } else { Self::Sweep }
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

/// The planes that each triangle meets, for those that meet any, in blocks of consecutive triangles.
pub(super) fn spans(mesh: &Mesh, planes: &[i32], threads: usize) -> Result<Vec<Vec<Span>>, TraceError> {
    // How many planes lie at or below each vertex: half the searches that triangles would need.
    let search = PlaneSearch::new(planes);
    let level: Vec<u32> =
        mesh.vertices.par_iter().with_min_len(1 << 12).map(|v| search.at_or_below(v.z)).collect();
    let block = (mesh.triangles.len() / (4 * threads)).max(1 << 14);
    mesh.triangles
        .par_chunks(block)
        .enumerate()
        .map(|(b, triangles)| {
            let mut spans = Vec::new();
            for (t, corners) in (b * block..).zip(triangles) {
                let [a, b, c] = *corners;
                let get = |v: u32| level.get(v as usize).copied();
                let (Some(a), Some(b), Some(c)) = (get(a), get(b), get(c)) else {
                    return Err(missing_vertex(t, *corners, level.len()));
                };
                let (first, end) = (a.min(b).min(c), a.max(b).max(c));
                if first < end {
                    spans.push(Span { triangle: t as u32, first, end });
                }
            }
            Ok(spans)
        })
        .collect()
}

fn missing_vertex(triangle: usize, corners: [u32; 3], vertices: usize) -> TraceError {
    let vertex = corners[0].max(corners[1]).max(corners[2]);
    TraceError::Vertex { triangle, vertex, vertices }
}

/// Counts planes at or below a height, from a table of evenly spaced cells.
struct PlaneSearch<'a> {
    planes: &'a [i32],
    base: i64,
    shift: u32,
    /// Per cell the number of planes below it; one more entry than cells.
    below: Vec<u32>,
}

impl<'a> PlaneSearch<'a> {
    fn new(planes: &'a [i32]) -> Self {
        let base = planes.first().map_or(0, |&z| i64::from(z));
        let extent = planes.last().map_or(0, |&z| i64::from(z)) - base;
        // About two cells per plane.
        let wanted = 2 * planes.len() as i64 + 1;
        let shift = (0..40).find(|s| extent >> s < wanted).unwrap_or(40);
        let cells = (extent >> shift) + 1;
        let below = (0..=cells)
            .map(|cell| planes.partition_point(|&z| i64::from(z) < base + (cell << shift)) as u32)
            .collect();
        Self { planes, base, shift, below }
    }

    fn at_or_below(&self, z: i32) -> u32 {
        let above_base = i64::from(z) - self.base;
        if above_base < 0 {
            return 0;
        }
        let cell = (above_base >> self.shift) as usize;
        match self.below.get(cell..cell + 2) {
            Some(&[from, to]) => {
                let within = &self.planes[from as usize..to as usize];
                from + within.partition_point(|&plane| plane <= z) as u32
            }
            _ => self.planes.len() as u32,
        }
    }
}

/// Number of segments on each plane.
fn per_plane(spans: &[Vec<Span>], planes: usize) -> Vec<u64> {
    let mut step = vec![0i64; planes + 1];
    for span in spans.iter().flatten() {
        step[span.first as usize] += 1;
        step[span.end as usize] -= 1;
    }
    let mut now = 0;
    step[..planes]
        .iter()
        .map(|d| {
            now += d;
            now as u64
        })
        .collect()
}

/// Runs of planes of about equal work, several per thread; fewer where triangles that span several
/// runs would be listed so often that the lists exceed the budget.
fn runs(per_plane: &[u64], threads: usize, memory_budget: u64) -> Vec<Range<usize>> {
    let total: u64 = per_plane.iter().sum();
    let mut parts = if threads == 1 { 1 } else { 8 * threads as u64 };
    loop {
        let runs = chunk::runs(per_plane, (total / parts).max(1));
        // A triangle is listed again for every border of a run that it crosses.
        let again: u64 = runs.iter().skip(1).map(|r| per_plane[r.start].min(per_plane[r.start - 1])).sum();
        if parts == 1 || again * size_of::<Span>() as u64 <= memory_budget {
            return runs;
        }
        parts /= 2;
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
    let trace_run = |lists: &[Vec<Span>], run: &Range<usize>| {
        let mut finish = Finish::new(options);
        let mut layers = Vec::with_capacity(run.len());
        match route {
            Route::Sweep => {
                let mut sweep = Sweep::new(surface, planes, lists, run.clone());
                for k in run.clone() {
                    sweep.plane(k, &mut finish);
                    layers.push(finish.layer());
                }
            }
            Route::Front => {
                let mut front = Front::new(surface, planes, lists, run.clone());
                for k in run.clone() {
                    front.plane(k, &mut finish);
                    layers.push(finish.layer());
                }
            }
        }
        layers
    };
    if let [run] = runs {
        return trace_run(&spans, run);
    }
    let lists = by_run(spans, planes.len(), runs);
    let layers: Vec<_> =
        runs.par_iter().zip(lists).with_max_len(1).map(|(run, lists)| trace_run(&lists, run)).collect();
    layers.into_iter().flatten().collect()
}

/// Per run its lists of spans.
fn by_run(spans: Vec<Vec<Span>>, planes: usize, runs: &[Range<usize>]) -> Vec<Vec<Vec<Span>>> {
    let mut run_of = vec![0u32; planes];
    for (r, run) in runs.iter().enumerate() {
        run_of[run.clone()].fill(r as u32);
    }
    let blocks: Vec<Vec<Vec<Span>>> = spans
        .into_par_iter()
        .map(|block| {
            let mut lists = vec![Vec::new(); runs.len()];
            for span in block {
                let (from, to) = (run_of[span.first as usize], run_of[span.end as usize - 1]);
                for list in &mut lists[from as usize..=to as usize] {
                    list.push(span);
                }
            }
            lists
        })
        .collect();
    let mut per_run = vec![Vec::with_capacity(blocks.len()); runs.len()];
    for block in blocks {
        for (lists, list) in per_run.iter_mut().zip(block) {
            lists.push(list);
        }
    }
    per_run
}
