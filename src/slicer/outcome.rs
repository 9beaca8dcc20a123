//! What came of a request.

use crate::job::{FailureKind, JobError};
use crate::mesh::MeshError;
use crate::settings::SettingsError;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::io::ErrorKind;

/// What a finished print is made of.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Material {
    /// Length of filament \[mm\]; 0 for resin.
    pub mm: f64,
    /// Volume \[cm³ = ml\].
    pub cm3: f64,
    /// Mass \[g\]; absent where the density is not set.
    pub g: Option<f64>,
    /// Price; absent where density or cost is not set.
    pub cost: Option<f64>,
    /// Length of filament by what is printed \[mm\].
    pub mm_by_role: BTreeMap<String, f64>,
}

/// A request done.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Outcome {
    /// Bytes of the output; 0 where only an estimate was asked for.
    pub bytes: u64,
    /// CRC-32 (IEEE 802.3) of the output, or of a folder's files in the order of their names.
    pub crc32: u32,
    /// Layers.
    pub layers: u64,
    /// Height of the top layer \[mm\].
    pub print_z_mm: f64,
    /// Triangles after welding, of one copy or of all on the plate.
    pub triangles: u64,
    /// What it is made of.
    pub material: Material,
    /// Lower bound of the print time: lengths over speeds, or exposures and lifts; no acceleration \[s\].
    pub time_lower_bound_s: f64,
    /// The same by what is printed \[s\]; `travel` among them.
    pub time_by_role_s: BTreeMap<String, f64>,
    /// Everything that deserves a look.
    pub warnings: Vec<String>,
    /// `cpu` or `gpu`.
    pub backend: String,
    /// Wall time of the work \[s\].
    pub seconds: f64,
    /// CPU time of the process over the work \[s\]; of everything in it, if it does several at once.
    pub cpu_seconds: f64,
    /// Wall time of each stage \[s\], in order.
    pub stages: Vec<(String, f64)>,
    /// The most memory the process held so far \[bytes\]; 0 where the system does not say.
    pub peak_bytes: u64,
}

/// A request that could not be done.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[error("{message}")]
pub struct Failure {
    /// What it is about.
    pub kind: FailureKind,
    /// File, place, value and remedy, in one line.
    pub message: String,
    /// Whether another try may succeed: a lost device, a file that changed, an error of the system.
    pub transient: bool,
    /// Whether the disk is full, so that others will fail too.
    pub disk_full: bool,
}

impl Failure {
    /// A failure that will come again.
    pub const fn new(kind: FailureKind, message: String) -> Self {
        Self { kind, message, transient: false, disk_full: false }
    }
}

impl From<&JobError> for Failure {
    fn from(error: &JobError) -> Self {
        let (transient, disk_full) = match error {
            #[cfg(feature = "gpu")]
            JobError::Device(e) => (e.may_pass(), false),
            JobError::Output(e) => (may_pass(e.source.kind()), is_full(e.source.kind())),
            JobError::Mesh(MeshError::Read { source, .. }) => (may_pass(source.kind()), false),
            JobError::Settings(e) => (settings_may_pass(e), false),
            _ => (false, false),
        };
        Self { kind: error.kind(), message: error.to_string(), transient, disk_full }
    }
}

/// Whether settings could not be read for a reason that may be gone at the next try.
pub(super) fn settings_may_pass(error: &SettingsError) -> bool {
    matches!(error, SettingsError::Io { source, .. } if may_pass(source.kind()))
}

fn is_full(kind: ErrorKind) -> bool {
    matches!(kind, ErrorKind::StorageFull | ErrorKind::QuotaExceeded)
}

/// Whether an error of the system may be gone at the next try: all but those that somebody must put right.
fn may_pass(kind: ErrorKind) -> bool {
    !is_full(kind)
        && !matches!(
            kind,
            ErrorKind::NotFound
                | ErrorKind::PermissionDenied
                | ErrorKind::IsADirectory
                | ErrorKind::NotADirectory
                | ErrorKind::DirectoryNotEmpty
                | ErrorKind::AlreadyExists
                | ErrorKind::ReadOnlyFilesystem
                | ErrorKind::FileTooLarge
                | ErrorKind::InvalidFilename
                | ErrorKind::InvalidInput
                | ErrorKind::InvalidData
                | ErrorKind::Unsupported
                | ErrorKind::BrokenPipe
        )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::job::output::OutputError;
    use std::io;
    use std::path::Path;

    #[test]
    fn what_may_pass_is_told_from_what_stays() {
        let output = |e: io::Error| Failure::from(&JobError::from(OutputError::new(Path::new("a"), e)));
        let full = output(ErrorKind::StorageFull.into());
        assert_eq!((full.kind, full.transient, full.disk_full), (FailureKind::Output, false, true));
        let full = output(io::Error::from_raw_os_error(122));
        assert!(full.disk_full, "EDQUOT: {full:?}");
        let denied = output(ErrorKind::PermissionDenied.into());
        assert!(!denied.transient && !denied.disk_full);
        let broken = output(io::Error::from_raw_os_error(5));
        assert!(broken.transient && !broken.disk_full, "EIO: {broken:?}");

        let mesh = |source| Failure::from(&JobError::from(MeshError::Read { path: "m".into(), source }));
        assert!(mesh(io::Error::from_raw_os_error(5)).transient);
        assert!(mesh(ErrorKind::TimedOut.into()).transient);
        assert!(!mesh(ErrorKind::PermissionDenied.into()).transient);
        let missing = Failure::from(&JobError::from(MeshError::Missing { path: "m".into() }));
        assert_eq!((missing.kind, missing.transient), (FailureKind::Model, false));
        assert!(!Failure::from(&JobError::Cancelled).transient);
    }
}
