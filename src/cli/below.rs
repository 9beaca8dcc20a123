//! `microtome below`.

use super::exit::CliError;
use super::mesh_args::MeshArgs;
use super::progress::Spinner;
use super::report;
use crate::job::JobError;
use crate::job::below::{BelowJob, below};
use crate::job::output::{OutputError, OutputFile};
use crate::job::part::PartOptions;
use crate::lattice::nm;
use crate::mesh::{Placement, stl_write};
use crate::settings::PrinterSettings;
use clap::Args;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `below`.
#[derive(Debug, Args)]
pub struct BelowArgs {
    /// The model: an STL file, binary or ASCII
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Height of the cut above the bed, after placing
    #[arg(long, value_name = "MM", allow_negative_numbers = true, value_parser = height)]
    z: f64,
    /// Where the STL goes; `-` is standard output
    #[arg(long, short, value_name = "FILE")]
    output: PathBuf,
    /// Close the cut with a flat lid
    #[arg(long)]
    cap: bool,
    /// Write ASCII instead of binary STL
    #[arg(long)]
    ascii: bool,
    /// Keep the model's coordinates instead of dropping it onto the bed and centring it there
    #[arg(long)]
    no_place: bool,
    /// Faulty meshes.
    #[command(flatten)]
    mesh: MeshArgs,
    /// Number of CPU threads [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
    /// Print a machine-readable summary on stdout
    #[arg(long, conflicts_with = "quiet")]
    json: bool,
}

/// Writes the mesh under a plane.
///
/// # Errors
/// [`CliError`]; the output is then as it was before.
pub fn run(args: &BelowArgs) -> Result<(), CliError> {
    super::options::set_threads(args.threads);
    let printer = PrinterSettings::default();
    let job = BelowJob {
        z: nm(args.z),
        cap: args.cap,
        part: PartOptions {
            printer: &printer,
            placement: if args.no_place { Placement::Keep } else { Placement::DropAndCentre },
            // Nothing is printed.
            must_fit: false,
            mesh: &args.mesh.options(),
            file: Some(&args.model),
        },
    };
    let spinner = Spinner::new(args.quiet);
    let (mesh, mut summary) = below(&args.model, &job, &spinner)?;
    let write = |out: &mut dyn Write| {
        let mut out = out;
        if args.ascii {
            stl_write::write_stl_ascii(&mesh, &mut out)
        } else {
            stl_write::write_stl_binary(&mesh, &mut out)
        }
    };
    if args.output == Path::new("-") {
        let mut out = io::BufWriter::with_capacity(1 << 18, io::stdout().lock());
        write(&mut out)
            .and_then(|()| out.flush())
            .map_err(|e| JobError::from(OutputError::new(Path::new("standard output"), e)))?;
    } else {
        let mut out = OutputFile::create(&args.output).map_err(JobError::from)?;
        write(&mut out).map_err(|e| JobError::from(OutputError::new(&args.output, e)))?;
        out.commit().map_err(JobError::from)?;
    }
    drop(spinner);
    summary.output = args.output.display().to_string();
    if !args.quiet {
        report::warning_lines(&summary.warnings);
        if !args.json {
            let mut err = io::stderr().lock();
            let lid = if args.cap { ", closed" } else { "" };
            drop(writeln!(
                err,
                "{}: {} triangles under z = {:.3} mm{lid}",
                summary.output, summary.triangles, summary.z_mm
            ));
        }
    }
    if args.json {
        report::json(&summary)?;
    }
    Ok(())
}

fn height(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| format!("`{text}` is not a number"))?;
    if value.is_finite() { Ok(value) } else { Err(format!("{value} is not a height")) }
}
