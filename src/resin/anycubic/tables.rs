//! The tables of a file as bytes.

use super::machines::Machine;
use crate::resin::bytes::Order;
use crate::resin::preview::{rgb565, scaled};
use crate::resin::{Motion, Print, Totals};

/// Name and length.
pub(super) const TABLE_HEAD: usize = 16;

/// A layer's record.
pub(super) const RECORD: usize = 32;

/// Where the tables of a file are. Those that its version lacks are 0.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Addresses {
    pub header: u32,
    pub software: u32,
    pub preview: u32,
    pub greys: u32,
    pub layers: u32,
    pub extra: u32,
    pub machine: u32,
    pub data: u32,
    pub model: u32,
}

/// Length of the mark with its addresses.
pub(super) fn mark_length(version: u32) -> usize {
    match version {
        516 => 52,
        517 => 56,
        518.. => 64,
        _ => 48,
    }
}

/// The mark. `version` is 1, 516 or 517.
pub(super) fn mark(version: u32, at: &Addresses) -> Vec<u8> {
    let tables = match version {
        516 => 8,
        517 => 9,
        _ => 4,
    };
    let mut out = Vec::with_capacity(mark_length(version));
    text(&mut out, "ANYCUBIC", 12);
    for number in [version, tables, at.header, at.software, at.preview, at.greys, at.layers, at.extra] {
        u32s(&mut out, &[number]);
    }
    if version >= 516 {
        u32s(&mut out, &[at.machine]);
    }
    u32s(&mut out, &[at.data]);
    if version >= 517 {
        u32s(&mut out, &[at.model]);
    }
    out
}

/// `HEADER`: pitch \[um\], thickness, exposure, rest before the exposure, bottom exposure, number of bottom
/// layers (as f32), lift \[mm\], its speed, speed of the retract, volume \[ml\]; anti-aliasing, pixels of a
/// row, rows; weight \[g\], price; currency, whether layers have values of their own, print time \[s\],
/// transition layers, their kind (0 = linear); from 516 on whether `EXTRA` holds; in 517 u16 grey, u16 blur,
/// u32 resin type.
pub(super) fn header(version: u32, print: &Print, totals: &Totals) -> Vec<u8> {
    let length = match version {
        516 => 84,
        517 => 92,
        _ => 80,
    };
    let mut out = table("HEADER", length);
    let pitch = print.panel.pitch_x.max(print.panel.pitch_y) as f64 / 1000.0;
    let motion = &print.motion;
    f32s(&mut out, &[pitch, print.layer_height, print.exposure, motion.rest_after_retract]);
    f32s(&mut out, &[print.bottom_exposure, f64::from(print.bottom_layers)]);
    f32s(&mut out, &[motion.lift + motion.lift2, speed(motion.lift_speed), speed(motion.retract_speed)]);
    f32s(&mut out, &[totals.volume_ml]);
    u32s(&mut out, &[print.anti_aliasing.clamp(1, 16), print.panel.width, print.panel.height]);
    f32s(&mut out, &[totals.weight_g, totals.cost]);
    text(&mut out, "$", 4);
    let time = totals.time.round().clamp(0.0, f64::from(u32::MAX)) as u32;
    u32s(&mut out, &[u32::from(own_values(version, print)), time, print.transition_layers, 0]);
    if version >= 516 {
        u32s(&mut out, &[u32::from(extra_holds(print))]);
    }
    if version >= 517 {
        u32s(&mut out, &[0, 0]);
    }
    out
}

/// True when layers must be printed by their own records: where one of them differs from what the header says
/// of bottom and normal layers.
fn own_values(version: u32, print: &Print) -> bool {
    let (normal, bottom) = (&print.motion, &print.bottom_motion);
    let lifts_differ =
        normal.lift + normal.lift2 != bottom.lift + bottom.lift2 || normal.lift_speed != bottom.lift_speed;
    print.transition_layers > 0
        || print.first_layer_height != print.layer_height
        || (version < 516 && lifts_differ)
}

/// True when the motion takes the two stages of `EXTRA`, or bottom layers move in another way.
fn extra_holds(print: &Print) -> bool {
    print.motion.lift2 > 0.0 || print.bottom_motion.lift2 > 0.0 || print.motion != print.bottom_motion
}

/// Size of the picture that machines show.
const PREVIEW: [u32; 2] = [224, 168];

/// `PREVIEW`: width, `x`, height, pixels.
pub(super) fn preview(version: u32, print: &Print) -> Vec<u8> {
    let [width, height] = PREVIEW;
    let head = if version == 1 { 0 } else { TABLE_HEAD as u32 };
    let mut out = table("PREVIEW", head + 12 + 2 * width * height);
    u32s(&mut out, &[width]);
    text(&mut out, "x", 4);
    u32s(&mut out, &[height]);
    out.extend(rgb565(&scaled(&print.preview, width, height), Order::Little));
    out
}

/// The table of greys, without a name: 0, their number, the greys of the 16 levels, 0.
pub(super) fn greys() -> Vec<u8> {
    let mut out = Vec::with_capacity(28);
    u32s(&mut out, &[0, 16]);
    out.extend((0..16u8).map(|level| 16 * level + 15));
    u32s(&mut out, &[0]);
    out
}

/// `EXTRA`: for bottom layers, then for the others: 2 stages; lift of the first, its speed, the speed at which
/// it is taken back, the same of the second.
pub(super) fn extra(print: &Print) -> Vec<u8> {
    let mut out = table("EXTRA", 24);
    for motion in [&print.bottom_motion, &print.motion] {
        let two = motion.lift2 > 0.0;
        let up2 = if two { motion.lift2_speed } else { motion.lift_speed };
        let down1 = if two && motion.retract2 > 0.0 { motion.retract2_speed } else { motion.retract_speed };
        u32s(&mut out, &[2]);
        f32s(&mut out, &[motion.lift, speed(motion.lift_speed), speed(down1)]);
        f32s(&mut out, &[motion.lift2, speed(up2), speed(motion.retract_speed)]);
    }
    out
}

/// `MACHINE`: name, kind of layer data, levels of anti-aliasing, 1 (517: 7), width, height, z \[mm\], highest
/// file version, colour of the background.
pub(super) fn machine(version: u32, machine: &Machine, print: &Print) -> Vec<u8> {
    let mut out = table("MACHINE", 156);
    let given = print.machine.strip_prefix("Anycubic ").unwrap_or(&print.machine);
    text(&mut out, if given.is_empty() { machine.name } else { given }, 96);
    text(&mut out, "pw0Img", 16);
    u32s(&mut out, &[16, if version >= 517 { 7 } else { 1 }]);
    let [width, height] = print.panel.image_nm().map(|nm| nm as f64 * 1e-6);
    f32s(&mut out, &[width, height, print.build_height]);
    u32s(&mut out, &[machine.highest, 6_506_241]);
    out
}

/// The table of the software, its name first.
pub(super) fn software() -> Vec<u8> {
    let mut out = Vec::with_capacity(164);
    text(&mut out, "microtome", 32);
    u32s(&mut out, &[164]);
    text(&mut out, env!("CARGO_PKG_VERSION"), 32);
    text(&mut out, "", 64);
    text(&mut out, "3.3-CoreProfile", 32);
    out
}

/// `MODEL`: bounds of the lit pixels from the middle of the panel \[mm\], in the image, and two words on
/// supports. `bounds`: first column, first row, and those behind the last \[pixels\].
pub(super) fn model(print: &Print, bounds: [u32; 4], height: f64) -> Vec<u8> {
    let mut out = table("MODEL", 48);
    let panel = &print.panel;
    let x = |column: u32| (f64::from(column) - f64::from(panel.width) / 2.0) * panel.pitch_x as f64 * 1e-6;
    let y = |row: u32| (f64::from(row) - f64::from(panel.height) / 2.0) * panel.pitch_y as f64 * 1e-6;
    let [left, top, right, bottom] = bounds;
    f32s(&mut out, &[x(left), y(top), 0.0, x(right), y(bottom), height]);
    u32s(&mut out, &[0, 0]);
    out
}

/// The record of a layer.
pub(super) fn record(
    out: &mut Vec<u8>,
    [address, length, lit]: [u32; 3],
    motion: &Motion,
    [exposure, height]: [f64; 2],
) {
    u32s(out, &[address, length]);
    f32s(out, &[motion.lift + motion.lift2, speed(motion.lift_speed), exposure, height]);
    u32s(out, &[lit, 0]);
}

/// Name and length of a table.
pub(super) fn table(name: &str, length: u32) -> Vec<u8> {
    let mut out = Vec::with_capacity(length as usize + TABLE_HEAD);
    text(&mut out, name, 12);
    u32s(&mut out, &[length]);
    out
}

/// mm/min to mm/s.
fn speed(mm_per_min: f64) -> f64 {
    mm_per_min / 60.0
}

/// Text in a field of `length` bytes, cut off before its end so that a zero follows.
fn text(out: &mut Vec<u8>, text: &str, length: usize) {
    let start = out.len();
    let printable = text.chars().map(|c| if c.is_ascii() && !c.is_ascii_control() { c as u8 } else { b'?' });
    out.extend(printable.take(length - 1));
    out.resize(start + length, 0);
}

fn u32s(out: &mut Vec<u8>, numbers: &[u32]) {
    out.extend(numbers.iter().flat_map(|n| n.to_le_bytes()));
}

fn f32s(out: &mut Vec<u8>, numbers: &[f64]) {
    out.extend(numbers.iter().flat_map(|n| (*n as f32).to_le_bytes()));
}
