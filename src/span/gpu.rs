//! The span kernels on a device: from a resident mesh to the spans of every plane, bit for bit those of
//! [`super::scan()`]. Segments and crossings never leave the device.

mod flight;

use super::{RowFrame, RowWindow, Rows, rings};
use crate::gpu::timing::KernelTime;
use crate::gpu::{Device, GpuError};
use crate::lattice::Point2;
use crate::shaders::{
    SCAN_ADD, SCAN_BLOCK, SLICE_COUNT, SLICE_EMIT, SLICE_EMIT_EVEN, SPAN_COMPACT, SPAN_COUNT, SPAN_FILL,
    SPAN_SORT,
};
use crate::slice::gpu::{DEFAULT_BUDGET, GpuMesh, ResidentSegments};
use flight::{Flight, Pending, Source, Work};
use std::ops::Range;
use std::sync::Arc;

/// Crossings per segment until a run has shown better.
const CROSSINGS_PER_SEGMENT: u64 = 4;

/// A device with the kernels from slicing to spans and the arrays that they reuse from run to run.
pub struct GpuSpans {
    device: Arc<Device>,
    budget: u64,
    times: Option<Vec<KernelTime>>,
    flights: [Flight; 2],
}

impl GpuSpans {
    /// Compiles the kernels.
    ///
    /// # Errors
    /// [`GpuError::Validation`], [`GpuError::OutOfMemory`] and the like.
    pub fn new(device: Arc<Device>) -> Result<Self, GpuError> {
        device.prepare(&[
            SLICE_COUNT,
            SCAN_BLOCK,
            SCAN_ADD,
            SLICE_EMIT,
            SLICE_EMIT_EVEN,
            SPAN_COUNT,
            SPAN_FILL,
            SPAN_SORT,
            SPAN_COMPACT,
        ])?;
        let flights = [Flight::new(&device)?, Flight::new(&device)?];
        Ok(Self { budget: DEFAULT_BUDGET, times: None, flights, device })
    }

    /// Sets the memory that a mesh and its runs may take \[bytes\].
    #[must_use]
    pub const fn with_budget(mut self, bytes: u64) -> Self {
        self.budget = bytes;
        self
    }

    /// Bytes of device memory that it holds between runs.
    pub fn held(&self) -> u64 {
        self.flights.iter().map(Flight::held).sum()
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

    /// The spans of every plane \[nm, mesh frame, ascending\] on the rows of a window, run after run of as
    /// many planes as memory and bindings hold. `per_plane` is the number of segments on each, from
    /// [`crate::slice::chunk::segments_per_plane`].
    ///
    /// `receive` gets the numbers of the planes and for each its rows, without empty ones at either end;
    /// `None` for a plane on which segments end in open edges, whose contours must be closed first.
    /// While it works, the device is busy with the next run.
    ///
    /// # Errors
    /// The first of the device or of the receiver: a single plane beyond a binding or the budget
    /// ([`GpuError::TooLarge`], [`GpuError::Budget`]); on diagonal rows also a part that reaches further
    /// than [`super::window::REACH`]; a lost or hung device. All planes before those that failed have been
    /// handed over.
    pub fn scan<E: From<GpuError>>(
        &mut self,
        mesh: &GpuMesh,
        planes: &[i32],
        per_plane: &[u64],
        window: &RowWindow,
        receive: impl FnMut(Range<usize>, Vec<Option<Rows>>) -> Result<(), E>,
    ) -> Result<(), E> {
        let share = self.share(mesh)?;
        let source = |run: Range<usize>| Source::Mesh(mesh, planes.get(run).unwrap_or_default());
        self.run(planes.len(), per_plane, window, share, source, receive)
    }

    /// As [`GpuSpans::scan`], of closed rings \[nm\] at the host instead of sections of a mesh, on the rows of
    /// any frame: bit for bit those of [`super::scan()`]. `window` is [`rings::window`] of the same planes, or
    /// of more.
    ///
    /// # Errors
    /// As [`GpuSpans::scan`].
    pub fn scan_rings<E: From<GpuError>>(
        &mut self,
        planes: &[Vec<&[Point2]>],
        frame: &RowFrame,
        window: &RowWindow,
        receive: impl FnMut(Range<usize>, Vec<Option<Rows>>) -> Result<(), E>,
    ) -> Result<(), E> {
        let points = |rings: &Vec<&[Point2]>| rings.iter().map(|r| r.len() as u64).sum();
        let per_plane: Vec<u64> = planes.iter().map(points).collect();
        let source = |run| Source::Host(rings::segments(planes.get(run).unwrap_or_default(), frame));
        self.run(planes.len(), &per_plane, window, self.budget / 2, source, receive)
    }

    /// Run after run of `planes`, one ahead of the other.
    fn run<'s, E: From<GpuError>>(
        &mut self,
        planes: usize,
        per_plane: &[u64],
        window: &RowWindow,
        share: u64,
        source: impl Fn(Range<usize>) -> Source<'s>,
        mut receive: impl FnMut(Range<usize>, Vec<Option<Rows>>) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut ahead: Option<(Range<usize>, Pending)> = None;
        let mut density = CROSSINGS_PER_SEGMENT;
        let (mut from, mut turn) = (0, 0);
        while from < planes {
            let mut end = self.plan(from, planes, per_plane, window, share, density);
            let begun = loop {
                let segments = (from..end).map(|k| per_plane.get(k).copied().unwrap_or(0)).sum();
                let work = Work { source: source(from..end), planes: end - from, segments, window, share };
                let flight = &mut self.flights[turn % 2];
                let begun = flight.begin(&self.device, &work, &mut density, &mut self.times);
                match begun {
                    Err(GpuError::TooLarge { .. } | GpuError::Budget { .. }) if end - from > 1 => {
                        // By what has been found, and at least by half.
                        let again = self.plan(from, planes, per_plane, window, share, density);
                        end = again.min(from + (end - from) / 2);
                    }
                    other => break other,
                }
            };
            if let Some((run, before)) = ahead.take() {
                let rows = before.finish(&self.device, &mut self.times)?;
                receive(run, rows)?;
            }
            ahead = Some((from..end, begun?));
            (from, turn) = (end, turn + 1);
        }
        if let Some((run, last)) = ahead {
            let rows = last.finish(&self.device, &mut self.times)?;
            receive(run, rows)?;
        }
        Ok(())
    }

    /// Bytes for each of the two runs in flight.
    fn share(&self, mesh: &GpuMesh) -> Result<u64, GpuError> {
        let triangles = mesh.triangles() as u64 * ResidentSegments::BYTES_PER_TRIANGLE;
        let taken = mesh.bytes() + 2 * triangles;
        let left = self.budget.saturating_sub(taken) / 2;
        if left == 0 {
            return Err(GpuError::Budget { what: "the mesh", needs: taken + 2, budget: self.budget });
        }
        Ok(left)
    }

    /// Where a run from plane `from` on should end.
    fn plan(
        &self,
        from: usize,
        planes: usize,
        per_plane: &[u64],
        window: &RowWindow,
        share: u64,
        density: u64,
    ) -> usize {
        let binding = self.device.limits().binding;
        let (mut segments, mut rows) = (0u64, 0u64);
        for k in from..planes {
            segments += per_plane.get(k).copied().unwrap_or(0);
            rows += u64::from(window.rows());
            let crossings = segments.saturating_mul(density);
            let fits = 8 * segments <= binding
                && 4 * (rows + 2) <= binding
                && crossings <= binding / 4
                && flight::bytes(segments, rows, crossings) <= share;
            if !fits {
                return k.max(from + 1);
            }
        }
        planes
    }
}
