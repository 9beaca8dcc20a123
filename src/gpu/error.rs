//! What can go wrong with a device, one line each. That the CPU could do the work goes without saying
//! here; who asked for a device says it.

use thiserror::Error;

/// A failure of a device or of its use.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum GpuError {
    /// No adapter is a hardware GPU, so automatic choice takes none.
    #[error(
        "no hardware GPU found (present: {present}); name a device with --adapter to take it all the same"
    )]
    NoHardware {
        /// Names of all adapters, or "none".
        present: String,
    },
    /// No adapter has the name asked for.
    #[error("no GPU has '{wanted}' in its name (present: {present})")]
    NoSuchAdapter {
        /// The part of a name that was asked for.
        wanted: String,
        /// Names of all adapters, or "none".
        present: String,
    },
    /// The adapter offers less than the kernels need.
    #[error("{adapter}: {limit} is {has}, the kernels need {needs}")]
    Unsuitable {
        /// The adapter's name.
        adapter: String,
        /// The limit that is too low.
        limit: &'static str,
        /// What the adapter has.
        has: u64,
        /// What the kernels need.
        needs: u64,
    },
    /// The driver refused to open the device.
    #[error("{adapter}: cannot open the device: {reason}")]
    Open {
        /// The adapter's name.
        adapter: String,
        /// The driver's words.
        reason: String,
    },
    /// Something is larger than the device takes; checked before anything is allocated.
    #[error("{what}: {needs} {unit}, but the device takes at most {limit}")]
    TooLarge {
        /// What is too large.
        what: &'static str,
        /// In what it is counted.
        unit: &'static str,
        /// What it needs.
        needs: u64,
        /// What the device takes.
        limit: u64,
    },
    /// The memory that slicing may take does not suffice; checked before anything is allocated.
    #[error("{what} on the device takes {needs} bytes, more than the {budget} allowed; raise --memory")]
    Budget {
        /// What needs the memory.
        what: &'static str,
        /// What it needs \[bytes\].
        needs: u64,
        /// What is allowed \[bytes\].
        budget: u64,
    },
    /// The device ran out of memory.
    #[error("out of device memory: {0}; a smaller --memory may help")]
    OutOfMemory(String),
    /// A call was refused as invalid: an error in this program.
    #[error("the device refused a call, please report this: {0}")]
    Validation(String),
    /// The driver failed inside.
    #[error("the device failed inside: {0}")]
    Internal(String),
    /// The device was lost, for example unplugged or reset.
    #[error("the device was lost: {0}")]
    Lost(String),
    /// The device did not finish within the watchdog's time.
    #[error("the device did not finish within {seconds} s")]
    Timeout {
        /// The watchdog's time \[s\].
        seconds: u64,
    },
}

impl GpuError {
    /// Whether another try may succeed: a device that failed on the way, not one that is missing or too small.
    pub const fn may_pass(&self) -> bool {
        match self {
            Self::NoHardware { .. }
            | Self::NoSuchAdapter { .. }
            | Self::Unsuitable { .. }
            | Self::TooLarge { .. }
            | Self::Budget { .. } => false,
            Self::Open { .. }
            | Self::OutOfMemory(_)
            | Self::Validation(_)
            | Self::Internal(_)
            | Self::Lost(_)
            | Self::Timeout { .. } => true,
        }
    }
}

impl From<wgpu::Error> for GpuError {
    fn from(error: wgpu::Error) -> Self {
        // wgpu's texts run over several lines; ours are one line each.
        let line = |text: String| text.split_whitespace().collect::<Vec<_>>().join(" ");
        match error {
            wgpu::Error::OutOfMemory { source } => Self::OutOfMemory(line(source.to_string())),
            wgpu::Error::Validation { description, .. } => Self::Validation(line(description)),
            wgpu::Error::Internal { description, .. } => Self::Internal(line(description)),
        }
    }
}
