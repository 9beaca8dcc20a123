//! Header and layer records of a `.ctb` file, as they are read.

use super::NAME;
use super::sections::{self, magic};
use crate::resin::bytes::{Fields, Order, Source};
use crate::resin::{Head, LayerInfo, Motion, ReadError};

/// What is needed to find and read the layers.
pub(super) struct Found {
    pub(super) head: Head,
    pub(super) version: u32,
    pub(super) key: u32,
    pub(super) table: u64,
}

/// Reads the header and what it points to.
pub(super) fn read(source: &mut Source) -> Result<Found, ReadError> {
    let start = source.fields(0, 4, Order::Little, "header")?.u32("magic number")?;
    let foreign = |hint: &str| {
        let known = "ctb of versions 2 to 5 that are not encrypted".to_owned();
        Err(ReadError::Foreign { hint: hint.to_owned(), known })
    };
    match start {
        magic::PLAIN | magic::TWO_STAGES | magic::UNIFORMATION => {}
        magic::ENCRYPTED => return foreign(", but an encrypted ctb, which cannot be read"),
        magic::CBDDLP => return foreign(", but a cbddlp or photon file, which is older than ctb"),
        _ => return foreign(""),
    }
    let mut f = source.fields(0, sections::HEADER.into(), Order::Little, "header")?;
    f.skip(4);
    let version = f.u32("version")?;
    if !(2..=5).contains(&version) {
        return Err(f.damaged("version", version, "2 to 5"));
    }
    let mut head = Head { format: NAME, ..Head::default() };
    head.display = Some([f.quantity("panel width")?, f.quantity("panel height")?]);
    f.quantity("build height")?;
    f.skip(8);
    f.quantity("height")?;
    head.layer_height = f.quantity("layer height")?;
    head.exposure = f.quantity("exposure")?;
    head.bottom_exposure = f.quantity("bottom exposure")?;
    f.quantity("light-off time")?;
    head.bottom_layers = f.u32("number of bottom layers")?;
    head.width = f.u32("width")?;
    head.height = f.u32("height")?;
    let pixels = u64::from(head.width) * u64::from(head.height);
    if pixels == 0 || pixels > u64::from(u32::MAX) {
        let value = format!("{} x {}", head.width, head.height);
        return Err(f.damaged("size of the image", value, "at least 1 and below 2^32 pixels"));
    }
    f.skip(4);
    let table = u64::from(f.u32("place of the layer table")?);
    head.layers = f.u32("number of layers")?;
    if head.layers == 0 {
        return Err(f.damaged("number of layers", 0, "at least 1"));
    }
    f.skip(4);
    head.time = Some(f.u32("print time")?.into());
    // 1 stands for a mirror along either axis.
    head.mirror = match f.u32("mirror")? {
        0 => Some([false; 2]),
        _ => None,
    };
    let parameters = u64::from(f.u32("place of the parameters")?);
    f.skip(4);
    match f.u32("number of bit planes")? {
        0 | 1 => {}
        planes => return Err(f.damaged("number of bit planes", planes, 1)),
    }
    f.skip(4);
    let key = f.u32("key")?;
    let slicer = u64::from(f.u32("place of the slicer's settings")?);

    if table.saturating_add(u64::from(head.layers) * u64::from(sections::RECORD)) > source.length() {
        let what = format!("layer table of {} layers", head.layers);
        return Err(ReadError::Truncated { format: NAME, what, end: source.length() });
    }
    if parameters != 0 {
        let length = u64::from(sections::PARAMETERS);
        let mut f = source.fields(parameters, length, Order::Little, "parameters")?;
        f.go(0x14);
        head.volume_ml = Some(f.quantity("volume")?);
    }
    if slicer != 0 {
        let length = u64::from(sections::SLICER);
        let mut f = source.fields(slicer, length, Order::Little, "slicer's settings")?;
        f.go(0x1C);
        let (at, length) = (f.u32("place of the name")?, f.u32("length of the name")?);
        if length as usize > sections::MOST_NAME {
            return Err(f.damaged("length of the name", length, "at most 255"));
        }
        let mut name = source.fields(at.into(), length.into(), Order::Little, "printer's name")?;
        head.machine = name.text(length as usize, "text")?;
    }
    Ok(Found { head, version, key, table })
}

/// Where the data of a layer lie.
pub(super) struct Place {
    pub(super) at: u64,
    pub(super) size: u32,
    /// A record precedes the data.
    pub(super) extended: bool,
}

/// Reads the record of layer `index` in the layer table.
pub(super) fn read_record(mut f: Fields, index: u32) -> Result<(LayerInfo, Place), ReadError> {
    let mut info = LayerInfo { index, z: f.quantity("height over the plate")?, ..LayerInfo::default() };
    info.exposure = f.quantity("exposure")?;
    f.quantity("light-off time")?;
    let at = u64::from(f.u32("place of the data")?);
    let size = f.u32("size of the data")?;
    let at = u64::from(f.u32("page of the data")?) << 32 | at;
    let extended = f.u32("size of the record")? >= sections::EXTENDED && at >= sections::EXTENDED.into();
    Ok((info, Place { at, size, extended }))
}

/// Reads the record before a layer's data.
pub(super) fn read_extended(mut f: Fields, version: u32, info: &mut LayerInfo) -> Result<(), ReadError> {
    f.skip(sections::RECORD as usize + 4);
    let mut motion =
        Motion { lift: f.quantity("lift")?, lift_speed: f.quantity("lift speed")?, ..Motion::default() };
    // Version 3 has fields for all that follows, but nothing sensible in most of them.
    let two_stages = version >= 4;
    if two_stages {
        motion.lift2 = f.quantity("second lift")?;
        motion.lift2_speed = f.quantity("second lift speed")?;
        motion.lift = (motion.lift - motion.lift2).max(0.0);
    } else {
        f.skip(2 * 4);
    }
    motion.retract_speed = f.quantity("retract speed")?;
    if two_stages {
        motion.retract2 = f.quantity("second retract")?;
        motion.retract2_speed = f.quantity("second retract speed")?;
        motion.rest_before_lift = f.quantity("rest before lift")?;
        motion.rest_after_lift = f.quantity("rest after lift")?;
        motion.rest_after_retract = f.quantity("rest after retract")?;
    } else {
        f.skip(5 * 4);
    }
    info.motion = motion;
    let light = f.f32("light")?;
    if !(0.0..=255.0).contains(&light) {
        return Err(f.damaged("light", light, "0 to 255"));
    }
    info.light = light.round() as u8;
    Ok(())
}
