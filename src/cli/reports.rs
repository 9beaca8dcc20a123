//! `microtome report`.

use super::exit::CliError;
use super::report::json;
use crate::batch::report::{self, Merged};
use crate::batch::shard::Shard;
use clap::Args;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `report`.
#[derive(Debug, Args)]
pub struct ReportArgs {
    /// Output folders of batches, or of shards of one
    #[arg(value_name = "DIR", required = true)]
    pub folders: Vec<PathBuf>,
    /// Folder for report.json, report.csv and report.html [default: the first one given]
    #[arg(long, short, value_name = "DIR")]
    pub output: Option<PathBuf>,
    /// Print the sums as JSON on standard output
    #[arg(long)]
    pub json: bool,
}

/// Joins reports.
///
/// # Errors
/// [`CliError`] when a folder holds no batch or the report cannot be written; [`CliError::Unfinished`] where
/// jobs failed, or shards are missing or have not come to their end.
pub fn run(args: &ReportArgs) -> Result<(), CliError> {
    let Some(first) = args.folders.first() else { return Ok(()) };
    let output = args.output.as_ref().unwrap_or(first);
    let merged = report::merge(&args.folders, output)?;
    if args.json {
        json(&merged)?;
    } else {
        let text = people(&merged, &report::page(output, Shard::default()));
        drop(io::stderr().lock().write_all(text.as_bytes()));
    }
    if !merged.notes.is_empty() {
        let page = report::page(output, Shard::default());
        let problem =
            format!("the batch is not complete: {}; see {}", merged.notes.join("; "), page.display());
        return Err(CliError::Unfinished(merged.totals.exit_code(), report::plain(&problem)));
    }
    super::batch::finished(&merged.totals, output, Shard::default())
}

/// The sums for people.
fn people(merged: &Merged, page: &Path) -> String {
    let sums = &merged.sums;
    let mut text = format!("{}: {} done", report::count(sums.jobs, "job", "jobs"), sums.done);
    for (count, what) in [(sums.failed, "failed"), (sums.quarantined, "quarantined")] {
        if count > 0 {
            text.push_str(&format!(", {count} {what}"));
        }
    }
    if sums.with_warnings > 0 {
        text.push_str(&format!(", {} with warnings", sums.with_warnings));
    }
    text.push('\n');
    if sums.filament_mm > 0.0 {
        text.push_str(&format!("filament {:.2} m, ", sums.filament_mm / 1000.0));
    }
    text.push_str(&format!("{:.2} cm3", sums.volume_cm3));
    let of = |count: usize| if count == sums.done { String::new() } else { format!(" (of {count} jobs)") };
    if let Some(g) = sums.mass_g {
        text.push_str(&format!(", {g:.2} g{}", of(sums.jobs_with_mass)));
    }
    if let Some(cost) = sums.cost {
        text.push_str(&format!(", price {cost:.2}{}", of(sums.jobs_with_cost)));
    }
    text.push_str(&format!(", at least {} of printing\n", report::duration(sums.time_lower_bound_s)));
    text.push_str(&format!("report: {}\n", report::plain(&page.display().to_string())));
    text
}
