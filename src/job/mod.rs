//! Where the stages are chained.

pub mod output;
