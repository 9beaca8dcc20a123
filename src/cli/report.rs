//! What a command says when it is done.

use crate::job::summary::Summary;
use crate::settings::LoadReport;
use std::io::{self, Write};
use std::path::PathBuf;

/// Warnings on stderr, one line each; the same line only once.
pub fn warnings(summary: &Summary) {
    warning_lines(&summary.warnings);
}

/// Warnings on stderr, one line each.
pub fn warning_lines(warnings: &[String]) {
    let mut err = io::stderr().lock();
    for warning in warnings {
        // Nobody is left to tell when stderr is closed.
        drop(writeln!(err, "warning: {warning}"));
    }
}

/// The keys of loaded files that have no effect here.
pub fn ignored_keys(files: &[(PathBuf, LoadReport)]) -> Vec<String> {
    let keys =
        |r: &LoadReport| r.ignored.iter().chain(&r.unknown).map(|(_, key)| key.clone()).collect::<Vec<_>>();
    files.iter().flat_map(|(_, report)| keys(report)).collect()
}

/// How many settings of each loaded file have no effect here; with `list` also which.
pub fn ignored(files: &[(PathBuf, LoadReport)], list: bool) {
    let mut err = io::stderr().lock();
    for (path, report) in files {
        let (known, unknown) = (report.ignored.len(), report.unknown.len());
        if known + unknown == 0 {
            continue;
        }
        let more = if list { "" } else { " (--list-ignored lists them)" };
        drop(writeln!(
            err,
            "{}: {} settings applied, {known} not honoured yet, {unknown} unknown{more}",
            path.display(),
            report.applied
        ));
        let all = [("not honoured yet", &report.ignored), ("unknown", &report.unknown)];
        for (what, keys) in all.into_iter().filter(|_| list) {
            for (line, key) in keys {
                drop(writeln!(err, "  {}:{line}: {key} ({what})", path.display()));
            }
        }
    }
}

/// The summary as one JSON object on stdout.
///
/// # Errors
/// When stdout cannot be written.
pub fn json(summary: &impl serde::Serialize) -> io::Result<()> {
    let text = serde_json::to_string_pretty(summary).map_err(io::Error::other)?;
    writeln!(io::stdout().lock(), "{text}")
}

/// The summary for people on stderr, so that stdout stays free for G-code and JSON.
pub fn people(s: &Summary) {
    let mut err = io::stderr().lock();
    let mass = s.filament.g.map_or(String::new(), |g| format!(", {g:.2} g"));
    let adapter = s.backend.adapter.as_deref().map_or(String::new(), |a| format!(" {a}"));
    let seconds: f64 = s.stages.iter().map(|t| t.seconds).sum();
    // An estimate has no output.
    let (name, done) = match s.output.as_str() {
        "" => (s.model.as_str(), "estimated".to_owned()),
        output => (output, format!("{} bytes", s.bytes)),
    };
    let text = format!(
        "{name}: {} layers to z = {:.3} mm, {} triangles, {} segments\n\
         filament {:.1} mm ({:.2} cm3{mass}), at least {}\n\
         {done} by {}{adapter} in {:.3} s\n",
        s.layers,
        s.print_z_mm,
        s.triangles,
        s.segments,
        s.filament.mm,
        s.filament.cm3,
        duration(s.time_lower_bound_s),
        s.backend.kind,
        seconds,
    );
    drop(err.write_all(text.as_bytes()));
}

/// `1h 2m 3s`.
pub fn duration(seconds: f64) -> String {
    let s = seconds.round().max(0.0) as u64;
    match (s / 3600, s / 60 % 60, s % 60) {
        (0, 0, s) => format!("{s}s"),
        (0, m, s) => format!("{m}m {s}s"),
        (h, m, s) => format!("{h}h {m}m {s}s"),
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn durations_read_well() {
        assert_eq!(super::duration(59.6), "1m 0s");
        assert_eq!(super::duration(3723.0), "1h 2m 3s");
        assert_eq!(super::duration(7.2), "7s");
    }
}
