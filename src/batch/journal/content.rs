//! Checksums of outputs.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::Path;

/// CRC-32 (IEEE 802.3) of a file, or of the files of a folder one after the other, in the order of their names,
/// as in [`crate::slicer::Outcome::crc32`].
///
/// # Errors
/// When something cannot be read.
pub fn content_crc32(path: &Path) -> io::Result<u32> {
    let mut hasher = crc32fast::Hasher::new();
    let mut buffer = vec![0; 1 << 17];
    if fs::metadata(path)?.is_dir() {
        let mut names =
            fs::read_dir(path)?.map(|entry| entry.map(|e| e.path())).collect::<io::Result<Vec<_>>>()?;
        names.sort();
        for name in names {
            add(&mut hasher, &mut buffer, &name)?;
        }
    } else {
        add(&mut hasher, &mut buffer, path)?;
    }
    Ok(hasher.finalize())
}

fn add(hasher: &mut crc32fast::Hasher, buffer: &mut [u8], path: &Path) -> io::Result<()> {
    let mut file = File::open(path)?;
    loop {
        match file.read(buffer) {
            Ok(0) => return Ok(()),
            Ok(n) => hasher.update(buffer.get(..n).unwrap_or_default()),
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
}
