//! What is supported, and what it costs.
