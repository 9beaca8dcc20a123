//! Flags about supports that are not settings.

use super::exit::CliError;
use crate::job::JobError;
use crate::job::filament::ModifierFiles;
use crate::job::output::{OutputError, OutputFile};
use crate::job::summary::Summary;
use crate::job::support_report::{SupportRecord, SupportWish};
use crate::job::toolpaths::save_png;
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Meshes that say where supports go, and what is to be said about them.
#[derive(Clone, Debug, Default, Args)]
pub struct SupportArgs {
    /// Support what hangs inside this mesh, however steep; in the model's coordinates, may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Supports")]
    pub support_enforcer: Vec<PathBuf>,
    /// Support nothing inside this mesh; in the model's coordinates, may be repeated
    #[arg(long, value_name = "FILE", help_heading = "Supports")]
    pub support_blocker: Vec<PathBuf>,
    /// Write what supports hold, touch and cost, in each style, as JSON
    #[arg(long, value_name = "FILE", help_heading = "Supports")]
    pub support_report: Option<PathBuf>,
    /// Draw overhangs and supports, from the front and from above, as a PNG picture
    #[arg(long, value_name = "FILE", help_heading = "Supports")]
    pub support_picture: Option<PathBuf>,
}

impl SupportArgs {
    /// The modifiers.
    pub fn modifiers(&self) -> ModifierFiles {
        ModifierFiles { enforcers: self.support_enforcer.clone(), blockers: self.support_blocker.clone() }
    }

    /// What is to be found out.
    pub fn wish(&self) -> SupportWish {
        let (report, picture) = (self.support_report.is_some(), self.support_picture.is_some());
        SupportWish { report, picture, areas: false }
    }

    /// Writes what was found out about a print.
    ///
    /// # Errors
    /// A file cannot be written; it is then as it was before.
    pub fn write(&self, record: SupportRecord, print: &Summary) -> Result<(), CliError> {
        if let (Some(path), Some(picture)) = (&self.support_picture, &record.picture) {
            save_png(picture, path).map_err(JobError::from)?;
        }
        if let (Some(path), Some(mut report)) = (&self.support_report, record.report) {
            report.set_print(&print.filament);
            let text = serde_json::to_string_pretty(&report).map_err(std::io::Error::other)?;
            save(path, &text).map_err(JobError::from)?;
        }
        Ok(())
    }
}

fn save(path: &Path, text: &str) -> Result<(), OutputError> {
    let mut out = OutputFile::create(path)?;
    writeln!(out, "{text}").map_err(|e| OutputError::new(path, e))?;
    out.commit()
}
