//! Well-known text (OGC Simple Features, ISO 19125): one multi-polygon per plane.

use super::{Drawing, decimal, write_sheets};
use crate::contour::ExPolygon;
use crate::region::areas::areas;
use std::io::{self, Write};

/// Writes one `MULTIPOLYGON Z` a line, with the plane's height as every point's z \[mm\]; a plane
/// without area is `MULTIPOLYGON Z EMPTY`.
///
/// The standard wants polygons that neither cross nor overlap, so what is written are the areas that
/// the contours bound: shells that overlap are merged. Rings are closed by their first point.
///
/// # Errors
/// Those of the writer.
pub fn write(drawing: &Drawing<'_>, out: &mut impl Write) -> io::Result<()> {
    write_sheets(drawing, out, |_, sheet, text| {
        let polygons = areas(sheet.rings);
        if polygons.is_empty() {
            text.extend_from_slice(b"MULTIPOLYGON Z EMPTY\n");
            return;
        }
        text.extend_from_slice(b"MULTIPOLYGON Z (");
        for (i, polygon) in polygons.iter().enumerate() {
            text.extend_from_slice(if i == 0 { b"" } else { b", " });
            write_polygon(polygon, drawing.offset, sheet.z, text);
        }
        text.extend_from_slice(b")\n");
    })
}

fn write_polygon(polygon: &ExPolygon, offset: [i64; 2], z: i64, text: &mut Vec<u8>) {
    for (r, ring) in polygon.rings().enumerate() {
        text.extend_from_slice(if r == 0 { b"((" } else { b", (" });
        for (k, &p) in ring.iter().chain(ring.first()).enumerate() {
            text.extend_from_slice(if k == 0 { b"" } else { b", " });
            decimal::point(text, p, offset, b' ');
            text.push(b' ');
            decimal::mm(text, z);
        }
        text.push(b')');
    }
    text.push(b')');
}
