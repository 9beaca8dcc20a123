//! `microtome demo`.

use super::exit::CliError;
use super::progress::Spinner;
use super::report;
use crate::job::JobError;
use crate::job::backend::{Backend, BackendOptions};
use crate::job::filament::{self, FilamentJob, ModifierFiles};
use crate::job::output::OutputFile;
use crate::job::part::MeshOptions;
use crate::job::progress::Progress;
use crate::job::summary::{Stopwatch, Summary};
use crate::job::toolpaths::{save_png, toolpaths};
use crate::mesh::{self, Loaded, Placement};
use crate::picture;
use crate::settings::Settings;
use clap::Args;
use sha2::{Digest, Sha256};
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Arguments of `demo`.
#[derive(Debug, Args)]
pub struct DemoArgs {
    /// Folder for demo.gcode and demo.png
    #[arg(long, short, value_name = "DIR", default_value = ".")]
    output: PathBuf,
    /// Print nothing but errors
    #[arg(long, short)]
    quiet: bool,
}

/// Size of each half of the picture \[pixels\].
const PANEL: (u32, u32) = (800, 600);

/// Slices the built-in part, draws it, and compares the file's hash between CPU and GPU.
///
/// # Errors
/// [`CliError`]; a device that fails or differs is an error too.
pub fn run(args: &DemoArgs) -> Result<(), CliError> {
    let spinner = Spinner::new(args.quiet);
    let settings = settings();
    let on = |backend, adapter: Option<String>| FilamentJob {
        settings: &settings,
        placement: Placement::DropAndCentre,
        mesh: MeshOptions::default(),
        backend: BackendOptions::new(backend, adapter, None),
        stem: "demo".to_owned(),
        date: super::source_date_epoch(),
        modifiers: ModifierFiles::default(),
        copies: 1,
    };
    let job = on(Backend::Cpu, None);
    let planned = plan(&job, &spinner)?;
    let image = draw(&planned, &job);
    let gcode = args.output.join("demo.gcode");
    let (summary, cpu_hash) = write(planned, &job, &gcode, &spinner)?;
    let png = args.output.join("demo.png");
    save_png(&image, &png).map_err(JobError::from)?;

    let mut lines = vec![format!("cpu  {cpu_hash}")];
    let mut differs = None;
    for adapter in adapters() {
        let job = on(Backend::Gpu, Some(adapter.clone()));
        let planned = plan(&job, &spinner)?;
        let mut sink = Hashing { inner: io::sink(), hash: Sha256::new() };
        filament::write(planned, &job, &mut sink, &spinner).map_err(|e| e.at(Path::new("memory")))?;
        let hash = sink.hex();
        if hash != cpu_hash {
            differs = Some(adapter.clone());
        }
        lines.push(format!("gpu  {hash}  {adapter}"));
    }
    drop(spinner);

    if !args.quiet {
        report::people(&summary);
        let mut out = io::stdout().lock();
        writeln!(out, "{}\n{}", gcode.display(), png.display())?;
        writeln!(out, "SHA-256 of the G-code:")?;
        for line in &lines {
            writeln!(out, "{line}")?;
        }
        if lines.len() == 1 {
            writeln!(out, "gpu  no device found: the CPU did everything")?;
        } else if differs.is_none() {
            writeln!(out, "the same bytes")?;
        }
    }
    differs.map_or(Ok(()), |adapter| Err(CliError::Differs { adapter }))
}

/// What the demo is printed with: common values for a 0.4 mm nozzle and PLA.
fn settings() -> Settings {
    let mut s = Settings::default();
    s.slicing.layer_height = 0.2;
    s.slicing.first_layer_height = crate::settings::FloatOrPercent::Float(0.2);
    s.slicing.resolution = 0.005;
    s.output.gcode_resolution = 0.005;
    s.widths.extrusion_width = crate::settings::FloatOrPercent::Float(0.45);
    s.widths.first_layer_extrusion_width = crate::settings::FloatOrPercent::Float(0.45);
    s.filament.temperature = 210;
    s.filament.first_layer_temperature = 215;
    s.filament.bed_temperature = 60;
    s.filament.first_layer_bed_temperature = 60;
    s.filament.filament_density = 1.24;
    s.retraction.retract_length = 0.8;
    s
}

fn plan(job: &FilamentJob<'_>, progress: &dyn Progress) -> Result<filament::Planned, JobError> {
    let part = mesh::demo_part();
    let facets = part.triangles.len() as u64;
    let loaded = Loaded { mesh: part, facets, collapsed: 0, warnings: Vec::new() };
    filament::plan_mesh(loaded, "the demo part", job, progress, Stopwatch::default())
}

fn write(
    planned: filament::Planned,
    job: &FilamentJob<'_>,
    path: &Path,
    progress: &dyn Progress,
) -> Result<(Summary, String), JobError> {
    let mut out = Hashing { inner: OutputFile::create(path)?, hash: Sha256::new() };
    let mut summary = filament::write(planned, job, &mut out, progress).map_err(|e| e.at(path))?;
    summary.output = path.display().to_string();
    let hash = out.hex();
    out.inner.commit()?;
    Ok((summary, hash))
}

/// Every device of this machine, hardware or not.
fn adapters() -> Vec<String> {
    #[cfg(feature = "gpu")]
    return crate::gpu::adapters().into_iter().map(|a| a.name).collect();
    #[cfg(not(feature = "gpu"))]
    Vec::new()
}

/// The part on the left; on the right the layer with the most kinds of line and islands.
fn draw(planned: &filament::Planned, job: &FilamentJob<'_>) -> image::RgbImage {
    let light = [picture::BACKGROUND.0; 2];
    let part = picture::preview::render_on(&[&mesh::demo_part()], PANEL.0, PANEL.1, light);
    let part = image::RgbImage::from_raw(part.width, part.height, part.rgb).unwrap_or_default();
    let telling = planned.layers.iter().enumerate().max_by_key(|(_, l)| {
        let fills = || l.islands.iter().flat_map(|i| &i.fills);
        let kinds: BTreeSet<_> = fills().map(|f| f.kind).collect();
        (kinds.len(), l.islands.len(), fills().count())
    });
    let plan = telling.and_then(|(i, _)| toolpaths(planned, job, i)).unwrap_or_default();
    let strokes = picture::toolpaths::strokes(&plan);
    picture::beside(&part, &picture::strokes::render(&strokes, PANEL.0, PANEL.1))
}

/// Passes bytes on and hashes them.
struct Hashing<W> {
    inner: W,
    hash: Sha256,
}

impl<W> Hashing<W> {
    fn hex(&self) -> String {
        self.hash.clone().finalize().iter().map(|b| format!("{b:02x}")).collect()
    }
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.inner.write(bytes)?;
        self.hash.update(&bytes[..n]);
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
