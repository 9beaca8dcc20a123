//! `microtome bench`.

use super::exit::CliError;
use crate::bench::{self, Options};
use crate::job::JobError;
use crate::job::output::{OutputError, OutputFile};
use crate::slice::classic::Algorithm;
use clap::Args;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Arguments of `bench`.
#[derive(Debug, Args)]
pub struct BenchArgs {
    /// Models to slice: STL files [default: models made by the program, large ones]
    #[arg(value_name = "MODEL")]
    models: Vec<PathBuf>,
    /// Small built-in models: seconds instead of minutes
    #[arg(long)]
    quick: bool,
    /// Distance of the planes in mm [default: 0.2, or the built-in model's own]
    #[arg(long, value_name = "MM", value_parser = height, conflicts_with = "planes_count")]
    layer_height: Option<f64>,
    /// Number of planes, evenly spaced over the model's height
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1 << 24))]
    planes_count: Option<u32>,
    /// Algorithms: main, trivial, sweep, grouping, incremental
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "main,trivial,sweep,grouping,incremental"
    )]
    algorithms: Vec<Algorithm>,
    /// Numbers of threads for the main core [default: 1, 2, 4 ... and all cores]
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Vec<u16>,
    /// Part of the name of a GPU to measure as well (see `microtome devices`); may be repeated
    #[arg(long, value_name = "NAME")]
    adapter: Vec<String>,
    /// Runs of each stage; the median counts
    #[arg(long, value_name = "N", default_value = "3", value_parser = clap::value_parser!(u16).range(1..=1000))]
    runs: u16,
    /// Skip the trivial algorithm above this many triangles x planes
    #[arg(long, value_name = "N", default_value = "1000000000")]
    work_limit: u64,
    /// Skip what keeps all segments in memory where they take more than this many MiB
    #[arg(long, value_name = "MIB", default_value = "1024", value_parser = clap::value_parser!(u64).range(0..=1 << 30))]
    memory_limit: u64,
    /// Write the figures as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the figures as CSV, one line per stage
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a bar chart as SVG
    #[arg(long, value_name = "FILE")]
    plot: Option<PathBuf>,
}

/// Measures and compares as asked.
///
/// # Errors
/// [`CliError`]; outputs that differ are an error after everything is written.
pub fn run(args: &BenchArgs) -> Result<(), CliError> {
    let options = Options {
        models: args.models.clone(),
        quick: args.quick,
        layer_height: args.layer_height,
        planes_count: args.planes_count,
        algorithms: args.algorithms.clone(),
        threads: if args.threads.is_empty() {
            doublings()
        } else {
            args.threads.iter().map(|&n| n.into()).collect()
        },
        adapters: args.adapter.clone(),
        runs: args.runs.into(),
        work_limit: args.work_limit,
        memory_limit: args.memory_limit << 20,
    };
    let mut shown = Ok(());
    let report = bench::run(&options, &mut |line| {
        if shown.is_ok() {
            let mut out = std::io::stdout().lock();
            shown = writeln!(out, "{line}").and_then(|()| out.flush());
        }
    })?;
    if let Some(path) = &args.json {
        let text = serde_json::to_string_pretty(&report).map_err(std::io::Error::other)?;
        write(path, &text)?;
    }
    if let Some(path) = &args.csv {
        write(path, &report.csv())?;
    }
    if let Some(path) = &args.plot {
        write(path, &bench::plot(&report))?;
    }
    report.check()?;
    Ok(shown?)
}

/// 1, 2, 4 and so on, and the number of cores.
fn doublings() -> Vec<usize> {
    let cores = std::thread::available_parallelism().map_or(1, Into::into);
    let mut list: Vec<usize> =
        std::iter::successors(Some(1), |n| Some(2 * n)).take_while(|n| *n < cores).collect();
    list.push(cores);
    list
}

fn height(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(mm) if (1e-6..=2000.0).contains(&mm) => Ok(mm),
        _ => Err("a height in mm, for example 0.2".to_owned()),
    }
}

fn write(path: &Path, text: &str) -> Result<(), JobError> {
    let mut out = OutputFile::create(path)?;
    out.write_all(text.as_bytes()).map_err(|e| OutputError::new(path, e))?;
    Ok(out.commit()?)
}
