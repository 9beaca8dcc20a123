//! `microtome worker`.

use super::exit::CliError;
use super::options::{BackendArg, RunArgs, set_threads};
use crate::slicer::Slicer;
use crate::slicer::serve::{ServeOptions, serve};
use clap::Args;
use std::io;

/// Printed under `microtome worker --help`.
const PROTOCOL: &str = r#"A line in is a JSON object with an id, any JSON value, and one order; a line out has the same id. The first line out says that the worker is ready:
  out {"id":null,"ready":{"version":"0.1.0","pid":4711}}
A request names a model and an output; all else is as for `slice` and `mask`:
  in  {"id":1,"slice":{"model":"a.stl","output":"a.gcode","load":["pla.ini"],"settings":{"layer_height":0.2}}}
  in  {"id":2,"slice":{"model":"b.stl","output":"b.goo","technology":"resin","printer":"elegoo-mars-4","check":true}}
Answers come in the order in which the work ends; what is not printed is null:
  out {"id":2,"failed":{"kind":"model","message":"b.stl: no such file; check the path","transient":false,"disk_full":false}}
  out {"id":1,"done":{"bytes":81920,"crc32":305419896,"layers":100,"material":{"mm":512.3,...},"warnings":[],...}}
Kinds of failures: model, settings, device, output, defect, cancelled. Other orders:
  {"id":3,"follow":{...}}   as slice, with {"id":3,"started":null} and {"id":3,"stage":"walls"} on the way
  {"id":4,"cancel":3}       {"id":4,"ok":null}, and request 3 fails as cancelled
  {"id":5,"ping":null}      {"id":5,"ok":null}
  {"id":6,"quit":null}      what is in hand is finished, then {"id":6,"ok":null}, then the worker ends
A line that is not understood is answered by {"id":...,"refused":"why"}; the end of the input is as good as a quit.
Fields of a request: model, output, technology (filament, resin), printer, load, settings, copies, orient, match_tolerance, snap_grid, no_place, support_enforcers, support_blockers, rotate, check, estimate, picture, threads, expect, date."#;

/// Arguments of `worker`.
#[derive(Debug, Args)]
#[command(after_help = PROTOCOL)]
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
    /// A failure that GPUs play: KIND@SUBMISSION or KIND@SUBMISSIONxDEVICES, such as lost@5
    #[cfg(feature = "gpu")]
    #[arg(long, value_name = "SPEC", hide = true)]
    pub fault: Option<crate::job::warm::FaultPlan>,
}

/// Answers requests until the input ends.
///
/// # Errors
/// [`CliError`] when standard input or output fails.
pub fn run(args: &WorkerArgs) -> Result<(), CliError> {
    let backend = RunArgs {
        backend: args.backend,
        adapter: args.adapter.clone(),
        memory: args.memory,
        threads: args.threads,
        quiet: true,
        json: false,
    };
    // Side by side, each request has its own threads; alone it takes those of the process.
    let own = args.threads.filter(|_| args.jobs > 1);
    set_threads(args.threads);
    let backend = backend.backend();
    #[cfg(feature = "gpu")]
    let backend = match args.fault {
        Some(faults) => backend.with_faults(faults),
        None => backend,
    };
    let slicer = Slicer::new(backend).with_threads(own);
    let options = ServeOptions { jobs: args.jobs.into(), die_with_input: args.die_with_input };
    let input = io::BufReader::with_capacity(1 << 16, io::stdin());
    Ok(serve(&slicer, &options, input, io::stdout())?)
}
