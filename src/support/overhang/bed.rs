//! Overhangs that have nothing but the bed under them.

use super::Overhang;
use crate::span::Rows;
use crate::span::algebra::{or, sub};
use std::sync::Arc;

/// Takes away what hangs above the part; of an area that is partly above it the rest is kept.
pub fn keep_over_bed(outlines: &[Arc<Rows>], found: &mut [Overhang]) {
    let Some(last) = found.iter().rposition(|o| !o.area.is_empty()) else { return };
    let mut under = Rows::default();
    for i in 1..=last.min(outlines.len()) {
        if i < 2 || !Arc::ptr_eq(&outlines[i - 1], &outlines[i - 2]) {
            under = or(&under, &outlines[i - 1]);
        }
        if !found[i].area.is_empty() {
            found[i].area = sub(&found[i].area, &under);
        }
    }
}
