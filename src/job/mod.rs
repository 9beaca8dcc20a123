//! Where the stages are chained.
