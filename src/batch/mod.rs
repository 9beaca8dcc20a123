//! Thousands of models, unattended: worker processes, a journal, reports.
//!
//! [`run`] keeps worker processes (`microtome worker`) busy with [`Item`]s; whatever befalls one of them,
//! the others go on. What was done is in a journal in the output folder, from which a later run goes on.

mod error;
pub mod event;
pub mod inputs;
pub mod item;
pub mod journal;
pub mod key;
pub mod manifest;
pub mod names;
pub mod options;
pub mod pool;
pub mod prometheus;
pub mod report;
mod run;
pub mod schedule;
pub mod shard;
pub mod tally;

pub use error::BatchError;
pub use event::{Event, Observer, Totals};
pub use item::{Input, Item};
pub use key::Key;
pub use options::{BatchOptions, Limits};
pub use run::run;
pub use shard::Shard;

/// Name of the folder inside the output folder that holds journals and pictures.
pub const STATE_FOLDER: &str = ".microtome";
