//! Recording kernels and copies, running them, and reading back.

use super::buffer::{Buffer, Staging, allocate};
use super::timing::{KernelTime, Pending, Stamps};
use super::{Device, GpuError};
use crate::shaders::{GROUP_SIZE, Kernel};
use bytemuck::Pod;
use std::marker::PhantomData;
use std::ops::Range;
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
    /// Uniforms of the dispatches, handed back for reuse once submitted.
    uniforms: Vec<wgpu::Buffer>,
}

/// Bytes of every uniform buffer; no kernel's sizes take more.
const UNIFORM: u64 = 128;

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
        Ok(Self { device, encoder, stamps, uniforms: Vec::new() })
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
        let kept = device.uniforms.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let uniform = match kept {
            Some(kept) => kept,
            None => {
                let usage = wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST;
                allocate(device, "uniform", UNIFORM, usage)?
            }
        };
        // Held until the submission: a write happens when the next submission begins, so a uniform that
        // two dispatches of one recording shared would show both of them the later value.
        self.uniforms.push(uniform);
        let Self { encoder, stamps, uniforms, .. } = self;
        device.guarded(|| {
            let uniform = uniforms.last();
            uniform.iter().for_each(|uniform| device.queue.write_buffer(uniform, 0, bytes));
            let buffers = uniform.into_iter().chain(arrays.iter().map(|array| array.raw()));
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
        self.read_back_part(array, 0..array.len())
    }

    /// Copies a part of an array for the host to [`Readback::take`] later.
    ///
    /// # Errors
    /// As [`Self::read_back`]; [`GpuError::Validation`] when the part is not inside the array.
    pub fn read_back_part<T: Pod>(
        &mut self,
        array: &Buffer<T>,
        part: Range<usize>,
    ) -> Result<Readback<T>, GpuError> {
        if part.end > array.len() {
            return Err(GpuError::Validation(format!("{part:?} of {} elements read back", array.len())));
        }
        let size = size_of::<T>() as u64;
        let bytes = part.start as u64 * size..part.end as u64 * size;
        let kept = Staging::clone(&array.staging);
        Readback::record(self.device, &mut self.encoder, &array.raw, bytes, kept)
    }

    /// Fills an array with zeros.
    ///
    /// # Errors
    /// [`GpuError::Lost`] and the like.
    pub fn clear<T: Pod>(&mut self, array: &Buffer<T>) -> Result<(), GpuError> {
        self.device.guarded(|| self.encoder.clear_buffer(&array.raw, 0, None))
    }

    /// Hands the recording to the device.
    ///
    /// # Errors
    /// Whatever the recording did wrong: [`GpuError::Validation`], [`GpuError::OutOfMemory`].
    pub fn submit(self) -> Result<Submission, GpuError> {
        let Self { device, mut encoder, stamps, uniforms } = self;
        let times = match stamps {
            Some(stamps) => stamps.resolve(device, &mut encoder)?,
            None => None,
        };
        let index = device.guarded(|| device.queue.submit([encoder.finish()]))?;
        device.uniforms.lock().unwrap_or_else(PoisonError::into_inner).extend(uniforms);
        device.inject()?;
        Ok(Submission { index, times })
    }
}

impl Submission {
    /// Waits until it is done.
    ///
    /// # Errors
    /// [`GpuError::Timeout`], [`GpuError::Lost`] and the like.
    pub fn wait(&self, device: &Device) -> Result<(), GpuError> {
        device.wait(self.index.clone())
    }

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
    /// Records the copy of a range of a buffer's bytes, both ends multiples of 4.
    pub(super) fn record(
        device: &Device,
        encoder: &mut wgpu::CommandEncoder,
        buffer: &wgpu::Buffer,
        range: Range<u64>,
        home: Staging,
    ) -> Result<Self, GpuError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let bytes = range.end.saturating_sub(range.start);
        let kept = {
            let mut kept = home.lock().unwrap_or_else(PoisonError::into_inner);
            let found = kept.iter().position(|kept| kept.size() >= bytes);
            found.map(|i| kept.swap_remove(i)).or_else(|| {
                // What is too small now would only pile up.
                kept.clear();
                None
            })
        };
        let staging = match kept {
            Some(kept) => kept,
            None => allocate(device, "read-back", bytes, usage)?,
        };
        if bytes > 0 {
            device.guarded(|| encoder.copy_buffer_to_buffer(buffer, range.start, &staging, 0, bytes))?;
        }
        Ok(Self { staging, home, element: PhantomData, bytes })
    }

    /// Waits for the submission that fills it and takes the contents.
    ///
    /// # Errors
    /// [`GpuError::Timeout`], [`GpuError::Lost`] and the like.
    pub fn take(self, device: &Device, submission: &Submission) -> Result<Vec<T>, GpuError> {
        let mut data = Vec::new();
        self.take_into(device, submission, &mut data)?;
        Ok(data)
    }

    /// [`Self::take`], appended to what is there already.
    ///
    /// # Errors
    /// As [`Self::take`].
    pub fn take_into(
        self,
        device: &Device,
        submission: &Submission,
        data: &mut Vec<T>,
    ) -> Result<(), GpuError> {
        if self.bytes == 0 {
            return Ok(());
        }
        let slice = self.staging.slice(..self.bytes);
        let (sender, receiver) = mpsc::channel();
        // The receiver may be gone when a device is lost; nobody waits for the answer then.
        device.guarded(|| slice.map_async(wgpu::MapMode::Read, move |result| drop(sender.send(result))))?;
        device.wait(submission.index.clone())?;
        // Another thread's wait may have picked up this answer and be about to deliver it.
        match receiver.recv_timeout(device.watchdog()) {
            Ok(Ok(())) => {}
            Ok(Err(error)) => return Err(device.cause(GpuError::Internal(error.to_string()))),
            Err(_) => return Err(GpuError::Internal("a finished buffer was not mapped".to_owned())),
        }
        let view = slice.get_mapped_range().map_err(|e| GpuError::Internal(e.to_string()))?;
        let bytes = view.get(..self.bytes as usize).unwrap_or_default();
        // Collected element by element where the mapped address is not aligned for `T`.
        match bytemuck::try_cast_slice(bytes) {
            Ok(aligned) => data.extend_from_slice(aligned),
            Err(_) => data.extend(bytes.chunks_exact(size_of::<T>()).map(bytemuck::pod_read_unaligned::<T>)),
        }
        drop(view);
        self.staging.unmap();
        self.home.lock().unwrap_or_else(PoisonError::into_inner).push(self.staging);
        Ok(())
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
