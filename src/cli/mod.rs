//! The command line.

pub mod setting_flags;
