//! JSON: planes with their contours as arrays of points, and the transform to the model.

use super::{Drawing, decimal, write_sheets};
use crate::contour::chains::OpenReport;
use crate::lattice::mm;
use serde_json::json;
use std::io::{self, Write};

/// Writes a drawing as one JSON object, a plane a line.
///
/// `frame` holds the unit vectors `u`, `v`, `n` and the `origin` \[mm\]: the point \[x, y\] of a contour
/// on the plane at `z` is `origin + x u + y v + z n` in the model file. A layer has `z` (its plane),
/// `top` and `height` \[mm\], `area` (signed sum of its contours \[mm²\]), `contours` (closed, the first
/// point not repeated, solid on the left) and `open`: how many open chains there were, how they were
/// closed, and the widest gap.
///
/// # Errors
/// Those of the writer.
pub fn write(drawing: &Drawing<'_>, out: &mut impl Write) -> io::Result<()> {
    let frame = drawing.frame;
    let head = json!({ "u": frame.u, "v": frame.v, "n": frame.n, "origin": frame.origin });
    writeln!(out, r#"{{"format":"microtome contours 1","model":{},"#, json!(drawing.model))?;
    writeln!(out, r#""units":"mm","frame":{head},"#)?;
    writeln!(out, r#""layers":["#)?;
    let last = drawing.sheets.len().saturating_sub(1);
    write_sheets(drawing, out, |i, sheet, text| {
        for (key, nm) in [("{\"z\":", sheet.z), (",\"top\":", sheet.top), (",\"height\":", sheet.height)] {
            text.extend_from_slice(key.as_bytes());
            decimal::mm(text, nm);
        }
        text.extend_from_slice(format!(",\"area\":{},\"contours\":[", json!(sheet.area_mm2())).as_bytes());
        for (r, ring) in sheet.rings.iter().enumerate() {
            text.extend_from_slice(if r == 0 { b"[" } else { b",[" });
            for (k, &p) in ring.iter().enumerate() {
                text.extend_from_slice(if k == 0 { b"[" } else { b",[" });
                decimal::point(text, p, drawing.offset, b',');
                text.push(b']');
            }
            text.push(b']');
        }
        text.push(b']');
        text.extend_from_slice(format!(",\"open\":{}}}", open(&sheet.open, drawing.offset)).as_bytes());
        text.extend_from_slice(if i == last { b"\n" } else { b",\n" });
    })?;
    writeln!(out, "]}}")
}

fn open(report: &OpenReport, offset: [i64; 2]) -> serde_json::Value {
    let worst = report.worst.map(|gap| {
        let at = [i64::from(gap.at.x) + offset[0], i64::from(gap.at.y) + offset[1]].map(mm);
        json!({ "length": mm(gap.length), "at": at })
    });
    json!({
        "chains": report.chains,
        "matched": report.matched,
        "forced": report.forced,
        "dropped": report.dropped,
        "widest_gap": worst,
    })
}
