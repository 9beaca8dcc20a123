//! Areas and lines → ordered moves.
