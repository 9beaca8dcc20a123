//! Moves → bytes.

pub mod template;
