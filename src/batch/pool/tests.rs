//! What a worker says; the rest is tested with whole batches.
#![allow(clippy::unwrap_used)]
