//! A model file to a mesh: open, recognise, parse, measure, weld.

use super::detect::{Kind, detect};
use super::error::{MeshError, Place};
use super::frame::{self, Soup};
use super::stl::{ascii, binary};
use super::{Mesh, weld};
use memmap2::Mmap;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Largest number of facets: half-edge ids and the mark of an open edge share 32 bits.
pub const FACET_LIMIT: u64 = (u32::MAX as u64 - 1) / 3;

/// A model as it came from its file.
#[derive(Debug)]
pub struct Loaded {
    /// The part; its `origin` keeps the file's coordinates.
    pub mesh: Mesh,
    /// Facets in the file.
    pub facets: u64,
    /// Facets dropped because two of their corners are one point of the lattice.
    pub collapsed: u64,
    /// What was odd about the file.
    pub warnings: Vec<Warning>,
}

/// An oddity of a file that could be used all the same. One line each.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum Warning {
    /// Bytes behind the facets that the header promised.
    #[error("{}: {bytes} bytes behind the promised {facets} facets were ignored", path.display())]
    TrailingBytes {
        /// The file.
        path: PathBuf,
        /// Bytes ignored.
        bytes: u64,
        /// Facets read.
        facets: u64,
    },
    /// An ASCII file that stops after a whole facet.
    #[error("{}: the file ends without `endsolid`; it may have been cut short", path.display())]
    NoEndSolid {
        /// The file.
        path: PathBuf,
    },
}

/// Loads an STL file, binary or ASCII, recognised by its content.
///
/// Coordinates are millimetres, rounded to nanometres, halves away from zero.
///
/// # Errors
/// [`MeshError`] names the file, the place in it, the value, and what to do.
pub fn load(path: &Path) -> Result<Loaded, MeshError> {
    let read = |source: io::Error| match source.kind() {
        io::ErrorKind::NotFound => MeshError::Missing { path: path.into() },
        _ => MeshError::Read { path: path.into(), source },
    };
    let kind = fs::metadata(path).map_err(read)?;
    if kind.is_dir() {
        return Err(MeshError::Directory { path: path.into() });
    }
    if !kind.is_file() {
        return Err(MeshError::NotAFile { path: path.into() });
    }
    if kind.len() == 0 {
        return Err(MeshError::Empty { path: path.into() });
    }
    let file = File::open(path).map_err(read)?;
    // SAFETY: the map is only read, as bytes, of which every pattern is valid. A file that another
    // program shortens meanwhile ends this program, as it would any that maps its input.
    let bytes = unsafe { Mmap::map(&file) }.map_err(read)?;
    load_bytes(path, &bytes)
}

/// [`load`] for bytes in memory; `path` names them in messages and lends its extension.
///
/// # Errors
/// As [`load`].
pub fn load_bytes(path: &Path, bytes: &[u8]) -> Result<Loaded, MeshError> {
    if bytes.is_empty() {
        return Err(MeshError::Empty { path: path.into() });
    }
    let kind = detect(bytes);
    if let (Some(extension), false) = (foreign(path), matches!(kind, Kind::Binary | Kind::Ascii)) {
        return Err(MeshError::Unsupported { path: path.into(), extension });
    }
    match kind {
        Kind::Binary | Kind::Unclear => load_binary(path, bytes),
        Kind::Ascii => load_ascii(path, bytes),
        Kind::Utf16 { big_endian } => load_ascii(path, utf8(bytes, big_endian).as_bytes()),
        Kind::Html => Err(MeshError::Html { path: path.into() }),
        Kind::Other(looks_like) => Err(MeshError::NotStl { path: path.into(), looks_like }),
        Kind::Short => Err(MeshError::TooShort { path: path.into(), bytes: bytes.len() as u64 }),
    }
}

/// An extension that names another format, lower case.
fn foreign(path: &Path) -> Option<String> {
    let extension = path.extension()?.to_string_lossy().to_lowercase();
    (extension != "stl").then_some(extension)
}

fn load_binary(path: &Path, bytes: &[u8]) -> Result<Loaded, MeshError> {
    let soup = binary::parse(bytes).map_err(|t| MeshError::Truncated {
        path: path.into(),
        claimed: t.claimed,
        held: t.held,
    })?;
    let mut loaded = index(path, &soup, |_| None)?;
    if soup.trailing > 0 {
        let (bytes, facets) = (soup.trailing, loaded.facets);
        loaded.warnings.push(Warning::TrailingBytes { path: path.into(), bytes, facets });
    }
    Ok(loaded)
}

fn load_ascii(path: &Path, text: &[u8]) -> Result<Loaded, MeshError> {
    let bom = if text.starts_with(&[0xEF, 0xBB, 0xBF]) { 3 } else { 0 };
    let text = &text[bom..];
    let soup = ascii::parse(text).map_err(|fault| {
        let (path, line) = (path.into(), ascii::line(text, fault.at));
        match fault.found {
            None => MeshError::CutShort { path, line },
            Some(found) => MeshError::Syntax { path, line, expected: fault.expected, found },
        }
    })?;
    let mut loaded =
        index(path, &soup, |fault| Some(ascii::line_of_corner(text, fault.facet, fault.corner)))?;
    if !soup.ended {
        loaded.warnings.push(Warning::NoEndSolid { path: path.into() });
    }
    Ok(loaded)
}

/// Measures and welds a soup; `line` finds a faulty coordinate's line in a text.
fn index(
    path: &Path,
    soup: &impl Soup,
    line: impl Fn(&frame::Fault) -> Option<u64>,
) -> Result<Loaded, MeshError> {
    let facets = soup.len() as u64;
    if facets == 0 {
        return Err(MeshError::NoTriangles { path: path.into() });
    }
    if facets > FACET_LIMIT {
        return Err(MeshError::TooMany { path: path.into(), facets });
    }
    let (welded, frame) = weld::weld(soup).map_err(|fault| {
        let (path, value) = (path.into(), fault.value);
        let place = Place {
            facet: fault.facet as u64 + 1,
            corner: fault.corner as u8 + 1,
            axis: ['x', 'y', 'z'][fault.axis],
            line: line(&fault),
        };
        match fault.extent {
            Some(extent) => MeshError::TooLarge { path, place, value, extent },
            None if value.is_finite() => MeshError::OutOfRange { path, place, value },
            None => MeshError::NotFinite { path, place, value },
        }
    })?;
    if welded.triangles.is_empty() {
        return Err(MeshError::AllCollapsed { path: path.into(), facets });
    }
    let mesh = Mesh { vertices: welded.vertices, triangles: welded.triangles, origin: frame.origin };
    Ok(Loaded { mesh, facets, collapsed: welded.collapsed, warnings: Vec::new() })
}

/// UTF-16 text behind its byte order mark as UTF-8; what is not text becomes U+FFFD.
pub(super) fn utf8(bytes: &[u8], big_endian: bool) -> String {
    let (pairs, _) = bytes[2..].as_chunks::<2>();
    let unit =
        |pair: &[u8; 2]| if big_endian { u16::from_be_bytes(*pair) } else { u16::from_le_bytes(*pair) };
    char::decode_utf16(pairs.iter().map(unit)).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}
