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
            sink.row(report::Stage::new("load", "file", 1), time, None);
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
