//! Moves → bytes.
