//! What a running job tells its caller, and what the caller tells it.

use super::JobError;

/// Receives news of a running job. All methods may be called from any thread.
pub trait Progress: Sync {
    /// A stage begins.
    fn stage(&self, name: &'static str);

    /// So many of all layers are written.
    fn layers(&self, _done: u64, _all: u64) {}

    /// Whether the caller wants the job to stop. It ends with [`JobError::Cancelled`] at the next
    /// occasion: between stages and between the layers that are written.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Ends a job whose caller wants it to stop.
///
/// # Errors
/// [`JobError::Cancelled`].
pub fn go_on(progress: &dyn Progress) -> Result<(), JobError> {
    if progress.cancelled() { Err(JobError::Cancelled) } else { Ok(()) }
}

/// Says nothing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Progress for Silent {
    fn stage(&self, _name: &'static str) {}
}
