//! The closed rings of a layer to its areas.

use super::boolean::{self, Winding};
use crate::contour::nest;
use crate::contour::{ExPolygon, Ring};

/// The disjoint areas \[nm\] bounded by the directed closed rings of one layer, solid on their left.
///
/// A point is inside when the rings wind around it at least once: shells that overlap merge, a shell
/// inside a solid one vanishes, a clockwise ring alone bounds nothing. Where the rings are proven not
/// to touch, they pass unchanged; otherwise their union is computed, which drops rings below
/// [`boolean::MIN_AREA`]. The result is canonical, see [`boolean`].
pub fn areas(rings: &[Ring]) -> Vec<ExPolygon> {
    match nest::nest(rings.to_vec()) {
        Ok(polygons) => polygons,
        Err(rings) => boolean::union(&rings, Winding::Positive),
    }
}
