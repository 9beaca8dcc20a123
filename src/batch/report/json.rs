//! The report for programs: sums, then a job a line.

use super::{Report, Sums};
use crate::batch::event::{Row, Totals};
use serde::Serialize;
use std::borrow::Cow;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

#[derive(Serialize)]
struct Head<'a> {
    program: &'a str,
    version: &'a str,
    title: &'a str,
    notes: &'a [String],
    totals: &'a Totals,
    sums: &'a Sums,
}

/// Writes it. Jobs are written one by one: there may be a million.
pub(super) fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let head = Head {
        program: env!("CARGO_PKG_NAME"),
        version: env!("CARGO_PKG_VERSION"),
        title: &report.title,
        notes: report.notes,
        totals: report.totals,
        sums: &report.sums,
    };
    let head = serde_json::to_string_pretty(&head)?;
    write!(out, "{},\n  \"jobs\": [", head.strip_suffix("\n}").unwrap_or(&head))?;
    for (index, job) in report.jobs.iter().enumerate() {
        out.write_all(if index == 0 { b"\n    " } else { b",\n    " })?;
        serde_json::to_writer(&mut *out, &*writable(job.row))?;
    }
    out.write_all(b"\n  ]\n}\n")
}

/// A row that JSON can hold: paths that are no UTF-8 with U+FFFD in place of what is not.
pub(in crate::batch) fn writable(row: &Row) -> Cow<'_, Row> {
    let odd = |path: &PathBuf| path.to_str().is_none();
    let request = &row.request;
    let lists = [&request.load, &request.support_enforcers, &request.support_blockers];
    if ![Some(&request.model), request.output.as_ref(), request.picture.as_ref()]
        .into_iter()
        .flatten()
        .any(odd)
        && !lists.into_iter().flatten().any(odd)
    {
        return Cow::Borrowed(row);
    }
    let mut row = row.clone();
    let request = &mut row.request;
    let lossy = |path: &mut PathBuf| *path = Path::new(&*path.to_string_lossy()).to_owned();
    lossy(&mut request.model);
    request.output.iter_mut().chain(&mut request.picture).for_each(lossy);
    let lists = [&mut request.load, &mut request.support_enforcers, &mut request.support_blockers];
    lists.into_iter().flatten().for_each(lossy);
    Cow::Owned(row)
}
