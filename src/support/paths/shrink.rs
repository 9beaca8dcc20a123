//! Areas made smaller.

use super::outline::outlines_within;
use crate::contour::ExPolygon;
use crate::region::offset::fast_inset;
use crate::span::morph::erode_disc;
use crate::span::{RowFrame, scan};

/// Rows on which areas are made smaller are at most this far apart \[nm\],
const ROW: f64 = 75e3;
/// so that the way is a little more than a whole number of rows: it is one row more then, and half a row less by
/// what an outline adds, right on average.
const MORE: f64 = 0.02;
/// Borders are straightened by up to this \[nm\].
const TOLERANCE: f64 = 10e3;
/// What is smaller is left out \[mm²\].
const LEAST: f64 = 0.001;

/// The points of an area that are at least `distance` \[nm\] from its border: exactly, where nothing parts or
/// vanishes, else within half of [`ROW`] across the rows. That is near enough for lines of support, and takes a
/// small part of the time that exact booleans of ragged areas take.
pub fn shrink(area: &ExPolygon, distance: i64) -> Vec<ExPolygon> {
    fast_inset(area, distance).unwrap_or_else(|| on_rows(area, distance))
}

/// The same for several areas, each by itself.
pub fn shrink_all(areas: &[ExPolygon], distance: i64) -> Vec<ExPolygon> {
    areas.iter().flat_map(|a| shrink(a, distance)).collect()
}

pub fn on_rows(area: &ExPolygon, distance: i64) -> Vec<ExPolygon> {
    let distance = distance.max(1) as f64;
    let rows = (distance / ROW).ceil() + MORE;
    let frame = RowFrame::new(0.0, 0.0, distance / rows);
    let own = scan(area.rings().map(|r| &r[..]), &frame);
    outlines_within(TOLERANCE, &erode_disc(&own, distance as i64, |k| frame.t(k)), &frame, LEAST)
}
