//! A stable radix sort of 32-bit keys with 32-bit values on the device.
//!
//! Least significant digit first, four bits a pass (Knuth, TAOCP vol. 3, 5.2.5). Where a key goes follows
//! from counts alone, so the order is that of any other stable sort.

use super::buffer::Buffer;
use super::dispatch::Recording;
use super::scan::{self, Scratch};
use super::{Device, GpuError};
use crate::shaders::{GROUP_SIZE, SCAN_BLOCK_LEN, SORT_COUNT, SORT_SCATTER, SortSizes};

/// Bits per pass.
const DIGIT: u32 = 4;

/// Keys and values, and the memory that sorting them takes.
pub struct Sorter {
    keys: [Buffer<u32>; 2],
    values: [Buffer<u32>; 2],
    /// Which of the two holds the present order.
    now: usize,
    counts: Buffer<u32>,
    places: Buffer<u32>,
    scratch: Scratch,
}

impl Sorter {
    /// Room for `len` keys.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`].
    pub fn new(device: &Device, len: usize) -> Result<Self, GpuError> {
        let array = |what| Buffer::zeroed(device, what, len);
        let counts = len.div_ceil(SCAN_BLOCK_LEN as usize) << DIGIT;
        Ok(Self {
            keys: [array("the keys")?, array("the sorted keys")?],
            values: [array("the sorted values")?, array("the values")?],
            now: 0,
            counts: Buffer::zeroed(device, "the digits' counts", counts)?,
            places: Buffer::zeroed(device, "the digits' places", counts)?,
            scratch: Scratch::default(),
        })
    }

    /// The keys in their present order.
    pub const fn keys(&self) -> &Buffer<u32> {
        &self.keys[self.now]
    }

    /// The values in their present order.
    pub const fn values(&self) -> &Buffer<u32> {
        &self.values[self.now]
    }

    /// Records the sort by the lowest `bits` of the keys. Equal ones keep their order.
    ///
    /// # Errors
    /// As [`Self::new`].
    pub fn record(&mut self, device: &Device, recording: &mut Recording, bits: u32) -> Result<(), GpuError> {
        let length = self.keys[0].len();
        let blocks = length.div_ceil(SCAN_BLOCK_LEN as usize) as u32;
        let lanes = u64::from(blocks) * u64::from(GROUP_SIZE);
        for shift in (0..bits.min(u32::BITS)).step_by(DIGIT as usize) {
            let sizes = SortSizes { length: length as u32, shift, blocks, padding: 0 };
            let (now, next) = (self.now, 1 - self.now);
            recording.dispatch(&SORT_COUNT, &sizes, &[&self.keys[now], &self.counts], lanes)?;
            scan::record(device, recording, &mut self.scratch, &self.counts, &self.places)?;
            recording.dispatch(
                &SORT_SCATTER,
                &sizes,
                &[&self.keys[now], &self.values[now], &self.places, &self.keys[next], &self.values[next]],
                lanes,
            )?;
            self.now = next;
        }
        Ok(())
    }
}
