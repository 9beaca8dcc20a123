//! Where masks are written: a file, or a folder of files, whole or not at all.

use crate::job::JobError;
use crate::job::output::{self, OutputError, OutputFile};
use crate::resin::{Container, Format, LayerInfo, LayerSink, Print, Totals, stack};
use crate::settings::Settings;
use std::fs;
use std::io::{self, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The format of an output, by its name and by what the printer reads.
///
/// # Errors
/// [`JobError::NoFormat`], [`JobError::Settings`] where the printer reads files that cannot be written.
pub fn format_of(path: &Path, settings: &Settings) -> Result<Format, JobError> {
    if Format::is_folder(path) {
        return Ok(Format::PngFolder);
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    let extension = match name.rsplit_once('.') {
        Some(_) if name.ends_with(".svg.zip") => Some("svg.zip"),
        Some((_, extension)) => Some(extension),
        // A device such as /dev/null.
        None => None,
    };
    let extension = settings.output_extension(extension)?;
    Format::of_extension(extension).ok_or_else(|| JobError::NoFormat { path: path.to_owned() })
}

/// An output that appears when it is committed; dropping it leaves no trace.
pub(super) struct Target {
    path: PathBuf,
    place: Place,
}

enum Place {
    File(Box<OutputFile>),
    /// A folder beside the target that becomes the target.
    Folder(TempDir),
}

/// The layers of an output, with errors that name it.
pub(super) struct TargetSink<'a> {
    path: &'a Path,
    sink: Box<dyn LayerSink + 'a>,
}

impl Target {
    /// Begins an output.
    ///
    /// # Errors
    /// [`OutputError`]: the folder around it is missing or not writable, or the target is a folder with
    /// other things in it, which would be lost.
    pub(super) fn create(path: &Path, format: Format) -> Result<Self, OutputError> {
        let place = if format == Format::PngFolder {
            Self::refuse_other_folders(path)?;
            let made = tempfile::Builder::new()
                .prefix(&output::prefix(path))
                .suffix(output::PART)
                .tempdir_in(around(path));
            Place::Folder(made.map_err(|e| OutputError::new(path, e))?)
        } else {
            Place::File(Box::new(OutputFile::create(path)?))
        };
        Ok(Self { path: path.to_owned(), place })
    }

    fn refuse_other_folders(path: &Path) -> Result<(), OutputError> {
        let failed = |source| OutputError::new(path, source);
        if !path.exists() {
            return Ok(());
        }
        if !path.is_dir() {
            return Err(OutputError {
                path: path.to_owned(),
                source: io::ErrorKind::NotADirectory.into(),
                remedy: "it is a file; name a folder that does not exist yet with -o",
            });
        }
        let mut entries = fs::read_dir(path).map_err(failed)?;
        if entries.next().is_none() || path.join(stack::MANIFEST).is_file() {
            return Ok(());
        }
        Err(OutputError {
            path: path.to_owned(),
            source: io::ErrorKind::DirectoryNotEmpty.into(),
            remedy: "the folder holds other files than layers; name another with -o",
        })
    }

    /// Begins to write.
    ///
    /// # Errors
    /// [`JobError::Unfit`] where the format cannot hold the print, [`OutputError`].
    pub(super) fn begin<'a>(
        &'a mut self,
        container: &'a dyn Container,
        print: &'a Print,
    ) -> Result<TargetSink<'a>, JobError> {
        let path = &self.path;
        let sink = match &mut self.place {
            Place::File(file) => container.begin(file.as_mut(), print),
            Place::Folder(folder) => stack::PngStack.begin_folder(folder.path(), print),
        };
        let sink = sink.map_err(|e| match e.kind() {
            io::ErrorKind::InvalidInput => {
                JobError::Unfit { format: container.name(), problem: e.to_string() }
            }
            _ => OutputError::new(path, e).into(),
        })?;
        Ok(TargetSink { path, sink })
    }

    /// Makes the output visible and returns its length in bytes, of a folder that of all its files.
    ///
    /// # Errors
    /// [`OutputError`].
    pub(super) fn commit(self) -> Result<u64, OutputError> {
        let path = self.path;
        let failed = |source| OutputError::new(&path, source);
        match self.place {
            Place::File(mut file) => {
                let bytes = file.seek(SeekFrom::End(0)).map_err(failed)?;
                file.commit()?;
                Ok(bytes)
            }
            Place::Folder(folder) => replace(folder, &path).map_err(failed),
        }
    }
}

/// Puts a folder in the place of another, and returns the length of its files.
fn replace(folder: TempDir, path: &Path) -> io::Result<u64> {
    let mut bytes = 0;
    for entry in fs::read_dir(folder.path())? {
        bytes += entry?.metadata()?.len();
    }
    open_to_others(folder.path())?;
    if path.is_dir() {
        // The old layers go aside in one step and the new ones come in another: a kill between the two
        // leaves both, whole, beside each other.
        let aside = tempfile::Builder::new()
            .prefix(&output::prefix(path))
            .suffix(output::OLD)
            .tempdir_in(around(path))?;
        let old = aside.path().join("layers");
        fs::rename(path, &old)?;
        if let Err(error) = fs::rename(folder.path(), path) {
            fs::rename(&old, path)?;
            return Err(error);
        }
    } else {
        fs::rename(folder.path(), path)?;
    }
    // It has another name now; there is nothing left to remove under the old one.
    let _ = folder.keep();
    Ok(bytes)
}

/// Temporary folders are closed to other users; the output should be like any folder.
fn open_to_others(folder: &Path) -> io::Result<()> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        fs::set_permissions(folder, fs::Permissions::from_mode(0o755))?;
    }
    #[cfg(not(unix))]
    let _ = folder;
    Ok(())
}

fn around(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

impl TargetSink<'_> {
    /// Appends a layer.
    ///
    /// # Errors
    /// [`OutputError`].
    pub(super) fn layer(&mut self, info: &LayerInfo, encoded: &[u8]) -> Result<(), JobError> {
        self.sink.layer(info, encoded).map_err(|e| OutputError::new(self.path, e).into())
    }

    /// Completes the file.
    ///
    /// # Errors
    /// [`OutputError`].
    pub(super) fn finish(self, totals: &Totals) -> Result<(), JobError> {
        self.sink.finish(totals).map_err(|e| OutputError::new(self.path, e).into())
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;

    #[test]
    fn folders_of_layers_are_replaced_and_others_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("layers");
        let write = |text: &str| {
            let target = Target::create(&path, Format::PngFolder).unwrap();
            let Place::Folder(folder) = &target.place else { unreachable!() };
            fs::write(folder.path().join(stack::MANIFEST), text).unwrap();
            target
        };
        drop(write("lost"));
        assert!(!path.exists() && fs::read_dir(dir.path()).unwrap().next().is_none());
        assert_eq!(write("first").commit().unwrap(), 5);
        assert_eq!(write("second").commit().unwrap(), 6);
        assert_eq!(fs::read_to_string(path.join(stack::MANIFEST)).unwrap(), "second");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1, "nothing stays beside it");
        let other = dir.path().join("other");
        fs::create_dir(&other).unwrap();
        assert!(Target::create(&other, Format::PngFolder).is_ok(), "an empty folder is as good as none");
        fs::write(other.join("letter.txt"), "dear").unwrap();
        let error = Target::create(&other, Format::PngFolder).err().unwrap().to_string();
        assert!(error.contains("holds other files"), "{error}");
        let error = Target::create(&other.join("letter.txt"), Format::PngFolder).err().unwrap().to_string();
        assert!(error.contains("it is a file"), "{error}");
    }
}
