//! The containers known here: their names, extensions, and how files are told apart.

use super::{Container, ReadError, Reader, anycubic, ctb, goo, layer_files, nanodlp, sl1, stack, svg};
use std::fs::File;
use std::io::{BufReader, Read, Seek};
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
            Self::Svg => vec!["svg.zip"],
        }
    }

    /// The format whose files have this extension (lower case, no dot).
    pub fn of_extension(extension: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|f| f.extensions().contains(&extension))
    }

    /// Whether an output is a folder: it is one already, ends in a slash, or is new and has no extension.
    pub fn is_folder(path: &Path) -> bool {
        let new = || path.extension().is_none() && !path.exists();
        path.is_dir() || path.as_os_str().as_encoded_bytes().ends_with(b"/") || new()
    }

    /// The writer of the format for an output's name. `version` is `ctb_version` of the settings, 0
    /// for the writer's own choice. `None` where the format can only be read.
    pub fn container(self, path: &Path, version: u32) -> Option<Box<dyn Container>> {
        Some(match self {
            Self::Anycubic => Box::new(anycubic::Anycubic::new(&extension(path))?),
            Self::Goo => Box::new(goo::Goo),
            Self::Ctb => {
                let version = if version == 4 { ctb::Version::Four } else { ctb::Version::Three };
                Box::new(ctb::Ctb { version })
            }
            Self::Sl1 => Box::new(sl1::Sl1),
            Self::NanoDlp => Box::new(nanodlp::NanoDlp),
            Self::PngZip | Self::PngFolder => Box::new(stack::PngStack),
            Self::Svg => Box::new(svg::SvgLayers),
        })
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

/// Opens a container of any known format; what it is, its content says, not its name.
///
/// # Errors
/// [`ReadError`].
pub fn open(path: &Path) -> Result<Box<dyn Reader>, ReadError> {
    if path.is_dir() {
        return layer_files::open_folder(path);
    }
    let mut file = File::open(path)?;
    let mut start = Vec::with_capacity(64);
    file.by_ref().take(64).read_to_end(&mut start)?;
    file.rewind()?;
    match detect(&start) {
        Kind::Known(Format::Goo) => goo::open(Box::new(file)),
        Kind::Known(Format::Ctb) => ctb::open(Box::new(file)),
        Kind::Known(Format::Anycubic) => anycubic::open(BufReader::new(file), &extension(path)),
        Kind::Zip => layer_files::open_zip(Box::new(file)),
        Kind::Known(other) => Err(foreign(&format!(", it is {} and not in an archive", other.name()))),
        Kind::Other(what) => Err(foreign(&format!(", it is {what}"))),
        Kind::Unknown if start.is_empty() => Err(foreign(", it is empty")),
        Kind::Unknown => Err(foreign("")),
    }
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
    use crate::settings::printers;
    use std::path::PathBuf;

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
        for preset in printers::all() {
            let container = preset.settings().unwrap().machine.container;
            let path = PathBuf::from(format!("a.{}", container.extension()));
            let format = Format::of_extension(container.extension()).unwrap();
            let writes = format.container(&path, 0).is_some() && container.name() != "encrypted-ctb";
            assert_eq!(writes, container.is_written(), "{container:?}");
        }
        assert_eq!(Format::of_extension("stl"), None);
        assert!(Format::is_folder(Path::new("a/b/")) && Format::is_folder(Path::new("a/b")));
        assert!(!Format::is_folder(Path::new("a/b.goo")));
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
        assert!(!said("a.zip", b"PK\x03\x04 but no more").is_empty());
        assert!(said("a.pwmx", b"ANYCUBIC").contains("truncated"));
        assert!(matches!(open(&dir.path().join("missing.goo")), Err(ReadError::Io(_))));
    }
}
