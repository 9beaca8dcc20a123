//! Where the stages are chained.

pub mod adhesion;
mod assemble;
pub mod backend;
pub mod contours;
pub mod copies;
pub mod below;
pub mod error;
pub mod filament;
pub mod mask_check;
pub mod mask_picture;
pub mod memory;
mod gcode_text;
pub mod modifiers;
pub mod open;
pub mod output;
pub mod part;
pub mod progress;
pub mod resin;
pub mod summary;
mod support_picture;
pub mod support_report;
pub mod supports;
pub mod threads;
pub mod toolpaths;
#[cfg(feature = "gpu")]
pub mod warm;

pub use error::{FailureKind, JobError};
