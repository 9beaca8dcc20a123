//! The loop of `microtome worker`.

use super::Slicer;
use std::io::{self, BufRead, Write};

/// How a worker works.
#[derive(Clone, Debug)]
pub struct ServeOptions {
    /// Requests worked on at a time.
    pub jobs: usize,
    /// End at once, in the middle of everything, when the input ends without a `quit`: whoever employed the
    /// worker has died. Otherwise what is in hand is finished first.
    pub die_with_input: bool,
}

/// Answers lines of requests until the input ends or a `quit` comes.
///
/// # Errors
/// When the input cannot be read or the output cannot be written.
pub fn serve(
    slicer: &Slicer,
    options: &ServeOptions,
    input: impl BufRead + Send,
    output: impl Write + Send,
) -> io::Result<()> {
    let _ = (slicer, options, input, output);
    Ok(())
}
