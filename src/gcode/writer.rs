//! The moves of the layers as text.

use super::number::Line;
use super::summary::{Summary, section};
use super::texts::append;
use super::{LayerText, Texts, flavor, preamble};
use crate::lattice::{NM_PER_MM, Point2, mm};
use crate::path::{Extrusion, LayerPlan, Role};
use crate::settings::Settings;
use std::io;

/// Writes a file layer by layer: [`Writer::new`], [`Writer::layer`] for each, [`Writer::finish`].
pub struct Writer<'a, W> {
    out: W,
    /// Only counts: what would be written is not even formed.
    counts_only: bool,
    buffer: Vec<u8>,
    line: Line,
    settings: &'a Settings,
    texts: &'a Texts<'a>,
    origin: [i64; 2],
    /// Filament per volume, 10 nm for each mm³.
    e_per_mm3: f64,
    machine: Machine,
    summary: Summary,
    bounds: Bounds,
    /// Filament by role \[10 nm\].
    role_e: [i64; Role::COUNT],
}

/// Lowest and highest extruded coordinates \[µm\].
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [i64; 3],
    high: [i64; 3],
}

impl Bounds {
    /// Widens the box along some axes, the first one being number `first`.
    #[inline]
    fn include<const N: usize>(&mut self, first: usize, values: [i64; N]) {
        for (axis, v) in values.into_iter().enumerate() {
            let axis = first + axis;
            self.low[axis] = self.low[axis].min(v);
            self.high[axis] = self.high[axis].max(v);
        }
    }
}

/// What the machine was told last.
#[derive(Clone, Debug, Default)]
struct Machine {
    /// X and Y \[µm\]; `None` where the user's G-code may have moved them.
    at: Option<[i64; 2]>,
    /// Z without lift \[µm\].
    z: i64,
    /// Feed rate \[µm/min\]; 0 where it is not known.
    feed: i64,
    /// E as last written, since the last G92 \[10 nm\].
    e: i64,
    /// Filament due but not yet written, because it is less than half a step \[10 nm\].
    e_due: f64,
    /// Filament written by extruding moves since the start \[10 nm\].
    e_net: i64,
    retracted: bool,
    role: Option<Role>,
    width: f64,
    /// Height of the bead \[mm\].
    height: f64,
    fan: u8,
    /// Where the fan belongs on this layer.
    layer_fan: u8,
}

/// An absolute E is set back to 0 at the next occasion once it exceeds 50 mm, which keeps it exact
/// in firmwares that calculate in single precision. \[10 nm\]
const E_RESET: i64 = 5_000_000;

/// Bytes gathered before they go out.
const BATCH: usize = 1 << 18;

impl<'a, W: io::Write> Writer<'a, W> {
    /// Writes everything up to the first layer. `layers` is the number to come; `origin` \[nm\] is
    /// added to X and Y, its third entry is not used.
    ///
    /// # Errors
    /// Whatever `out` returns, as for the other methods.
    pub fn new(
        out: W,
        layers: usize,
        origin: [i64; 3],
        settings: &'a Settings,
        texts: &'a Texts<'a>,
    ) -> io::Result<Self> {
        let area = section(&settings.filament).max(1e-6);
        let mut writer = Self {
            out,
            counts_only: false,
            buffer: Vec::with_capacity(BATCH + (BATCH >> 2)),
            line: Line::default(),
            settings,
            texts,
            origin: [origin[0], origin[1]],
            e_per_mm3: settings.filament.extrusion_multiplier / area * 1e5,
            machine: Machine::default(),
            summary: Summary::default(),
            bounds: Bounds { low: [i64::MAX; 3], high: [i64::MIN; 3] },
            role_e: [0; Role::COUNT],
        };
        writer.buffer.extend_from_slice(&preamble::head(layers, settings, texts));
        Ok(writer)
    }

    /// The same, but nothing is written from now on: [`Writer::finish`] tells what a file would hold, in
    /// `bytes` none.
    #[must_use]
    pub fn counting_only(mut self) -> Self {
        self.counts_only = true;
        self.buffer = Vec::new();
        self
    }

    /// Writes one layer.
    ///
    /// # Errors
    /// See [`Writer::new`].
    pub fn layer(&mut self, layer: &LayerPlan) -> io::Result<()> {
        let index = self.summary.layers;
        let z = self.micrometres(i64::from(layer.print_z)) + self.z_offset();
        let text = LayerText { index, z: z as f64 / 1000.0, height: mm(layer.height) };
        if !self.counts_only {
            preamble::layer_change(text.z, text.height, &mut self.buffer);
            let current = flavor::current_layer(self.settings.printer.gcode_flavor, index + 1);
            append(&current.unwrap_or_default(), &mut self.buffer);
        }
        self.custom(&(self.texts.before_layer)(text));
        if index > 0 && self.settings.retraction.retract_layer_change {
            self.retract();
        }
        self.reset_e();
        self.machine.z = z;
        self.move_z(z, "move to next layer");
        self.custom(&(self.texts.layer)(text));
        if index == 1 && !self.counts_only {
            preamble::second_layer(self.settings, &mut self.buffer);
        }
        self.machine.layer_fan = flavor::fan_step(layer.fan);
        self.fan(self.machine.layer_fan);
        (self.machine.role, self.machine.height) = (None, text.height);
        for extrusion in &layer.extrusions {
            self.extrusion(extrusion, layer.path(extrusion));
            if self.buffer.len() >= BATCH {
                self.flush()?;
            }
        }
        if !layer.extrusions.is_empty() {
            self.bounds.include(2, [z]);
        }
        self.summary.layers += 1;
        Ok(())
    }

    /// Writes everything after the last layer; returns what was counted.
    ///
    /// # Errors
    /// See [`Writer::new`].
    pub fn finish(mut self) -> io::Result<Summary> {
        if self.summary.extruded_mm > 0.0 {
            self.retract();
        }
        self.summary.filament_mm = self.machine.e_net as f64 / 1e5;
        self.summary.role_mm = self.role_e.map(|e| e as f64 / 1e5);
        self.summary.weigh(&self.settings.filament);
        if self.bounds.low[2] <= self.bounds.high[2] {
            self.summary.low = self.bounds.low.map(|v| v as f64 / 1000.0);
            self.summary.high = self.bounds.high.map(|v| v as f64 / 1000.0);
        }
        if self.counts_only {
            return Ok(self.summary);
        }
        let tail = preamble::tail(&self.summary.comments(), self.settings, self.texts);
        self.buffer.extend_from_slice(&tail);
        self.flush()?;
        self.out.flush()?;
        Ok(self.summary)
    }

    fn extrusion(&mut self, extrusion: &Extrusion, path: &[Point2]) {
        let Some((&start, rest)) = path.split_first() else { return };
        self.travel(start, extrusion.retract);
        let m = &mut self.machine;
        if m.role != Some(extrusion.role) {
            m.role = Some(extrusion.role);
            m.width = 0.0;
            if !self.counts_only {
                self.buffer.extend_from_slice(b";TYPE:");
                append(extrusion.role.name(), &mut self.buffer);
            }
        }
        if m.width != extrusion.width {
            m.width = extrusion.width;
            self.comment(b";WIDTH:", extrusion.width);
        }
        if self.machine.height != extrusion.height {
            self.machine.height = extrusion.height;
            self.comment(b";HEIGHT:", extrusion.height);
        }
        self.fan(extrusion.fan.map_or(self.machine.layer_fan, flavor::fan_step));
        self.unretract();
        let feed = feed(extrusion.speed);
        let before = self.machine.e_net;
        let at = self.world(start);
        self.bounds.include(0, at);
        let steps_per_nm = extrusion.mm3_per_mm * self.e_per_mm3 / NM_PER_MM;
        let mut from = start;
        for &to in rest {
            self.machine.e_due += from.distance(to) * steps_per_nm;
            from = to;
            self.extrude_to(to, feed, extrusion.role);
        }
        self.role_e[extrusion.role.index()] += self.machine.e_net - before;
        self.summary.extruded_mm += extrusion.length;
        let seconds = extrusion.length / extrusion.speed;
        self.summary.seconds_at_least += seconds;
        self.summary.role_seconds[extrusion.role.index()] += seconds;
    }

    /// Sets the fan, unless it turns like that already.
    #[inline]
    fn fan(&mut self, step: u8) {
        if step != self.machine.fan {
            self.machine.fan = step;
            if self.counts_only {
                return;
            }
            append(&flavor::fan(self.settings.printer.gcode_flavor, step), &mut self.buffer);
        }
    }

    /// Writes a comment that states a length \[mm\].
    fn comment(&mut self, tag: &[u8], value: f64) {
        if self.counts_only {
            return;
        }
        self.line.clear();
        self.line.text(tag);
        self.line.hundred_thousandths((value * 1e5).round() as i64);
        self.line.text(b"\n");
        self.line.append_to(&mut self.buffer);
    }

    /// Extrudes what is due on the way to a point; a way shorter than the file's resolution is left
    /// to the next one.
    #[inline]
    fn extrude_to(&mut self, to: Point2, feed: i64, role: Role) {
        let [x, y] = self.world(to);
        let m = &mut self.machine;
        let [x0, y0] = m.at.unwrap_or([i64::MIN; 2]);
        if x == x0 && y == y0 {
            return;
        }
        // Never negative but for a rounding of at most half a step, so that this rounds to nearest.
        let step = (m.e_due + 0.5) as i64;
        m.e_due -= step as f64;
        m.e += step;
        m.e_net += step;
        m.at = Some([x, y]);
        self.bounds.include(0, [x, y]);
        if self.counts_only {
            return;
        }
        let line = &mut self.line;
        line.clear();
        line.text(b"G1");
        if x != x0 {
            line.word(b'X');
            line.thousandths(x);
        }
        if y != y0 {
            line.word(b'Y');
            line.thousandths(y);
        }
        if step != 0 {
            line.word(b'E');
            line.hundred_thousandths(if self.settings.printer.use_relative_e_distances { step } else { m.e });
        }
        if m.feed != feed {
            m.feed = feed;
            line.word(b'F');
            line.thousandths(feed);
        }
        self.end_line(role.comment());
    }

    /// Moves to a point without extruding.
    fn travel(&mut self, to: Point2, retract: bool) {
        let [x, y] = self.world(to);
        if self.machine.at == Some([x, y]) {
            return;
        }
        // Before the first line there is nothing to be pulled back.
        if retract && self.summary.extruded_mm > 0.0 {
            self.retract();
        }
        let lift = (self.settings.retraction.retract_lift * 1000.0).round() as i64;
        let lifted = self.machine.retracted && lift > 0;
        if lifted {
            self.move_z(self.machine.z + lift, "lift nozzle");
        }
        let feed = feed(self.settings.speed.travel_speed);
        let old = self.machine.at;
        if let Some([x0, y0]) = old {
            let (dx, dy) = ((x - x0) as f64 / 1000.0, (y - y0) as f64 / 1000.0);
            let length = (dx * dx + dy * dy).sqrt();
            self.summary.travel_mm += length;
            let seconds = length / self.settings.speed.travel_speed.max(1e-3);
            self.summary.seconds_at_least += seconds;
            self.summary.travel_seconds += seconds;
        }
        self.machine.at = Some([x, y]);
        if self.counts_only {
            return;
        }
        let line = &mut self.line;
        line.clear();
        line.text(b"G1");
        if old.is_none_or(|o| o[0] != x) {
            line.word(b'X');
            line.thousandths(x);
        }
        if old.is_none_or(|o| o[1] != y) {
            line.word(b'Y');
            line.thousandths(y);
        }
        if self.machine.feed != feed {
            self.machine.feed = feed;
            line.word(b'F');
            line.thousandths(feed);
        }
        self.end_line("move to first point");
        if lifted {
            self.move_z(self.machine.z, "restore layer Z");
        }
    }

    fn move_z(&mut self, z: i64, comment: &str) {
        if self.counts_only {
            return;
        }
        let speed = match self.settings.speed.travel_speed_z {
            z if z > 0.0 => z,
            _ => self.settings.speed.travel_speed,
        };
        self.line.clear();
        self.line.text(b"G1");
        self.line.word(b'Z');
        self.line.thousandths(z);
        // Always with its feed rate, because hosts look for heights in lines of this form.
        self.machine.feed = feed(speed);
        self.line.word(b'F');
        self.line.thousandths(self.machine.feed);
        self.end_line(comment);
    }

    fn retract(&mut self) {
        let r = &self.settings.retraction;
        let length = (r.retract_length * 1e5).round() as i64;
        if self.machine.retracted || (length <= 0 && !self.settings.printer.use_firmware_retraction) {
            return;
        }
        self.machine.retracted = true;
        self.summary.retractions += 1;
        self.feed_filament(-length, r.retract_speed, "G10", "retract");
        if self.machine.e > E_RESET {
            self.reset_e();
        }
    }

    fn unretract(&mut self) {
        if !self.machine.retracted {
            return;
        }
        self.machine.retracted = false;
        let r = &self.settings.retraction;
        let length = (r.retract_length * 1e5).round() as i64;
        let extra = (r.retract_restart_extra * 1e5).round() as i64;
        let speed = if r.deretract_speed > 0.0 { r.deretract_speed } else { r.retract_speed };
        if !self.settings.printer.use_firmware_retraction {
            self.machine.e_net += extra;
        }
        self.feed_filament(length + extra, speed, "G11", "unretract");
    }

    /// Moves only the filament, by `steps` of 10 nm, or gives the firmware's own command for it.
    fn feed_filament(&mut self, steps: i64, speed: f64, command: &str, comment: &str) {
        self.line.clear();
        if self.settings.printer.use_firmware_retraction {
            self.line.text(command.as_bytes());
        } else {
            self.machine.e += steps;
            let feed = feed(speed);
            self.line.text(b"G1");
            self.line.word(b'E');
            let relative = self.settings.printer.use_relative_e_distances;
            self.line.hundred_thousandths(if relative { steps } else { self.machine.e });
            let seconds = steps.abs() as f64 / 1e5 / speed.max(1e-3);
            self.summary.seconds_at_least += seconds;
            self.summary.retraction_seconds += seconds;
            if self.machine.feed != feed {
                self.machine.feed = feed;
                self.line.word(b'F');
                self.line.thousandths(feed);
            }
        }
        self.end_line(comment);
    }

    /// Starts counting an absolute E from 0 again.
    fn reset_e(&mut self) {
        if !self.settings.printer.use_relative_e_distances && self.machine.e != 0 {
            self.append("G92 E0");
        }
        self.machine.e = 0;
    }

    /// Writes G-code of the user's, after which less is known about the machine.
    fn custom(&mut self, text: &str) {
        if !text.trim().is_empty() {
            self.append(text);
            self.machine.at = None;
            self.machine.feed = 0;
        }
    }

    #[inline]
    fn end_line(&mut self, comment: &str) {
        if self.counts_only {
            return;
        }
        if self.settings.output.gcode_comments {
            self.line.text(b" ; ");
            self.line.text(comment.as_bytes());
        }
        self.line.text(b"\n");
        self.line.append_to(&mut self.buffer);
    }

    /// Lines that stand alone.
    fn append(&mut self, text: &str) {
        if !self.counts_only {
            append(text, &mut self.buffer);
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.summary.bytes += self.buffer.len() as u64;
        self.out.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }

    /// A point in the machine's frame \[µm\].
    #[inline]
    fn world(&self, p: Point2) -> [i64; 2] {
        [self.micrometres(i64::from(p.x) + self.origin[0]), self.micrometres(i64::from(p.y) + self.origin[1])]
    }

    /// Rounded to nearest, halves upwards.
    #[inline]
    fn micrometres(&self, nm: i64) -> i64 {
        (nm + 500).div_euclid(1000)
    }

    fn z_offset(&self) -> i64 {
        (self.settings.printer.z_offset * 1000.0).round() as i64
    }
}

/// A speed in mm/s as F, in thousandths of mm/min and rounded to whole mm/min.
fn feed(speed: f64) -> i64 {
    ((speed * 60.0).clamp(1.0, 1e9) + 0.5) as i64 * 1000
}
