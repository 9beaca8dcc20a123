//! Segments that stay on the device, for kernels that go on with them.

use super::flight::Flight;
use super::mesh::GpuMesh;
use crate::gpu::dispatch::{Readback, Recording};
use crate::gpu::{Buffer, Device, GpuError};
use crate::lattice::Point2;
use crate::shaders::{SLICE_EMIT, SLICE_EMIT_EVEN, SliceSizes};
use crate::slice::Segments;

/// The segments of a run of planes in device memory, as in [`crate::slice::Segments`]. All of them lie in
/// one binding each, because a link leads anywhere in the run.
pub struct ResidentSegments(Flight);

impl ResidentSegments {
    /// Bytes of device memory per segment.
    pub const BYTES_PER_SEGMENT: u64 = 12;

    /// Bytes of device memory per triangle of the mesh.
    pub const BYTES_PER_TRIANGLE: u64 = 12;

    /// Without segments yet.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`].
    pub fn new(device: &Device) -> Result<Self, GpuError> {
        Flight::new(device).map(Self)
    }

    /// Records the slice of a mesh at a run of planes \[nm, mesh frame, ascending\] that has `total`
    /// segments. What comes back is the total as the device counts it, modulo 2^32: segments are complete
    /// where the two agree.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when the segments exceed a binding, [`GpuError::OutOfMemory`].
    pub fn record(
        &mut self,
        device: &Device,
        recording: &mut Recording,
        mesh: &GpuMesh,
        planes: &[i32],
        total: usize,
    ) -> Result<Readback<u32>, GpuError> {
        let Self(flight) = self;
        flight.start.resize(device, total)?;
        flight.next.resize(device, total)?;
        flight.planes.replace(device, planes)?;
        let planes = planes.len() as u32;
        flight.record_count(device, recording, mesh, planes)?;
        // An invocation per segment finds its triangle in the whole mesh: not where that lies in pieces.
        let single = mesh.pieces.len() == 1;
        for piece in &mesh.pieces {
            let sizes = SliceSizes {
                triangles: piece.range.len() as u32,
                planes,
                piece: piece.range.start as u32,
                segments: total as u32,
                ..SliceSizes::default()
            };
            let (kernel, items) =
                if single { (SLICE_EMIT_EVEN, total) } else { (SLICE_EMIT, piece.range.len()) };
            recording.dispatch(
                &kernel,
                &sizes,
                &[
                    &mesh.vertices[piece.vertices],
                    &piece.triangles,
                    &flight.planes,
                    &piece.twin,
                    &flight.first,
                    &flight.offset,
                    &flight.start,
                    &flight.next,
                ],
                if total == 0 { 0 } else { items as u64 },
            )?;
        }
        let triangles = mesh.triangles();
        recording.read_back_part(&flight.offset, triangles..triangles + 1)
    }

    /// Takes segments from the host in place of sliced ones.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when they exceed a binding, [`GpuError::OutOfMemory`].
    pub fn replace(&mut self, device: &Device, segments: &Segments) -> Result<(), GpuError> {
        let Self(flight) = self;
        flight.first.replace(device, &segments.first)?;
        flight.offset.replace(device, &segments.offset)?;
        flight.start.replace(device, &segments.start)?;
        flight.next.replace(device, &segments.next)
    }

    /// Bytes of device memory that they hold.
    pub fn held(&self) -> u64 {
        self.0.held()
    }

    /// Per triangle the first plane that it meets.
    pub const fn first(&self) -> &Buffer<u32> {
        &self.0.first
    }

    /// Per triangle the slot of its first segment, and the total.
    pub const fn offset(&self) -> &Buffer<u32> {
        &self.0.offset
    }

    /// Per segment its start \[nm\].
    pub const fn start(&self) -> &Buffer<Point2> {
        &self.0.start
    }

    /// Per segment its successor's slot, or [`crate::mesh::OPEN`].
    pub const fn next(&self) -> &Buffer<u32> {
        &self.0.next
    }
}
