//! Which device intersects planes and triangles, and doing it there.

use super::JobError;
use super::summary::BackendSummary;
use crate::contour::{LayerContours, TraceOptions};
#[cfg(feature = "gpu")]
use crate::gpu;
use crate::mesh::{Adjacency, Mesh};
use crate::{contour, slice};

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
/// [`JobError::Device`] when a GPU was demanded and is missing or fails; with [`Backend::Auto`] a
/// failing GPU is replaced by the CPU and a warning.
pub fn contours(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    wish: &BackendOptions,
    options: &TraceOptions,
) -> Result<Traced, JobError> {
    let per_plane = slice::chunk::segments_per_plane(mesh, planes);
    let segments = per_plane.iter().sum();
    let cpu = |reason: &str, warning: Option<String>| {
        Ok(Traced {
            layers: contour::trace(mesh, adjacency, planes, options)?,
            segments,
            backend: BackendSummary {
                kind: "cpu",
                adapter: None,
                reason: reason.to_owned(),
                threads: rayon::current_num_threads(),
            },
            warning,
        })
    };
    if wish.backend == Backend::Cpu {
        return cpu("--backend cpu", None);
    }
    #[cfg(not(feature = "gpu"))]
    return match wish.backend {
        Backend::Gpu => Err(JobError::NoGpuSupport),
        _ => cpu("built without GPU support", None),
    };
    #[cfg(feature = "gpu")]
    {
        // Opening a driver costs more than slicing most models does, so the work is weighed first.
        if wish.backend == Backend::Auto
            && wish.adapter.is_none()
            && !slice::gpu::repays_startup(mesh.triangles.len() as u64, segments)
        {
            return cpu("the work does not repay a GPU's start-up", None);
        }
        match on_gpu(mesh, adjacency, planes, &per_plane, wish, options) {
            Ok((layers, adapter)) => Ok(Traced {
                layers,
                segments,
                backend: BackendSummary {
                    kind: "gpu",
                    adapter: Some(adapter),
                    reason: if wish.adapter.is_some() {
                        "named with --adapter"
                    } else {
                        "the best hardware GPU"
                    }
                    .to_owned(),
                    threads: rayon::current_num_threads(),
                },
                warning: None,
            }),
            Err(e) if wish.backend == Backend::Gpu || wish.adapter.is_some() => Err(e),
            Err(JobError::Device(gpu::GpuError::NoHardware { .. })) => cpu("no hardware GPU was found", None),
            Err(e) => cpu("the GPU failed", Some(format!("{e}; the CPU took over, with the same result"))),
        }
    }
}

#[cfg(feature = "gpu")]
fn on_gpu(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    per_plane: &[u64],
    wish: &BackendOptions,
    options: &TraceOptions,
) -> Result<(Vec<LayerContours>, String), JobError> {
    let selection = wish.adapter.clone().map_or(gpu::Selection::Auto, gpu::Selection::Named);
    let device = gpu::Device::open(&selection)?;
    let info = device.info();
    let name = format!("{} ({} {})", info.name, info.driver, info.driver_info);
    let mut slicer = slice::gpu::GpuSlicer::new(device.into())?.with_budget(options.memory_budget);
    let resident = slicer.upload(mesh, adjacency)?;
    let mut layers = Vec::with_capacity(planes.len());
    let runs = slice::chunk::runs(per_plane, slicer.max_segments());
    slicer.slice_runs::<JobError>(&resident, planes, &runs, |run, segments| {
        layers.extend(contour::contours_of(mesh, &planes[run], &segments, options));
        Ok(())
    })?;
    Ok((layers, name))
}
