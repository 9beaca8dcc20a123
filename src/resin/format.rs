//! The containers known here: their names, extensions, and how files are told apart.

use super::{Container, ReadError, Reader, anycubic};
use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;

/// A kind of container.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Elegoo and others, `.goo`.
    Goo,
    /// Chitubox, `.ctb`, unencrypted.
    Ctb,
    /// Anycubic's binary family, `.pwmx` and kin.
    Anycubic,
    /// Prusa's zip, `.sl1`, `.sl1s`.
    Sl1,
    /// NanoDLP's zip.
    NanoDlp,
    /// A zip of pictures with a manifest.
    PngZip,
    /// A folder of pictures with a manifest.
    PngFolder,
    /// Layers as vector graphics in one file.
    Svg,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Goo,
        Self::Ctb,
        Self::Anycubic,
        Self::Sl1,
        Self::NanoDlp,
        Self::PngZip,
        Self::PngFolder,
        Self::Svg,
    ];

    /// Its name in messages and in `--format`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Goo => "goo",
            Self::Ctb => "ctb",
            Self::Anycubic => "anycubic",
            Self::Sl1 => "sl1",
            Self::NanoDlp => "nanodlp",
            Self::PngZip => "zip",
            Self::PngFolder => "folder",
            Self::Svg => "svg",
        }
    }

    /// Its extensions, lower case, without the dot.
    pub fn extensions(self) -> Vec<&'static str> {
        match self {
            Self::Goo => vec!["goo", "prz"],
            Self::Ctb => vec!["ctb"],
            Self::Anycubic => anycubic::MACHINES.iter().map(|m| m.extension).collect(),
            Self::Sl1 => vec!["sl1", "sl1s"],
            Self::NanoDlp => vec!["nanodlp"],
            Self::PngZip => vec!["zip"],
            Self::PngFolder => vec![],
            Self::Svg => vec!["svg"],
        }
    }

    /// The format of an output's name: by its extension, a folder where it ends in a slash or exists.
    pub fn of_output(path: &Path) -> Option<Self> {
        if path.is_dir() || path.as_os_str().as_encoded_bytes().ends_with(b"/") {
            return Some(Self::PngFolder);
        }
        let extension = extension(path);
        Self::ALL.into_iter().find(|f| f.extensions().contains(&extension.as_str()))
    }

    /// The writer of the format for an output's name; `None` where it can only be read.
    pub fn container(self, path: &Path) -> Option<Box<dyn Container>> {
        match self {
            Self::Anycubic => anycubic::Anycubic::new(&extension(path)).map(|c| Box::new(c) as _),
            // To be filled in: the writers of these formats.
            Self::Goo | Self::Ctb => None,
            Self::Sl1 | Self::NanoDlp | Self::PngZip | Self::PngFolder | Self::Svg => None,
        }
    }
}

/// What a file's first bytes say it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A container.
    Known(Format),
    /// A zip; its entries tell which.
    Zip,
    /// Something else, said so that it follows "it is".
    Other(&'static str),
    /// No idea.
    Unknown,
}

/// Tells a file by its first bytes; 64 are enough.
pub fn detect(start: &[u8]) -> Kind {
    const OTHERS: [(&[u8], &str); 14] = [
        (&[0x07, 0x01, 0xFD, 0x12], "an encrypted CTB; write it again as plain CTB"),
        (&[0x19, 0x00, 0xFD, 0x12], "a CBDDLP or PHOTON file"),
        (b"\x89PNG", "a single PNG picture"),
        (b"\xFF\xD8\xFF", "a single JPEG picture"),
        (b"solid", "an ASCII STL model; slice it first"),
        (b"\x1F\x8B", "a gzip archive"),
        (b"7z\xBC\xAF", "a 7z archive"),
        (b"Rar!", "a RAR archive"),
        (b"%PDF", "a PDF document"),
        (b"\x7FELF", "a program"),
        (b"MZ", "a program"),
        (b"GCDE", "binary G-code"),
        (b"\x09\0\0\0CXSW3DV2", "a Creality CXDLP file"),
        (b"; ", "G-code"),
    ];
    // Bytes 4 to 11 of a .goo; the four before them are its version.
    if start.get(4..12) == Some(&[7, 0, 0, 0, b'D', b'L', b'P', 0]) {
        return Kind::Known(Format::Goo);
    }
    if [[0x86, 0x00, 0xFD, 0x12], [0x06, 0x01, 0xFD, 0x12]].iter().any(|magic| start.starts_with(magic)) {
        return Kind::Known(Format::Ctb);
    }
    if start.starts_with(anycubic::MAGIC) {
        return Kind::Known(Format::Anycubic);
    }
    // A local file, or the end of an empty archive.
    if start.starts_with(b"PK\x03\x04") || start.starts_with(b"PK\x05\x06") {
        return Kind::Zip;
    }
    if let Some((_, what)) = OTHERS.iter().find(|(magic, _)| start.starts_with(magic)) {
        return Kind::Other(what);
    }
    let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start).trim_ascii_start();
    if text.starts_with(b"<?xml") || text.starts_with(b"<svg") || text.starts_with(b"<!DOCTYPE svg") {
        return Kind::Known(Format::Svg);
    }
    Kind::Unknown
}

/// Tells a zip by the names of its entries.
///
/// # Errors
/// [`ReadError::Damaged`] where it has no readable list of entries.
fn detect_zip(file: &File) -> Result<Option<Format>, ReadError> {
    let archive = zip::ZipArchive::new(BufReader::new(file.try_clone()?)).map_err(|e| match e {
        zip::result::ZipError::Io(e) => ReadError::Io(e),
        other => ReadError::Damaged {
            format: "zip",
            what: "the list of entries".to_owned(),
            value: format!("unreadable ({other})"),
            expected: "a whole archive".to_owned(),
        },
    })?;
    let has = |name: &str| archive.index_for_name(name).is_some();
    Ok(if has("prusaslicer.ini") || (has("config.ini") && !has("plate.json")) {
        Some(Format::Sl1)
    } else if has("plate.json") {
        Some(Format::NanoDlp)
    } else if has("manifest.json") {
        Some(Format::PngZip)
    } else {
        None
    })
}

/// Opens a container of any known format; what it is, its content says, not its name.
///
/// # Errors
/// [`ReadError`].
pub fn open(path: &Path) -> Result<Box<dyn Reader>, ReadError> {
    if path.is_dir() {
        return reader(Format::PngFolder, path, None);
    }
    let mut file = File::open(path)?;
    let mut start = Vec::with_capacity(64);
    file.by_ref().take(64).read_to_end(&mut start)?;
    let format = match detect(&start) {
        Kind::Known(format) => Some(format),
        Kind::Zip => detect_zip(&file)?,
        Kind::Other(what) => return Err(foreign(&format!(", it is {what}"))),
        Kind::Unknown => None,
    };
    match format {
        Some(format) => reader(format, path, Some(file)),
        None if start.is_empty() => Err(foreign(", it is empty")),
        None if detect(&start) == Kind::Zip => Err(foreign(", it is a zip without the entries of one")),
        None => Err(foreign("")),
    }
}

/// The reader of a format.
fn reader(format: Format, path: &Path, file: Option<File>) -> Result<Box<dyn Reader>, ReadError> {
    match (format, file) {
        (Format::Anycubic, Some(file)) => anycubic::open(BufReader::new(file), &extension(path)),
        // To be filled in: a reader each.
        (Format::Goo, _) => Err(unread(format)),
        (Format::Ctb, _) => Err(unread(format)),
        (Format::Sl1, _) => Err(unread(format)),
        (Format::NanoDlp, _) => Err(unread(format)),
        (Format::PngZip, _) => Err(unread(format)),
        (Format::PngFolder, _) => Err(unread(format)),
        (Format::Svg, _) => Err(unread(format)),
        (_, None) => Err(ReadError::Io(io::ErrorKind::IsADirectory.into())),
    }
}

fn unread(format: Format) -> ReadError {
    foreign(&format!(", it is {}, which cannot be read yet", format.name()))
}

fn foreign(hint: &str) -> ReadError {
    let known = Format::ALL.map(Format::name).join(", ");
    ReadError::Foreign { hint: hint.to_owned(), known }
}

/// The extension in lower case, without the dot; empty where there is none.
fn extension(path: &Path) -> String {
    path.extension().map_or(String::new(), |e| e.to_string_lossy().to_ascii_lowercase())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn files_are_told_by_their_first_bytes() {
        let known = [
            (b"V3.0\x07\0\0\0DLP\0rest".as_slice(), Kind::Known(Format::Goo)),
            (b"\x86\x00\xFD\x12", Kind::Known(Format::Ctb)),
            (b"\x06\x01\xFD\x12", Kind::Known(Format::Ctb)),
            (b"ANYCUBIC\0\0\0\0", Kind::Known(Format::Anycubic)),
            (b"PK\x03\x04..", Kind::Zip),
            (b"\xEF\xBB\xBF <?xml version", Kind::Known(Format::Svg)),
            (b"", Kind::Unknown),
            (b"V3.0\x07\0\0\0DL", Kind::Unknown),
        ];
        for (start, kind) in known {
            assert_eq!(detect(start), kind, "{}", start.escape_ascii());
        }
        assert!(matches!(detect(b"\x07\x01\xFD\x12"), Kind::Other(what) if what.contains("encrypted")));
    }

    #[test]
    fn extensions_name_one_format_each() {
        let mut all: Vec<&str> = Format::ALL.iter().flat_map(|f| f.extensions()).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count);
        assert_eq!(Format::of_output(Path::new("a/b.PWMX")), Some(Format::Anycubic));
        assert_eq!(Format::of_output(Path::new("a/b/")), Some(Format::PngFolder));
        assert_eq!(Format::of_output(Path::new("a/b.stl")), None);
    }

    #[test]
    fn what_cannot_be_opened_says_why() {
        let dir = tempfile::tempdir().unwrap();
        let said = |name: &str, bytes: &[u8]| {
            let path = dir.path().join(name);
            std::fs::write(&path, bytes).unwrap();
            open(&path).map(drop).unwrap_err().to_string()
        };
        assert!(said("a.goo", b"").contains("it is empty"));
        assert!(said("a.goo", b"\x89PNG\r\n\x1A\n").contains("a single PNG"));
        assert!(said("a.goo", b"something").starts_with("is no container known here; known are goo, ctb"));
        assert!(said("a.zip", b"PK\x03\x04 but no more").contains("list of entries"));
        assert!(said("a.pwmx", b"ANYCUBIC").contains("truncated"));
        assert!(matches!(open(&dir.path().join("missing.goo")), Err(ReadError::Io(_))));
    }
}
