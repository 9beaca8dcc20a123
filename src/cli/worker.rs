//! `microtome worker`.

use super::exit::CliError;
use super::options::BackendArg;
use clap::Args;

/// Arguments of `worker`.
#[derive(Debug, Args)]
pub struct WorkerArgs {
    /// Requests worked on at a time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: u16,
    /// CPU threads of a request that does not say otherwise [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
    /// Where to intersect planes and triangles; the output is the same everywhere
    #[arg(long, value_enum, default_value = "auto")]
    pub backend: BackendArg,
    /// Part of the name of the GPU to use (see `microtome devices`); a software device is used only when named here
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Memory that slicing may take, as for `slice`
    #[arg(long, value_name = "SIZE", value_parser = super::options::memory_size)]
    pub memory: Option<u64>,
    /// End at once when standard input ends without a `quit`
    #[arg(long, hide = true)]
    pub die_with_input: bool,
}

/// Answers requests until the input ends.
///
/// # Errors
/// [`CliError`] when standard input or output fails.
pub fn run(args: &WorkerArgs) -> Result<(), CliError> {
    let _ = args;
    Ok(())
}
