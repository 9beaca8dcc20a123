//! What was measured, as a table, as JSON and as CSV.

use super::case::Case;
use super::machine::{Machine, Time};
use super::{BenchError, cpu::Reference};
use serde::Serialize;
use std::fmt::Write as _;

/// A whole benchmark.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Report {
    /// Where it ran.
    pub machine: Machine,
    /// Every figure is the median of so many runs.
    pub runs: usize,
    /// Per model.
    pub models: Vec<ModelReport>,
}

/// The figures of one model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelReport {
    /// Its name.
    pub model: String,
    /// Triangles after welding.
    pub triangles: u64,
    /// Vertices after welding.
    pub vertices: u64,
    /// Planes.
    pub planes: u64,
    /// (Triangle, plane) pairs.
    pub segments: u64,
    /// Closed contours of the CPU core.
    pub contours: u64,
    /// SHA-256 of the CPU core's contours.
    pub sha256: String,
    /// Stage by stage.
    pub stages: Vec<Row>,
    /// What was left out, and why.
    pub skipped: Vec<String>,
}

/// How an output compares with that of the CPU core on its first number of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The same contours, byte for byte.
    Equal,
    /// The same area on every plane (contours joined by end points alone may part differently).
    EqualArea,
    /// Not the same.
    Different,
}

impl Verdict {
    /// For people; a difference is not to be overlooked.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::EqualArea => "equal area",
            Self::Different => "DIFFERENT",
        }
    }
}

/// One stage on one engine.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Row {
    /// Who did it.
    pub engine: String,
    /// What.
    pub stage: &'static str,
    /// CPU threads.
    pub threads: usize,
    /// Wall time \[s\].
    pub seconds: f64,
    /// CPU time \[s\].
    pub cpu_seconds: Option<f64>,
    /// Segments each second of wall time.
    pub segments_per_s: f64,
    /// Triangles × planes each second of wall time.
    pub triangle_planes_per_s: f64,
    /// Bytes that the stage moves by `bytes_formula`.
    pub bytes: u64,
    /// T triangles, V vertices, P planes, S segments.
    pub bytes_formula: &'static str,
    /// Those bytes each second, as a part of what copying memory reaches with as many threads. Above 1
    /// where they come from a cache.
    pub bandwidth_share: Option<f64>,
    /// How the output compares, where there is one.
    pub output: Option<Verdict>,
}

/// A stage before it is timed.
pub(super) struct Stage {
    pub(super) engine: String,
    pub(super) stage: &'static str,
    pub(super) threads: usize,
    /// Bytes for each of T, V, T × P and S.
    pub(super) bytes: [u64; 4],
    pub(super) formula: &'static str,
}

impl Stage {
    pub(super) fn new(engine: impl Into<String>, stage: &'static str, threads: usize) -> Self {
        Self { engine: engine.into(), stage, threads, bytes: [0; 4], formula: "" }
    }

    /// Bytes for each triangle, vertex, triangle × plane and segment, and that in words.
    pub(super) fn bytes(self, bytes: [u64; 4], formula: &'static str) -> Self {
        Self { bytes, formula, ..self }
    }
}

/// Takes the rows of one model, shows each as it comes.
pub(super) struct Sink<'a> {
    machine: &'a Machine,
    show: &'a mut (dyn FnMut(&str) + Send),
    report: ModelReport,
    work: u64,
}

impl<'a> Sink<'a> {
    pub(super) fn new(case: &Case, machine: &'a Machine, show: &'a mut (dyn FnMut(&str) + Send)) -> Self {
        let report = ModelReport {
            model: case.name.clone(),
            triangles: case.mesh.triangles.len() as u64,
            vertices: case.mesh.vertices.len() as u64,
            planes: case.planes.len() as u64,
            segments: case.segments(),
            contours: 0,
            sha256: String::new(),
            stages: Vec::new(),
            skipped: Vec::new(),
        };
        show(&format!(
            "\n{}: {} triangles x {} planes, {} segments\n{}",
            report.model,
            report.triangles,
            report.planes,
            report.segments,
            header()
        ));
        Self { machine, show, report, work: case.work() }
    }

    pub(super) fn row(&mut self, stage: Stage, time: Time, output: Option<Verdict>) {
        let (r, wall) = (&self.report, time.wall.max(1e-9));
        let amounts = [r.triangles, r.vertices, self.work, r.segments];
        let bytes = amounts.iter().zip(stage.bytes).map(|(n, each)| n.saturating_mul(each)).sum();
        let bandwidth = self.machine.bandwidth(stage.threads).filter(|_| bytes > 0);
        let row = Row {
            engine: stage.engine,
            stage: stage.stage,
            threads: stage.threads,
            seconds: time.wall,
            cpu_seconds: time.cpu,
            segments_per_s: r.segments as f64 / wall,
            triangle_planes_per_s: self.work as f64 / wall,
            bytes,
            bytes_formula: stage.formula,
            bandwidth_share: bandwidth.map(|best| bytes as f64 / wall / best),
            output,
        };
        (self.show)(&line(&row));
        self.report.stages.push(row);
    }

    pub(super) fn skip(&mut self, what: String) {
        (self.show)(&format!("  skipped: {what}"));
        self.report.skipped.push(what);
    }

    pub(super) fn finish(self, reference: &Reference) -> ModelReport {
        let contours = reference.rings;
        (self.show)(&format!("  {contours} contours, SHA-256 {}", reference.sha256));
        ModelReport { contours, sha256: reference.sha256.clone(), ..self.report }
    }
}

fn header() -> String {
    format!(
        "  {:<28} {:<12} {:>3} {:>10} {:>10} {:>9} {:>9} {:>9} {:>7}  {}",
        "engine", "stage", "thr", "wall ms", "cpu ms", "Mseg/s", "Gtp/s", "MB", "of copy", "output"
    )
}

fn line(r: &Row) -> String {
    let cpu = r.cpu_seconds.map_or_else(|| "-".to_owned(), |s| format!("{:.3}", s * 1e3));
    let share = r.bandwidth_share.map_or_else(|| "-".to_owned(), |s| format!("{:.1} %", s * 100.0));
    format!(
        "  {:<28} {:<12} {:>3} {:>10.3} {:>10} {:>9.2} {:>9.3} {:>9.1} {:>7}  {}",
        r.engine,
        r.stage,
        r.threads,
        r.seconds * 1e3,
        cpu,
        r.segments_per_s / 1e6,
        r.triangle_planes_per_s / 1e9,
        r.bytes as f64 / 1e6,
        share,
        r.output.map_or("", Verdict::text),
    )
    .trim_end()
    .to_owned()
}

impl Report {
    /// Fails when engines disagree.
    ///
    /// # Errors
    /// [`BenchError::Different`].
    pub fn check(&self) -> Result<(), BenchError> {
        let rows = self.models.iter().flat_map(|m| &m.stages);
        let count = rows.filter(|r| r.output == Some(Verdict::Different)).count();
        if count == 0 { Ok(()) } else { Err(BenchError::Different { count }) }
    }

    /// One line per stage under a line of names, in the way of RFC 4180.
    pub fn csv(&self) -> String {
        let mut text = "model,triangles,vertices,planes,segments,contours,engine,stage,threads,seconds,\
                        cpu_seconds,segments_per_s,triangle_planes_per_s,bytes,bytes_formula,\
                        bandwidth_share,output\n"
            .to_owned();
        let optional = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
        for m in &self.models {
            for r in &m.stages {
                // Writing to a String cannot fail.
                let _ = writeln!(
                    text,
                    "{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}",
                    quoted(&m.model),
                    m.triangles,
                    m.vertices,
                    m.planes,
                    m.segments,
                    m.contours,
                    quoted(&r.engine),
                    r.stage,
                    r.threads,
                    r.seconds,
                    optional(r.cpu_seconds),
                    r.segments_per_s,
                    r.triangle_planes_per_s,
                    r.bytes,
                    quoted(r.bytes_formula),
                    optional(r.bandwidth_share),
                    r.output.map_or("", Verdict::text),
                );
            }
        }
        text
    }
}

fn quoted(field: &str) -> String {
    format!("\"{}\"", field.replace('"', "\"\""))
}
