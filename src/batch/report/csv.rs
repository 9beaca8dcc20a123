//! The report as a table.

use super::{Report, words};
use crate::batch::event::Row;
use std::io::{self, Write};

const HEADER: [&str; 22] = [
    "name",
    "model",
    "status",
    "attempts",
    "copies",
    "layers",
    "print_z_mm",
    "triangles",
    "filament_mm",
    "volume_cm3",
    "mass_g",
    "cost",
    "time_lower_bound_s",
    "bytes",
    "backend",
    "seconds",
    "cpu_seconds",
    "peak_bytes",
    "warnings",
    "first_warning",
    "error_kind",
    "error",
];

/// Writes it: a header, then a row a job. What is not known is empty.
pub(super) fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(out);
    table.write_record(HEADER)?;
    for job in &report.jobs {
        table.write_record(record(job.row))?;
    }
    table.flush()
}

fn record(row: &Row) -> [String; 22] {
    let done = row.outcome.as_ref();
    let material = done.map(|o| &o.material);
    let failure = row.failure.as_ref();
    let whole = |value: Option<u64>| value.map_or(String::new(), |v| v.to_string());
    [
        row.name.clone(),
        row.model.clone(),
        words::status(row.status).to_owned(),
        row.attempts.to_string(),
        row.copies.to_string(),
        whole(done.map(|o| o.layers)),
        decimal(done.map(|o| o.print_z_mm)),
        whole(done.map(|o| o.triangles)),
        decimal(material.map(|m| m.mm)),
        decimal(material.map(|m| m.cm3)),
        decimal(material.and_then(|m| m.g)),
        decimal(material.and_then(|m| m.cost)),
        decimal(done.map(|o| o.time_lower_bound_s)),
        whole(done.map(|o| o.bytes)),
        done.map_or(String::new(), |o| o.backend.clone()),
        decimal(done.map(|o| o.seconds)),
        decimal(done.map(|o| o.cpu_seconds)),
        whole(done.map(|o| o.peak_bytes)),
        whole(done.map(|o| o.warnings.len() as u64)),
        done.and_then(|o| o.warnings.first().cloned()).unwrap_or_default(),
        failure.map_or("", |f| words::kind(f.kind)).to_owned(),
        failure.map_or(String::new(), |f| f.message.clone()),
    ]
}

/// Six decimals at most, none more than needed.
fn decimal(value: Option<f64>) -> String {
    let Some(value) = value else { return String::new() };
    let text = format!("{value:.6}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}
