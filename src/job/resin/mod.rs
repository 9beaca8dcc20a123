//! From models to a resin printer's file: the one place where its stages are chained.

#[cfg(feature = "gpu")]
mod gpu;
mod layers;
mod make;
mod pictures;
mod plate;
mod stream;
mod summary;
mod target;

pub use plate::{ModelSummary, PlateOptions};
pub use summary::{LargestLayer, PanelSummary, ResinSummary};
pub use target::format_of;

use super::JobError;
use super::backend::BackendOptions;
use super::mask_check::CheckReport;
use super::memory;
use super::open::OpenContours;
use super::output::{OutputError, OutputFile};
use super::progress::{Progress, go_on};
use super::summary::Stopwatch;
use super::threads::on_pool;
use crate::contour::TraceOptions;
use crate::lattice;
use crate::mask::Panel;
use crate::mask::antialias::Shading;
use crate::mask::check::{CheckLayer, CheckSettings, Checker, Findings};
use crate::mask::raster::Raster;
use crate::picture;
use crate::resin::schedule::{self, Schedule};
use crate::resin::{Format, LayerInfo, Print, Totals, machine};
use crate::settings::Settings;
use crate::slice::planes::{self, LayerZ, PlaneError};
use layers::Wanted;
use make::{Made, Maker};
use plate::Plate;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use target::Target;

/// What is to be done with the models.
#[derive(Clone, Debug)]
pub struct ResinJob<'a> {
    /// All settings, of a resin printer.
    pub settings: &'a Settings,
    /// How models come onto the plate.
    pub plate: PlateOptions,
    /// Where planes and triangles are intersected.
    pub backend: BackendOptions,
    /// The layers wanted, counted from 0; `None` = all.
    pub layers: Option<Range<u32>>,
    /// The print's name, for members of archives.
    pub name: String,
    /// The date in the file, seconds since 1970-01-01 UTC.
    pub date: i64,
    /// What islands, cups and trapped resin are looked for with; `None` = they are not.
    pub check: Option<CheckSettings>,
    /// File for the report of the checks, as JSON.
    pub check_report: Option<PathBuf>,
    /// Folder for pictures of the worst layers that the checks found.
    pub check_pictures: Option<PathBuf>,
    /// File for a small picture of the middle layer, as PNG.
    pub picture: Option<PathBuf>,
}

/// Cuts models into masks and writes them.
///
/// # Errors
/// [`JobError`]: see its variants. The output is then as it was before.
pub fn run(
    paths: &[PathBuf],
    job: &ResinJob<'_>,
    format: Format,
    output: &Path,
    progress: &dyn Progress,
) -> Result<ResinSummary, JobError> {
    make(paths, job, format, Some(output), progress)
}

/// [`run`], or without an output only what it would say.
fn make(
    paths: &[PathBuf],
    job: &ResinJob<'_>,
    format: Format,
    output: Option<&Path>,
    progress: &dyn Progress,
) -> Result<ResinSummary, JobError> {
    let mut watch = Stopwatch::default();
    let settings = job.settings;
    let mut warnings: Vec<String> = settings.validate_resin()?.iter().map(ToString::to_string).collect();
    let panel = machine::panel(settings);
    let name = paths.first().map_or_else(String::new, |p| p.display().to_string());
    let height = settings.printer.max_print_height;
    go_on(progress)?;
    let plate = on_pool(|| plate::prepare(paths, &job.plate, &panel, height, progress, &mut watch))?;
    warnings.extend_from_slice(&plate.warnings);

    progress.stage("slicing");
    go_on(progress)?;
    watch.stage("preview");
    let layers = layers_of(&plate, job, &name)?;
    let shading = Shading {
        sub_rows: settings.image.anti_aliasing,
        gamma: settings.image.gamma_correction,
        minimum_grey: u8::try_from(settings.image.minimum_grey).unwrap_or(u8::MAX),
    };
    let [x, y, z] = plate.mesh.origin;
    let raster = Raster::new(panel, [x, y], &shading)?;
    let name_of_output = output.map_or_else(|| would_be(job, format), Path::to_owned);
    let container = format
        .container(&name_of_output, settings.machine.ctb_version)
        .ok_or(JobError::NoWriter(name_of_output))?;
    let print = print(&plate, &layers, job, &panel, output.map(|_| container.preview_size()));
    warnings.extend(container.losses(&print));
    let mut target = output.map(|path| Target::create(path, format)).transpose()?;
    let schedule = Schedule::new(settings, &panel);
    let offset = |layer: u32| machine::outline_offset(settings, &panel, layer);
    let maker = Maker {
        raster: &raster,
        container: output.map(|_| container.as_ref()),
        offset: &offset,
        keep_masks: job.check.is_some(),
    };
    let zs = planes::plane_zs(&layers.list, z);
    let trace = TraceOptions {
        simplify_tolerance: None,
        memory_budget: job.backend.memory.unwrap_or_else(memory::default_budget),
        ..job.plate.mesh.trace_options(&settings.slicing)
    };
    let wanted = Wanted {
        plate: &plate,
        planes: &zs,
        first: layers.first,
        maker: &maker,
        backend: &job.backend,
        trace: &trace,
    };

    watch.stage("masks");
    let mut sums = Sums::new(job.check, panel);
    let mut written = 0;
    let done = {
        let mut sink = target.as_mut().map(|t| t.begin(container.as_ref(), &print)).transpose()?;
        let done = stream::stream(
            |sender| wanted.make(sender),
            |made: Arc<Made>| {
                go_on(progress)?;
                let number = layers.first + written;
                let info = LayerInfo {
                    lit: made.lit,
                    area_mm2: made.area_mm2,
                    index: written,
                    ..schedule.layer(number, &layers.list[written as usize])
                };
                sums.layer(&info, &made, schedule.time(&info));
                if let Some(sink) = &mut sink {
                    sink.layer(&info, &made.encoded)?;
                }
                written += 1;
                progress.layers(written.into(), layers.list.len() as u64);
                Ok(())
            },
        )?;
        if sums.lit == 0 {
            return Err(JobError::Dark { model: name });
        }
        if let Some(sink) = sink {
            sink.finish(&sums.totals(&print))?;
        }
        done
    };
    warnings.extend(done.warning);
    let open_contours = OpenContours::new(&done.contours, &layers.list, plate.mesh.origin);
    warnings.extend(open_contours.warning(&name));
    watch.stage("finish");
    go_on(progress)?;
    let totals = sums.totals(&print);
    let (largest_layer, lit_pixels) = (sums.largest, sums.lit);
    let check = match (sums.finish(), &job.check) {
        (Some(findings), Some(settings)) => Some(CheckReport::new(findings, settings)),
        _ => None,
    };
    let pictures = job.check_pictures.as_ref().filter(|_| output.is_some());
    if let (Some(check), Some(settings), Some(folder)) = (&check, &job.check, pictures) {
        on_pool(|| pictures::draw(check, settings, &wanted, folder))?;
    }
    if let Some(path) = &job.picture {
        on_pool(|| pictures::draw_middle(&wanted, path))?;
    }
    let report = job.check_report.as_ref().filter(|_| output.is_some());
    if let (Some(check), Some(path)) = (&check, report) {
        write_report(path, check)?;
    }
    warnings.extend(check.iter().flat_map(CheckReport::warnings));
    go_on(progress)?;
    let bytes = target.map_or(Ok(0), Target::commit)?;
    Ok(ResinSummary {
        models: plate.models,
        output: output.map_or_else(String::new, |path| path.display().to_string()),
        format: format.name(),
        printer: print.machine.clone(),
        bytes,
        panel: PanelSummary {
            width: panel.width,
            height: panel.height,
            pitch_um: [panel.pitch_x as f64 / 1e3, panel.pitch_y as f64 / 1e3],
            anti_aliasing: shading.sub_rows,
        },
        layers: print.layers,
        print_z_mm: layers.list.last().map_or(0.0, |l| lattice::mm(l.print_z)),
        triangles: plate.mesh.triangles.len() as u64,
        lit_pixels,
        volume_ml: totals.volume_ml,
        weight_g: (print.density > 0.0).then_some(totals.weight_g),
        cost: (print.cost > 0.0).then_some(totals.cost),
        time_lower_bound_s: totals.time,
        largest_layer,
        open_contours,
        check,
        warnings,
        backend: done.backend,
        ignored_settings: Vec::new(),
        stages: watch.finish(),
    })
}

/// What [`run`] would say of a print in `format`, without writing anything: same layers, same volume, same bound
/// of the time. `bytes` is 0. Masks are measured but not compressed. Files for the checks' findings are not
/// written either, only a picture that was asked for.
///
/// # Errors
/// As [`run`], but for what only shows when a file is written: [`JobError::Unfit`], [`JobError::Output`].
pub fn estimate(
    paths: &[PathBuf],
    job: &ResinJob<'_>,
    format: Format,
    progress: &dyn Progress,
) -> Result<ResinSummary, JobError> {
    make(paths, job, format, None, progress)
}

/// A name that an output of the format could have; that of the printer's own files where they are of it.
fn would_be(job: &ResinJob<'_>, format: Format) -> PathBuf {
    let own = job.settings.machine.container.extension();
    let extension = match Format::of_extension(own) {
        Some(found) if found == format => own,
        _ => format.extensions().first().copied().unwrap_or_default(),
    };
    Path::new("estimate").with_extension(extension)
}

/// The layers wanted.
struct Layers {
    list: Vec<LayerZ>,
    /// Number of the first one in the whole print.
    first: u32,
}

fn layers_of(plate: &Plate, job: &ResinJob<'_>, name: &str) -> Result<Layers, JobError> {
    let planes = |error: PlaneError| JobError::Planes { model: name.to_owned(), error };
    let [lo, hi] = plate.mesh.world_bounds().unwrap_or_default();
    let all = schedule::layers(lo[2], hi[2], job.settings).map_err(planes)?;
    let Some(Range { start, end }) = job.layers.clone() else {
        return Ok(Layers { list: all, first: 0 });
    };
    let list = all.get(start as usize..(end as usize).min(all.len())).unwrap_or_default().to_vec();
    if list.is_empty() {
        return Err(JobError::LayerRange { layers: all.len(), range: start..end });
    }
    Ok(Layers { list, first: start })
}

/// The print as a whole, with a preview of that size or without one.
fn print(
    plate: &Plate,
    layers: &Layers,
    job: &ResinJob<'_>,
    panel: &Panel,
    preview: Option<[u32; 2]>,
) -> Print {
    let drawn = |[width, height]: [u32; 2]| picture::preview::render(&plate.mesh, width, height);
    Print {
        name: plain(&job.name),
        date: job.date,
        preview: Arc::new(preview.map(drawn).unwrap_or_default()),
        ..machine::print(job.settings, panel, layers.list.len() as u32)
    }
}

/// A name that every archive and printer can hold.
fn plain(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || c == '-' || c == '_' { c } else { '_' };
    let name: String = name.chars().take(60).map(plain).collect();
    if name.is_empty() { "print".to_owned() } else { name }
}

/// Before the masks appear: a report that cannot be written leaves no output behind.
fn write_report(path: &Path, check: &CheckReport) -> Result<(), JobError> {
    let mut out = OutputFile::create(path)?;
    serde_json::to_writer_pretty(&mut out, check)
        .map_err(std::io::Error::from)
        .and_then(|()| out.write_all(b"\n"))
        .map_err(|e| OutputError::new(path, e))?;
    out.commit()?;
    Ok(())
}

/// What is summed up while layers pass.
struct Sums {
    lit: u64,
    volume_mm3: f64,
    time: f64,
    largest: LargestLayer,
    checker: Option<Checker>,
    batch: Vec<CheckLayer>,
}

/// Layers that are checked in one go, in parallel.
const CHECKED_AT_ONCE: usize = 64;

impl Sums {
    fn new(check: Option<CheckSettings>, panel: Panel) -> Self {
        Self {
            lit: 0,
            volume_mm3: 0.0,
            time: 0.0,
            largest: LargestLayer::default(),
            checker: check.map(|settings| Checker::new(panel, settings)),
            batch: Vec::new(),
        }
    }

    fn layer(&mut self, info: &LayerInfo, made: &Made, time: f64) {
        self.lit += info.lit;
        self.volume_mm3 += info.area_mm2 * info.height;
        self.time += time;
        if info.area_mm2 > self.largest.area_mm2 {
            self.largest = LargestLayer { layer: info.index, area_mm2: info.area_mm2 };
        }
        if let (Some(checker), Some(mask)) = (&mut self.checker, &made.mask) {
            self.batch.push(CheckLayer { mask: Arc::clone(mask), z: info.z, height: info.height });
            if self.batch.len() >= CHECKED_AT_ONCE {
                on_pool(|| checker.push(&self.batch));
                self.batch.clear();
            }
        }
    }

    fn totals(&self, print: &Print) -> Totals {
        let volume_ml = self.volume_mm3 / 1000.0;
        Totals {
            time: self.time,
            volume_ml,
            weight_g: volume_ml * print.density,
            cost: volume_ml / 1000.0 * print.cost,
        }
    }

    fn finish(self) -> Option<Findings> {
        let mut checker = self.checker?;
        Some(on_pool(|| {
            checker.push(&self.batch);
            checker.finish()
        }))
    }
}
