//! An open device: its limits, its faults, its watchdog.

use super::adapter::{self, Adapter, AdapterInfo, Selection};
use super::error::GpuError;
use super::kernel::Pipelines;
use crate::shaders::GROUP_SIZE;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// No binding is ever larger \[bytes\]: offsets inside one stay below 2^31 on every driver.
const LARGEST_BINDING: u64 = (1 << 31) - 256;

/// Storage buffers that the largest kernel sees.
const STORAGE_BUFFERS: u32 = 8;

/// How a device is opened. Tests lower the limits to reach the far side of each.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// At most so many workgroups per dimension of a dispatch.
    pub groups_per_dimension: u32,
    /// No binding and no buffer above this \[bytes\].
    pub largest_binding: u64,
    /// How long one submission may take before the device counts as hung.
    pub watchdog: Duration,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            groups_per_dimension: u32::MAX,
            largest_binding: LARGEST_BINDING,
            // A software device may compute for long; nothing takes minutes.
            watchdog: Duration::from_secs(300),
        }
    }
}

/// What an open device takes, all options considered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest buffer that a kernel can see as a whole \[bytes\].
    pub binding: u64,
    /// Workgroups per dimension of a dispatch.
    pub groups_per_dimension: u32,
}

/// An open device.
pub struct Device {
    pub(super) raw: wgpu::Device,
    pub(super) queue: wgpu::Queue,
    pub(super) pipelines: Pipelines,
    info: AdapterInfo,
    limits: Limits,
    watchdog: Duration,
    fault: Arc<Mutex<Option<GpuError>>>,
}

impl Device {
    /// Finds and opens a device.
    ///
    /// # Errors
    /// As [`adapter::choose`] and [`Self::with_options`].
    pub fn open(selection: &Selection) -> Result<Self, GpuError> {
        Self::with_options(&adapter::choose(selection)?, Options::default())
    }

    /// Opens a device with exactly the limits that the kernels need, as far as the adapter offers them.
    ///
    /// # Errors
    /// [`GpuError::Unsuitable`] when it offers too little, [`GpuError::Open`] when the driver refuses.
    pub fn with_options(adapter: &Adapter, options: Options) -> Result<Self, GpuError> {
        let info = adapter.info.clone();
        let required_limits = required(&info)?;
        let mut required_features = wgpu::Features::empty();
        required_features.set(wgpu::Features::TIMESTAMP_QUERY, info.timestamps);
        let limits = Limits {
            binding: required_limits.max_storage_buffer_binding_size.min(options.largest_binding) / 16 * 16,
            groups_per_dimension: required_limits
                .max_compute_workgroups_per_dimension
                .min(options.groups_per_dimension),
        };
        let descriptor = wgpu::DeviceDescriptor {
            label: None,
            required_features,
            required_limits,
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            trace: wgpu::Trace::Off,
        };
        let (raw, queue) = pollster::block_on(adapter.raw.request_device(&descriptor))
            .map_err(|e| GpuError::Open { adapter: info.name.clone(), reason: e.to_string() })?;
        let fault = Arc::new(Mutex::new(None));
        let keep = |fault: &Mutex<Option<GpuError>>, error| {
            // The first fault is the cause, those after it are consequences.
            fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
        };
        let slot = Arc::clone(&fault);
        raw.on_uncaptured_error(Arc::new(move |error: wgpu::Error| keep(&slot, error.into())));
        let slot = Arc::clone(&fault);
        raw.set_device_lost_callback(move |_, reason| keep(&slot, GpuError::Lost(reason)));
        let pipelines = Pipelines::default();
        Ok(Self { raw, queue, pipelines, info, limits, watchdog: options.watchdog, fault })
    }

    /// What is known of the device.
    pub const fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// What the device takes.
    pub const fn limits(&self) -> Limits {
        self.limits
    }

    /// Gives the device up: whatever is done with it from now on fails with [`GpuError::Lost`], as if it
    /// had been unplugged. For trying out what a caller does then.
    pub fn lose(&self) {
        self.raw.destroy();
    }

    /// Runs calls to the driver and turns whatever they report into a result.
    pub(super) fn guarded<T>(&self, calls: impl FnOnce() -> T) -> Result<T, GpuError> {
        self.fault()?;
        let validation = self.raw.push_error_scope(wgpu::ErrorFilter::Validation);
        let internal = self.raw.push_error_scope(wgpu::ErrorFilter::Internal);
        let memory = self.raw.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let result = calls();
        let memory = pollster::block_on(memory.pop());
        let internal = pollster::block_on(internal.pop());
        let validation = pollster::block_on(validation.pop());
        self.fault()?;
        match memory.or(internal).or(validation) {
            Some(error) => {
                // On a lost device calls fail for strange reasons; the true one arrives with a poll.
                self.poll(wgpu::PollType::Poll);
                self.fault()?;
                Err(error.into())
            }
            None => Ok(result),
        }
    }

    /// Waits until a submission is done.
    pub(super) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), GpuError> {
        self.fault()?;
        let poll = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(self.watchdog) };
        let polled = self.poll(poll);
        self.fault()?;
        match polled {
            Some(Ok(_)) => Ok(()),
            Some(Err(wgpu::PollError::Timeout)) => {
                Err(GpuError::Timeout { seconds: self.watchdog.as_secs() })
            }
            Some(Err(error)) => Err(GpuError::Internal(error.to_string())),
            None => Err(GpuError::Lost("while waiting for it".to_owned())),
        }
    }

    /// Lets wgpu deliver what has happened. `None` when the device was lost meanwhile: wgpu has no other
    /// way than a panic to say so here.
    fn poll(&self, poll: wgpu::PollType) -> Option<Result<wgpu::PollStatus, wgpu::PollError>> {
        catch_unwind(AssertUnwindSafe(|| self.raw.poll(poll))).ok()
    }

    fn fault(&self) -> Result<(), GpuError> {
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner);
        fault.clone().map_or(Ok(()), Err)
    }
}

/// The limits to ask for. A device has exactly these, so all that is not needed stays at the floor.
fn required(info: &AdapterInfo) -> Result<wgpu::Limits, GpuError> {
    let at_least = |limit, has: u64, needs: u64| {
        if has >= needs {
            Ok(())
        } else {
            Err(GpuError::Unsuitable { adapter: info.name.clone(), limit, has, needs })
        }
    };
    let has = &info.limits;
    at_least("storage buffers per kernel", has.storage_buffers.into(), STORAGE_BUFFERS.into())?;
    at_least("invocations per workgroup", has.invocations_per_group.into(), GROUP_SIZE.into())?;
    at_least("workgroups per dimension", has.groups_per_dimension.into(), 3)?;
    at_least("bytes per storage binding", has.storage_binding.min(has.buffer), 1 << 20)?;
    let mut limits = wgpu::Limits::downlevel_webgl2_defaults();
    let binding = has.storage_binding.min(has.buffer).min(LARGEST_BINDING) / 16 * 16;
    limits.max_buffer_size = binding;
    limits.max_storage_buffer_binding_size = binding;
    limits.max_storage_buffers_per_shader_stage = STORAGE_BUFFERS;
    limits.max_compute_workgroup_storage_size = 4 * GROUP_SIZE;
    limits.max_compute_invocations_per_workgroup = GROUP_SIZE;
    limits.max_compute_workgroup_size_x = GROUP_SIZE;
    limits.max_compute_workgroup_size_y = 1;
    limits.max_compute_workgroup_size_z = 1;
    limits.max_compute_workgroups_per_dimension = has.groups_per_dimension;
    Ok(limits)
}
