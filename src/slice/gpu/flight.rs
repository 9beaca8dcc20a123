//! One run of planes on its way through the device.

use super::mesh::GpuMesh;
use super::nanoseconds;
use crate::gpu::dispatch::{Readback, Recording, Submission};
use crate::gpu::scan::{self, Scratch};
use crate::gpu::timing::{CopyTimes, KernelTime};
use crate::gpu::{Buffer, Device, GpuError};
use crate::lattice::Point2;
use crate::shaders::{SLICE_COUNT, SLICE_EMIT, SLICE_EMIT_EVEN, SliceSizes};
use crate::slice::Segments;
use std::ops::Range;
use std::time::Instant;

/// Mean planes per meeting triangle from which on invocations go by segments: neighbouring invocations
/// then write neighbouring places.
const MANY_PLANES: u64 = 16;

/// Triangles whose invocations run in step on common devices.
const IN_STEP: usize = 32;

/// The arrays of one run.
pub(super) struct Flight {
    pub(super) planes: Buffer<i32>,
    pub(super) first: Buffer<u32>,
    count: Buffer<u32>,
    pub(super) offset: Buffer<u32>,
    pub(super) start: Buffer<Point2>,
    pub(super) next: Buffer<u32>,
    scratch: Scratch,
}

/// Times gathered since they were last asked for.
#[derive(Default)]
pub(super) struct Times {
    pub kernels: Vec<KernelTime>,
    pub copies: CopyTimes,
}

/// A run whose segments are being computed or are on their way back.
pub(super) struct Pending {
    first: Vec<u32>,
    offset: Vec<u32>,
    submission: Submission,
    parts: Vec<(Readback<Point2>, Readback<u32>)>,
}

impl Flight {
    pub(super) fn new(device: &Device) -> Result<Self, GpuError> {
        Ok(Self {
            planes: Buffer::zeroed(device, "the planes", 0)?,
            first: Buffer::zeroed(device, "the first planes", 0)?,
            count: Buffer::zeroed(device, "the plane counts", 0)?,
            offset: Buffer::zeroed(device, "the segment offsets", 0)?,
            start: Buffer::zeroed(device, "the segment starts", 0)?,
            next: Buffer::zeroed(device, "the segment links", 0)?,
            scratch: Scratch::default(),
        })
    }

    /// Bytes of device memory.
    pub(super) fn held(&self) -> u64 {
        let numbers = [&self.first, &self.count, &self.offset, &self.next].map(Buffer::held);
        self.planes.held() + self.start.held() + numbers.iter().sum::<u64>()
    }

    /// Counts, waits for the exact total, and sends the kernels that emit on their way.
    pub(super) fn begin(
        &mut self,
        device: &Device,
        mesh: &GpuMesh,
        planes: &[i32],
        limit: u64,
        times: &mut Option<Times>,
    ) -> Result<Pending, GpuError> {
        let begun = Instant::now();
        self.planes.replace(device, planes)?;
        if let Some(times) = times {
            device.flush()?;
            times.copies.uploaded += size_of_val(planes) as u64;
            times.copies.upload += nanoseconds(begun);
        }
        let planes = planes.len() as u32;
        let (first, offset) = self.count(device, mesh, planes, times)?;
        // The true total, before anything is allocated for it.
        let total = exact_total(&offset);
        if total > limit {
            let (what, unit) = ("a run of planes", "segments");
            return Err(GpuError::TooLarge { what, unit, needs: total, limit });
        }
        self.emit(device, mesh, planes, first, offset, times)
    }

    /// First plane and first slot of every triangle, left on the device and brought back.
    fn count(
        &mut self,
        device: &Device,
        mesh: &GpuMesh,
        planes: u32,
        times: &mut Option<Times>,
    ) -> Result<(Vec<u32>, Vec<u32>), GpuError> {
        let begun = Instant::now();
        let mut recording = Recording::new(device, times.is_some())?;
        self.record_count(device, &mut recording, mesh, planes)?;
        let mut recording = kernels_alone(device, recording, begun, times)?;
        let begun = Instant::now();
        let (first, offset) = (recording.read_back(&self.first)?, recording.read_back(&self.offset)?);
        let submission = recording.submit()?;
        copies_alone(device, &submission, begun, times)?;
        let begun = Instant::now();
        let result = (first.take(device, &submission)?, offset.take(device, &submission)?);
        if let Some(times) = times {
            times.copies.fetched += 4 * (result.0.len() + result.1.len()) as u64;
            times.copies.unpack += nanoseconds(begun);
        }
        Ok(result)
    }

    /// Records first plane and first slot of every triangle.
    pub(super) fn record_count(
        &mut self,
        device: &Device,
        recording: &mut Recording,
        mesh: &GpuMesh,
        planes: u32,
    ) -> Result<(), GpuError> {
        let triangles = mesh.triangles();
        self.first.resize(device, triangles)?;
        self.count.resize(device, triangles)?;
        self.offset.resize(device, triangles + 1)?;
        for piece in &mesh.pieces {
            let sizes = SliceSizes {
                triangles: piece.range.len() as u32,
                planes,
                piece: piece.range.start as u32,
                ..SliceSizes::default()
            };
            let vertices = &mesh.vertices[piece.vertices];
            recording.dispatch(
                &SLICE_COUNT,
                &sizes,
                &[vertices, &piece.triangles, &self.planes, &self.first, &self.count],
                piece.range.len() as u64,
            )?;
        }
        scan::record(device, recording, &mut self.scratch, &self.count, &self.offset)
    }

    /// Start and successor of every segment, in as many parts as bindings ask for.
    fn emit(
        &mut self,
        device: &Device,
        mesh: &GpuMesh,
        planes: u32,
        first: Vec<u32>,
        offset: Vec<u32>,
        times: &mut Option<Times>,
    ) -> Result<Pending, GpuError> {
        let most = device.limits().binding / size_of::<Point2>() as u64;
        let mut parts = Vec::new();
        for piece in &mesh.pieces {
            parts.extend(ranges(&offset, piece.range.clone(), most)?.into_iter().map(|range| (piece, range)));
        }
        let segments = |range: &Range<usize>| offset[range.end] - offset[range.start];
        let largest = parts.iter().map(|(_, range)| segments(range)).max().unwrap_or(0) as usize;
        self.start.resize(device, largest)?;
        self.next.resize(device, largest)?;
        let even = spread_evenly(&offset);
        let begun = Instant::now();
        let mut recording = Recording::new(device, times.is_some())?;
        let mut readbacks = Vec::new();
        let single = parts.len() == 1;
        for (piece, range) in parts {
            let segments = segments(&range);
            let sizes = SliceSizes {
                triangles: range.len() as u32,
                planes,
                piece: piece.range.start as u32,
                begin: (range.start - piece.range.start) as u32,
                slot: offset[range.start],
                segments,
                padding: [0; 2],
            };
            let vertices = &mesh.vertices[piece.vertices];
            let (kernel, items) =
                if even { (SLICE_EMIT_EVEN, segments) } else { (SLICE_EMIT, sizes.triangles) };
            recording.dispatch(
                &kernel,
                &sizes,
                &[
                    vertices,
                    &piece.triangles,
                    &self.planes,
                    &piece.twin,
                    &self.first,
                    &self.offset,
                    &self.start,
                    &self.next,
                ],
                if segments == 0 { 0 } else { items.into() },
            )?;
            // The next part's kernel overwrites the arrays after this copy, in the order of recording.
            if !single {
                let part = 0..segments as usize;
                let start = recording.read_back_part(&self.start, part.clone())?;
                readbacks.push((start, recording.read_back_part(&self.next, part)?));
            }
        }
        let mut recording = kernels_alone(device, recording, begun, times)?;
        let begun = Instant::now();
        if single {
            readbacks.push((recording.read_back(&self.start)?, recording.read_back(&self.next)?));
        }
        let submission = recording.submit()?;
        copies_alone(device, &submission, begun, times)?;
        Ok(Pending { first, offset, submission, parts: readbacks })
    }
}

impl Pending {
    /// Waits for the segments.
    pub(super) fn finish(self, device: &Device, times: &mut Option<Times>) -> Result<Segments, GpuError> {
        let begun = Instant::now();
        let Self { first, offset, submission, parts } = self;
        let total = offset.last().copied().unwrap_or(0) as usize;
        let (mut start, mut next) = (Vec::with_capacity(total), Vec::with_capacity(total));
        for (starts, nexts) in parts {
            starts.take_into(device, &submission, &mut start)?;
            nexts.take_into(device, &submission, &mut next)?;
        }
        if let Some(times) = times {
            times.copies.fetched += 12 * total as u64;
            times.copies.unpack += nanoseconds(begun);
        }
        Ok(Segments { first, offset, start, next })
    }
}

/// Runs what is recorded when times are asked for, so that they are those of the kernels alone.
pub(super) fn kernels_alone<'d>(
    device: &'d Device,
    recording: Recording<'d>,
    begun: Instant,
    times: &mut Option<Times>,
) -> Result<Recording<'d>, GpuError> {
    let Some(times) = times else { return Ok(recording) };
    let mut submission = recording.submit()?;
    times.copies.encode += nanoseconds(begun);
    let begun = Instant::now();
    submission.wait(device)?;
    times.copies.wait += nanoseconds(begun);
    times.kernels.extend(submission.times(device)?);
    Recording::new(device, false)
}

/// Waits for copies when times are asked for.
fn copies_alone(
    device: &Device,
    submission: &Submission,
    begun: Instant,
    times: &mut Option<Times>,
) -> Result<(), GpuError> {
    let Some(times) = times else { return Ok(()) };
    submission.wait(device)?;
    times.copies.fetch += nanoseconds(begun);
    Ok(())
}

/// Cuts the triangles of a piece into ranges of at most `most` segments each.
fn ranges(offset: &[u32], piece: Range<usize>, most: u64) -> Result<Vec<Range<usize>>, GpuError> {
    let mut ranges = Vec::new();
    let mut from = piece.start;
    while from < piece.end {
        let reach = u64::from(offset[from]) + most;
        let later = &offset[from + 1..=piece.end];
        let end = from + later.partition_point(|&o| u64::from(o) <= reach);
        if end == from {
            let needs = u64::from(offset[from + 1] - offset[from]);
            let (what, unit) = ("a triangle", "segments");
            return Err(GpuError::TooLarge { what, unit, needs, limit: most });
        }
        ranges.push(from..end);
        from = end;
    }
    Ok(ranges)
}

/// Whether an invocation per segment serves better than one per triangle: where triangles meet many
/// planes, or where those that run in step meet so different numbers of planes that more than half of
/// their steps would be idle.
fn spread_evenly(offset: &[u32]) -> bool {
    let total = u64::from(offset.last().copied().unwrap_or(0));
    let (mut meeting, mut steps) = (0u64, 0u64);
    let mut from = 0;
    while from + 1 < offset.len() {
        let end = (from + IN_STEP).min(offset.len() - 1);
        let mut most = 0;
        for pair in offset[from..=end].windows(2) {
            let count = pair[1] - pair[0];
            meeting += u64::from(count > 0);
            most = most.max(count);
        }
        // A step takes as long for one invocation as for all that run in step.
        steps += u64::from(most) * IN_STEP as u64;
        from = end;
    }
    // With fewer than four planes each, finding a segment's triangle costs what idle steps do.
    let work = total.max(4 * meeting);
    meeting > 0 && (total >= MANY_PLANES * meeting || steps > 2 * work)
}

/// The total that 32-bit offsets stand for, also when they have wrapped: one triangle has fewer than
/// 2^32 segments, so an offset below its predecessor has wrapped exactly once more.
fn exact_total(offset: &[u32]) -> u64 {
    let wraps = offset.windows(2).filter(|pair| pair[1] < pair[0]).count() as u64;
    (wraps << 32) + u64::from(offset.last().copied().unwrap_or(0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_keep_the_limit() {
        let offset = [0, 3, 3, 7, 12, 12];
        assert_eq!(ranges(&offset, 0..5, 5), Ok(vec![0..2, 2..3, 3..5]));
        assert_eq!(ranges(&offset, 2..4, 5), Ok(vec![2..3, 3..4]));
        assert!(matches!(ranges(&offset, 0..5, 4), Err(GpuError::TooLarge { needs: 5, limit: 4, .. })));
    }

    #[test]
    fn many_planes_and_uneven_counts_go_by_segments() {
        let offsets = |counts: &[u32]| crate::slice::cpu::scan(counts);
        assert!(!spread_evenly(&offsets(&[])));
        assert!(!spread_evenly(&offsets(&[0; 100])));
        assert!(!spread_evenly(&offsets(&[2; 100])));
        assert!(!spread_evenly(&offsets(&[0, 1, 1, 0].repeat(50))), "few planes are no matter");
        assert!(spread_evenly(&offsets(&[16; 100])));
        let mut uneven = [4; 64];
        uneven[9] = 40;
        uneven[50] = 30;
        assert!(spread_evenly(&offsets(&uneven)));
    }

    #[test]
    fn the_exact_total_sees_every_wrap() {
        assert_eq!(exact_total(&[0]), 0);
        assert_eq!(exact_total(&[0, 3, 3, 7]), 7);
        let most = u32::MAX;
        assert_eq!(exact_total(&[0, most, most.wrapping_add(most), 2]), 2 * u64::from(u32::MAX) + 4);
    }
}
