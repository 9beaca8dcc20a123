//! Typed settings per stage, under PrusaSlicer's names, in PrusaSlicer's units and with its defaults.
//!
//! [`types`] holds the values, [`keys`] the one table from which parsing, range checks, command-line
//! flags, the reference in `docs/SETTINGS.md` and the G-code's config block are made, [`load_file`] reads
//! TOML and PrusaSlicer's `.ini`, and [`Settings::validate`] checks values against each other.

mod assign;
pub mod flow;
pub mod foreign;
mod ini;
pub mod keys;
pub mod kind;
mod list;
mod load;
mod suggest;
mod toml;
pub mod types;
mod validate;
mod value;

pub use assign::{Assigned, ValueError, Warning};
pub use keys::{KEYS, Key};
pub use kind::{Kind, Stage};
pub use list::{reference, terminal_list};
pub use load::{LoadReport, SettingsError, load_bytes, load_file};
pub use types::*;
pub use validate::Invalid;

#[cfg(test)]
mod tests;
