//! Which format a path means.

use std::path::{Path, PathBuf};
use thiserror::Error;

/// A way to write contours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Scalable Vector Graphics, one file.
    Svg,
    /// JavaScript Object Notation, one file.
    Json,
    /// Well-known text, one `MULTIPOLYGON Z` a line.
    Wkt,
    /// Common Layer Interface, ASCII, one file.
    Cli,
    /// A folder with a picture per plane.
    Png,
}

/// A path whose ending names no format.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error(
    "{}: cannot tell the format of the contours; name a file ending in .svg, .json, .wkt or .cli, or a folder (ending in /) for a PNG picture per layer", path.display()
)]
pub struct UnknownFormat {
    /// The path.
    pub path: PathBuf,
}

impl Format {
    /// The format that a path means: a folder (it exists, or the path ends in a separator) gets
    /// pictures, a file what its extension says, in capitals or not.
    ///
    /// # Errors
    /// [`UnknownFormat`] lists what there is.
    pub fn of(path: &Path) -> Result<Self, UnknownFormat> {
        if path.as_os_str().to_string_lossy().ends_with(std::path::is_separator) || path.is_dir() {
            return Ok(Self::Png);
        }
        let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        match extension.as_deref() {
            Some("svg") => Ok(Self::Svg),
            Some("json") => Ok(Self::Json),
            Some("wkt") => Ok(Self::Wkt),
            Some("cli") => Ok(Self::Cli),
            _ => Err(UnknownFormat { path: path.to_owned() }),
        }
    }

    /// Its name, as in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Svg => "svg",
            Self::Json => "json",
            Self::Wkt => "wkt",
            Self::Cli => "cli",
            Self::Png => "png",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_name_formats() {
        let of = |path: &str| Format::of(Path::new(path)).map_err(|e| e.to_string());
        assert_eq!(of("a/b.SVG"), Ok(Format::Svg));
        assert_eq!(of("b.cli"), Ok(Format::Cli));
        assert_eq!(of("no/such/folder/"), Ok(Format::Png));
        assert_eq!(Format::of(&std::env::temp_dir()), Ok(Format::Png));
        for bad in ["a", "a.txt", ".svg", "a.png", "-", ""] {
            let error = of(bad).err().unwrap_or_default();
            assert!([".svg", ".json", ".wkt", ".cli", "folder"].iter().all(|w| error.contains(w)), "{error}");
        }
    }
}
