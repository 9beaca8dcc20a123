//! Typed settings per stage, under PrusaSlicer's names, in PrusaSlicer's units and with its defaults.
//!
//! [`types`] holds the values, [`keys`] the one table from which parsing, range checks, command-line
//! flags, the reference in `docs/SETTINGS.md` and the G-code's config block are made, [`load_file`] reads
//! TOML and PrusaSlicer's `.ini`, and [`Settings::validate`] and [`Settings::validate_resin`] check values
//! against each other. [`printers`] are the presets of resin printers.

mod assign;
pub mod flow;
pub mod foreign;
mod foreign_resin;
mod ini;
pub mod keys;
mod keys_resin;
pub mod kind;
mod list;
mod load;
pub mod printers;
mod suggest;
mod toml;
pub mod types;
mod types_part;
mod types_resin;
mod types_support;
mod validate;
mod validate_resin;
mod validate_support;
mod value;

pub use assign::{Assigned, ValueError, Warning};
pub use keys::{KEYS, Key};
pub use keys_resin::RESIN_KEYS;
pub use kind::{Kind, Stage, Technology};
pub use list::{reference, terminal_list};
pub use load::{LoadReport, SettingsError, load_bytes, load_file};
pub use suggest::nearest_of;
pub use types::*;
pub use types_part::*;
pub use types_resin::*;
pub use types_support::*;
pub use validate::Invalid;

#[cfg(test)]
mod tests;
