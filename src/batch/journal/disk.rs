//! What makes writes last, and keeps two processes apart.

use std::fs::{File, TryLockError};
use std::io;
use std::path::Path;
use std::time::Duration;

/// All that was written to the file system of a folder, data and names, reaches the disk.
///
/// # Errors
/// What the system says; an error of any file of that file system that nobody was told of yet is among it.
#[cfg(target_os = "linux")]
pub(super) fn sync_file_system(folder: &File) -> io::Result<()> {
    Ok(rustix::fs::syncfs(folder)?)
}

/// A new name in a folder reaches the disk, where folders can be synced; some file systems and systems know no
/// such thing, and keep names in order by themselves.
pub(super) fn sync_folder(folder: &Path) {
    #[cfg(unix)]
    if let Ok(folder) = File::open(folder) {
        drop(folder.sync_all());
    }
    #[cfg(not(unix))]
    let _ = folder;
}

/// How a lock was had.
#[derive(Debug)]
pub(super) enum Lock {
    /// It is ours until the process ends, however it ends.
    Held,
    /// Another process has it.
    Taken,
    /// The file system has no locks.
    Unknown(io::Error),
}

/// Takes a lock. One that is taken may be let go soon: a process that was killed takes a moment to end, and a
/// process that it was just starting holds its files until its own program begins.
pub(super) fn lock(file: &File) -> Lock {
    for _ in 0..LOCK_TRIES {
        match file.try_lock() {
            Ok(()) => return Lock::Held,
            Err(TryLockError::WouldBlock) => std::thread::sleep(LOCK_PAUSE),
            Err(TryLockError::Error(e)) => return Lock::Unknown(e),
        }
    }
    Lock::Taken
}

/// How often a lock is asked for, and the time in between.
const LOCK_TRIES: u32 = 25;
const LOCK_PAUSE: Duration = Duration::from_millis(20);

/// Whether the path still leads to the file: another process may have renamed it before we had the lock.
pub(super) fn leads_to(path: &Path, file: &File) -> io::Result<bool> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let found = match std::fs::metadata(path) {
            Ok(found) => found,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(false),
            Err(e) => return Err(e),
        };
        let ours = file.metadata()?;
        Ok((found.dev(), found.ino()) == (ours.dev(), ours.ino()))
    }
    #[cfg(not(unix))]
    {
        let _ = (path, file);
        Ok(true)
    }
}
