//! Recording kernels and copies, running them, and reading back.

use super::buffer::{Buffer, Staging, allocate};
use super::timing::{KernelTime, Pending, Stamps};
use super::{Device, GpuError};
use crate::shaders::{GROUP_SIZE, Kernel};
use bytemuck::Pod;
use std::marker::PhantomData;
use std::sync::{PoisonError, mpsc};

/// A one-dimensional row of workgroups folded into two dimensions.
///
/// Serial number of a group = `y * width + x`; the twin of this is `shaders/shared/grid.wgsl`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// Groups along x.
    pub width: u32,
    /// Groups along y.
    pub height: u32,
}

impl Grid {
    /// Folds `groups` workgroups, where a dimension takes at most `per_dimension`.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when two dimensions do not suffice, or when the serial number of an
    /// invocation would not fit 32 bits.
    pub fn fold(groups: u64, per_dimension: u32) -> Result<Self, GpuError> {
        let side = u64::from(per_dimension.max(1));
        let width = groups.min(side);
        let height = if width == 0 { 0 } else { groups.div_ceil(width) };
        // The last row may be longer than needed; its invocations must not wrap around to item 0.
        let most = (side * side).min((1 << 32) / u64::from(GROUP_SIZE));
        if height > side || width * height > most {
            let what = "a dispatch";
            return Err(GpuError::TooLarge { what, unit: "workgroups", needs: groups, limit: most });
        }
        Ok(Self { width: width as u32, height: height as u32 })
    }
}

/// Kernels and copies in the order in which they will run.
pub struct Recording<'d> {
    device: &'d Device,
    encoder: wgpu::CommandEncoder,
    stamps: Option<Stamps>,
}

/// Array contents on their way back to the host.
pub struct Readback<T> {
    staging: wgpu::Buffer,
    home: Staging,
    element: PhantomData<T>,
    bytes: u64,
}

/// What was submitted and can be waited for.
pub struct Submission {
    index: wgpu::SubmissionIndex,
    times: Option<Pending>,
}

impl<'d> Recording<'d> {
    /// An empty recording, which times its kernels if asked to and if the device has a clock.
    ///
    /// # Errors
    /// [`GpuError::Lost`], [`GpuError::OutOfMemory`] and the like.
    pub fn new(device: &'d Device, timed: bool) -> Result<Self, GpuError> {
        let descriptor = wgpu::CommandEncoderDescriptor { label: None };
        let encoder = device.guarded(|| device.raw.create_command_encoder(&descriptor))?;
        let stamps = if timed { Stamps::new(device)? } else { None };
        Ok(Self { device, encoder, stamps })
    }

    /// Runs a kernel over `items` invocations. `sizes` is its uniform, `arrays` its other bindings.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when the grid cannot hold the items; [`GpuError::Validation`] when the
    /// arrays do not match the kernel's bindings.
    pub fn dispatch<U: Pod>(
        &mut self,
        kernel: &Kernel,
        sizes: &U,
        arrays: &[&dyn Bind],
        items: u64,
    ) -> Result<(), GpuError> {
        let groups = items.div_ceil(u64::from(GROUP_SIZE));
        let grid = Grid::fold(groups, self.device.limits().groups_per_dimension)?;
        if groups == 0 {
            return Ok(());
        }
        let device = self.device;
        let pipeline = device.pipeline(kernel)?;
        let bytes = bytemuck::bytes_of(sizes);
        let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
        let uniform = allocate(device, "uniform", bytes.len() as u64, usage)?;
        let Self { encoder, stamps, .. } = self;
        device.guarded(|| {
            device.queue.write_buffer(&uniform, 0, bytes);
            let buffers = std::iter::once(&uniform).chain(arrays.iter().map(|array| array.raw()));
            let entries: Vec<_> = (0..)
                .zip(buffers)
                .map(|(binding, buffer)| wgpu::BindGroupEntry {
                    binding,
                    resource: buffer.as_entire_binding(),
                })
                .collect();
            let bindings = device.raw.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some(kernel.name),
                layout: &pipeline.layout,
                entries: &entries,
            });
            let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor {
                label: Some(kernel.name),
                timestamp_writes: stamps.as_mut().and_then(|stamps| stamps.next(kernel.name)),
            });
            pass.set_pipeline(&pipeline.raw);
            pass.set_bind_group(0, &bindings, &[]);
            pass.dispatch_workgroups(grid.width, grid.height, 1);
        })
    }

    /// Copies an array for the host to [`Readback::take`] later.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] and the like.
    pub fn read_back<T: Pod>(&mut self, array: &Buffer<T>) -> Result<Readback<T>, GpuError> {
        let kept = Staging::clone(&array.staging);
        Readback::record(self.device, &mut self.encoder, &array.raw, array.byte_len(), kept)
    }

    /// Hands the recording to the device.
    ///
    /// # Errors
    /// Whatever the recording did wrong: [`GpuError::Validation`], [`GpuError::OutOfMemory`].
    pub fn submit(self) -> Result<Submission, GpuError> {
        let Self { device, mut encoder, stamps } = self;
        let times = match stamps {
            Some(stamps) => stamps.resolve(device, &mut encoder)?,
            None => None,
        };
        let index = device.guarded(|| device.queue.submit([encoder.finish()]))?;
        Ok(Submission { index, times })
    }
}

impl Submission {
    /// What each kernel took, in the order of the dispatches; empty when nothing was timed, and
    /// when called again.
    ///
    /// # Errors
    /// As [`Readback::take`].
    pub fn times(&mut self, device: &Device) -> Result<Vec<KernelTime>, GpuError> {
        self.times.take().map_or(Ok(Vec::new()), |pending| pending.take(device, self))
    }
}

impl<T: Pod> Readback<T> {
    /// Records the copy of a buffer's first bytes.
    pub(super) fn record(
        device: &Device,
        encoder: &mut wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        bytes: u64,
        home: Staging,
    ) -> Result<Self, GpuError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let kept = home.lock().unwrap_or_else(PoisonError::into_inner).take();
        let staging = match kept.filter(|kept| kept.size() >= bytes) {
            Some(kept) => kept,
            None => allocate(device, "read-back", bytes, usage)?,
        };
        // Copies go by four bytes; every allocation is a multiple of 16.
        let copied = bytes.next_multiple_of(4);
        if copied > 0 {
            device.guarded(|| encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, copied))?;
        }
        Ok(Self { staging, home, element: PhantomData, bytes })
    }

    /// Waits for the submission that fills it and takes the contents.
    ///
    /// # Errors
    /// [`GpuError::Timeout`], [`GpuError::Lost`] and the like.
    pub fn take(self, device: &Device, submission: &Submission) -> Result<Vec<T>, GpuError> {
        if self.bytes == 0 {
            return Ok(Vec::new());
        }
        let slice = self.staging.slice(..self.bytes.next_multiple_of(4));
        let (sender, receiver) = mpsc::channel();
        // The receiver may be gone when a device is lost; nobody waits for the answer then.
        device.guarded(|| slice.map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result))))?;
        device.wait(submission.index.clone())?;
        match receiver.try_recv() {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(GpuError::Internal(error.to_string())),
            Err(_) => return Err(GpuError::Internal("a finished buffer was not mapped".to_owned())),
        }
        let view = slice.get_mapped_range().map_err(|e| GpuError::Internal(e.to_string()))?;
        let bytes = view.get(..self.bytes as usize).unwrap_or_default();
        // Collected element by element because a mapped address need not be aligned for `T`.
        let data = match bytemuck::try_cast_slice(bytes) {
            Ok(aligned) => aligned.to_vec(),
            Err(_) => bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned).collect(),
        };
        drop(view);
        self.staging.unmap();
        *self.home.lock().unwrap_or_else(PoisonError::into_inner) = Some(self.staging);
        Ok(data)
    }
}

/// Something that a kernel can be bound to: a [`Buffer`] of any element.
pub trait Bind {
    /// The buffer behind it.
    #[doc(hidden)]
    fn raw(&self) -> &wgpu::Buffer;
}

impl<T> Bind for Buffer<T> {
    fn raw(&self) -> &wgpu::Buffer {
        &self.raw
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_grid_holds_every_group_and_refuses_what_it_cannot() {
        for per_dimension in [1, 3, 65_535] {
            for groups in [0, 1, 2, 3, 4, 8, 9, 10, 65_535, 65_536, 1 << 24] {
                match Grid::fold(groups, per_dimension) {
                    Ok(Grid { width, height }) => {
                        assert!(width <= per_dimension && height <= per_dimension);
                        let held = u64::from(width) * u64::from(height);
                        assert!(held >= groups && held < groups + u64::from(width.max(1)));
                        assert!(held * 256 <= 1 << 32);
                    }
                    Err(_) => assert!(groups > u64::from(per_dimension).pow(2) || groups == 1 << 24),
                }
            }
        }
        assert_eq!(Grid::fold(65_536, 65_535), Ok(Grid { width: 65_535, height: 2 }));
        assert!(Grid::fold(u64::MAX, u32::MAX).is_err());
    }
}
