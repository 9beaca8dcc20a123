//! Manifests: a job a line, as JSON or CSV.
