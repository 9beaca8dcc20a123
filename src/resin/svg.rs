//! Masks as SVG: one path of rectangles per grey, in pixels, scaled to millimetres by the view box.
//!
//! After SVG 1.1 (W3C), sections 7 and 8. Rectangles that continue from row to row are one.

use super::archive::{Sink, ZipSink};
use super::png::{MOST_RUNS, Place};
use super::stack::StackSink;
use super::{Container, LayerSink, Print, ReadError, WriteSeek};
use crate::mask::{MaskLayer, Panel, Run};
use quick_xml::events::{BytesStart, Event};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io;
use std::path::Path;

/// Longest SVG that is read \[bytes\].
pub const LONGEST: u64 = 1 << 28;

/// A zip of SVG layers with a manifest.
#[derive(Clone, Copy, Debug, Default)]
pub struct SvgLayers;

impl Container for SvgLayers {
    fn name(&self) -> &'static str {
        "svg"
    }

    fn preview_size(&self) -> [u32; 2] {
        [854, 480]
    }

    fn encode(&self, mask: &MaskLayer, panel: &Panel) -> Vec<u8> {
        encode(mask, panel).into_bytes()
    }

    fn begin<'a>(
        &'a self,
        out: &'a mut dyn WriteSeek,
        print: &'a Print,
    ) -> io::Result<Box<dyn LayerSink + 'a>> {
        let sink = Sink::Zip(Box::new(ZipSink::new(out, print.date)));
        Ok(Box::new(StackSink::begin(sink, print, true)?))
    }
}

impl SvgLayers {
    /// Begins a folder of SVG layers; `folder` must exist and should be empty.
    ///
    /// # Errors
    /// Those of the folder.
    pub fn begin_folder<'a>(&self, folder: &Path, print: &'a Print) -> io::Result<Box<dyn LayerSink + 'a>> {
        Ok(Box::new(StackSink::begin(Sink::Folder(folder.to_owned()), print, true)?))
    }
}

/// A rectangle of one grey; `left`, `right` and `top` in pixels.
#[derive(Clone, Copy)]
struct Rectangle {
    left: u32,
    right: u32,
    top: u32,
    value: u8,
}

/// The SVG of a mask.
pub fn encode(mask: &MaskLayer, panel: &Panel) -> String {
    let mut paths: BTreeMap<u8, String> = BTreeMap::new();
    let mut close = |open: &[Rectangle], bottom: u32| {
        for r in open {
            let (wide, high) = (r.right - r.left, bottom - r.top);
            let path = paths.entry(r.value).or_default();
            // Writing to a string cannot fail.
            let _ = write!(path, "M{} {}h{wide}v{high}h-{wide}z", r.left, r.top);
        }
    };
    // Rectangles that reach down to the last row looked at, and those of the row being looked at.
    let (mut above, mut row): (Vec<Rectangle>, Vec<Rectangle>) = (Vec::new(), Vec::new());
    let mut y = 0;
    let mut next = |to: u32, above: &mut Vec<Rectangle>, row: &mut Vec<Rectangle>, y: &mut u32| {
        let mut kept = 0;
        let mut ended: Vec<Rectangle> = Vec::new();
        for r in above.iter() {
            while row.get(kept).is_some_and(|n| n.left < r.left) {
                kept += 1;
            }
            match row.get_mut(kept) {
                Some(n) if (n.left, n.right, n.value) == (r.left, r.right, r.value) => n.top = r.top,
                _ => ended.push(*r),
            }
        }
        close(&ended, *y);
        std::mem::swap(above, row);
        row.clear();
        if to > *y + 1 {
            close(above, *y + 1);
            above.clear();
        }
        *y = to;
    };
    let width = panel.width.max(1);
    for run in &mask.runs {
        let mut start = run.start;
        while start < run.end {
            let of_row = start / width;
            if of_row != y {
                next(of_row, &mut above, &mut row, &mut y);
            }
            let left = start - of_row * width;
            let right = (run.end - of_row * width).min(width);
            row.push(Rectangle { left, right, top: of_row, value: run.value });
            start = of_row * width + right;
        }
    }
    next(y + 1, &mut above, &mut row, &mut y);
    next(y + 2, &mut above, &mut row, &mut y);
    let [wide, high] = panel.image_nm().map(|nm| nm as f64 * 1e-6);
    let (w, h) = (panel.width, panel.height);
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" \
         width=\"{wide}mm\" height=\"{high}mm\" viewBox=\"0 0 {w} {h}\" preserveAspectRatio=\"none\" \
         shape-rendering=\"crispEdges\">\n<rect width=\"{w}\" height=\"{h}\" fill=\"#000000\"/>\n"
    );
    for (value, path) in paths {
        let _ = writeln!(out, "<path fill=\"#{value:02x}{value:02x}{value:02x}\" d=\"{path}\"/>");
    }
    out.push_str("</svg>\n");
    out
}

/// The mask in an SVG as [`encode`] writes it, of `width` by `height` pixels.
///
/// # Errors
/// [`ReadError`] where it is no such SVG, or has more than [`MOST_RUNS`] runs.
pub fn decode(bytes: &[u8], width: u32, height: u32, place: Place<'_>) -> Result<MaskLayer, ReadError> {
    let text = std::str::from_utf8(bytes).map_err(|e| place.damaged("the text", e, "UTF-8"))?;
    let mut reader = quick_xml::Reader::from_str(text);
    let mut runs: Vec<Run> = Vec::new();
    let (mut begun, mut ended) = (false, false);
    loop {
        let event = reader
            .read_event()
            .map_err(|e| place.damaged("the XML", format!("not readable ({e})"), "SVG"))?;
        match event {
            Event::Start(element) if element.name().as_ref() == "svg" => {
                let expected = format!("0 0 {width} {height}");
                let found = attribute(&element, "viewBox", place)?;
                if found != expected {
                    return Err(place.damaged("the viewBox", found, expected));
                }
                begun = true;
            }
            Event::Empty(element) if element.name().as_ref() == "path" && begun && !ended => {
                let fill = attribute(&element, "fill", place)?;
                let value = grey(&fill).ok_or_else(|| place.damaged("fill", &fill, "a grey like #808080"))?;
                let path = attribute(&element, "d", place)?;
                rectangles(&path, value, width, height, &mut runs, place)?;
            }
            Event::End(element) if element.name().as_ref() == "svg" => ended = true,
            Event::Empty(element) if element.name().as_ref() == "rect" => {}
            Event::Start(_) | Event::Empty(_) => {
                return Err(place.damaged("the elements", "not all known", "svg, rect and path"));
            }
            Event::Eof => break,
            _ => {}
        }
    }
    if !(begun && ended) {
        return Err(place.damaged("the XML", "incomplete", "a whole svg element"));
    }
    runs.sort_unstable_by_key(|r| r.start);
    let mut mask = MaskLayer::default();
    let mut last = 0;
    for run in runs {
        if run.start < last {
            return Err(place.damaged(
                "the rectangles",
                format!("overlapping at pixel {}", run.start),
                "apart",
            ));
        }
        last = run.end;
        mask.push(run.start, run.end, run.value);
    }
    Ok(mask)
}

/// The value of an attribute.
fn attribute(element: &BytesStart<'_>, name: &str, place: Place<'_>) -> Result<String, ReadError> {
    let found = element
        .try_get_attribute(name)
        .map_err(|e| place.damaged("the XML", format!("not readable ({e})"), "SVG"))?;
    let Some(found) = found else {
        return Err(place.damaged(name, "missing", "present"));
    };
    Ok(found.value.into_owned())
}

/// The grey of a colour.
fn grey(fill: &str) -> Option<u8> {
    let digits = fill.strip_prefix('#').filter(|d| d.len() == 6 && d.is_ascii())?;
    let [r, g, b] = [0, 2, 4].map(|at| digits.get(at..at + 2));
    if r != g || g != b {
        return None;
    }
    u8::from_str_radix(r?, 16).ok().filter(|v| *v > 0)
}

/// Appends the rows of rectangles such as `M1 2h3v4h-3z`.
fn rectangles(
    path: &str,
    value: u8,
    width: u32,
    height: u32,
    runs: &mut Vec<Run>,
    place: Place<'_>,
) -> Result<(), ReadError> {
    for part in path.split('M').skip(1) {
        let wrong = || {
            let shown: String = part.chars().take(40).collect();
            place.damaged("a path", shown, "rectangles like M1 2h3v4h-3z within the panel")
        };
        let [left, top, wide, high] = rectangle(part).ok_or_else(wrong)?;
        let fits =
            |from: u32, by: u32, size: u32| from.checked_add(by).is_some_and(|end| by > 0 && end <= size);
        if !(fits(left, wide, width) && fits(top, high, height)) {
            return Err(wrong());
        }
        if runs.len() + high as usize > MOST_RUNS {
            return Err(place.damaged("the number of runs", format!("above {MOST_RUNS}"), "a mask"));
        }
        runs.extend((top..top + high).map(|y| {
            let start = y * width + left;
            Run { start, end: start + wide, value }
        }));
    }
    Ok(())
}

/// Left, top, width and height.
fn rectangle(part: &str) -> Option<[u32; 4]> {
    let (left, rest) = part.split_once(' ')?;
    let (top, rest) = rest.split_once('h')?;
    let (wide, rest) = rest.split_once('v')?;
    let (high, rest) = rest.split_once('h')?;
    let back = rest.strip_prefix('-')?.strip_suffix('z')?;
    if back != wide {
        return None;
    }
    Some([left.parse().ok()?, top.parse().ok()?, wide.parse().ok()?, high.parse().ok()?])
}
