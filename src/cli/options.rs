//! Flags that several commands share.

use crate::job::backend::{Backend, BackendOptions};
use clap::{Args, ValueEnum};

/// Where the planes are intersected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum BackendArg {
    /// A hardware GPU where the work repays its start-up, else the CPU
    Auto,
    /// The CPU, always
    Cpu,
    /// A GPU, or an error
    Gpu,
}

/// How to run, as typed.
#[derive(Clone, Debug, Args)]
pub struct RunArgs {
    /// Where to intersect planes and triangles; the output is the same everywhere
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: BackendArg,
    /// Part of the name of the GPU to use (see `microtome devices`); a software device is used only when named here
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Number of CPU threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Print nothing but errors
    #[arg(long, short)]
    pub quiet: bool,
    /// Print a machine-readable summary on stdout
    #[arg(long)]
    pub json: bool,
}

impl RunArgs {
    /// The backend as meant.
    pub fn backend(&self) -> BackendOptions {
        let backend = match self.backend {
            BackendArg::Auto => Backend::Auto,
            BackendArg::Cpu => Backend::Cpu,
            BackendArg::Gpu => Backend::Gpu,
        };
        BackendOptions { backend, adapter: self.adapter.clone() }
    }

    /// Sets the number of worker threads of the process; to be called once, before any work.
    pub fn set_threads(&self) {
        set_threads(self.threads);
    }
}

/// Sets the number of worker threads of the process; to be called once, before any work.
pub fn set_threads(threads: Option<u16>) {
    if let Some(n) = threads {
        // Fails only when the pool exists already, which a command never lets happen.
        drop(rayon::ThreadPoolBuilder::new().num_threads(n.into()).build_global());
    }
}
