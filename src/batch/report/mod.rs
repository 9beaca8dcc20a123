//! Reports of a batch: JSON, CSV, one page of HTML, and a manifest of what failed.

mod csv;
mod escape;
mod html;
mod json;
mod merge;
mod page;
mod pictures;
mod quarantine;
mod sums;
#[cfg(test)]
mod tests;
mod words;

pub(super) use json::writable;
pub use merge::{Merged, merge};
pub use sums::Sums;
pub use words::{count, duration, plain};

use super::event::{Row, Totals};
use super::{BatchError, Shard};
use crate::job::output::{OutputError, OutputFile};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// A job with the folder in which its batch was run.
#[derive(Clone, Copy, Debug)]
struct Job<'a> {
    /// Under this name it is in the report.
    row: &'a Row,
    /// The folder of its batch.
    folder: &'a Path,
    /// Its name there.
    name: &'a str,
}

/// What a report says.
#[derive(Debug)]
struct Report<'a> {
    /// What it is about, for people.
    title: String,
    /// Where it is written.
    folder: &'a Path,
    jobs: Vec<Job<'a>>,
    totals: &'a Totals,
    sums: Sums,
    /// What is not as it should be.
    notes: &'a [String],
}

/// Where the page of a batch's report is.
pub fn page(folder: &Path, shard: Shard) -> PathBuf {
    folder.join(format!("report{}.html", suffix(shard)))
}

/// The manifest of what failed, as [`write()`] writes it.
pub fn quarantine(folder: &Path, shard: Shard) -> PathBuf {
    folder.join(format!("quarantine{}.jsonl", suffix(shard)))
}

/// Writes `report.json`, `report.csv`, `report.html` and, where something failed, `quarantine.jsonl` (a
/// manifest with those jobs) into a folder; those of one shard among several are `report-I-of-N.*`. Each is
/// whole or absent.
///
/// # Errors
/// [`BatchError::Write`].
pub fn write(folder: &Path, shard: Shard, rows: &[Row], totals: &Totals) -> Result<(), BatchError> {
    let mut title = shown(folder);
    if shard.count > 1 {
        title.push_str(&format!(", shard {} of {}", shard.index, shard.count));
    }
    let jobs = rows.iter().map(|row| Job { row, folder, name: &row.name }).collect();
    let sums = Sums::of(rows);
    let notes: Vec<String> =
        totals.stopped.iter().map(|why| format!("The batch was stopped: {why}")).collect();
    write_all(&Report { title, folder, jobs, totals, sums, notes: &notes }, &suffix(shard))
}

/// All files of a report; `suffix` comes after the first part of their names.
fn write_all(report: &Report<'_>, suffix: &str) -> Result<(), BatchError> {
    let at = |name: &str, extension: &str| report.folder.join(format!("{name}{suffix}.{extension}"));
    file(&at("report", "json"), |out| json::write(report, out))?;
    file(&at("report", "csv"), |out| csv::write(report, out))?;
    file(&at("report", "html"), |out| html::write(report, out))?;
    let path = at("quarantine", "jsonl");
    if report.sums.failed + report.sums.quarantined > 0 {
        return file(&path, |out| quarantine::write(report, out));
    }
    match std::fs::remove_file(&path) {
        Err(source) if source.kind() != io::ErrorKind::NotFound => Err(BatchError::Write { path, source }),
        _ => Ok(()),
    }
}

/// Writes a file that is whole or absent.
fn file(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> Result<(), BatchError> {
    let failed = |source| BatchError::Write { path: path.to_owned(), source };
    let by_name = |e: OutputError| failed(e.source);
    let mut out = BufWriter::with_capacity(1 << 16, OutputFile::create(path).map_err(by_name)?);
    write(&mut out).map_err(failed)?;
    out.into_inner().map_err(|e| failed(e.into_error()))?.commit().map_err(by_name)
}

fn suffix(shard: Shard) -> String {
    if shard.count > 1 { format!("-{}-of-{}", shard.index, shard.count) } else { String::new() }
}

fn shown(folder: &Path) -> String {
    std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned()).display().to_string()
}
