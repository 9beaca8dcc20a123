//! Pictures of layers inside the page.

use super::Job;
use crate::batch::STATE_FOLDER;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use std::path::PathBuf;

/// Where a job's picture is, if it has one.
pub(super) fn path(job: &Job<'_>) -> PathBuf {
    job.folder.join(STATE_FOLDER).join("pictures").join(format!("{}.png", job.name))
}

/// What may still be put into a page.
#[derive(Debug)]
pub(super) struct Budget {
    pub count: usize,
    /// Bytes of the files.
    pub bytes: u64,
}

/// A job's picture for the page.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Picture {
    /// As the source of an image.
    Inside(String),
    /// Too much for the page.
    Beside(PathBuf),
}

impl Budget {
    /// A job's picture, inside the page as long as there is room.
    pub(super) fn picture(&mut self, job: &Job<'_>) -> Option<Picture> {
        let path = path(job);
        let size = std::fs::metadata(&path).ok().filter(|m| m.is_file())?.len();
        if self.count == 0 || size > self.bytes {
            return Some(Picture::Beside(path));
        }
        let bytes = std::fs::read(&path).ok()?;
        // A torn picture is none; the output has its own check.
        if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
            return None;
        }
        self.count -= 1;
        self.bytes = self.bytes.saturating_sub(bytes.len() as u64);
        Some(Picture::Inside(format!("data:image/png;base64,{}", STANDARD.encode(bytes))))
    }
}
