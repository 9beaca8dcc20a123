//! Everything that can end a job.

use super::output::OutputError;
use crate::contour::TraceError;
use crate::export::png::PictureError;
use crate::gcode::template::TemplateError;
use crate::mask::raster::RasterError;
use crate::mesh::{MeshError, PlaceError};
use crate::resin::Format;
use crate::settings::SettingsError;
use crate::slice::direction::DirectionError;
use crate::slice::planes::PlaneError;
use crate::slice::planes::list::ListError;
use crate::slice::section::SectionError;
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a job ended without output.
#[derive(Debug, Error)]
pub enum JobError {
    /// The model cannot be read.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The model does not fit the printer.
    #[error("{model}: {error}")]
    Place {
        /// The model.
        model: String,
        /// What does not fit.
        error: PlaceError,
    },
    /// The model fits the printer, but not on its raft.
    #[error(
        "{model}: on its raft of {raft_mm:.2} mm the part reaches {height:.2} mm, max_print_height is {limit:.2} mm; set fewer raft_layers, scale, turn or split the part, or set max_print_height (0 = unlimited)"
    )]
    TooHighOnRaft {
        /// The model.
        model: String,
        /// Height of its top above the bed \[mm\].
        height: f64,
        /// Height of the raft with the gap above it \[mm\].
        raft_mm: f64,
        /// The printer's \[mm\].
        limit: f64,
    },
    /// The models do not fit the plate together.
    #[error("{0}")]
    Plate(PlaceError),
    /// The model is larger than what a resin printer lights.
    #[error(
        "{model}: {problem}; scale it, turn it with --rotate, split it, or choose a larger printer with --printer"
    )]
    OffPanel {
        /// The model.
        model: String,
        /// What does not fit.
        problem: String,
    },
    /// The plate cannot be drawn on the panel.
    #[error(transparent)]
    Raster(#[from] RasterError),
    /// The mesh is too large to be cut.
    #[error(transparent)]
    Section(#[from] SectionError),
    /// No pixel of any layer is lit.
    #[error("{model}: nothing to print: no layer lights a pixel; check the model's units and its scale")]
    Dark {
        /// The model.
        model: String,
    },
    /// Layers that the print does not have.
    #[error("--layers {}..{}: the print has {layers} layers, counted from 0; choose among these", range.start, range.end)]
    LayerRange {
        /// Number of layers of the print.
        layers: usize,
        /// The layers asked for.
        range: std::ops::Range<u32>,
    },
    /// A print that the format cannot hold.
    #[error("{format}: {problem}; choose another format with -o")]
    Unfit {
        /// The format.
        format: &'static str,
        /// Why not.
        problem: String,
    },
    /// A format that is only read.
    #[error("{}: such files can be read but not written; choose another format with -o", .0.display())]
    NoWriter(PathBuf),
    /// An output whose name says nothing about its format.
    #[error("{}: no format of layer masks has this extension; give a name that ends in {} with -o, or a folder", path.display(), extensions())]
    NoFormat {
        /// The output.
        path: PathBuf,
    },
    /// The model gives no layers, or too many.
    #[error("{model}: {error}")]
    Planes {
        /// The model.
        model: String,
        /// Why there are none.
        error: PlaneError,
    },
    /// A list of planes is wrong.
    #[error(transparent)]
    PlaneList(#[from] ListError),
    /// A list of planes cannot be read.
    #[error("{}: cannot read the list of planes: {source}; give --planes a text file", path.display())]
    PlaneFile {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The mesh cannot be turned to the planes' normal.
    #[error(transparent)]
    Direction(#[from] DirectionError),
    /// Pictures of that scale cannot be drawn.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The mesh is too large to be traced.
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// A mesh that says where supports go cannot be cut.
    #[error("{}: {error}", file.display())]
    Modifier {
        /// Its file.
        file: PathBuf,
        /// Why not.
        error: TraceError,
    },
    /// There are layers, but nothing on them is wide enough for a line.
    #[error(
        "{model}: nothing to print: no layer has an area that a line of {width_mm:.2} mm fits into; check the model's units and its scale"
    )]
    Empty {
        /// The model.
        model: String,
        /// Width of the external wall \[mm\].
        width_mm: f64,
    },
    /// The whole model lies above the height up to which it was asked for.
    #[error(
        "{model}: nothing lies under z = {z_mm} mm, the part begins at {bottom_mm} mm; use a greater --z"
    )]
    NothingBelow {
        /// The model.
        model: String,
        /// The height \[mm\].
        z_mm: f64,
        /// Its lowest point \[mm\].
        bottom_mm: f64,
    },
    /// A setting is wrong.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// A G-code template is wrong.
    #[error(transparent)]
    Template(#[from] TemplateError),
    /// The GPU asked for is missing or failed.
    #[cfg(feature = "gpu")]
    #[error("{0}; --backend cpu writes the same without a GPU")]
    Device(#[from] crate::gpu::GpuError),
    /// A GPU was asked for, and this program has none built in.
    #[error(
        "this microtome was built without GPU support; use --backend cpu, or build with the feature `gpu`"
    )]
    NoGpuSupport,
    /// The output cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The caller wanted the job to stop.
    #[error("cancelled")]
    Cancelled,
}

/// What a failure is about: what a caller can tell from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureKind {
    /// The model cannot be read, sliced or placed.
    Model,
    /// A setting, a list of planes or a G-code template is wrong.
    Settings,
    /// The GPU asked for is missing or failed.
    Device,
    /// The output cannot be written.
    Output,
    /// A defect of microtome itself: a panic.
    Defect,
    /// The caller wanted the job to stop.
    Cancelled,
    /// The job took longer than it may.
    TimeLimit,
    /// The job took more memory than it may.
    MemoryLimit,
    /// The process that did the job died.
    Crashed,
}

impl FailureKind {
    /// The exit code of a command that ends so.
    pub const fn exit_code(self) -> u8 {
        match self {
            Self::Model => 3,
            Self::Settings => 4,
            Self::Device => 5,
            Self::Output => 6,
            Self::Defect | Self::Cancelled | Self::TimeLimit | Self::MemoryLimit | Self::Crashed => 1,
        }
    }
}

impl JobError {
    /// What the failure is about.
    pub fn kind(&self) -> FailureKind {
        match self {
            Self::Mesh(_)
            | Self::Place { .. }
            | Self::TooHighOnRaft { .. }
            | Self::Plate(_)
            | Self::OffPanel { .. }
            | Self::Section(_)
            | Self::Dark { .. }
            | Self::Planes { .. }
            | Self::Trace(_)
            | Self::Modifier { .. }
            | Self::Direction(_)
            | Self::NothingBelow { .. }
            | Self::Empty { .. } => FailureKind::Model,
            Self::Settings(_)
            | Self::Raster(_)
            | Self::LayerRange { .. }
            | Self::Unfit { .. }
            | Self::NoWriter(_)
            | Self::NoFormat { .. }
            | Self::Template(_)
            | Self::PlaneList(_)
            | Self::PlaneFile { .. }
            | Self::Picture(_) => FailureKind::Settings,
            #[cfg(feature = "gpu")]
            Self::Device(_) => FailureKind::Device,
            Self::NoGpuSupport => FailureKind::Device,
            Self::Output(_) => FailureKind::Output,
            Self::Cancelled => FailureKind::Cancelled,
        }
    }
}

/// The extensions of all formats of masks, as part of a sentence.
fn extensions() -> String {
    let all: Vec<String> =
        Format::ALL.iter().flat_map(|f| f.extensions()).map(|extension| format!(".{extension}")).collect();
    all.join(", ")
}

/// Why writing failed: an error of the stream still without a file's name, or any other.
#[derive(Debug)]
pub enum WriteError {
    /// The stream failed.
    Io(std::io::Error),
    /// Anything else.
    Job(JobError),
}

impl WriteError {
    /// Names the output.
    pub fn at(self, path: &Path) -> JobError {
        match self {
            Self::Io(e) => OutputError::new(path, e).into(),
            Self::Job(e) => e,
        }
    }
}

impl From<std::io::Error> for WriteError {
    fn from(e: std::io::Error) -> Self {
        Self::Io(e)
    }
}

impl From<TemplateError> for WriteError {
    fn from(e: TemplateError) -> Self {
        Self::Job(e.into())
    }
}

impl From<JobError> for WriteError {
    fn from(e: JobError) -> Self {
        Self::Job(e)
    }
}
