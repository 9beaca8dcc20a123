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

impl BackendArg {
    /// The backend as meant.
    pub fn options(self, adapter: Option<String>, memory: Option<u64>) -> BackendOptions {
        let backend = match self {
            Self::Auto => Backend::Auto,
            Self::Cpu => Backend::Cpu,
            Self::Gpu => Backend::Gpu,
        };
        BackendOptions::new(backend, adapter, memory)
    }
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
    /// Memory that slicing may take, in bytes or with K, M, G or T, as in 512M or 1.5G; less memory means more runs of layers, never another result [default: a quarter of the machine's, on a GPU at most half of its largest buffer]
    #[arg(long, value_name = "SIZE", value_parser = memory_size)]
    pub memory: Option<u64>,
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
        self.backend.options(self.adapter.clone(), self.memory)
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

/// The smallest memory that can be asked for \[bytes\].
const LEAST_MEMORY: u64 = 1 << 20;

/// A number of bytes, with a unit of 1024, 1024^2, ... bytes behind it.
pub(super) fn memory_size(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let bytes = text.trim_end_matches(['b', 'B']);
    let bytes = bytes.strip_suffix(['i', 'I']).unwrap_or(bytes);
    let units = [('k', 10), ('m', 20), ('g', 30), ('t', 40)];
    let unit = |c: char| units.iter().find(|(unit, _)| *unit == c.to_ascii_lowercase());
    let (number, shift) = match bytes.chars().last().and_then(unit) {
        Some(&(_, shift)) => (&bytes[..bytes.len() - 1], shift),
        None => (text, 0),
    };
    let number = number.trim();
    let whole = number.bytes().all(|b| b.is_ascii_digit() || b == b'.');
    let value = number.parse::<f64>().ok().filter(|_| whole);
    let value = value.ok_or("expected a size such as 512M or 1.5G")? * (1u64 << shift) as f64;
    if value < LEAST_MEMORY as f64 {
        return Err("at least 1M is needed".to_owned());
    }
    // Saturates: more than 2^64 bytes is no limit at all.
    Ok(value as u64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read() {
        for (text, bytes) in [
            ("512M", 512 << 20),
            ("2G", 2 << 30),
            ("1.5g", 3 << 29),
            ("2048K", 2 << 20),
            ("16777216", 16 << 20),
            ("3 GiB", 3 << 30),
            ("64MB", 64 << 20),
            ("1T", 1 << 40),
        ] {
            assert_eq!(memory_size(text), Ok(bytes), "{text}");
        }
        for text in ["", "M", "-1G", "1e9", "12X", "1..5G", "0", "1023K", "nanG", "infG", "5 5G", "512MM"] {
            assert!(memory_size(text).is_err(), "{text}");
        }
    }
}
