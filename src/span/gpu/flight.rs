//! One run of planes on its way through the device.

use crate::gpu::dispatch::{Readback, Recording, Submission};
use crate::gpu::scan::{self, Scratch};
use crate::gpu::timing::KernelTime;
use crate::gpu::{Buffer, Device, GpuError};
use crate::shaders::{SPAN_COMPACT, SPAN_COUNT, SPAN_FILL, SPAN_SORT, SpanSizes};
use crate::slice::Segments;
use crate::slice::gpu::{GpuMesh, ResidentSegments};
use crate::span::window::REACH;
use crate::span::{RowWindow, Rows, Span};
use rayon::prelude::*;

/// Memory of a run \[bytes\], on the device and at the host.
pub(super) const fn bytes(segments: u64, rows: u64, crossings: u64) -> u64 {
    // Count, bucket and offset.
    let per_segment = ResidentSegments::BYTES_PER_SEGMENT + 12;
    // Steps, counts, offsets; the last once more where the host reads them, as it does, and in its rows.
    let per_row = 12 + 12;
    // Keys and, half as many and twice as long, spans; these in the same three places.
    let per_crossing = 8 + 12;
    segments
        .saturating_mul(per_segment)
        .saturating_add(rows.saturating_mul(per_row))
        .saturating_add(crossings.saturating_mul(per_crossing))
}

/// What a run is made from.
pub(super) struct Work<'a> {
    pub source: Source<'a>,
    /// How many planes there are.
    pub planes: usize,
    /// How many segments the planes have.
    pub segments: u64,
    pub window: &'a RowWindow,
    /// Memory that the run may take \[bytes\].
    pub share: u64,
}

/// Where segments come from.
pub(super) enum Source<'a> {
    /// A mesh, cut at planes.
    Mesh(&'a GpuMesh, &'a [i32]),
    /// The host, one to a triangle.
    Host(Segments),
}

/// The arrays of one run.
pub(super) struct Flight {
    segments: ResidentSegments,
    /// Per segment its crossings, the bucket of the lowest, and the crossings before it.
    count: Buffer<u32>,
    bucket: Buffer<u32>,
    offset: Buffer<u32>,
    /// Differences of the buckets' counts; in the end the spans of each row.
    steps: Buffer<u32>,
    /// The buckets' counts; in the end the spans before each row.
    row_count: Buffer<u32>,
    row_offset: Buffer<u32>,
    totals: Buffer<u32>,
    keys: Buffer<u32>,
    spans: Buffer<[i32; 2]>,
    segment_scratch: Scratch,
    row_scratch: Scratch,
}

/// A run whose spans are being computed or are on their way back.
pub(super) struct Pending {
    sent: Sent,
    /// Per plane its open segments.
    open: Vec<u32>,
    first: i32,
    rows: usize,
}

/// Spans on their way back, and per row those before it.
struct Sent {
    submission: Submission,
    offset: Readback<u32>,
    spans: Readback<[i32; 2]>,
}

impl Flight {
    /// Bytes of device memory.
    pub(super) fn held(&self) -> u64 {
        let numbers = [
            &self.count,
            &self.bucket,
            &self.offset,
            &self.steps,
            &self.row_count,
            &self.row_offset,
            &self.keys,
        ];
        self.segments.held() + self.spans.held() + numbers.map(Buffer::held).iter().sum::<u64>()
    }

    pub(super) fn new(device: &Device) -> Result<Self, GpuError> {
        let array = |what| Buffer::zeroed(device, what, 0);
        Ok(Self {
            segments: ResidentSegments::new(device)?,
            count: array("the segments' crossings")?,
            bucket: array("the segments' rows")?,
            offset: array("the crossings' offsets")?,
            steps: array("the rows' steps")?,
            row_count: array("the rows' counts")?,
            row_offset: array("the rows' offsets")?,
            totals: array("the totals")?,
            keys: array("the crossings")?,
            spans: Buffer::zeroed(device, "the spans", 0)?,
            segment_scratch: Scratch::default(),
            row_scratch: Scratch::default(),
        })
    }

    /// Slices and counts, waits for the exact number of crossings, and sends the kernels that make spans
    /// of them on their way. `density` becomes the crossings per segment that were found.
    pub(super) fn begin(
        &mut self,
        device: &Device,
        work: &Work<'_>,
        density: &mut u64,
        times: &mut Option<Vec<KernelTime>>,
    ) -> Result<Pending, GpuError> {
        let rows = work.planes as u64 * u64::from(work.window.rows());
        let needs = bytes(work.segments, rows, 0);
        if needs > work.share {
            return Err(GpuError::Budget { what: "a run of planes", needs, budget: work.share });
        }
        let sizes = self.sizes(device, work, rows)?;
        let totals = self.count(device, work, &sizes, times)?;
        let word = |i: usize| totals.get(i).copied().unwrap_or(0);
        let crossings = u64::from(word(1)) << 32 | u64::from(word(0));
        *density = crossings.div_ceil(work.segments.max(1)).max(1);
        if word(2) != 0 {
            let (what, unit) = ("rows along a diagonal", "units from the centre");
            return Err(GpuError::TooLarge {
                what,
                unit,
                needs: word(2).into(),
                limit: u64::from(REACH) - 1,
            });
        }
        let needs = bytes(work.segments, rows, crossings);
        if needs > work.share {
            return Err(GpuError::Budget { what: "a run of planes", needs, budget: work.share });
        }
        let limit = device.limits().binding / 4;
        if crossings > limit {
            return Err(GpuError::TooLarge { what: "the rows", unit: "crossings", needs: crossings, limit });
        }
        let sizes = SpanSizes { crossings: crossings as u32, ..sizes };
        let sent = self.make(device, &sizes, times.is_some())?;
        let open = totals.get(4..).unwrap_or_default().to_vec();
        let (first, rows) = (work.window.first(), work.window.rows() as usize);
        Ok(Pending { sent, open, first, rows })
    }

    /// Makes room for everything but the crossings.
    fn sizes(&mut self, device: &Device, work: &Work<'_>, rows: u64) -> Result<SpanSizes, GpuError> {
        let limit = device.limits().binding;
        let largest = (4 * (rows + 2)).max(8 * work.segments);
        if largest > limit {
            return Err(GpuError::TooLarge { what: "a run of planes", unit: "bytes", needs: largest, limit });
        }
        let (segments, rows) = (work.segments as usize, rows as usize);
        self.count.resize(device, segments)?;
        self.bucket.resize(device, segments)?;
        self.offset.resize(device, segments + 1)?;
        self.steps.resize(device, rows + 1)?;
        self.row_count.resize(device, rows + 2)?;
        self.row_offset.resize(device, rows + 2)?;
        self.totals.resize(device, 4 + work.planes)?;
        Ok(SpanSizes {
            planes: work.planes as u32,
            triangles: match &work.source {
                Source::Mesh(mesh, _) => mesh.triangles() as u32,
                Source::Host(segments) => segments.first.len() as u32,
            },
            segments: segments as u32,
            ..work.window.sizes()
        })
    }

    /// The totals of a run; its segments and counts stay on the device.
    fn count(
        &mut self,
        device: &Device,
        work: &Work<'_>,
        sizes: &SpanSizes,
        times: &mut Option<Vec<KernelTime>>,
    ) -> Result<Vec<u32>, GpuError> {
        let mut recording = Recording::new(device, times.is_some())?;
        let total = match &work.source {
            Source::Mesh(mesh, planes) => {
                let total = sizes.segments as usize;
                Some(self.segments.record(device, &mut recording, mesh, planes, total)?)
            }
            Source::Host(segments) => {
                self.segments.replace(device, segments)?;
                None
            }
        };
        recording.clear(&self.steps)?;
        recording.clear(&self.totals)?;
        recording.dispatch(
            &SPAN_COUNT,
            sizes,
            &[
                self.segments.start(),
                self.segments.next(),
                self.segments.first(),
                self.segments.offset(),
                &self.count,
                &self.bucket,
                &self.steps,
                &self.totals,
            ],
            sizes.segments.into(),
        )?;
        scan::record(device, &mut recording, &mut self.segment_scratch, &self.count, &self.offset)?;
        scan::record(device, &mut recording, &mut self.row_scratch, &self.steps, &self.row_count)?;
        scan::record(device, &mut recording, &mut self.row_scratch, &self.row_count, &self.row_offset)?;
        let totals = recording.read_back(&self.totals)?;
        let mut submission = recording.submit()?;
        let total = total.map(|total| total.take(device, &submission)).transpose()?;
        let totals = totals.take(device, &submission)?;
        if let Some(times) = times {
            times.extend(submission.times(device)?);
        }
        if let Some(total) = total
            && total != [sizes.segments]
        {
            let message = format!("{total:?} segments where {} were expected", sizes.segments);
            return Err(GpuError::Validation(message));
        }
        Ok(totals)
    }

    /// Crossings into their buckets, spans of them, and the spans on their way back.
    fn make(&mut self, device: &Device, sizes: &SpanSizes, timed: bool) -> Result<Sent, GpuError> {
        let crossings = sizes.crossings as usize;
        let rows = self.steps.len() - 1;
        self.keys.resize(device, crossings)?;
        // A span has two crossings or more.
        self.spans.resize(device, crossings / 2)?;
        let mut recording = Recording::new(device, timed)?;
        recording.dispatch(
            &SPAN_FILL,
            sizes,
            &[
                self.segments.start(),
                self.segments.next(),
                &self.offset,
                &self.bucket,
                &self.row_offset,
                &self.row_count,
                &self.keys,
            ],
            crossings as u64,
        )?;
        recording.dispatch(&SPAN_SORT, sizes, &[&self.row_offset, &self.keys, &self.steps], rows as u64)?;
        scan::record(device, &mut recording, &mut self.row_scratch, &self.steps, &self.row_count)?;
        recording.dispatch(
            &SPAN_COMPACT,
            sizes,
            &[&self.row_offset, &self.keys, &self.row_count, &self.spans],
            rows as u64,
        )?;
        // All spans at once rather than a round trip for their number: without overlaps it is exact.
        let offset = recording.read_back_part(&self.row_count, 0..rows + 1)?;
        let spans = recording.read_back(&self.spans)?;
        Ok(Sent { submission: recording.submit()?, offset, spans })
    }
}

impl Pending {
    /// Waits for the spans; the rows of each plane, `None` for one with open segments.
    pub(super) fn finish(
        self,
        device: &Device,
        times: &mut Option<Vec<KernelTime>>,
    ) -> Result<Vec<Option<Rows>>, GpuError> {
        let Self { sent, open, first, rows } = self;
        let Sent { mut submission, offset, spans } = sent;
        let offset = offset.take(device, &submission)?;
        let spans = spans.take(device, &submission)?;
        if let Some(times) = times {
            times.extend(submission.times(device)?);
        }
        let plane = |(k, &open): (usize, &u32)| {
            if open > 0 {
                return Ok(None);
            }
            rows_of(first, offset.get(k * rows..=(k + 1) * rows), &spans)
                .map(Some)
                .ok_or_else(|| GpuError::Internal("the spans do not fit their rows".to_owned()))
        };
        open.par_iter().enumerate().map(plane).collect()
    }
}

/// The rows of one plane, from where its spans lie among those of the run.
fn rows_of(first: i32, offset: Option<&[u32]>, spans: &[[i32; 2]]) -> Option<Rows> {
    let offset = offset?;
    let range = *offset.first()? as usize..*offset.last()? as usize;
    let spans = spans.get(range)?.iter().map(|&[start, end]| Span { start, end }).collect();
    Rows::from_parts(first, offset, spans)
}
