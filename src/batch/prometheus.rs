//! A file of figures for Prometheus, in its text exposition format, version 0.0.4
//! (<https://prometheus.io/docs/instrumenting/exposition_formats/>), as the text collector of its node
//! exporter reads it.

use super::tally::Tally;
use super::{BatchError, Shard};
use crate::job::output::OutputFile;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Seconds between two versions of the file.
const EVERY: f64 = 5.0;

/// A file that is replaced every few seconds, in one step.
#[derive(Debug)]
pub struct TextFile {
    path: PathBuf,
    /// `folder="...",shard="..."`: several batches of a machine may have their files side by side.
    labels: String,
    written: Option<f64>,
}

impl TextFile {
    /// A file about the batch that writes into a folder.
    pub fn new(path: &Path, folder: &Path, shard: Shard) -> Self {
        let labels = format!("folder=\"{}\",shard=\"{}/{}\"", label(folder), shard.index, shard.count);
        Self { path: path.to_owned(), labels, written: None }
    }

    /// Writes the file if it is time, the first time, and when the batch is over. `now` is seconds since the
    /// begin of the batch, `clock` seconds since 1970.
    ///
    /// # Errors
    /// [`BatchError::Write`]; the next call tries again only when it is time.
    pub fn update(&mut self, tally: &Tally, now: f64, clock: f64) -> Result<(), BatchError> {
        if !tally.is_over() && self.written.is_some_and(|last| now - last < EVERY) {
            return Ok(());
        }
        self.written = Some(now);
        let failed = |source| BatchError::Write { path: self.path.clone(), source };
        let mut file = OutputFile::create(&self.path).map_err(|e| failed(e.source))?;
        file.write_all(text(tally, &self.labels, now, clock).as_bytes()).map_err(failed)?;
        file.commit().map_err(|e| failed(e.source))
    }
}

/// All figures. `labels` are those of every sample, in the format's own words.
fn text(tally: &Tally, labels: &str, now: f64, clock: f64) -> String {
    let mut out = String::new();
    let states = [
        ("done", tally.done),
        ("skipped", tally.skipped),
        ("failed", tally.failed),
        ("quarantined", tally.quarantined),
        ("running", tally.running()),
        ("waiting", tally.waiting()),
    ];
    header(
        &mut out,
        "batch_jobs",
        "gauge",
        "Jobs of this shard by state; skipped ones were done by an earlier run.",
    );
    for (state, count) in states {
        line(&mut out, "batch_jobs", &format!("{labels},state=\"{state}\""), count as f64);
    }
    let figures = [
        ("batch_jobs_all", "gauge", "Jobs of this shard, as far as known.", tally.jobs as f64),
        ("batch_bytes", "gauge", "Bytes of the models of this shard, as far as known.", tally.bytes as f64),
        (
            "batch_bytes_done",
            "gauge",
            "Bytes of the models of all jobs that have ended.",
            tally.bytes_done as f64,
        ),
        (
            "batch_rate_models_per_minute",
            "gauge",
            "Models finished a minute since the begin, skipped ones left out.",
            tally.models_per_minute(now),
        ),
        ("batch_retries_total", "counter", "Further tries of jobs that had failed.", tally.retries as f64),
        (
            "batch_workers_lost_total",
            "counter",
            "Worker processes that died or were killed.",
            tally.workers_lost as f64,
        ),
        (
            "batch_peak_memory_bytes",
            "gauge",
            "The most memory of all workers together.",
            tally.peak_bytes as f64,
        ),
        (
            "batch_filament_millimetres_total",
            "counter",
            "Length of filament of the jobs done by this run.",
            tally.filament_mm,
        ),
        (
            "batch_volume_cubic_centimetres_total",
            "counter",
            "Volume of material of the jobs done by this run.",
            tally.cm3,
        ),
        (
            "batch_eta_seconds",
            "gauge",
            "Time left; NaN as long as there is nothing to judge by.",
            tally.eta(now).unwrap_or(f64::NAN),
        ),
        (
            "batch_running",
            "gauge",
            "1 while the batch runs, 0 when it has ended.",
            f64::from(u8::from(!tally.is_over())),
        ),
        (
            "batch_last_update_timestamp_seconds",
            "gauge",
            "When this file was written, in seconds since 1970.",
            clock,
        ),
    ];
    for (name, kind, help, value) in figures {
        header(&mut out, name, kind, help);
        line(&mut out, name, labels, value);
    }
    out
}

fn header(out: &mut String, name: &str, kind: &str, help: &str) {
    out.push_str(&format!("# HELP microtome_{name} {help}\n# TYPE microtome_{name} {kind}\n"));
}

fn line(out: &mut String, name: &str, labels: &str, value: f64) {
    out.push_str(&format!("microtome_{name}{{{labels}}} {value}\n"));
}

/// A path as the value of a label.
fn label(path: &Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    path.to_string_lossy().replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "tests")]
mod tests {
    use super::*;
    use crate::batch::event::{Event, Totals};
    use std::collections::{BTreeMap, BTreeSet};

    /// Samples by name and labels; an error where the format forbids something.
    fn parse(text: &str) -> Result<BTreeMap<String, f64>, String> {
        let (mut types, mut helps, mut closed) = (BTreeMap::new(), BTreeSet::new(), BTreeSet::new());
        let (mut samples, mut last) = (BTreeMap::new(), String::new());
        if !text.ends_with('\n') {
            return Err("no line feed at the end".into());
        }
        for line in text.lines() {
            if let Some(rest) = line.strip_prefix("# HELP ") {
                let (name, _) = rest.split_once(' ').ok_or("help without text")?;
                helps.insert(name.to_owned()).then_some(()).ok_or_else(|| format!("second help: {name}"))?;
                continue;
            }
            if let Some(rest) = line.strip_prefix("# TYPE ") {
                let (name, kind) = rest.split_once(' ').ok_or("type without a kind")?;
                if !["counter", "gauge"].contains(&kind) {
                    return Err(format!("type {kind}"));
                }
                let fresh = types.insert(name.to_owned(), kind.to_owned()).is_none();
                fresh.then_some(()).ok_or_else(|| format!("second type: {name}"))?;
                continue;
            }
            let name = &line[..line.find(['{', ' ']).ok_or("no value")?];
            let legal = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == ':';
            if name.is_empty() || name.starts_with(|c: char| c.is_ascii_digit()) || !name.chars().all(legal) {
                return Err(format!("name {name}"));
            }
            let rest = labels(&line[name.len()..])?;
            if !types.contains_key(name) || !helps.contains(name) {
                return Err(format!("{name} has no type or no help"));
            }
            if types[name] == "counter" && !name.ends_with("_total") {
                return Err(format!("counter {name}"));
            }
            if last != name && !closed.insert(name.to_owned()) {
                return Err(format!("samples of {name} are not together"));
            }
            last = name.to_owned();
            let value = rest.strip_prefix(' ').ok_or("no space before the value")?;
            let value = value.parse::<f64>().map_err(|e| format!("{value}: {e}"))?;
            let key = line[..line.len() - rest.len()].to_owned();
            samples.insert(key.clone(), value).is_none().then_some(()).ok_or(format!("{key} comes twice"))?;
        }
        Ok(samples)
    }

    /// What follows the labels.
    fn labels(text: &str) -> Result<&str, String> {
        let Some(mut rest) = text.strip_prefix('{') else { return Ok(text) };
        loop {
            let equals = rest.find("=\"").ok_or_else(|| format!("label: {rest}"))?;
            if !rest[..equals].chars().all(|c| c.is_ascii_lowercase() || c == '_') || equals == 0 {
                return Err(format!("label: {rest}"));
            }
            let mut escaped = false;
            let end = rest[equals + 2..].find(|c| {
                let quote = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                quote
            });
            rest = &rest[equals + 2 + end.ok_or_else(|| format!("open label: {rest}"))? + 1..];
            match rest.split_at_checked(1) {
                Some(("}", after)) => return Ok(after),
                Some((",", after)) => rest = after,
                _ => return Err(format!("after a label: {rest}")),
            }
        }
    }

    #[test]
    fn the_file_obeys_the_format() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.prom");
        let mut file = TextFile::new(&path, Path::new("/a \"b\"\\c\nd"), Shard { index: 2, count: 3 });
        let mut tally = Tally::default();
        tally.event(&Event::Begun { jobs: 5, bytes: 100, workers: 2 }, 0.0);
        tally.event(&Event::Started { name: "x", attempt: 1, worker: 1 }, 0.5);
        file.update(&tally, 1.0, 1e9).unwrap();
        let samples = parse(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let labels = r#"folder="/a \"b\"\\c\nd",shard="2/3""#;
        let value = |name: &str, more: &str| samples[&format!("microtome_batch_{name}{{{labels}{more}}}")];
        assert_eq!(value("jobs", ",state=\"running\""), 1.0);
        assert_eq!(value("jobs", ",state=\"waiting\""), 4.0);
        assert!(value("eta_seconds", "").is_nan());
        assert_eq!(value("running", ""), 1.0);
        assert_eq!(value("last_update_timestamp_seconds", ""), 1e9);

        tally.event(&Event::Ended(&Totals { done: 5, retries: 3, ..Totals::default() }), 2.0);
        file.update(&tally, 2.0, 1e9 + 1.0).unwrap();
        let samples = parse(&std::fs::read_to_string(&path).unwrap()).unwrap();
        let value = |name: &str, more: &str| samples[&format!("microtome_batch_{name}{{{labels}{more}}}")];
        assert_eq!(value("jobs", ",state=\"done\""), 5.0);
        assert_eq!(value("retries_total", ""), 3.0);
        assert_eq!((value("running", ""), value("eta_seconds", "")), (0.0, 0.0));
    }

    #[test]
    fn the_parser_sees_what_is_wrong() {
        let good = text(&Tally::default(), "folder=\"a\",shard=\"1/1\"", 1.0, 2.0);
        assert!(parse(&good).is_ok());
        let faults: [(&str, &str); 5] = [
            ("folder=\"a\"", "folder=\"a\"\""),
            ("# TYPE microtome_batch_running gauge\n", ""),
            ("batch_retries_total", "batch_retries"),
            ("state=\"failed\"", "state=\"done\""),
            ("microtome_batch_bytes{", "microtome-batch_bytes{"),
        ];
        for (what, with) in faults {
            let bad = good.replace(what, with);
            assert_ne!(bad, good);
            assert!(parse(&bad).is_err(), "{what} -> {with}");
        }
        assert!(parse(good.trim_end()).is_err());
    }

    #[test]
    fn it_is_written_at_most_every_few_seconds() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.prom");
        let mut file = TextFile::new(&path, dir.path(), Shard::default());
        let tally = Tally::default();
        file.update(&tally, 0.0, 1.0).unwrap();
        std::fs::remove_file(&path).unwrap();
        file.update(&tally, EVERY - 0.1, 1.0).unwrap();
        assert!(!path.exists());
        file.update(&tally, EVERY, 1.0).unwrap();
        assert!(path.exists());

        let mut lost = TextFile::new(&dir.path().join("no/a.prom"), dir.path(), Shard::default());
        let error = lost.update(&tally, 0.0, 1.0).unwrap_err().to_string();
        assert!(error.contains("no/a.prom"), "{error}");
    }
}
