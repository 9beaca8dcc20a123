//! Output files that exist whole or not at all.
//!
//! The bytes go to a file without a name in the target's folder, which becomes the target by a link
//! once everything is written, or by a link and a rename where there is one already. A run that is killed
//! on the way leaves the old file, or none, and nothing beside it, save for the moment between link and
//! rename. Where the system has no nameless files a temporary one with a name takes its place, which a
//! kill can leave behind. [`sweep`] removes what was left.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// An output that could not be written.
#[derive(Debug, Error)]
#[error("cannot write {}: {source}; {remedy}", path.display())]
pub struct OutputError {
    /// The file asked for.
    pub path: PathBuf,
    /// What the system said.
    pub source: io::Error,
    /// What to do about it.
    pub remedy: &'static str,
}

impl OutputError {
    /// Names the file and, by the kind of failure, the remedy.
    pub fn new(path: &Path, source: io::Error) -> Self {
        let remedy = match source.kind() {
            io::ErrorKind::NotFound => "create the folder first",
            io::ErrorKind::PermissionDenied => "choose a folder that you may write to with -o",
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => {
                "free some space or choose another disk with -o"
            }
            io::ErrorKind::IsADirectory => "name a file, not a folder, with -o",
            _ => "choose another place with -o",
        };
        Self { path: path.to_owned(), source, remedy }
    }

    /// True when the reader at the other end of a pipe has gone, which is no failure of ours.
    pub fn is_broken_pipe(&self) -> bool {
        self.source.kind() == io::ErrorKind::BrokenPipe
    }
}

/// A file being written; [`Self::commit`] makes it visible, dropping it leaves no trace.
#[derive(Debug)]
pub struct OutputFile {
    target: PathBuf,
    sink: Sink,
}

#[derive(Debug)]
enum Sink {
    /// A file without a name.
    #[cfg(target_os = "linux")]
    Nameless(BufWriter<File>),
    /// A temporary file with a name, removed on drop.
    Named(BufWriter<tempfile::NamedTempFile>),
    /// A device, pipe or socket: cannot be replaced, so it is written to as it is.
    Direct(BufWriter<File>),
}

const BUFFER: usize = 1 << 18;

/// What unfinished outputs end with.
pub(super) const PART: &str = ".part";

/// What old folders end with that are about to be removed.
pub(super) const OLD: &str = ".old";

/// What unfinished outputs of a target begin with; a word and [`PART`] or [`OLD`] follow.
pub(super) fn prefix(target: &Path) -> String {
    format!(".{}.", target.file_name().unwrap_or_default().to_string_lossy())
}

/// What killed processes have left in a folder of files and folders that they were making, each after what it
/// was to become. What others are making at the moment is among it.
pub fn leftovers(folder: &Path) -> Vec<(PathBuf, PathBuf)> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let found = entries.flatten().filter_map(|entry| {
        let name = entry.file_name();
        let name = name.to_str()?.strip_prefix('.')?;
        let name = name.strip_suffix(PART).or_else(|| name.strip_suffix(OLD))?;
        let (target, word) = name.rsplit_once('.')?;
        let ours = !target.is_empty() && !word.is_empty() && word.bytes().all(|b| b.is_ascii_alphanumeric());
        ours.then(|| (folder.join(target), entry.path()))
    });
    found.collect()
}

/// Removes a leftover, as far as possible.
pub fn remove(leftover: &Path) {
    drop(match std::fs::symlink_metadata(leftover) {
        Ok(meta) if meta.is_dir() => std::fs::remove_dir_all(leftover),
        _ => std::fs::remove_file(leftover),
    });
}

/// Removes all that killed processes have left of one output. Nobody may be making it at the moment.
pub fn sweep(target: &Path) {
    for (other, leftover) in leftovers(folder_of(target)) {
        if other.file_name() == target.file_name() {
            remove(&leftover);
        }
    }
}

impl OutputFile {
    /// Starts an output at `path`. The folder must exist; nothing is visible there before
    /// [`Self::commit`]. A symbolic link keeps pointing where it does; its target is replaced.
    ///
    /// # Errors
    /// [`OutputError`] when the folder is missing or not writable, or the path is a folder.
    pub fn create(path: &Path) -> Result<Self, OutputError> {
        Self::open(path).map_err(|e| OutputError::new(path, e))
    }

    fn open(path: &Path) -> io::Result<Self> {
        let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
        if let Ok(meta) = std::fs::metadata(&target) {
            if meta.is_dir() {
                return Err(io::ErrorKind::IsADirectory.into());
            }
            if !meta.is_file() {
                let file = File::options().write(true).open(&target)?;
                return Ok(Self { target, sink: Sink::Direct(BufWriter::with_capacity(BUFFER, file)) });
            }
        }
        if target.file_name().is_none() {
            return Err(io::ErrorKind::IsADirectory.into());
        }
        let folder = folder_of(&target).to_owned();
        #[cfg(target_os = "linux")]
        if let Ok(file) = nameless(&folder) {
            return Ok(Self { target, sink: Sink::Nameless(BufWriter::with_capacity(BUFFER, file)) });
        }
        let file = tempfile::Builder::new().prefix(&prefix(&target)).suffix(PART).tempfile_in(&folder)?;
        Ok(Self { target, sink: Sink::Named(BufWriter::with_capacity(BUFFER, file)) })
    }

    /// Makes the file visible under its name, replacing what was there in one step.
    ///
    /// # Errors
    /// [`OutputError`] when the last bytes cannot be written or the rename fails.
    pub fn commit(self) -> Result<(), OutputError> {
        let target = self.target;
        let done = match self.sink {
            #[cfg(target_os = "linux")]
            Sink::Nameless(mut w) => w.flush().and_then(|()| link_over(w.get_ref(), &target)),
            Sink::Named(mut w) => w.flush().and_then(|()| {
                let named = w.into_inner().map_err(io::IntoInnerError::into_error)?;
                named.persist(&target).map(drop).map_err(|e| e.error)
            }),
            Sink::Direct(mut w) => w.flush(),
        };
        done.map_err(|e| OutputError::new(&target, e))
    }
}

impl Write for OutputFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.sink {
            #[cfg(target_os = "linux")]
            Sink::Nameless(w) => w.write(bytes),
            Sink::Named(w) => w.write(bytes),
            Sink::Direct(w) => w.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.sink {
            #[cfg(target_os = "linux")]
            Sink::Nameless(w) => w.flush(),
            Sink::Named(w) => w.flush(),
            Sink::Direct(w) => w.flush(),
        }
    }
}

impl Seek for OutputFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match &mut self.sink {
            #[cfg(target_os = "linux")]
            Sink::Nameless(w) => w.seek(to),
            Sink::Named(w) => w.seek(to),
            Sink::Direct(w) => w.seek(to),
        }
    }
}

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

#[cfg(target_os = "linux")]
fn nameless(folder: &Path) -> io::Result<File> {
    use rustix::fs::{Mode, OFlags};
    let flags = OFlags::TMPFILE | OFlags::WRONLY | OFlags::CLOEXEC;
    Ok(File::from(rustix::fs::open(folder, flags, Mode::from_raw_mode(0o666))?))
}

/// Gives a nameless file its name. A link alone cannot replace an existing file: then it gets a name beside
/// the target, and is renamed over it.
#[cfg(target_os = "linux")]
fn link_over(file: &File, target: &Path) -> io::Result<()> {
    use rustix::fs::{AtFlags, CWD, linkat};
    use rustix::io::Errno;
    use std::os::fd::AsRawFd;
    let source = format!("/proc/self/fd/{}", file.as_raw_fd());
    let link = |name: &Path| linkat(CWD, source.as_str(), CWD, name, AtFlags::SYMLINK_FOLLOW);
    match link(target) {
        Err(Errno::EXIST) => {}
        other => return Ok(other?),
    }
    let beside = folder_of(target).join(format!("{}{}{PART}", prefix(target), std::process::id()));
    match link(&beside) {
        // A leftover of a killed process that had our number.
        Err(Errno::EXIST) => {
            std::fs::remove_file(&beside)?;
            link(&beside)?;
        }
        other => other?,
    }
    std::fs::rename(&beside, target).inspect_err(|_| drop(std::fs::remove_file(&beside)))
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn nothing_is_visible_before_the_commit_and_all_of_it_after() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.gcode");
        std::fs::write(&path, "old").unwrap();
        let mut out = OutputFile::create(&path).unwrap();
        out.write_all(b"new").unwrap();
        out.flush().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        drop(out);
        assert_eq!(std::fs::read(&path).unwrap(), b"old");
        assert_eq!(names(dir.path()), ["a.gcode"], "a dropped output leaves no trace");

        let mut out = OutputFile::create(&path).unwrap();
        out.write_all(b"new").unwrap();
        out.commit().unwrap();
        assert_eq!(std::fs::read(&path).unwrap(), b"new");
        assert_eq!(names(dir.path()), ["a.gcode"]);
    }

    #[test]
    fn the_named_fallback_does_the_same() {
        let dir = tempfile::tempdir().unwrap();
        let target = dir.path().join("b.gcode");
        let file = tempfile::NamedTempFile::new_in(dir.path()).unwrap();
        let mut out = OutputFile { target: target.clone(), sink: Sink::Named(BufWriter::new(file)) };
        out.write_all(b"x").unwrap();
        assert!(!target.exists());
        out.commit().unwrap();
        assert_eq!(names(dir.path()), ["b.gcode"]);
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_written_to_and_links_followed() {
        let mut null = OutputFile::create(Path::new("/dev/null")).unwrap();
        null.write_all(b"x").unwrap();
        null.commit().unwrap();
        assert!(!std::fs::metadata("/dev/null").unwrap().is_file());

        let dir = tempfile::tempdir().unwrap();
        let (real, link) = (dir.path().join("real"), dir.path().join("link"));
        std::fs::write(&real, "old").unwrap();
        std::os::unix::fs::symlink(&real, &link).unwrap();
        let mut out = OutputFile::create(&link).unwrap();
        out.write_all(b"new").unwrap();
        out.commit().unwrap();
        assert!(std::fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(std::fs::read(&real).unwrap(), b"new");
    }

    #[test]
    fn leftovers_are_swept_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let stay = ["a.gcode", ".a.gcode.b.12.part", ".a.gcode.part", ".a.gcode.12.txt", ".b.gcode.12.part"];
        for name in stay.iter().chain(&[".a.gcode.12.part", ".a.gcode.x9Y.part"]) {
            std::fs::write(dir.path().join(name), "x").unwrap();
        }
        for name in [".a.gcode.y.part", ".a.gcode.z.old"] {
            std::fs::create_dir(dir.path().join(name)).unwrap();
            std::fs::write(dir.path().join(name).join("0.png"), "x").unwrap();
        }
        sweep(&dir.path().join("a.gcode"));
        let mut left = names(dir.path());
        left.sort();
        let mut stay = stay.map(str::to_owned);
        stay.sort();
        assert_eq!(left, stay);
        sweep(Path::new("/no/such/folder/a.gcode"));
    }

    #[test]
    fn a_missing_folder_is_named_with_its_remedy() {
        let error = OutputFile::create(Path::new("/no/such/folder/a.gcode")).unwrap_err().to_string();
        assert!(error.contains("/no/such/folder/a.gcode") && error.contains("create the folder"), "{error}");
        let error = OutputFile::create(&std::env::temp_dir()).unwrap_err().to_string();
        assert!(error.contains("name a file"), "{error}");
    }
}
