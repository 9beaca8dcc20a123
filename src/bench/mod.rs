//! The same work on every engine: the algorithms of the literature, the CPU core at any number of
//! threads, GPUs. Timed stage by stage, and compared.

mod case;
mod cpu;
#[cfg(feature = "gpu")]
mod gpu;
mod machine;
pub mod models;
mod plot;
pub mod report;

pub use machine::{Machine, Time};
pub use plot::plot;
pub use report::{ModelReport, Report, Row, Verdict};

use crate::contour::TraceOptions;
use crate::job::JobError;
use crate::slice::classic::Algorithm;
use case::Case;
use report::Sink;
use std::path::PathBuf;
use thiserror::Error;

/// What to measure.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// Model files; the built-in models where there are none.
    pub models: Vec<PathBuf>,
    /// Small built-in models instead of large ones.
    pub quick: bool,
    /// Distance of the planes \[mm\]; 0.2, or the built-in model's own, where neither this nor
    /// `planes_count` is given.
    pub layer_height: Option<f64>,
    /// Number of evenly spaced planes.
    pub planes_count: Option<u32>,
    /// Which algorithms; [`Algorithm::Main`] is the CPU core.
    pub algorithms: Vec<Algorithm>,
    /// Numbers of threads for the CPU core.
    pub threads: Vec<usize>,
    /// Parts of names of GPUs.
    pub adapters: Vec<String>,
    /// Each stage is run so many times and its median is reported.
    pub runs: usize,
    /// The trivial algorithm is skipped where triangles × planes exceed this.
    pub work_limit: u64,
    /// Engines that keep all segments are skipped where these would take more \[bytes\].
    pub memory_limit: u64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            models: Vec::new(),
            quick: false,
            layer_height: None,
            planes_count: None,
            algorithms: Algorithm::ALL.to_vec(),
            threads: vec![1],
            adapters: Vec::new(),
            runs: 3,
            work_limit: 1_000_000_000,
            memory_limit: 1 << 30,
        }
    }
}

/// Why a benchmark ended early.
#[derive(Debug, Error)]
pub enum BenchError {
    /// A model or a device failed.
    #[error(transparent)]
    Job(#[from] JobError),
    /// The system refused threads.
    #[error("cannot start {threads} threads: {source}; ask for fewer with --threads")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// What the system said.
        source: rayon::ThreadPoolBuildError,
    },
    /// Engines disagree.
    #[error("{count} outputs differ from the CPU core's; please report this with the table above")]
    Different {
        /// How many.
        count: usize,
    },
}

/// Contours as they come from the walk, every point kept.
const RAW: TraceOptions =
    TraceOptions { simplify_tolerance: None, match_tolerance: 100_000, memory_budget: 256 << 20 };

/// Measures everything asked for; `show` gets lines for people while it runs.
///
/// # Errors
/// [`BenchError`]; engines that disagree are no error here but in the report, see [`Report::check`].
pub fn run(options: &Options, show: &mut (dyn FnMut(&str) + Send)) -> Result<Report, BenchError> {
    let machine = Machine::measure(&options.threads, options.quick)?;
    show(&machine.to_string());
    #[cfg(not(feature = "gpu"))]
    if !options.adapters.is_empty() {
        return Err(JobError::NoGpuSupport.into());
    }
    #[cfg(feature = "gpu")]
    let mut devices = gpu::open(&options.adapters)?;
    let mut models = Vec::new();
    for source in case::sources(options) {
        let (case, load) = Case::new(&source, options)?;
        let mut sink = Sink::new(&case, &machine, show);
        if let Some(time) = load {
            let stage = report::Stage::new("cpu core", "load", rayon::current_num_threads());
            sink.row(stage.bytes([62, 12, 0, 0], "62 T + 12 V"), time, None);
        }
        let reference = cpu::core(&case, options, &mut sink)?;
        cpu::classic(&case, &reference, options, &mut sink)?;
        #[cfg(feature = "gpu")]
        for device in &mut devices {
            gpu::measure(device, &case, &reference, options, &mut sink)?;
        }
        models.push(sink.finish(&reference));
    }
    Ok(Report { machine, runs: options.runs, models })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::mesh::{shapes, stl_write};

    #[test]
    fn all_engines_agree_on_a_file() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a,\"torus\".stl");
        let mut bytes = Vec::new();
        stl_write::write_stl_binary(&shapes::torus(6.0, 2.0, 40, 20), &mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let options = Options {
            models: vec![path],
            quick: true,
            threads: vec![1, 2],
            runs: 1,
            planes_count: Some(31),
            ..Options::default()
        };
        let mut lines = Vec::new();
        let mut report = run(&options, &mut |line| lines.push(line.to_owned())).unwrap();
        assert!(report.check().is_ok(), "{lines:#?}");
        let model = &report.models[0];
        assert_eq!((model.triangles, model.planes, model.skipped.len()), (1600, 31, 0));
        let compared = model.stages.iter().filter(|r| r.output.is_some()).count();
        assert_eq!(compared, 2 + 1 + 4 * 2, "two of the core, the twin's, two of each algorithm");
        assert!(model.stages.iter().any(|r| r.stage == "load"));
        assert_eq!(report.csv().lines().count(), 1 + model.stages.len());
        assert!(report.csv().contains("\"a,\"\"torus\"\".stl\","));
        assert!(plot(&report).contains("a,&quot;torus&quot;.stl"));
        assert!(serde_json::to_string(&report).unwrap().contains("\"output\":\"equal\""));

        let stages = &mut report.models[0].stages;
        let row = stages.iter_mut().find(|r| r.output.is_some()).unwrap();
        row.output = Some(Verdict::Different);
        let error = report.check().unwrap_err().to_string();
        assert!(error.starts_with("1 outputs differ"), "{error}");
    }

    #[test]
    fn what_would_take_too_long_is_skipped_and_said_so() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("box.stl");
        let mut bytes = Vec::new();
        stl_write::write_stl_binary(&shapes::cuboid([0.0; 3], [1.0; 3]), &mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        let options = Options { models: vec![path], quick: true, runs: 1, ..Options::default() };
        let skipped = |options: Options| run(&options, &mut |_| ()).unwrap().models[0].skipped.clone();
        let work = skipped(Options { work_limit: 59, ..options.clone() });
        assert_eq!(work, ["trivial: 60 triangle-planes, the bound is 59"]);
        assert_eq!(skipped(Options { memory_limit: 100, ..options }).len(), 5);
    }
}
