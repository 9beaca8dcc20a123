//! Facts about files: whether one has changed, what is in it.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;

/// Size \[bytes\] and time of modification \[ns since 1970\] of a file, as [`super::Request::expect`] takes it.
///
/// # Errors
/// What the system says; `InvalidInput` where it is no regular file.
pub fn stat(path: &Path) -> io::Result<[i64; 2]> {
    let meta = fs::metadata(path)?;
    if !meta.is_file() {
        return Err(io::ErrorKind::InvalidInput.into());
    }
    let nanos = match meta.modified()?.duration_since(UNIX_EPOCH) {
        Ok(after) => i64::try_from(after.as_nanos()).unwrap_or(i64::MAX),
        Err(before) => i64::try_from(before.duration().as_nanos()).map_or(i64::MIN, |n| -n),
    };
    Ok([i64::try_from(meta.len()).unwrap_or(i64::MAX), nanos])
}

/// Length \[bytes\] and CRC-32 (IEEE 802.3) of a file, or of a folder's files one after the other in the order
/// of their names. What is neither, such as a pipe, has none of both.
///
/// # Errors
/// What the system says.
pub fn length_and_crc32(path: &Path) -> io::Result<(u64, u32)> {
    let meta = fs::metadata(path)?;
    let mut crc = crc32fast::Hasher::new();
    let mut length = 0;
    if meta.is_dir() {
        let entries = fs::read_dir(path)?.map(|entry| Ok(entry?.path()));
        let mut files = entries.collect::<io::Result<Vec<PathBuf>>>()?;
        files.sort();
        for file in files {
            length += add(&file, &mut crc)?;
        }
    } else if meta.is_file() {
        length = add(path, &mut crc)?;
    }
    Ok((length, crc.finalize()))
}

fn add(path: &Path, crc: &mut crc32fast::Hasher) -> io::Result<u64> {
    let mut file = File::open(path)?;
    let mut buffer = vec![0; 1 << 18];
    let mut length = 0;
    loop {
        match file.read(&mut buffer) {
            Ok(0) => return Ok(length),
            Ok(n) => {
                crc.update(buffer.get(..n).unwrap_or_default());
                length += n as u64;
            }
            Err(e) if e.kind() == io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
}

/// Makes the folder that a file is to go into, and those around it.
///
/// # Errors
/// What the system says.
pub fn make_folder_of(path: &Path) -> io::Result<()> {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => fs::create_dir_all(folder),
        _ => Ok(()),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn folders_count_in_the_order_of_names() {
        let dir = tempfile::tempdir().unwrap();
        for (name, text) in [("b", "89"), ("a", "1234567")] {
            fs::write(dir.path().join(name), text).unwrap();
        }
        // The check value of CRC-32 is that of "123456789".
        assert_eq!(length_and_crc32(dir.path()).unwrap(), (9, 0xCBF4_3926));
        assert_eq!(length_and_crc32(&dir.path().join("b")).unwrap().0, 2);
        assert!(length_and_crc32(&dir.path().join("c")).is_err());
    }

    #[test]
    fn a_file_s_state_tells_changes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("sub/folder/a");
        assert!(stat(&path).is_err() && stat(dir.path()).is_err());
        make_folder_of(&path).unwrap();
        fs::write(&path, "abc").unwrap();
        let file = File::options().write(true).open(&path).unwrap();
        file.set_modified(UNIX_EPOCH + std::time::Duration::from_nanos(1_500_000_000)).unwrap();
        assert_eq!(stat(&path).unwrap(), [3, 1_500_000_000]);
        file.set_modified(UNIX_EPOCH - std::time::Duration::from_secs(2)).unwrap();
        assert_eq!(stat(&path).unwrap(), [3, -2_000_000_000]);
    }
}
