//! Overhangs, supports and adhesion.

pub mod skirt;
