//! What stands before the layers of a `.ctb` file, as it is written.

use super::Version;
use crate::resin::bytes::{Order, Put};
use crate::resin::{LayerInfo, Motion, Preview, Print, Totals, preview};
use std::io;

/// First four bytes of a file.
pub(super) mod magic {
    /// Versions 2 and 3.
    pub const PLAIN: u32 = 0x12FD_0086;
    /// Versions 4 and 5.
    pub const TWO_STAGES: u32 = 0x12FD_0106;
    /// A variant of version 4 of one maker.
    pub const UNIFORMATION: u32 = 0xFF22_0810;
    /// Settings and layer table are encrypted.
    pub const ENCRYPTED: u32 = 0x12FD_0107;
    /// The predecessor `.cbddlp`, also `.photon`.
    pub const CBDDLP: u32 = 0x12FD_0019;
}

pub(super) const HEADER: u32 = 112;
pub(super) const PREVIEW: u32 = 32;
pub(super) const PARAMETERS: u32 = 60;
pub(super) const SLICER: u32 = 76;
pub(super) const TWO_STAGES: u32 = 464;
pub(super) const RECORD: u32 = 36;
pub(super) const EXTENDED: u32 = 84;

/// Length of the text before the table of version 4, where the vendor's slicer has a notice of its own.
const NOTICE: u32 = 320;

/// Sizes of the previews, in their order in the file.
const PREVIEWS: [(u32, u32); 2] = [(400, 300), (200, 125)];

/// Where the sections lie, and the previews, which come between the header and the rest.
pub(super) struct Layout {
    version: Version,
    pub(super) previews: Vec<u8>,
    large: u32,
    small: u32,
    pub(super) parameters: u32,
    name: u32,
    name_length: u32,
    notice: u32,
    two_stages: u32,
    pub(super) table: u32,
}

impl Layout {
    pub(super) fn new(version: Version, print: &Print) -> io::Result<Self> {
        let mut put = Put::new(Order::Little);
        let mut starts = [0; PREVIEWS.len()];
        for (start, (width, height)) in starts.iter_mut().zip(PREVIEWS) {
            *start = HEADER + put.len() as u32;
            put_preview(&mut put, *start, &preview::scaled(&print.preview, width, height));
        }
        let [large, small] = starts;
        let previews = put.done()?;
        let parameters = HEADER + previews.len() as u32;
        let name = parameters + PARAMETERS + SLICER;
        let name_length = print.machine.chars().take(MOST_NAME).count() as u32;
        let notice = name + name_length;
        let two_stages = notice + NOTICE;
        let table = if version == Version::Four { two_stages + TWO_STAGES } else { notice };
        Ok(Self { version, previews, large, small, parameters, name, name_length, notice, two_stages, table })
    }

    /// The header.
    pub(super) fn header(&self, print: &Print, key: u32, totals: &Totals) -> io::Result<Vec<u8>> {
        let mut put = Put::new(Order::Little);
        put.u32(if self.version == Version::Four { magic::TWO_STAGES } else { magic::PLAIN });
        put.u32(self.version.number());
        let [width, height] = print.panel.image_nm().map(|nm| nm as f64 * 1e-6);
        put.f32("panel width", width);
        put.f32("panel height", height);
        put.f32("build height", print.build_height);
        put.zeros(8);
        let behind_first = f64::from(print.layers.saturating_sub(1)) * print.layer_height;
        put.f32("height", print.first_layer_height + behind_first);
        put.f32("layer height", print.layer_height);
        put.f32("exposure", print.exposure);
        put.f32("bottom exposure", print.bottom_exposure);
        put.f32("light-off time", light_off(self.version, &print.motion));
        put.u32(print.bottom_layers);
        put.u32(print.panel.width);
        put.u32(print.panel.height);
        put.u32(self.large);
        put.u32(self.table);
        put.u32(print.layers);
        put.u32(self.small);
        put.u32(totals.time.round() as u32);
        put.u32((print.panel.mirror_x || print.panel.mirror_y).into());
        put.u32(self.parameters);
        put.u32(PARAMETERS);
        // Number of bit planes; greys are in the runs.
        put.u32(1);
        put.u16(print.light.into());
        put.u16(print.bottom_light.into());
        put.u32(key);
        put.u32(self.parameters + PARAMETERS);
        put.u32(SLICER);
        put.done()
    }

    /// What stands between the previews and the layer table. `per_layer`: the values of the layer
    /// records rule.
    pub(super) fn settings(&self, print: &Print, per_layer: bool, totals: &Totals) -> io::Result<Vec<u8>> {
        let [bottom, normal] = [&print.bottom_motion, &print.motion].map(|m| stages(self.version, m));
        let mut put = Put::new(Order::Little);
        for motion in [&bottom, &normal] {
            put.f32("lift", motion.lift + motion.lift2);
            put.f32("lift speed", motion.lift_speed);
        }
        put.f32("retract speed", normal.retract_speed);
        put.f32("volume", totals.volume_ml);
        put.f32("weight", totals.weight_g);
        put.f32("cost", totals.cost);
        for motion in [&print.bottom_motion, &print.motion] {
            put.f32("light-off time", light_off(self.version, motion));
        }
        put.u32(print.bottom_layers);
        put.zeros(16);

        for motion in [&bottom, &normal] {
            put.f32("second lift", motion.lift2);
            put.f32("second lift speed", motion.lift2_speed);
        }
        put.f32("second retract", normal.retract2);
        put.f32("second retract speed", normal.retract2_speed);
        put.f32("rest after lift", normal.rest_after_lift);
        put.u32(self.name);
        put.u32(self.name_length);
        put.u8(if print.anti_aliasing > 1 { 15 } else { 7 });
        put.zeros(2);
        put.u8(if per_layer { self.version.number() as u8 * 0x10 } else { 0 });
        put.u32(u32::try_from(print.date.div_euclid(60)).unwrap_or(0));
        put.u32(print.anti_aliasing);
        // The version of the vendor's slicer that wrote this version of the format.
        put.u32(if self.version == Version::Four { 0x0109_0000 } else { 0x0106_0300 });
        put.f32("rest after retract", normal.rest_after_retract);
        put.f32("rest after lift", normal.rest_after_lift);
        put.u32(print.transition_layers);
        put.u32(if self.version == Version::Four { self.two_stages } else { 0 });
        put.zeros(8);
        // Not ended by a zero byte; the field has one, which the next section covers.
        let mut name = Put::new(Order::Little);
        name.text(self.name_length as usize + 1, &print.machine);
        put.bytes(name.done()?.get(..self.name_length as usize).unwrap_or_default());

        if self.version == Version::Four {
            put.zeros(NOTICE as usize);
            put.f32("bottom retract speed", bottom.retract_speed);
            put.f32("second bottom retract speed", bottom.retract2_speed);
            // Meaning unknown, here and below: what other writers have.
            put.u32(0);
            put.f32("constant", 4.0);
            put.u32(0);
            put.f32("constant", 4.0);
            put.f32("rest after retract", normal.rest_after_retract);
            put.f32("rest after lift", normal.rest_after_lift);
            put.f32("rest before lift", normal.rest_before_lift);
            put.f32("second bottom retract", bottom.retract2);
            put.zeros(8);
            put.u32(5);
            put.u32(print.layers.saturating_sub(1));
            put.zeros(16);
            put.u32(self.notice);
            put.u32(NOTICE);
            put.zeros(4 + 380);
        }
        put.done()
    }

    /// The records of a layer whose `size` bytes of data lie at `at`: that of the table, and the one
    /// before the data, which begins with a copy of it.
    pub(super) fn records(&self, info: &LayerInfo, at: u64, size: u32) -> io::Result<(Vec<u8>, Vec<u8>)> {
        let motion = stages(self.version, &info.motion);
        let mut put = Put::new(Order::Little);
        put.f32("height over the plate", info.z);
        put.f32("exposure", info.exposure);
        put.f32("light-off time", light_off(self.version, &info.motion));
        put.u32(at as u32);
        put.u32(size);
        put.u32((at >> 32) as u32);
        put.u32(EXTENDED);
        put.zeros(8);
        let record = put.clone().done()?;
        put.u32(size.saturating_add(EXTENDED));
        put.f32("lift", motion.lift + motion.lift2);
        put.f32("lift speed", motion.lift_speed);
        put.f32("second lift", motion.lift2);
        put.f32("second lift speed", motion.lift2_speed);
        put.f32("retract speed", motion.retract_speed);
        put.f32("second retract", motion.retract2);
        put.f32("second retract speed", motion.retract2_speed);
        put.f32("rest before lift", motion.rest_before_lift);
        put.f32("rest after lift", motion.rest_after_lift);
        put.f32("rest after retract", motion.rest_after_retract);
        put.f32("light", info.light.into());
        Ok((record, put.done()?))
    }
}

/// Longest name of a machine [characters].
pub(super) const MOST_NAME: usize = 255;

fn put_preview(put: &mut Put, start: u32, preview: &Preview) {
    let runs = preview::rle15(preview);
    put.u32(preview.width);
    put.u32(preview.height);
    put.u32(start + PREVIEW);
    put.u32(runs.len() as u32);
    put.zeros(16);
    put.bytes(&runs);
}

/// The motion as a version can tell it: before version 4, lifts and retracts are joined at the slower of
/// their speeds, and rests are left to [`light_off`].
fn stages(version: Version, motion: &Motion) -> Motion {
    if version == Version::Four {
        return *motion;
    }
    let slower = |first: f64, second: f64, length: f64| {
        if length > 0.0 && second > 0.0 { first.min(second) } else { first }
    };
    Motion {
        lift: motion.lift + motion.lift2,
        lift_speed: slower(motion.lift_speed, motion.lift2_speed, motion.lift2),
        retract_speed: slower(motion.retract_speed, motion.retract2_speed, motion.retract2),
        ..Motion::default()
    }
}

/// Time from the end of an exposure to the next \[s\] where rests are asked for and the version has no
/// field for them, else 0: the printer then goes on as soon as its motion ends.
fn light_off(version: Version, motion: &Motion) -> f64 {
    let rests = motion.rest_before_lift + motion.rest_after_lift + motion.rest_after_retract;
    if version == Version::Four || rests <= 0.0 {
        return 0.0;
    }
    let joined = stages(version, motion);
    let seconds = |speed: f64| if speed > 0.0 { joined.lift / speed * 60.0 } else { 0.0 };
    rests + seconds(joined.lift_speed) + seconds(joined.retract_speed)
}
