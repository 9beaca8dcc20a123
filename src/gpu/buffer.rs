//! Arrays in device memory.

use super::{Device, GpuError};
use bytemuck::Pod;
use std::marker::PhantomData;
use std::sync::{Arc, Mutex};

/// A binding is never empty, and its size is a multiple of every element's \[bytes\].
const SMALLEST: u64 = 16;

/// An array of `T` in device memory, visible to kernels as a whole.
pub struct Buffer<T> {
    pub(super) raw: wgpu::Buffer,
    what: &'static str,
    len: usize,
    element: PhantomData<T>,
    /// Host-visible memory for reading back, kept from one time to the next.
    pub(super) staging: Staging,
}

/// Memory that wandered from an array to its [`super::dispatch::Readback`]s and back.
pub(super) type Staging = Arc<Mutex<Vec<wgpu::Buffer>>>;

impl<T: Pod> Buffer<T> {
    /// A zeroed array. `what` names it in errors.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when it exceeds one binding, [`GpuError::OutOfMemory`].
    pub fn zeroed(device: &Device, what: &'static str, len: usize) -> Result<Self, GpuError> {
        let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC | wgpu::BufferUsages::COPY_DST;
        let raw = allocate(device, what, byte_len::<T>(len), usage)?;
        Ok(Self { raw, what, len, element: PhantomData, staging: Staging::default() })
    }

    /// A copy of `data`.
    ///
    /// # Errors
    /// As [`Self::zeroed`].
    pub fn upload(device: &Device, what: &'static str, data: &[T]) -> Result<Self, GpuError> {
        let buffer = Self::zeroed(device, what, data.len())?;
        buffer.write(device, data)?;
        Ok(buffer)
    }

    /// Makes room for `len` elements; the contents are undefined afterwards. Memory is taken only when
    /// the array must grow.
    ///
    /// # Errors
    /// As [`Self::zeroed`].
    pub fn resize(&mut self, device: &Device, len: usize) -> Result<(), GpuError> {
        if byte_len::<T>(len) > self.raw.size() {
            // Freed first, so that old and new never exist together; what is left if the new one cannot
            // be had is an empty array.
            let empty = Self::zeroed(device, self.what, 0)?;
            std::mem::replace(self, empty).raw.destroy();
            *self = Self::zeroed(device, self.what, len)?;
        }
        self.len = len;
        Ok(())
    }

    /// Makes the array a copy of `data`.
    ///
    /// # Errors
    /// As [`Self::zeroed`].
    pub fn replace(&mut self, device: &Device, data: &[T]) -> Result<(), GpuError> {
        self.resize(device, data.len())?;
        self.write(device, data)
    }

    /// Number of elements.
    pub const fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no elements.
    pub const fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Bytes of device memory that it holds.
    pub fn held(&self) -> u64 {
        self.raw.size()
    }

    fn write(&self, device: &Device, data: &[T]) -> Result<(), GpuError> {
        if data.is_empty() {
            return Ok(());
        }
        device.guarded(|| device.queue.write_buffer(&self.raw, 0, bytemuck::cast_slice(data)))
    }
}

/// A buffer of at least `bytes`.
pub(super) fn allocate(
    device: &Device,
    what: &'static str,
    bytes: u64,
    usage: wgpu::BufferUsages,
) -> Result<wgpu::Buffer, GpuError> {
    let limit = device.limits().binding;
    if bytes > limit {
        return Err(GpuError::TooLarge { what, unit: "bytes", needs: bytes, limit });
    }
    let size = bytes.next_multiple_of(SMALLEST).max(SMALLEST);
    let descriptor = wgpu::BufferDescriptor { label: Some(what), size, usage, mapped_at_creation: false };
    device.guarded(|| device.raw.create_buffer(&descriptor))
}

const fn byte_len<T>(len: usize) -> u64 {
    len as u64 * size_of::<T>() as u64
}
