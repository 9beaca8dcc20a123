//! Slicing for programs: one [`Slicer`] that stays warm, many [`Request`]s.
//!
//! The same requests, as lines of JSON, are what `microtome worker` answers; see [`protocol`].

pub mod outcome;
pub mod protocol;
pub mod request;
pub mod serve;

pub use outcome::{Failure, Material, Outcome};
pub use request::{Request, Technology};

use crate::job::FailureKind;
use crate::job::backend::BackendOptions;
use crate::job::progress::Progress;

/// Slices models one after the other or side by side; what was costly to set up, such as a GPU, is kept.
#[derive(Debug)]
pub struct Slicer {
    backend: BackendOptions,
}

impl Slicer {
    /// A slicer that works where the options say.
    pub fn new(backend: BackendOptions) -> Self {
        Self { backend: backend.kept_warm() }
    }

    /// Does what is asked. Panics inside are caught; nothing is left half written.
    ///
    /// # Errors
    /// [`Failure`]: what went wrong, and of what kind.
    pub fn slice(&self, request: &Request, progress: &dyn Progress) -> Result<Outcome, Failure> {
        let _ = (&self.backend, request, progress);
        Err(Failure::new(FailureKind::Defect, "not yet".to_owned()))
    }
}
