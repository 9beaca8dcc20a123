//! A manifest of the jobs that failed: once the cause is mended, `microtome batch quarantine.jsonl` does them.

use super::{Report, json};
use crate::batch::event::Status;
use crate::slicer::{Request, Technology};
use serde_json::{Map, Value};
use std::io::{self, Write};
use std::path::Path;

/// Writes it: a job a line, with all that differs from a job without options.
pub(super) fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    for job in report.jobs.iter().filter(|job| job.row.status != Status::Done) {
        let row = json::writable(job.row);
        serde_json::to_writer(&mut *out, &entry(&row.request, &row.name))?;
        out.write_all(b"\n")?;
    }
    Ok(())
}

fn entry(request: &Request, name: &str) -> Map<String, Value> {
    let plain = Request::default();
    let mut entry = Map::new();
    let mut put = |key: &str, value: Value| drop(entry.insert(key.to_owned(), value));
    put("model", path(&request.model));
    put("output", name.into());
    if request.technology != plain.technology {
        put(
            "technology",
            match request.technology {
                Technology::Filament => "filament".into(),
                Technology::Resin => "resin".into(),
            },
        );
    }
    if let Some(printer) = &request.printer {
        // A name, or a file that describes one.
        let file = Path::new(printer);
        put("printer", if file.is_file() { path(file) } else { printer.as_str().into() });
    }
    let lists = [
        ("profile", &request.load),
        ("support_enforcers", &request.support_enforcers),
        ("support_blockers", &request.support_blockers),
    ];
    for (key, files) in lists {
        if !files.is_empty() {
            put(key, files.iter().map(|file| path(file)).collect());
        }
    }
    if !request.settings.is_empty() {
        let settings = request.settings.iter().map(|(k, v)| (k.clone(), v.as_str().into()));
        put("settings", Value::Object(settings.collect()));
    }
    if request.copies != plain.copies {
        put("copies", request.copies.into());
    }
    if request.orient != plain.orient {
        put("orient", request.orient.as_str().into());
    }
    for (key, value) in [("match_tolerance", request.match_tolerance), ("snap_grid", request.snap_grid)] {
        if let Some(value) = value {
            put(key, value.into());
        }
    }
    if request.rotate != plain.rotate {
        put("rotate", request.rotate.into());
    }
    for (key, value) in [("no_place", request.no_place), ("check", request.check)] {
        if value {
            put(key, true.into());
        }
    }
    entry
}

/// Absolute, so that the manifest may be moved.
fn path(path: &Path) -> Value {
    std::path::absolute(path).unwrap_or_else(|_| path.to_owned()).to_string_lossy().into()
}
