//! Common Layer Interface, version 2.0, ASCII.
//!
//! The format of the Brite-EuRam project BE 2578 (1994), read by the software of laser sintering and
//! melting machines.

use super::{Drawing, decimal, write_sheets};
use crate::contour::Ring;
use crate::lattice::area2;
use std::io::{self, Write};

/// Writes a drawing as CLI in units of a millimetre.
///
/// By the format's convention a layer's height is that of its *top*, not of the plane it was cut at.
/// Outer contours come first, counter-clockwise (direction 1), then holes, clockwise (direction 0);
/// each repeats its first point at the end.
///
/// # Errors
/// Those of the writer.
pub fn write(drawing: &Drawing<'_>, out: &mut impl Write) -> io::Result<()> {
    let [lo, hi] = drawing.bounds().unwrap_or_default();
    let bottom = drawing.sheets.first().map_or(0, |s| s.top - s.height);
    let top = drawing.sheets.last().map_or(0, |s| s.top);
    let corners = [lo[0], lo[1], bottom, hi[0], hi[1], top].map(decimal::text).join(",");
    // Some readers want the first four lines in this order.
    writeln!(out, "$$HEADERSTART\n$$ASCII\n$$UNITS/1\n$$VERSION/200\n$$LABEL/1,part")?;
    writeln!(out, "$$DIMENSION/{corners}\n$$LAYERS/{}\n$$HEADEREND\n$$GEOMETRYSTART", drawing.sheets.len())?;
    write_sheets(drawing, out, |_, sheet, text| {
        text.extend_from_slice(b"$$LAYER/");
        decimal::mm(text, sheet.top);
        text.push(b'\n');
        for outer in [true, false] {
            for ring in sheet.rings.iter().filter(|r| (area2(r) > 0) == outer) {
                write_ring(ring, outer, drawing.offset, text);
            }
        }
    })?;
    writeln!(out, "$$GEOMETRYEND")
}

fn write_ring(ring: &Ring, outer: bool, offset: [i64; 2], text: &mut Vec<u8>) {
    text.extend_from_slice(format!("$$POLYLINE/1,{},{}", u8::from(outer), ring.len() + 1).as_bytes());
    for &p in ring.iter().chain(ring.first()) {
        text.push(b',');
        decimal::point(text, p, offset, b',');
    }
    text.push(b'\n');
}
