//! Containers written, read back to equal masks, and damaged in many ways.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod nanodlp;
mod sl1;
mod stack;
mod svg;
mod zipped;
