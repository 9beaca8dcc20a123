//! Which device intersects planes and triangles, and doing it there.

use super::JobError;
use super::memory;
use super::summary::BackendSummary;
#[cfg(feature = "gpu")]
use super::warm::{self, FaultPlan, Lease, Taken, Warm};
use crate::contour;
use crate::contour::{LayerContours, TraceOptions};
#[cfg(feature = "gpu")]
use crate::gpu::{self, GpuError};
use crate::mesh::{Adjacency, Mesh};
#[cfg(feature = "gpu")]
use crate::slice;
#[cfg(feature = "gpu")]
use std::ops::Range;

/// Where planes and triangles are intersected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backend {
    /// A hardware GPU where the work repays its start-up, else the CPU.
    #[default]
    Auto,
    /// The CPU.
    Cpu,
    /// A GPU, or an error.
    Gpu,
}

/// A wish for a backend.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BackendOptions {
    /// Kind.
    pub backend: Backend,
    /// Part of the name of the device; allows software devices.
    pub adapter: Option<String>,
    /// Memory that slicing may take beside the mesh at the host, and with it on a device \[bytes\]; `None`
    /// takes [`memory::default_budget`].
    pub memory: Option<u64>,
    /// A failure that the device plays, for trying out what follows from it.
    #[doc(hidden)]
    #[cfg(feature = "gpu")]
    pub fault: Option<gpu::Fault>,
    /// Devices that stay open from job to job; `None` opens one for each job.
    #[cfg(feature = "gpu")]
    pub warm: Option<Warm>,
}

impl BackendOptions {
    /// A wish without planned failures; see the fields.
    pub const fn new(backend: Backend, adapter: Option<String>, memory: Option<u64>) -> Self {
        Self {
            backend,
            adapter,
            memory,
            #[cfg(feature = "gpu")]
            fault: None,
            #[cfg(feature = "gpu")]
            warm: None,
        }
    }
}

impl BackendOptions {
    /// The same, with devices that stay open from job to job and are shared by clones. Those that have them
    /// already keep them.
    #[must_use]
    pub fn kept_warm(self) -> Self {
        #[cfg(feature = "gpu")]
        if self.warm.is_none() && self.backend != Backend::Cpu {
            return Self { warm: Some(Warm::new(&self)), ..self };
        }
        self
    }

    /// The same, [kept warm](Self::kept_warm), with failures that its devices play.
    #[doc(hidden)]
    #[must_use]
    #[cfg(feature = "gpu")]
    pub fn with_faults(self, faults: FaultPlan) -> Self {
        let warm = self.kept_warm();
        if let Some(pool) = &warm.warm {
            pool.play(faults);
        }
        warm
    }
}

/// The contours of all planes, and what found them.
#[derive(Debug)]
pub struct Traced {
    /// Per plane.
    pub layers: Vec<LayerContours>,
    /// (Triangle, plane) pairs.
    pub segments: u64,
    /// Which device.
    pub backend: BackendSummary,
    /// A device that failed and was replaced.
    pub warning: Option<String>,
}

/// Intersects the mesh with the planes \[nm, mesh frame, ascending\] on the device wished for.
///
/// The result does not depend on the device.
///
/// # Errors
/// [`JobError::Device`] when a GPU was demanded with [`Backend::Gpu`] and is missing or fails, or when no
/// device has the name wished for. With [`Backend::Auto`] a GPU that fails is replaced by the CPU from the
/// planes in hand on, with one warning.
pub fn contours(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    wish: &BackendOptions,
    options: &TraceOptions,
) -> Result<Traced, JobError> {
    let prepared = contour::Prepared::new(mesh, adjacency, planes)?;
    let segments = prepared.per_plane.iter().sum();
    let budget = wish.memory.unwrap_or_else(memory::default_budget);
    let options = &TraceOptions { memory_budget: budget, ..options.clone() };
    let cpu = |prepared: contour::Prepared<'_>, reason: &str| {
        let layers = prepared.trace(options);
        Ok(Traced { layers, segments, backend: summary("cpu", None, reason), warning: None })
    };
    if wish.backend == Backend::Cpu {
        return cpu(prepared, "--backend cpu");
    }
    #[cfg(not(feature = "gpu"))]
    return match wish.backend {
        Backend::Gpu => Err(JobError::NoGpuSupport),
        _ => cpu(prepared, "built without GPU support"),
    };
    #[cfg(feature = "gpu")]
    {
        // Opening a driver costs more than slicing most models does, so the work is weighed first.
        let lease = match warm::take(wish, mesh.triangles.len() as u64, segments)? {
            Taken::Device(lease) => lease,
            Taken::Cpu { reason, warning } => return Ok(Traced { warning, ..cpu(prepared, reason)? }),
        };
        // The device lists triangles by itself.
        let per_plane = prepared.per_plane;
        let mut done = Done { adapter: lease.name(), layers: Vec::new() };
        let failure = on_gpu(lease, (mesh, adjacency), planes, &per_plane, options, &mut done).err();
        let reason = if wish.adapter.is_some() { "named with --adapter" } else { "the best hardware GPU" };
        let Some(failure) = failure else {
            let backend = summary("gpu", Some(done.adapter), reason);
            return Ok(Traced { layers: done.layers, segments, backend, warning: None });
        };
        if wish.backend == Backend::Gpu {
            return Err(failure.into());
        }
        // What the device has delivered stays; the planes in hand and those after them are the CPU's.
        let from = done.layers.len().min(planes.len());
        let warning = if from == 0 {
            format!("{failure}; the CPU took over, with the same result")
        } else {
            format!(
                "{failure}; the CPU took over from layer {} of {}, with the same result",
                from + 1,
                planes.len()
            )
        };
        let mut layers = done.layers;
        layers.extend(contour::trace(mesh, adjacency, &planes[from..], options)?);
        let backend = if from == 0 {
            summary("cpu", None, "the GPU failed")
        } else {
            summary("gpu", Some(done.adapter), "the GPU failed on the way; the CPU did the rest")
        };
        Ok(Traced { layers, segments, backend, warning: Some(warning) })
    }
}

fn summary(kind: &'static str, adapter: Option<String>, reason: &str) -> BackendSummary {
    BackendSummary { kind, adapter, reason: reason.to_owned(), threads: rayon::current_num_threads() }
}

/// What a device has done so far.
#[cfg(feature = "gpu")]
struct Done {
    adapter: String,
    /// The contours of the first planes.
    layers: Vec<LayerContours>,
}

#[cfg(feature = "gpu")]
fn on_gpu(
    lease: Lease,
    (mesh, adjacency): (&Mesh, &Adjacency),
    planes: &[i32],
    per_plane: &[u64],
    options: &TraceOptions,
    done: &mut Done,
) -> Result<(), GpuError> {
    lease.slice(mesh, adjacency, options.memory_budget, |slicer, resident| {
        let runs = runs(per_plane, slicer.max_segments_beside(resident)?);
        slicer.slice_runs(resident, planes, &runs, |run, segments| {
            done.layers.extend(contour::contours_of(mesh, &planes[run], &segments, options));
            Ok(())
        })
    })
}

/// Runs of planes within the limit, and several even where one would do: the device works on one while
/// the host walks the one before.
#[cfg(feature = "gpu")]
fn runs(per_plane: &[u64], limit: u64) -> Vec<Range<usize>> {
    /// Runs that overlap well.
    const RUNS: u64 = 8;
    /// Segments below which a run is not worth its own round trip.
    const FEW: u64 = 1 << 18;
    let total: u64 = per_plane.iter().sum();
    slice::chunk::runs(per_plane, limit.min((total / RUNS).max(FEW)))
}
