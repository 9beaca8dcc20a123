//! A request → an output.

use super::files::{length_and_crc32, make_folder_of, stat};
use super::profiles::{Profiles, Resolved};
use super::usage::{cpu_seconds, peak_bytes};
use super::{Failure, Material, Outcome, Request, Technology};
use crate::job::backend::BackendOptions;
use crate::job::filament::{self, FilamentJob, ModifierFiles};
use crate::job::output::{OutputError, OutputFile};
use crate::job::part::MeshOptions;
use crate::job::progress::{Progress, go_on};
use crate::job::resin::{self, PlateOptions, ResinJob, ResinSummary};
use crate::job::summary::{StageTime, Summary};
use crate::job::threads::on_pool;
use crate::job::toolpaths::save_png;
use crate::job::{FailureKind, JobError};
use crate::lattice::nm;
use crate::mask::check::CheckSettings;
use crate::mesh::orient::Orient;
use crate::mesh::{Placement, Transform};
use crate::path::LayerPlan;
use crate::picture;
use crate::resin::Format;
use crate::settings::Settings;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Size of a picture of the middle layer \[pixels\].
const PICTURE: (u32, u32) = (320, 240);

/// The last date that files can state, in the year 9999 \[s since 1970\].
const LAST_DATE: i64 = 253_402_300_799;

/// Least distance of copies on a resin printer's plate \[mm\]; that of the command line.
const SPACING: f64 = 3.0;

/// Does what is asked.
pub fn make(
    request: &Request,
    backend: &BackendOptions,
    profiles: &Profiles,
    progress: &dyn Progress,
) -> Result<Outcome, Failure> {
    let (begun, cpu) = (Instant::now(), cpu_seconds());
    go_on(progress).map_err(|e| Failure::from(&e))?;
    let mesh = check(request)?;
    let Resolved { settings, warnings } = profiles.resolve(request)?;
    let watched = Watched { progress, request, changed: AtomicBool::new(false) };
    if watched.has_changed() {
        return Err(changed(&request.model));
    }
    let work = Work { request, settings: &settings, backend, mesh, progress: &watched };
    let made = match request.technology {
        Technology::Filament => work.filament().map(Outcome::from),
        Technology::Resin => work.resin().map(Outcome::from),
    };
    let mut outcome = made.map_err(|e| match e {
        JobError::Cancelled if watched.changed.load(Ordering::Relaxed) => changed(&request.model),
        other => Failure::from(&other),
    })?;
    if let Some(output) = request.output.as_deref().filter(|_| !request.estimate) {
        let read = length_and_crc32(output).map_err(|e| JobError::from(OutputError::new(output, e)));
        outcome.crc32 = read.map_err(|e| Failure::from(&e))?.1;
    }
    outcome.warnings.splice(0..0, warnings.into_iter().chain(without_effect(request)));
    outcome.seconds = begun.elapsed().as_secs_f64();
    outcome.cpu_seconds = cpu_seconds() - cpu;
    outcome.peak_bytes = peak_bytes();
    Ok(outcome)
}

/// Checks what is checked on the command line by its parser.
fn check(request: &Request) -> Result<MeshOptions, Failure> {
    let wrong = |message: String| Err(Failure::new(FailureKind::Settings, message));
    if request.model.as_os_str().is_empty() {
        return wrong("model: no file is named; name an STL file".to_owned());
    }
    if request.output.as_ref().is_none_or(|path| path.as_os_str().is_empty()) && !request.estimate {
        return wrong("output: no file is named; name one, or set estimate to true".to_owned());
    }
    if !(1..=1000).contains(&request.copies) {
        return wrong(format!("copies: {} is out of range; allowed: 1 to 1000", request.copies));
    }
    if !(0..=LAST_DATE).contains(&request.date) {
        return wrong(format!("date: {} s is out of range; allowed: 0 to {LAST_DATE}", request.date));
    }
    if !(-3600.0..=3600.0).contains(&request.rotate) {
        return wrong(format!("rotate: {} is no angle; give degrees, such as 45 or -12.5", request.rotate));
    }
    let lengths =
        [("match_tolerance", request.match_tolerance, 1000.0), ("snap_grid", request.snap_grid, 10.0)];
    for (name, value, highest) in lengths {
        if let Some(mm) = value.filter(|mm| !(0.0..=highest).contains(mm)) {
            return wrong(format!("{name}: {mm} mm is not between 0 and {highest} mm"));
        }
    }
    let orient = match request.orient.as_str() {
        "auto" => Orient::Auto,
        "winding" => Orient::Winding,
        "normals" => Orient::Normals,
        "repair" => Orient::Repair,
        other => {
            let other = other.escape_debug();
            return wrong(format!(
                "orient: \"{other}\" is not a choice; allowed: auto, winding, normals, repair"
            ));
        }
    };
    Ok(MeshOptions {
        orient,
        match_tolerance: request.match_tolerance.map(nm),
        snap_grid: request.snap_grid.map(nm),
    })
}

/// Wishes that mean nothing to the technology.
fn without_effect(request: &Request) -> Vec<String> {
    let (wishes, printers) = match request.technology {
        Technology::Filament => (vec![("rotate", request.rotate != 0.0), ("check", request.check)], "resin"),
        Technology::Resin => (
            vec![
                ("support_enforcers", !request.support_enforcers.is_empty()),
                ("support_blockers", !request.support_blockers.is_empty()),
            ],
            "filament",
        ),
    };
    let given = wishes.into_iter().filter(|(_, given)| *given);
    given.map(|(name, _)| format!("{name}: for {printers} printers only, so it has no effect here")).collect()
}

/// A request with all that it needs.
struct Work<'a> {
    request: &'a Request,
    settings: &'a Settings,
    backend: &'a BackendOptions,
    mesh: MeshOptions,
    progress: &'a dyn Progress,
}

impl Work<'_> {
    fn placement(&self) -> Placement {
        if self.request.no_place { Placement::Keep } else { Placement::DropAndCentre }
    }

    /// The model's name without folder and extension.
    fn stem(&self) -> String {
        self.request.model.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    fn filament(&self) -> Result<Summary, JobError> {
        let request = self.request;
        let job = FilamentJob {
            settings: self.settings,
            placement: self.placement(),
            mesh: self.mesh.clone(),
            backend: self.backend.clone(),
            stem: self.stem(),
            date: request.date,
            modifiers: ModifierFiles {
                enforcers: request.support_enforcers.clone(),
                blockers: request.support_blockers.clone(),
            },
            copies: request.copies,
        };
        on_pool(|| self.gcode(&job))
    }

    fn gcode(&self, job: &FilamentJob<'_>) -> Result<Summary, JobError> {
        let Self { request, progress, .. } = *self;
        let planned = filament::plan(&request.model, job, progress)?;
        let middle = request.picture.is_some().then_some(planned.layers.len() / 2);
        let Some(output) = request.output.as_ref().filter(|_| !request.estimate) else {
            let (summary, kept) = filament::count_keeping(planned, job, progress, middle)?;
            self.draw(kept)?;
            return Ok(Summary { bytes: 0, ..summary });
        };
        make_folder_of(output).map_err(|e| OutputError::new(output, e))?;
        let mut out = OutputFile::create(output)?;
        let (summary, kept) =
            filament::write_keeping(planned, job, &mut out, progress, middle).map_err(|e| e.at(output))?;
        self.draw(kept)?;
        go_on(progress)?;
        out.commit()?;
        Ok(summary)
    }

    /// Draws the layer kept.
    fn draw(&self, kept: Option<LayerPlan>) -> Result<(), JobError> {
        let (Some(path), Some(plan)) = (&self.request.picture, kept) else { return Ok(()) };
        make_folder_of(path).map_err(|e| OutputError::new(path, e))?;
        let strokes = picture::toolpaths::strokes(&plan);
        Ok(save_png(&picture::strokes::render(&strokes, PICTURE.0, PICTURE.1), path)?)
    }

    fn resin(&self) -> Result<ResinSummary, JobError> {
        let Self { request, settings, progress, .. } = *self;
        let image = &settings.image;
        let job = ResinJob {
            settings,
            plate: PlateOptions {
                transform: Transform {
                    scale: [
                        image.relative_correction_x,
                        image.relative_correction_y,
                        image.relative_correction_z,
                    ],
                    turn: request.rotate,
                },
                placement: self.placement(),
                spacing: nm(SPACING),
                mesh: self.mesh.clone(),
            },
            backend: self.backend.clone(),
            layers: None,
            name: self.stem(),
            date: request.date,
            check: request.check.then(CheckSettings::default),
            check_report: None,
            check_pictures: None,
            picture: request.picture.clone(),
        };
        let models: Vec<PathBuf> = vec![request.model.clone(); request.copies as usize];
        let format = match &request.output {
            Some(output) => resin::format_of(output, settings)?,
            None => self.own_format()?,
        };
        if let Some(path) = &request.picture {
            make_folder_of(path).map_err(|e| OutputError::new(path, e))?;
        }
        match &request.output {
            Some(output) if !request.estimate => {
                make_folder_of(output).map_err(|e| OutputError::new(output, e))?;
                resin::run(&models, &job, format, output, progress)
            }
            _ => resin::estimate(&models, &job, format, progress),
        }
    }

    /// The format that the printer reads.
    fn own_format(&self) -> Result<Format, JobError> {
        let extension = self.settings.output_extension(None)?;
        let path = || self.request.model.with_extension(extension);
        Format::of_extension(extension).ok_or_else(|| JobError::NoFormat { path: path() })
    }
}

fn changed(model: &Path) -> Failure {
    let message = format!("{}: the file has changed since it was asked for; ask again", model.display());
    Failure { transient: true, ..Failure::new(FailureKind::Model, message) }
}

/// Stops the job when the model is no longer the one that was asked for.
struct Watched<'a> {
    progress: &'a dyn Progress,
    request: &'a Request,
    changed: AtomicBool,
}

impl Watched<'_> {
    fn has_changed(&self) -> bool {
        // One that cannot be looked at cannot be read either, which is told better there.
        let now = || stat(&self.request.model).ok();
        self.request.expect.is_some_and(|expected| now().is_some_and(|now| now != expected))
    }
}

/// The stage in which the model is read.
const READING: &str = "reading";

impl Progress for Watched<'_> {
    fn stage(&self, name: &'static str) {
        if name != READING && !self.changed.load(Ordering::Relaxed) && self.has_changed() {
            self.changed.store(true, Ordering::Relaxed);
        }
        self.progress.stage(name);
    }

    fn layers(&self, done: u64, all: u64) {
        self.progress.layers(done, all);
    }

    fn cancelled(&self) -> bool {
        self.changed.load(Ordering::Relaxed) || self.progress.cancelled()
    }
}

/// JSON has no other numbers.
fn finite(value: f64) -> f64 {
    if value.is_finite() { value } else { 0.0 }
}

fn stages(stages: Vec<StageTime>) -> Vec<(String, f64)> {
    stages.into_iter().map(|s| (s.stage.to_owned(), s.seconds)).collect()
}

impl From<Summary> for Outcome {
    fn from(s: Summary) -> Self {
        Self {
            bytes: s.bytes,
            layers: s.layers as u64,
            print_z_mm: s.print_z_mm,
            triangles: s.triangles,
            material: Material {
                mm: finite(s.filament.mm),
                cm3: finite(s.filament.cm3),
                g: s.filament.g,
                cost: s.filament.cost,
                mm_by_role: s.filament.mm_by_role,
            },
            time_lower_bound_s: finite(s.time_lower_bound_s),
            time_by_role_s: s.time_by_role_s,
            warnings: s.warnings,
            backend: s.backend.kind.to_owned(),
            stages: stages(s.stages),
            ..Self::default()
        }
    }
}

impl From<ResinSummary> for Outcome {
    fn from(s: ResinSummary) -> Self {
        Self {
            bytes: s.bytes,
            layers: s.layers.into(),
            print_z_mm: s.print_z_mm,
            triangles: s.triangles,
            material: Material {
                cm3: finite(s.volume_ml),
                g: s.weight_g,
                cost: s.cost,
                ..Material::default()
            },
            time_lower_bound_s: finite(s.time_lower_bound_s),
            warnings: s.warnings,
            backend: s.backend.kind.to_owned(),
            stages: stages(s.stages),
            ..Self::default()
        }
    }
}
