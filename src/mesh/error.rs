//! Why a model could not be loaded: one line each, naming the file, the place, the value and a remedy.

use std::fmt;
use std::io;
use std::path::PathBuf;
use thiserror::Error;

/// A model file that cannot be used.
#[derive(Debug, Error)]
#[expect(missing_docs, reason = "fields say what their message shows")]
pub enum MeshError {
    /// No file of that name.
    #[error("{}: no such file; check the path", path.display())]
    Missing { path: PathBuf },
    /// A directory instead of a file.
    #[error("{}: is a directory; name an STL file in it", path.display())]
    Directory { path: PathBuf },
    /// A pipe, socket or device.
    #[error("{}: is not a regular file; save the model to disk first", path.display())]
    NotAFile { path: PathBuf },
    /// The operating system refused.
    #[error("{}: cannot be read: {source}", path.display())]
    Read { path: PathBuf, source: io::Error },
    /// Zero bytes.
    #[error("{}: the file is empty; export the model again", path.display())]
    Empty { path: PathBuf },
    /// Another kind of model file.
    #[error("{}: .{extension} files are not supported; supported are binary and ASCII STL (.stl)", path.display())]
    Unsupported { path: PathBuf, extension: String },
    /// A web page under the name of a model.
    #[error("{}: is a web page (HTML), not an STL model; download the file itself instead of the page about it", path.display())]
    Html { path: PathBuf },
    /// Something else that was recognised.
    #[error("{}: is {looks_like}, not an STL model; supported are binary and ASCII STL", path.display())]
    NotStl { path: PathBuf, looks_like: &'static str },
    /// Fewer bytes than the smallest STL file.
    #[error("{}: has {bytes} bytes and no STL content (a binary STL has at least 134); export the model again", path.display())]
    TooShort { path: PathBuf, bytes: u64 },
    /// A binary file that ends before its facets do.
    #[error("{}: truncated: its header promises {claimed} facets, the file holds {held}; it was cut short or is not an STL model, copy or export it again", path.display())]
    Truncated { path: PathBuf, claimed: u64, held: u64 },
    /// An ASCII file that ends inside a facet.
    #[error("{}: truncated: line {line}: the file ends inside a facet; copy or export it again", path.display())]
    CutShort { path: PathBuf, line: u64 },
    /// ASCII text that breaks the format.
    #[error("{}: line {line}: expected {expected}, found `{found}`; export the model again, as binary STL if possible", path.display())]
    Syntax { path: PathBuf, line: u64, expected: &'static str, found: String },
    /// A valid file without facets.
    #[error("{}: contains no triangles; export the model again", path.display())]
    NoTriangles { path: PathBuf },
    /// More triangles than 32-bit half-edge ids can count.
    #[error("{}: has {facets} facets, at most {limit} can be sliced; reduce the model's resolution", path.display(), limit = super::load::FACET_LIMIT)]
    TooMany { path: PathBuf, facets: u64 },
    /// NaN or infinity.
    #[error("{}: {place} is {value:?}, not a finite number; repair the model or export it again", path.display())]
    NotFinite { path: PathBuf, place: Place, value: f32 },
    /// A coordinate so far away that it has lost its precision.
    #[error("{}: {place} is {value:?} mm, further than 1 km from zero; check the units (millimetres are expected) and scale the model", path.display())]
    OutOfRange { path: PathBuf, place: Place, value: f32 },
    /// A part larger than the lattice.
    #[error("{}: {place} is {value:?} mm, which makes the part {extent:.0} mm long; at most 2147 mm fit, check the units (millimetres are expected) and scale the model", path.display())]
    TooLarge { path: PathBuf, place: Place, value: f32, extent: f64 },
    /// Every triangle has two corners in one point of the lattice.
    #[error("{}: all {facets} facets collapse to points or lines at a resolution of 1 nm; check the units (millimetres are expected) and scale the model", path.display())]
    AllCollapsed { path: PathBuf, facets: u64 },
}

/// Where in a model file a coordinate stands. Facets and corners are counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Facet, from 1.
    pub facet: u64,
    /// Corner, 1 to 3.
    pub corner: u8,
    /// `'x'`, `'y'` or `'z'`.
    pub axis: char,
    /// Line of an ASCII file, from 1.
    pub line: Option<u64>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(line) = self.line {
            write!(f, "line {line}: ")?;
        }
        write!(f, "{} of corner {} of facet {}", self.axis, self.corner, self.facet)
    }
}
