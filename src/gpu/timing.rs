//! How long kernels took by the device's own clock, and copies by the host's.
//!
//! Copies are not in the kernels' figures. On a software device the device's time is CPU time.

use super::buffer::{Staging, allocate};
use super::dispatch::{Readback, Submission};
use super::{Device, GpuError};

/// Dispatches that one recording times; those beyond run untimed.
const MOST: u32 = 512;

/// What one dispatch took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KernelTime {
    /// The kernel's name.
    pub kernel: &'static str,
    /// Time between its begin and its end on the device \[ns\].
    pub nanoseconds: u64,
}

/// What the host saw of the copies and of its own part, while kernels are timed.
///
/// Timing keeps kernels and copies in submissions of their own, which costs the overlap that an untimed
/// run has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CopyTimes {
    /// Bytes sent to the device.
    pub uploaded: u64,
    /// Until they had arrived \[ns\].
    pub upload: u64,
    /// Bytes fetched from the device.
    pub fetched: u64,
    /// Until they lay in memory that the host sees \[ns\].
    pub fetch: u64,
    /// Taking them out of that memory \[ns\].
    pub unpack: u64,
    /// Recording and submitting \[ns\].
    pub encode: u64,
    /// Waiting for kernels; at least their sum \[ns\].
    pub wait: u64,
}

/// Begin and end stamps of the dispatches of one recording.
pub(super) struct Stamps {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    kernels: Vec<&'static str>,
}

/// Stamps on their way back.
pub(super) struct Pending {
    stamps: Readback<u64>,
    kernels: Vec<&'static str>,
}

impl Stamps {
    /// Room for stamps, where the device has a clock.
    pub fn new(device: &Device) -> Result<Option<Self>, GpuError> {
        if !device.info().timestamps {
            return Ok(None);
        }
        let descriptor =
            wgpu::QuerySetDescriptor { label: None, ty: wgpu::QueryType::Timestamp, count: 2 * MOST };
        let queries = device.guarded(|| device.raw.create_query_set(&descriptor))?;
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = allocate(device, "time stamps", u64::from(2 * MOST) * 8, usage)?;
        Ok(Some(Self { queries, resolved, kernels: Vec::new() }))
    }

    /// Where the next dispatch writes its stamps.
    pub fn next(&mut self, kernel: &'static str) -> Option<wgpu::ComputePassTimestampWrites<'_>> {
        let begin = 2 * self.kernels.len() as u32;
        (begin < 2 * MOST).then(|| {
            self.kernels.push(kernel);
            wgpu::ComputePassTimestampWrites {
                query_set: &self.queries,
                beginning_of_pass_write_index: Some(begin),
                end_of_pass_write_index: Some(begin + 1),
            }
        })
    }

    /// Records the way back of all stamps.
    pub fn resolve(
        self,
        device: &Device,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<Option<Pending>, GpuError> {
        let count = 2 * self.kernels.len() as u32;
        if count == 0 {
            return Ok(None);
        }
        device.guarded(|| encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0))?;
        let stamps =
            Readback::record(device, encoder, &self.resolved, 0..u64::from(count) * 8, Staging::default())?;
        Ok(Some(Pending { stamps, kernels: self.kernels }))
    }
}

impl Pending {
    /// Waits for the stamps.
    pub fn take(self, device: &Device, submission: &Submission) -> Result<Vec<KernelTime>, GpuError> {
        let period = f64::from(device.queue.get_timestamp_period());
        let stamps = self.stamps.take(device, submission)?;
        let time = |(kernel, pair): (_, &[u64])| {
            let ticks = pair[1].saturating_sub(pair[0]);
            KernelTime { kernel, nanoseconds: (ticks as f64 * period) as u64 }
        };
        Ok(self.kernels.into_iter().zip(stamps.chunks_exact(2)).map(time).collect())
    }
}
