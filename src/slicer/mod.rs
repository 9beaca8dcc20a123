//! Slicing for programs: one [`Slicer`] that stays warm, many [`Request`]s.
//!
//! ```
//! use microtome::job::progress::Silent;
//! use microtome::mesh::{shapes, stl_write};
//! use microtome::slicer::{Request, Slicer};
//!
//! let folder = tempfile::tempdir()?;
//! let model = folder.path().join("cube.stl");
//! let cube = shapes::cuboid([0.0; 3], [10.0, 10.0, 2.0]);
//! stl_write::write_stl_binary(&cube, &mut std::fs::File::create(&model)?)?;
//!
//! let slicer = Slicer::default();
//! let request = Request::new(&model)
//!     .output(folder.path().join("cube.gcode"))
//!     .set("layer_height", "0.2")
//!     .set("first_layer_height", "0.2");
//! let outcome = slicer.slice(&request, &Silent)?;
//! assert_eq!(outcome.layers, 10);
//! assert!(outcome.material.mm > 0.0 && outcome.bytes > 0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A job is stopped by a [`Cancel`], from any thread. The same requests, as lines of JSON, are what `microtome
//! worker` answers; see [`protocol`].

mod cancel;
pub mod files;
mod make;
pub mod outcome;
mod pools;
pub mod profiles;
pub mod protocol;
pub mod request;
pub mod serve;
pub mod usage;

pub use cancel::Cancel;
pub use outcome::{Failure, Material, Outcome};
pub use request::{Request, Technology};

use crate::job::FailureKind;
use crate::job::backend::BackendOptions;
use crate::job::progress::Progress;
use crate::job::threads::with_pool;
use pools::Pools;
use profiles::Profiles;
use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Slices models one after the other or side by side; what was costly to set up, such as a GPU, is kept, and
/// so is what settings files gave.
#[derive(Debug)]
pub struct Slicer {
    backend: BackendOptions,
    threads: Option<u16>,
    profiles: Profiles,
    pools: Pools,
}

impl Default for Slicer {
    /// On a GPU where one repays its start-up, else on the CPU.
    fn default() -> Self {
        Self::new(BackendOptions::default())
    }
}

impl Slicer {
    /// A slicer that works where the options say.
    pub fn new(backend: BackendOptions) -> Self {
        Self {
            backend: backend.kept_warm(),
            threads: None,
            profiles: Profiles::default(),
            pools: Pools::default(),
        }
    }

    /// The same, with so many CPU threads for each request that does not say otherwise; `None` = the process's
    /// pool of threads, shared by all.
    #[must_use]
    pub fn with_threads(self, threads: Option<u16>) -> Self {
        Self { threads, ..self }
    }

    /// What settings files gave, for those who must know settings before slicing.
    pub fn profiles(&self) -> &Profiles {
        &self.profiles
    }

    /// Does what is asked. Panics inside are caught; nothing is left half written. With the same request the
    /// output has the same bytes, whatever the backend and the number of threads.
    ///
    /// # Errors
    /// [`Failure`]: what went wrong, and of what kind.
    pub fn slice(&self, request: &Request, progress: &dyn Progress) -> Result<Outcome, Failure> {
        let work = || make::make(request, &self.backend, &self.profiles, progress);
        let caught = match request.threads.or(self.threads) {
            None => catch_unwind(AssertUnwindSafe(work)),
            Some(threads) => {
                let pool = self.pools.take(threads)?;
                let caught = catch_unwind(AssertUnwindSafe(|| with_pool(pool.clone(), work)));
                self.pools.give_back(pool);
                caught
            }
        };
        caught.unwrap_or_else(|panic| Err(defect(panic.as_ref())))
    }
}

/// A panic, told in one line.
fn defect(panic: &(dyn Any + Send)) -> Failure {
    let said = panic.downcast_ref::<String>().map(String::as_str);
    let said = said.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no message");
    let message = format!(
        "this is a defect of microtome, please report it with the model and its settings: {}",
        said.escape_debug()
    );
    Failure::new(FailureKind::Defect, message)
}

#[cfg(test)]
mod tests;
