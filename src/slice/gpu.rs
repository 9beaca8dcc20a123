//! The slicing kernels on a device: the same segments as [`super::cpu`], bit for bit.
//!
//! A mesh goes to the device once and stays ([`GpuMesh`]); planes are sliced in runs, two of which are
//! in flight, so that the device works on one while the host walks the other.

mod flight;
mod mesh;
mod resident;
mod soup;

pub use mesh::GpuMesh;
pub use resident::ResidentSegments;
pub use soup::{Arrays, Built};

use super::Segments;
use crate::gpu::timing::{CopyTimes, KernelTime};
use crate::gpu::{Device, GpuError};
use crate::mesh::{Adjacency, Mesh};
use crate::shaders::{SCAN_ADD, SCAN_BLOCK, SLICE_COUNT, SLICE_EMIT, SLICE_EMIT_EVEN};
use flight::{Flight, Pending, Times};
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// Memory that a mesh and its runs may take unless said otherwise \[bytes\].
pub const DEFAULT_BUDGET: u64 = 512 << 20;

/// Bytes per segment: 12 on the device and 12 where the host reads them, both for two runs in flight;
/// then the host's own copy and the places of its walk.
const BYTES_PER_SEGMENT: u64 = 2 * (12 + 12) + 12 + 8;

/// Bytes per triangle beside the mesh: first plane, plane count and offset, for two runs in flight, two of
/// them twice for the way back, and once more at the host.
const BYTES_PER_TRIANGLE: u64 = 2 * (12 + 8) + 8;

/// A device with the slicing kernels and the arrays that they reuse from run to run and from job to job.
pub struct GpuSlicer {
    device: Arc<Device>,
    budget: u64,
    times: Option<Times>,
    flights: [Flight; 2],
}

impl GpuSlicer {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`GpuError::Validation`], [`GpuError::OutOfMemory`] and the like.
    pub fn new(device: Arc<Device>) -> Result<Self, GpuError> {
        device.prepare(&[SLICE_COUNT, SCAN_BLOCK, SCAN_ADD, SLICE_EMIT, SLICE_EMIT_EVEN])?;
        let flights = [Flight::new(&device)?, Flight::new(&device)?];
        Ok(Self { budget: DEFAULT_BUDGET, times: None, flights, device })
    }

    /// Sets the memory that a mesh and its runs may take \[bytes\], on the device and, where that is not the
    /// same memory, at the host.
    #[must_use]
    pub const fn with_budget(mut self, bytes: u64) -> Self {
        self.budget = bytes;
        self
    }

    /// Bytes of device memory that it holds between runs.
    pub fn held(&self) -> u64 {
        self.flights.iter().map(Flight::held).sum()
    }

    /// Times every kernel and every copy from now on, kernels where the device has a clock. Nothing
    /// overlaps then.
    #[must_use]
    pub fn with_timing(mut self) -> Self {
        self.times = Some(Times::default());
        self
    }

    /// What the kernels took since the last call.
    pub fn take_times(&mut self) -> Vec<KernelTime> {
        self.times.as_mut().map(|times| std::mem::take(&mut times.kernels)).unwrap_or_default()
    }

    /// What the copies and the host's part took since the last call; zero without [`Self::with_timing`].
    pub fn take_copy_times(&mut self) -> CopyTimes {
        self.times.as_mut().map(|times| std::mem::take(&mut times.copies)).unwrap_or_default()
    }

    /// The device.
    pub fn device(&self) -> &Device {
        &self.device
    }

    /// How many segments a run of planes may have by the budget alone, beside a small mesh.
    pub fn max_segments(&self) -> u64 {
        (self.budget / BYTES_PER_SEGMENT).min(u64::from(u32::MAX) - 1).max(1)
    }

    /// How many segments a run of planes may have beside a mesh; the limit for [`super::chunk::runs`].
    ///
    /// # Errors
    /// [`GpuError::Budget`] when the mesh leaves nothing of the budget.
    pub fn max_segments_beside(&self, mesh: &GpuMesh) -> Result<u64, GpuError> {
        let taken = mesh.bytes() + mesh.triangles() as u64 * BYTES_PER_TRIANGLE;
        let left = self.budget.saturating_sub(taken);
        if left < BYTES_PER_SEGMENT {
            return Err(GpuError::Budget {
                what: "the mesh",
                needs: taken + BYTES_PER_SEGMENT,
                budget: self.budget,
            });
        }
        Ok((left / BYTES_PER_SEGMENT).min(u64::from(u32::MAX) - 1))
    }

    /// Copies a mesh to the device, in pieces where one of its arrays exceeds a binding (128 MiB on the
    /// smallest devices: 11.1 million triangles).
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when the arrays of 4 bytes per triangle exceed a binding (33.5 million
    /// triangles on the smallest devices), [`GpuError::OutOfMemory`].
    pub fn upload(&mut self, mesh: &Mesh, adjacency: &Adjacency) -> Result<GpuMesh, GpuError> {
        let mut resident = GpuMesh::empty();
        self.upload_into(&mut resident, mesh, adjacency)?;
        Ok(resident)
    }

    /// [`Self::upload`] into the memory of a mesh that is no longer needed.
    ///
    /// # Errors
    /// As [`Self::upload`]; the old mesh is gone then too.
    pub fn upload_into(
        &mut self,
        resident: &mut GpuMesh,
        mesh: &Mesh,
        adjacency: &Adjacency,
    ) -> Result<(), GpuError> {
        let begun = Instant::now();
        resident.replace(&self.device, mesh, adjacency)?;
        if let Some(times) = &mut self.times {
            self.device.flush()?;
            times.copies.uploaded += resident.bytes();
            times.copies.upload += nanoseconds(begun);
        }
        Ok(())
    }

    /// Slices a mesh at one run of planes \[nm, mesh frame, ascending\].
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when the run has more than [`Self::max_segments_beside`] the mesh; a lost or
    /// hung device.
    pub fn slice(&mut self, mesh: &GpuMesh, planes: &[i32]) -> Result<Segments, GpuError> {
        let pending = self.begin(0, mesh, planes)?;
        self.finish(pending)
    }

    /// Slices run after run (see [`super::chunk::runs`]) and hands over each one's segments, whose plane
    /// indices count from the run's beginning. While a run's segments are received, the device works on
    /// the next run.
    ///
    /// # Errors
    /// The first of [`Self::slice`] or of the receiver. All runs before the one that failed have been
    /// handed over.
    pub fn slice_runs<E: From<GpuError>>(
        &mut self,
        mesh: &GpuMesh,
        planes: &[i32],
        runs: &[Range<usize>],
        mut receive: impl FnMut(Range<usize>, Segments) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut ahead: Option<(Range<usize>, Pending)> = None;
        let mut failed = None;
        for (i, run) in runs.iter().enumerate() {
            let begun = self.begin(i % 2, mesh, planes.get(run.clone()).unwrap_or_default());
            let before = ahead.take();
            match begun {
                Ok(pending) => ahead = Some((run.clone(), pending)),
                Err(error) => failed = Some(error),
            }
            if let Some((run, pending)) = before {
                // The later run's failure need not be this one's; where it is, it shows here again.
                let segments = self.finish(pending)?;
                receive(run, segments)?;
            }
            if let Some(error) = failed {
                return Err(error.into());
            }
        }
        if let Some((run, pending)) = ahead {
            let segments = self.finish(pending)?;
            receive(run, segments)?;
        }
        Ok(())
    }

    fn begin(&mut self, flight: usize, mesh: &GpuMesh, planes: &[i32]) -> Result<Pending, GpuError> {
        let limit = self.max_segments_beside(mesh)?;
        self.flights[flight % 2].begin(&self.device, mesh, planes, limit, &mut self.times)
    }

    fn finish(&mut self, pending: Pending) -> Result<Segments, GpuError> {
        pending.finish(&self.device, &mut self.times)
    }
}

fn nanoseconds(since: Instant) -> u64 {
    u64::try_from(since.elapsed().as_nanos()).unwrap_or(u64::MAX)
}

/// What it costs to load a driver, open a device and compile its kernels \[ns\]: 0.1 s to 0.5 s on desktop
/// systems, of which this is the upper end.
pub const START_UP: u64 = 500_000_000;

/// What a job costs on a device that is open, whatever its size \[ns\]. A guess on the safe side: a job takes
/// two to some twenty round trips.
const ROUND_TRIPS: u64 = 20_000_000;

/// The CPU time that a hardware device which is open saves a job \[ns\]; 0 where it saves none. For automatic
/// choice.
///
/// One core counts, emits and links in about 20 ns a triangle and 30 ns a segment (measured with
/// [`super::cpu`]), and several cores share that work. A device must be sent 30 bytes for each triangle and
/// send back 8 for it and 12 for each segment; that these take 0.2 ns a byte is an assumption, as is that the
/// kernels take nothing beside: neither has been measured on a hardware device.
pub const fn saving(triangles: u64, segments_estimate: u64) -> u64 {
    let cpu = triangles.saturating_mul(20).saturating_add(segments_estimate.saturating_mul(30));
    let device = triangles.saturating_mul(8).saturating_add(segments_estimate.saturating_mul(3));
    cpu.saturating_sub(device).saturating_sub(ROUND_TRIPS)
}

/// Whether a hardware device is likely to earn back what it costs, for automatic choice: `start_up` is
/// [`START_UP`], or 0 for a device that is open. Touches no driver, so that a small job never loads one.
pub const fn repays_startup(triangles: u64, segments_estimate: u64, start_up: u64) -> bool {
    saving(triangles, segments_estimate) > start_up
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_job_never_starts_a_device() {
        assert!(!repays_startup(225_000, 2_000_000, START_UP));
        assert!(repays_startup(1_000_000, 50_000_000, START_UP));
        assert!(!repays_startup(5_000, 100_000, 0), "not even one that is open");
        assert!(repays_startup(225_000, 2_000_000, 0));
    }
}
