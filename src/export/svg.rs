//! Scalable Vector Graphics: one group per plane, in millimetres.

use super::{Drawing, decimal, write_sheets};
use std::io::{self, Write};

/// Writes a drawing as SVG 1.1.
///
/// The planes' y points up: one group mirrors everything, so that coordinates are the contours' own.
/// Each plane is a group with its height \[mm\] in `data-z`, the top of its layer in `data-top`, and one
/// path of all its contours, filled by the non-zero rule.
///
/// # Errors
/// Those of the writer.
pub fn write(drawing: &Drawing<'_>, out: &mut impl Write) -> io::Result<()> {
    let [lo, hi] = drawing.bounds().unwrap_or_default();
    let [x, y, w, h] = [lo[0], -hi[1], hi[0] - lo[0], hi[1] - lo[1]].map(decimal::text);
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(
        out,
        r#"<svg xmlns="http://www.w3.org/2000/svg" version="1.1" width="{w}mm" height="{h}mm" viewBox="{x} {y} {w} {h}">"#
    )?;
    writeln!(out, "<title>{}</title>", escaped(drawing.model))?;
    writeln!(
        out,
        r##"<g transform="scale(1 -1)" fill="#3a7ca5" fill-opacity="0.15" fill-rule="nonzero" stroke="#1d3f57" stroke-width="0.02">"##
    )?;
    write_sheets(drawing, out, |i, sheet, text| {
        let [z, top] = [sheet.z, sheet.top].map(decimal::text);
        text.extend_from_slice(
            format!(r#"<g id="layer-{i}" data-z="{z}" data-top="{top}"><path d=""#).as_bytes(),
        );
        for ring in sheet.rings {
            for (k, &p) in ring.iter().enumerate() {
                // Points after the first of a move are lines.
                text.push(if k == 0 { b'M' } else { b' ' });
                decimal::point(text, p, drawing.offset, b',');
            }
            text.push(b'Z');
        }
        text.extend_from_slice(b"\"/></g>\n");
    })?;
    writeln!(out, "</g>\n</svg>")
}

/// Text for between two tags. Control characters have no place in XML.
fn escaped(text: &str) -> String {
    let clean: String = text.chars().filter(|c| !c.is_control()).collect();
    clean.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
