//! Why a container cannot be read.

use thiserror::Error;

/// A file that is not what it should be. Names the place; the caller adds the file.
#[derive(Debug, Error)]
pub enum ReadError {
    /// The system failed.
    #[error("cannot be read: {0}; check that the file exists and that you may read it")]
    Io(#[from] std::io::Error),
    /// None of the known formats.
    #[error("is no container known here{hint}; known are {known}")]
    Foreign {
        /// What it looks like instead, beginning with a comma, or empty.
        hint: String,
        /// The formats that can be read.
        known: String,
    },
    /// It ends too early.
    #[error("{format}: ends at byte {end} within {what}; the file is truncated, write or copy it again")]
    Truncated {
        /// The format.
        format: &'static str,
        /// What was being read.
        what: String,
        /// Length of the file.
        end: u64,
    },
    /// A field contradicts the format.
    #[error("{format}: {what} is {value}, expected {expected}; the file is damaged or of another version")]
    Damaged {
        /// The format.
        format: &'static str,
        /// The field, with its layer or place.
        what: String,
        /// Its value.
        value: String,
        /// What the format asks for.
        expected: String,
    },
    /// A layer whose number is beyond the last.
    #[error("there is no layer {index}; the file has {layers}, counted from 0")]
    NoLayer {
        /// The layer asked for.
        index: u32,
        /// Number of layers.
        layers: u32,
    },
}
