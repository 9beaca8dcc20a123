//! Header and layer records of `.goo`.

use super::{NAME, SIGNATURE};
use crate::resin::bytes::{Fields, Order, Put};
use crate::resin::{Head, LayerInfo, Motion, Print, ReadError, Totals, date, preview};
use std::io;

/// Length of the header, where the first layer begins.
pub(super) const LENGTH: u64 = 195_477;

/// Where the settings begin, behind the previews.
pub(super) const SETTINGS: u64 = 195_310;

/// Length of a layer's record, up to its image.
pub(super) const RECORD: u64 = 70;

/// What separates parts of a file.
pub(super) const DELIMITER: [u8; 2] = *b"\r\n";

/// Sides of the square previews.
const PREVIEWS: [u32; 2] = [116, 290];

/// What stands before the settings: texts and previews.
pub(super) fn texts(print: &Print) -> io::Result<Vec<u8>> {
    let mut put = Put::new(Order::Big);
    put.bytes(&SIGNATURE);
    put.text(32, "microtome");
    put.text(24, env!("CARGO_PKG_VERSION"));
    let [year, month, day, hour, minute, second] = date::civil(print.date);
    put.text(24, &format!("{year:04}-{month:02}-{day:02} {hour:02}:{minute:02}:{second:02}"));
    put.text(32, &print.machine);
    put.text(32, "DLP");
    put.text(32, &print.material);
    put.u16(u16::try_from(print.anti_aliasing).unwrap_or(u16::MAX));
    // Grey level as other writers set it; blur.
    put.u16(1);
    put.u16(0);
    for side in PREVIEWS {
        put.bytes(&preview::rgb565(&preview::scaled(&print.preview, side, side), Order::Big));
        put.bytes(&DELIMITER);
    }
    put.done()
}

/// The settings. `advance`: the values of the layer records rule, not these.
pub(super) fn settings(print: &Print, layers: u32, advance: bool, totals: &Totals) -> io::Result<Vec<u8>> {
    let panel = &print.panel;
    let short = |value: u32, what: &str| {
        u16::try_from(value).map_err(|_| {
            let reason = format!("{what} is {value}; a goo file holds at most 65535");
            io::Error::new(io::ErrorKind::InvalidInput, reason)
        })
    };
    let mut put = Put::new(Order::Big);
    put.u32(layers);
    put.u16(short(panel.width, "the panel's width")?);
    put.u16(short(panel.height, "the panel's height")?);
    put.u8(panel.mirror_x.into());
    put.u8(panel.mirror_y.into());
    let [width, height] = panel.image_nm().map(|nm| nm as f64 * 1e-6);
    put.f32("panel width", width);
    put.f32("panel height", height);
    put.f32("build height", print.build_height);
    put.f32("layer height", print.layer_height);
    put.f32("exposure", print.exposure);
    // The three rests rule, not the light-off time that follows.
    put.u8(1);
    put.f32("light-off time", 0.0);
    let (bottom, normal) = (&print.bottom_motion, &print.motion);
    for motion in [bottom, normal] {
        put.f32("rest before lift", motion.rest_before_lift);
        put.f32("rest after lift", motion.rest_after_lift);
        put.f32("rest after retract", motion.rest_after_retract);
    }
    put.f32("bottom exposure", print.bottom_exposure);
    put.u32(print.bottom_layers);
    for motion in [bottom, normal] {
        put.f32("lift", motion.lift);
        put.f32("lift speed", motion.lift_speed);
    }
    for motion in [bottom, normal] {
        put.f32("retract", motion.retract());
        put.f32("retract speed", motion.retract_speed);
    }
    for motion in [bottom, normal] {
        put.f32("second lift", motion.lift2);
        put.f32("second lift speed", motion.lift2_speed);
    }
    for motion in [bottom, normal] {
        put.f32("second retract", motion.retract2);
        put.f32("second retract speed", motion.retract2_speed);
    }
    put.u16(print.bottom_light.into());
    put.u16(print.light.into());
    put.u8(advance.into());
    put.u32(totals.time.round() as u32);
    // The specification asks for mm³.
    put.f32("volume", totals.volume_ml * 1e3);
    put.f32("weight", totals.weight_g);
    put.f32("cost", totals.cost);
    // The currency is not known.
    put.text(8, "");
    put.u32(LENGTH as u32);
    // Greys are 0..=255.
    put.u8(1);
    put.u16(u16::try_from(print.transition_layers).unwrap_or(u16::MAX));
    put.done()
}

/// Reads the header.
pub(super) fn read(mut f: Fields) -> Result<Head, ReadError> {
    f.expect(&SIGNATURE, "signature")?;
    f.skip(32 + 24 + 24);
    let mut head = Head { format: NAME, machine: f.text(32, "printer")?, ..Head::default() };
    f.go(SETTINGS as usize);
    head.layers = f.u32("number of layers")?;
    head.width = f.u16("width")?.into();
    head.height = f.u16("height")?.into();
    for (name, value) in [("number of layers", head.layers), ("width", head.width), ("height", head.height)] {
        if value == 0 {
            return Err(f.damaged(name, value, "at least 1"));
        }
    }
    let mut flag = |name| match f.u8(name)? {
        0 => Ok(false),
        1 => Ok(true),
        other => Err(f.damaged(name, other, "0 or 1")),
    };
    head.mirror = Some([flag("mirror along x")?, flag("mirror along y")?]);
    head.display = Some([f.quantity("panel width")?, f.quantity("panel height")?]);
    f.quantity("build height")?;
    head.layer_height = f.quantity("layer height")?;
    head.exposure = f.quantity("exposure")?;
    f.skip(1 + 7 * 4);
    head.bottom_exposure = f.quantity("bottom exposure")?;
    head.bottom_layers = f.u32("number of bottom layers")?;
    f.skip(16 * 4 + 2 + 2 + 1);
    head.time = Some(f.u32("print time")?.into());
    head.volume_ml = Some(f.quantity("volume")? * 1e-3);
    f.skip(4 + 4 + 8);
    let offset = f.u32("place of the first layer")?;
    if u64::from(offset) != LENGTH {
        return Err(f.damaged("place of the first layer", offset, LENGTH));
    }
    Ok(head)
}

/// The record of a layer whose image has `size` bytes.
pub(super) fn record(print: &Print, info: &LayerInfo, size: u32) -> io::Result<Vec<u8>> {
    let motion = &info.motion;
    let mut put = Put::new(Order::Big);
    // No pause; where one would wait.
    put.u16(0);
    put.f32("build height", print.build_height);
    put.f32("height over the plate", info.z);
    put.f32("exposure", info.exposure);
    put.f32("light-off time", 0.0);
    put.f32("rest before lift", motion.rest_before_lift);
    put.f32("rest after lift", motion.rest_after_lift);
    put.f32("rest after retract", motion.rest_after_retract);
    put.f32("lift", motion.lift);
    put.f32("lift speed", motion.lift_speed);
    put.f32("second lift", motion.lift2);
    put.f32("second lift speed", motion.lift2_speed);
    put.f32("retract", motion.retract());
    put.f32("retract speed", motion.retract_speed);
    put.f32("second retract", motion.retract2);
    put.f32("second retract speed", motion.retract2_speed);
    put.u16(info.light.into());
    put.bytes(&DELIMITER);
    put.u32(size);
    put.done()
}

/// Reads the record of layer `index`: what it says, and the size of its image.
pub(super) fn read_record(mut f: Fields, index: u32) -> Result<(LayerInfo, u32), ReadError> {
    f.skip(2 + 4);
    let mut info = LayerInfo { index, z: f.quantity("height over the plate")?, ..LayerInfo::default() };
    info.exposure = f.quantity("exposure")?;
    f.quantity("light-off time")?;
    let mut motion = Motion {
        rest_before_lift: f.quantity("rest before lift")?,
        rest_after_lift: f.quantity("rest after lift")?,
        rest_after_retract: f.quantity("rest after retract")?,
        lift: f.quantity("lift")?,
        lift_speed: f.quantity("lift speed")?,
        lift2: f.quantity("second lift")?,
        lift2_speed: f.quantity("second lift speed")?,
        ..Motion::default()
    };
    // Follows from the lift.
    f.quantity("retract")?;
    motion.retract_speed = f.quantity("retract speed")?;
    motion.retract2 = f.quantity("second retract")?;
    motion.retract2_speed = f.quantity("second retract speed")?;
    info.motion = motion;
    let light = f.u16("light")?;
    info.light = u8::try_from(light).map_err(|_| f.damaged("light", light, "0 to 255"))?;
    f.expect(&DELIMITER, "delimiter")?;
    Ok((info, f.u32("size of the image")?))
}
