//! An open device: its limits, its faults, its watchdog.

use super::adapter::{self, Adapter, AdapterInfo, Selection};
use super::error::GpuError;
use super::kernel::Pipelines;
use crate::shaders::GROUP_SIZE;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

/// No binding is ever larger \[bytes\]: offsets inside one stay below 2^31 on every driver.
const LARGEST_BINDING: u64 = (1 << 31) - 256;

/// Storage buffers that the largest kernel sees.
const STORAGE_BUFFERS: u32 = 8;

/// Memory that the invocations of a workgroup share in the largest kernel \[bytes\]; every WebGPU device
/// offers 16 KiB.
const WORKGROUP_MEMORY: u32 = 36 * GROUP_SIZE;

/// How a device is opened. Tests lower the limits to reach the far side of each.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// At most so many workgroups per dimension of a dispatch.
    pub groups_per_dimension: u32,
    /// No binding and no buffer above this \[bytes\].
    pub largest_binding: u64,
    /// How long one submission may take before the device counts as hung.
    pub watchdog: Duration,
    /// A failure to play.
    pub fault: Option<Fault>,
}

/// A failure that an open device plays, for trying out what its callers do then.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fault {
    /// The submission that fails, counted from 0.
    pub submission: u32,
    /// How it fails.
    pub kind: FaultKind,
}

/// How a device fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// It never finishes.
    Timeout,
    /// It is gone, as if it had been unplugged.
    Lost,
    /// It has no memory left.
    OutOfMemory,
    /// The driver refuses a call.
    Validation,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            groups_per_dimension: u32::MAX,
            largest_binding: LARGEST_BINDING,
            // A software device may compute for long; nothing takes minutes.
            watchdog: Duration::from_secs(300),
            fault: None,
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
    planned: Option<Fault>,
    submissions: AtomicU32,
    hung: AtomicBool,
    /// Small uniform buffers that wait for their next use.
    pub(super) uniforms: Mutex<Vec<wgpu::Buffer>>,
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
        Ok(Self {
            raw,
            queue,
            pipelines: Pipelines::default(),
            info,
            limits,
            watchdog: options.watchdog,
            fault,
            planned: options.fault,
            submissions: AtomicU32::new(0),
            hung: AtomicBool::new(false),
            uniforms: Mutex::default(),
        })
    }

    /// What is known of the device.
    pub const fn info(&self) -> &AdapterInfo {
        &self.info
    }

    /// What the device takes.
    pub const fn limits(&self) -> Limits {
        self.limits
    }

    /// The memory to take when nobody says \[bytes\]: half of the largest buffer that the driver would
    /// give, and 512 MiB at least. No portable interface tells how much memory a device has.
    pub fn default_budget(&self) -> u64 {
        (self.info.limits.buffer / 2).max(512 << 20)
    }

    /// How long one submission may take.
    pub(super) const fn watchdog(&self) -> Duration {
        self.watchdog
    }

    /// Plays the planned failure when its submission is reached.
    pub(super) fn inject(&self) -> Result<(), GpuError> {
        let submission = self.submissions.fetch_add(1, Ordering::Relaxed);
        match self.planned.filter(|planned| planned.submission == submission).map(|planned| planned.kind) {
            None => Ok(()),
            Some(FaultKind::Timeout) => {
                self.hung.store(true, Ordering::Relaxed);
                Ok(())
            }
            Some(FaultKind::Lost) => {
                self.lose();
                Ok(())
            }
            Some(FaultKind::OutOfMemory) => Err(GpuError::OutOfMemory("played".to_owned())),
            Some(FaultKind::Validation) => {
                // A use that no driver allows.
                let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::STORAGE;
                let descriptor =
                    wgpu::BufferDescriptor { label: None, size: 16, usage, mapped_at_creation: false };
                self.guarded(|| drop(self.raw.create_buffer(&descriptor)))
            }
        }
    }

    /// Gives the device up: whatever is done with it from now on fails with [`GpuError::Lost`], as if it
    /// had been unplugged. For trying out what a caller does then.
    pub fn lose(&self) {
        self.raw.destroy();
    }

    /// Waits until everything written so far has arrived.
    ///
    /// # Errors
    /// [`GpuError::Timeout`], [`GpuError::Lost`] and the like.
    pub fn flush(&self) -> Result<(), GpuError> {
        let index = self.guarded(|| self.queue.submit([]))?;
        self.wait(index)
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
            Some(error) => Err(self.cause(error.into())),
            None => Ok(result),
        }
    }

    /// Waits until a submission is done.
    pub(super) fn wait(&self, submission: wgpu::SubmissionIndex) -> Result<(), GpuError> {
        self.fault()?;
        if self.hung.load(Ordering::Relaxed) {
            return Err(GpuError::Timeout { seconds: self.watchdog.as_secs() });
        }
        let poll = wgpu::PollType::Wait { submission_index: Some(submission), timeout: Some(self.watchdog) };
        let polled = self.poll(poll);
        self.fault()?;
        match polled {
            Some(Ok(_)) => Ok(()),
            Some(Err(wgpu::PollError::Timeout)) => {
                Err(GpuError::Timeout { seconds: self.watchdog.as_secs() })
            }
            Some(Err(error)) => Err(self.cause(GpuError::Internal(error.to_string()))),
            None => Err(GpuError::Lost("while waiting for it".to_owned())),
        }
    }

    /// What is behind an error: on a lost device calls fail for strange reasons, and the true one arrives
    /// with a poll, once what was under way has ended.
    pub(super) fn cause(&self, error: GpuError) -> GpuError {
        let timeout = Some(self.watchdog.min(Duration::from_secs(2)));
        for poll in [wgpu::PollType::Poll, wgpu::PollType::Wait { submission_index: None, timeout }] {
            self.poll(poll);
            if let Err(fault) = self.fault() {
                return fault;
            }
        }
        error
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
    limits.max_compute_workgroup_storage_size = WORKGROUP_MEMORY;
    limits.max_compute_invocations_per_workgroup = GROUP_SIZE;
    limits.max_compute_workgroup_size_x = GROUP_SIZE;
    limits.max_compute_workgroup_size_y = 1;
    limits.max_compute_workgroup_size_z = 1;
    limits.max_compute_workgroups_per_dimension = has.groups_per_dimension;
    Ok(limits)
}
