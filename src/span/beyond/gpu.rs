//! What is out of reach, found on a device.

use super::super::Rows;
use super::pairs::Pairs;
use crate::gpu::dispatch::{Bind, Recording};
use crate::gpu::scan::{self, Scratch};
use crate::gpu::{Buffer, Device, GpuError};
use crate::shaders::{BEYOND_COUNT, BEYOND_FILL, BeyondSizes};

/// What [`super::beyond`] leaves of each pair of areas, span for span.
///
/// # Errors
/// [`GpuError`]: a lost or hung device, or one without room for the arrays.
pub fn beyond(device: &Device, pairs: &Pairs) -> Result<Vec<Rows>, GpuError> {
    let rows = pairs.places.len();
    let sizes = BeyondSizes { rows: rows as u32, ..BeyondSizes::default() };
    let offset = Buffer::upload(device, "the rows' offsets", &pairs.offset)?;
    let spans = Buffer::upload(device, "the spans", &pairs.spans)?;
    let places = Buffer::upload(device, "the rows' places", &pairs.places)?;
    let cover_offset = Buffer::upload(device, "the covers' offsets", &pairs.cover_offset)?;
    let cover = Buffer::upload(device, "the covers", &pairs.cover)?;
    let widths = Buffer::upload(device, "the half widths", &pairs.widths)?;
    let given: [&dyn Bind; 6] = [&offset, &spans, &places, &cover_offset, &cover, &widths];
    let counts = Buffer::<u32>::zeroed(device, "the rows' counts", rows)?;
    let sums = Buffer::<u32>::zeroed(device, "the counts' sums", rows + 1)?;
    let mut recording = Recording::new(device, false)?;
    let arrays = [&given[..], &[&counts]].concat();
    recording.dispatch(&BEYOND_COUNT, &sizes, &arrays, rows as u64)?;
    let mut scratch = Scratch::default();
    scan::record(device, &mut recording, &mut scratch, &counts, &sums)?;
    let left_offset = recording.read_back(&sums)?;
    let left_offset = left_offset.take(device, &recording.submit()?)?;
    let total = left_offset.last().map_or(0, |&total| total as usize);
    let left = Buffer::<[i32; 2]>::zeroed(device, "what is left", total)?;
    let mut recording = Recording::new(device, false)?;
    let arrays = [&given[..], &[&sums, &left]].concat();
    recording.dispatch(&BEYOND_FILL, &sizes, &arrays, rows as u64)?;
    let left = recording.read_back(&left)?;
    let left = left.take(device, &recording.submit()?)?;
    let unfit = || GpuError::Internal("the spans that are left do not fit their rows".to_owned());
    pairs.unpack(&left_offset, &left).ok_or_else(unfit)
}
