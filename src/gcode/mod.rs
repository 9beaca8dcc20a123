//! Moves → bytes.
//!
//! The file has PrusaSlicer's structure, comments and statistics, which the common hosts and viewers
//! understand. It depends on nothing but the arguments: no clock, no machine, no thread.

pub mod flavor;
pub mod number;
mod preamble;
pub mod summary;
pub mod template;
#[cfg(test)]
mod tests;
pub mod texts;
pub mod writer;

pub use summary::Summary;
pub use texts::{LayerText, Texts};
pub use writer::Writer;

use crate::path::LayerPlan;
use crate::settings::Settings;
use std::io;

/// Writes a whole file; returns what was counted on the way.
///
/// `origin` \[nm\] is added to X and Y; its third entry is not used, because layers carry their
/// height above the bed. A caller that plans and writes layer by layer uses a [`Writer`] instead.
///
/// # Errors
/// Whatever `out` returns.
pub fn write<'p>(
    out: &mut impl io::Write,
    layers: impl IntoIterator<Item = &'p LayerPlan, IntoIter: ExactSizeIterator>,
    origin: [i64; 3],
    settings: &Settings,
    texts: &Texts<'_>,
) -> io::Result<Summary> {
    let layers = layers.into_iter();
    let mut writer = Writer::new(out, layers.len(), origin, settings, texts)?;
    for layer in layers {
        writer.layer(layer)?;
    }
    writer.finish()
}
