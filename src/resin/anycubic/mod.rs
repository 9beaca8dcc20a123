//! Anycubic's binary files: `.pwmo`, `.pwms`, `.pwma`, `.pwmx`, `.pwmb`, `.pm3`, `.pm5` and their kin.
//!
//! There is no public specification. The facts below agree between three open programs that read or write
//! these files: uv3dp (2020, file version 1, from files of Anycubic's own slicer), PrusaSlicer's Anycubic
//! writer (file version 1) and UVtools (file versions 1 and 515 to 518), the latter two as of 2024; where
//! only UVtools knows a field, it is marked (U). Everything is little-endian.
//!
//! - Mark: `ANYCUBIC` in 12 bytes, u32 file version, u32 number of tables (4, 5, 8, 9 for file version
//!   1, 515, 516, 517), then the u32 addresses of: header, software, preview, grey table, layer table,
//!   extra, from 516 on machine, layer data, from 517 on model, from 518 on sub-images and a second
//!   preview. Tables that a version lacks have address 0.
//! - Tables begin with a name in 12 bytes and a u32 length: that of what follows in `HEADER`, `LAYERDEF` and,
//!   in file version 1, `PREVIEW`; with these 16 bytes in later `PREVIEW` (U), `MACHINE` (U) and `MODEL`
//!   (U); always 24 in `EXTRA` (U). Readers do not mind.
//! - `PREVIEW`: u32 224, four bytes that differ between programs, u32 168, rows of RGB565 from the top
//!   (PrusaSlicer writes BGR565; the other two agree on RGB).
//! - `HEADER`, `EXTRA`, `MACHINE`, ...: see the `tables` module. Speeds are mm/s.
//! - `LAYERDEF`: u32 count, then 32 bytes a layer: u32 address and length of its data; f32 lift \[mm\],
//!   lift speed, exposure \[s\], thickness of this layer \[mm\]; u32 lit pixels (U); u32 0.
//! - Layer data: see the `runs` module (`pw0`, 16 greys) and the `bits` module (`pws`, read only).
//!
//! **Written:** file versions 1, 516 and 517, by extension ([`MACHINES`]). Version 518 (`.pm5s`,
//! `.m5sp`) is read but not written: the length of its sub-image records is not known for certain. What
//! the format has no place for: rests other than the one before the exposure, the light's power, a
//! second stage of the retract whose length is not that of the lift's first stage, pixels that are not
//! square (versions below 518 hold one pitch; the larger is stored, from 516 on with the panel's size).

mod bits;
mod machines;
mod read;
mod runs;
mod tables;
mod write;

#[cfg(test)]
mod tests;

pub use machines::{MACHINES, Machine, machine};
pub use read::open;
pub use runs::{canonical, canonical_grey};
pub use write::Anycubic;

/// Name of the format in messages.
const FORMAT: &str = "anycubic";

/// The first eight bytes of every file.
pub const MAGIC: &[u8] = b"ANYCUBIC";
