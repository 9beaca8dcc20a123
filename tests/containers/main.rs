//! All containers are held to the same contract.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod contract;
mod formats;
mod nanodlp;
mod sl1;
mod stack;
mod svg;
mod zipped;

use microtome::resin::anycubic::{self, Anycubic};
use microtome::resin::{ReadError, Reader, format};
use std::io::Cursor;

/// Opens through a file in a folder of its own, as the program does.
fn through_file(extension: &str, bytes: &[u8]) -> Result<Box<dyn Reader>, ReadError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(format!("a.{extension}"));
    std::fs::write(&path, bytes).unwrap();
    // The file stays open when its name is gone.
    format::open(&path)
}

#[test]
fn anycubic_keeps_the_contract() {
    for extension in ["pw0", "pwmx", "pm5"] {
        let container = Anycubic::new(extension).unwrap();
        let memory = |bytes: &[u8]| anycubic::open(Cursor::new(bytes.to_vec()), extension);
        contract::round_trip(&container, &memory, anycubic::canonical_grey);
        contract::round_trip(&container, &|bytes| through_file(extension, bytes), anycubic::canonical_grey);
        contract::damage(&container, &memory, 2000);
        contract::counts(&container);
    }
}
