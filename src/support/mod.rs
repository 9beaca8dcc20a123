//! Overhangs, supports and adhesion.
