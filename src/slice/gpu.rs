//! The slicing kernels on a device: the same segments as [`super::cpu`], bit for bit.

use super::Segments;
use super::chunk::BYTES_PER_SEGMENT;
use crate::gpu::dispatch::Recording;
use crate::gpu::scan::{self, Scratch};
use crate::gpu::timing::KernelTime;
use crate::gpu::{Buffer, Device, GpuError};
use crate::lattice::{Point2, Point3};
use crate::mesh::{Adjacency, Mesh};
use crate::shaders::{SCAN_ADD, SCAN_BLOCK, SLICE_COUNT, SLICE_EMIT, SliceSizes};
use std::ops::Range;
use std::sync::Arc;

/// Device memory that the segments of one run may take unless said otherwise \[bytes\].
pub const DEFAULT_BUDGET: u64 = 512 << 20;

/// A device with the slicing kernels and the arrays that they reuse from run to run.
pub struct GpuSlicer {
    device: Arc<Device>,
    budget: u64,
    times: Option<Vec<KernelTime>>,
    planes: Buffer<i32>,
    first: Buffer<u32>,
    count: Buffer<u32>,
    offset: Buffer<u32>,
    start: Buffer<Point2>,
    next: Buffer<u32>,
    scratch: Scratch,
}

/// A mesh that stays on the device.
pub struct GpuMesh {
    vertices: Buffer<Point3>,
    triangles: Buffer<[u32; 3]>,
    twin: Buffer<u32>,
}

impl GpuSlicer {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`GpuError::Validation`], [`GpuError::OutOfMemory`] and the like.
    pub fn new(device: Arc<Device>) -> Result<Self, GpuError> {
        device.prepare(&[SLICE_COUNT, SCAN_BLOCK, SCAN_ADD, SLICE_EMIT])?;
        Ok(Self {
            budget: DEFAULT_BUDGET,
            times: None,
            planes: Buffer::zeroed(&device, "the planes", 0)?,
            first: Buffer::zeroed(&device, "the first planes", 0)?,
            count: Buffer::zeroed(&device, "the plane counts", 0)?,
            offset: Buffer::zeroed(&device, "the segment offsets", 0)?,
            start: Buffer::zeroed(&device, "the segment starts", 0)?,
            next: Buffer::zeroed(&device, "the segment links", 0)?,
            scratch: Scratch::default(),
            device,
        })
    }

    /// Sets the device memory that the segments of one run may take \[bytes\].
    #[must_use]
    pub const fn with_budget(mut self, bytes: u64) -> Self {
        self.budget = bytes;
        self
    }

    /// Times every kernel from now on, where the device has a clock.
    #[must_use]
    pub fn with_timing(mut self) -> Self {
        self.times = Some(Vec::new());
        self
    }

    /// What the kernels took since the last call.
    pub fn take_times(&mut self) -> Vec<KernelTime> {
        self.times.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// How many segments a run of planes may have; the limit for [`super::chunk::runs`].
    pub fn max_segments(&self) -> u64 {
        let one_binding = self.device.limits().binding / size_of::<Point2>() as u64;
        // Each array exists twice for a while: where the kernel writes it and where the host reads it.
        let budget = self.budget / (2 * BYTES_PER_SEGMENT);
        one_binding.min(budget).min(u64::from(u32::MAX) - 1).max(1)
    }

    /// Copies a mesh to the device.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when one of its arrays exceeds a binding (128 MiB on the smallest devices:
    /// 11.1 million triangles), [`GpuError::OutOfMemory`].
    pub fn upload(&self, mesh: &Mesh, adjacency: &Adjacency) -> Result<GpuMesh, GpuError> {
        let (edges, triangles) = (adjacency.twin.len(), mesh.triangles.len());
        if edges != 3 * triangles {
            let message = format!("{edges} half-edges for {triangles} triangles");
            return Err(GpuError::Validation(message));
        }
        Ok(GpuMesh {
            vertices: Buffer::upload(&self.device, "the mesh's vertices", &mesh.vertices)?,
            triangles: Buffer::upload(&self.device, "the mesh's triangles", &mesh.triangles)?,
            twin: Buffer::upload(&self.device, "the mesh's adjacency", &adjacency.twin)?,
        })
    }

    /// Slices a mesh at one run of planes \[nm, mesh frame, ascending\].
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when the run has more than [`Self::max_segments`]; a lost or hung device.
    pub fn slice(&mut self, mesh: &GpuMesh, planes: &[i32]) -> Result<Segments, GpuError> {
        let triangles = mesh.triangles.len() as u32;
        let sizes = SliceSizes { triangles, planes: planes.len() as u32, padding: [0; 2] };
        self.planes.replace(&self.device, planes)?;
        let (first, offset) = self.count(mesh, &sizes)?;
        // The true total, before anything is allocated for it.
        let (total, limit) = (exact_total(&offset), self.max_segments());
        if total > limit {
            return Err(GpuError::TooLarge {
                what: "a run of planes",
                unit: "segments",
                needs: total,
                limit,
            });
        }
        let (start, next) = self.emit(mesh, &sizes, total as usize)?;
        Ok(Segments { first, offset, start, next })
    }

    /// First plane and first slot of every triangle, left on the device and brought back.
    fn count(&mut self, mesh: &GpuMesh, sizes: &SliceSizes) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
        let (device, triangles) = (&*self.device, mesh.triangles.len());
        self.first.resize(device, triangles)?;
        self.count.resize(device, triangles)?;
        self.offset.resize(device, triangles + 1)?;
        let mut recording = Recording::new(device, self.times.is_some())?;
        recording.dispatch(
            &SLICE_COUNT,
            sizes,
            &[&mesh.vertices, &mesh.triangles, &self.planes, &self.first, &self.count],
            triangles as u64,
        )?;
        scan::record(device, &mut recording, &mut self.scratch, &self.count, &self.offset)?;
        let (first, offset) = (recording.read_back(&self.first)?, recording.read_back(&self.offset)?);
        let mut submission = recording.submit()?;
        let result = (first.take(device, &submission)?, offset.take(device, &submission)?);
        if let Some(times) = &mut self.times {
            times.extend(submission.times(device)?);
        }
        Ok(result)
    }

    /// Start and successor of every segment.
    fn emit(
        &mut self,
        mesh: &GpuMesh,
        sizes: &SliceSizes,
        total: usize,
    ) -> Result<(Vec<Point2>, Vec<u32>), GpuError> {
        let device = &*self.device;
        self.start.resize(device, total)?;
        self.next.resize(device, total)?;
        let mut recording = Recording::new(device, self.times.is_some())?;
        recording.dispatch(
            &SLICE_EMIT,
            sizes,
            &[
                &mesh.vertices,
                &mesh.triangles,
                &self.planes,
                &mesh.twin,
                &self.first,
                &self.offset,
                &self.start,
                &self.next,
            ],
            mesh.triangles.len() as u64,
        )?;
        let (start, next) = (recording.read_back(&self.start)?, recording.read_back(&self.next)?);
        let mut submission = recording.submit()?;
        let result = (start.take(device, &submission)?, next.take(device, &submission)?);
        if let Some(times) = &mut self.times {
            times.extend(submission.times(device)?);
        }
        Ok(result)
    }

    /// Slices run after run (see [`super::chunk::runs`]) and hands over each one's segments, whose plane
    /// indices count from the run's beginning.
    ///
    /// # Errors
    /// The first of [`Self::slice`] or of the receiver.
    pub fn slice_runs<E: From<GpuError>>(
        &mut self,
        mesh: &GpuMesh,
        planes: &[i32],
        runs: &[Range<usize>],
        mut receive: impl FnMut(Range<usize>, Segments) -> Result<(), E>,
    ) -> Result<(), E> {
        for run in runs {
            let segments = self.slice(mesh, planes.get(run.clone()).unwrap_or_default())?;
            receive(run.clone(), segments)?;
        }
        Ok(())
    }
}

/// The total that 32-bit offsets stand for, also when they have wrapped: one triangle has fewer than
/// 2^32 segments, so an offset below its predecessor has wrapped exactly once more.
fn exact_total(offset: &[u32]) -> u64 {
    let wraps = offset.windows(2).filter(|pair| pair[1] < pair[0]).count() as u64;
    (wraps << 32) + u64::from(offset.last().copied().unwrap_or(0))
}

/// Whether a hardware device is likely to earn back what it costs to start, for automatic choice.
/// Touches no driver, so that a small job never loads one.
///
/// Loading a driver, opening a device and compiling four kernels takes 0.1 s to 0.5 s on desktop
/// systems. One core counts, emits and links in about 20 ns a triangle and 30 ns a segment (measured
/// with [`super::cpu`]), and several cores share that work; a device must be sent 30 bytes or more for
/// each triangle and send back 8 for it and 12 for each segment. So a device pays only where one core
/// would compute for the better part of a second.
pub const fn repays_startup(triangles: u64, segments_estimate: u64) -> bool {
    triangles.saturating_mul(20).saturating_add(segments_estimate.saturating_mul(30)) > 700_000_000
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exact_total_sees_every_wrap() {
        assert_eq!(exact_total(&[0]), 0);
        assert_eq!(exact_total(&[0, 3, 3, 7]), 7);
        let most = u32::MAX;
        assert_eq!(exact_total(&[0, most, most.wrapping_add(most), 2]), 2 * u64::from(u32::MAX) + 4);
    }

    #[test]
    fn a_small_job_never_starts_a_device() {
        assert!(!repays_startup(225_000, 2_000_000));
        assert!(repays_startup(1_000_000, 50_000_000));
    }
}
