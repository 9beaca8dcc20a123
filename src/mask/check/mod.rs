//! Checks of a stack of masks: islands, overhangs, suction cups, trapped resin, peel areas.
//!
//! Exact on the runs of the masks; nothing is ever expanded to pixels. Layers are taken apart side by
//! side ([`LayerParts`]), compared in pairs ([`Unsupported`]), and then linked in order ([`Checker`]),
//! which remembers the last layer only.
//!
//! What counts as solid: a pixel of at least the threshold grey. Solid pixels are connected across
//! edges: corners that merely touch do not hold. The background is connected across edges and corners
//! within a layer, and from layer to layer where pixels lie over each other.

pub mod checker;
pub mod findings;
mod label;
pub mod parts;
pub mod support;
mod voids;

pub use checker::{CheckLayer, CheckSettings, Checker};
pub use findings::{Fate, Fates, Findings, Island, LayerFigures, Marks, Void, Worst};
pub use parts::{Gap, LayerParts, Region};
pub use support::{Reach, Unsupported};

#[cfg(test)]
mod tests;
