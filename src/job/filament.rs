//! From a model to G-code: the one place where the stages are chained.

use super::JobError;
use super::backend::{self, BackendOptions};
use super::copies::Copies;
use super::error::WriteError;
use super::gcode_text::GcodeText;
use super::modifiers::{Cuts, ModifierRows};
use super::open::OpenContours;
use super::part::{self, MeshOptions, Part, PartOptions};
use super::progress::{Progress, go_on};
use super::summary::{FilamentSummary, Stopwatch, Summary};
use super::support_report::{Subject, SupportRecord, SupportWish};
use super::{adhesion, assemble, copies, support_report, supports};
use crate::contour::{ExPolygon, LayerContours, TraceOptions};
use crate::infill::FillLayer;
use crate::lattice::{self, Point2};
use crate::mesh::{self, Loaded, Mesh, Placement};
use crate::path::{LayerPlan, Planner, PrintLayer, Role};
use crate::region::offset::{Join, inset, outset};
use crate::region::perimeters::WallPlan;
use crate::region::{Island, areas, foot};
use crate::settings::Settings;
use crate::slice::planes::{self, LayerZ};
use crate::support::SupportPlan;
use crate::support::raft::{self, Heights};
use crate::{gcode, infill, region};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

/// What is to be done with a model.
#[derive(Clone, Debug)]
pub struct FilamentJob<'a> {
    /// All settings.
    pub settings: &'a Settings,
    /// Where the part goes on the bed.
    pub placement: Placement,
    /// How faults of the mesh are dealt with.
    pub mesh: MeshOptions,
    /// Where planes and triangles are intersected.
    pub backend: BackendOptions,
    /// The model's name without folder and extension, for templates and messages.
    pub stem: String,
    /// The date in the file's head, seconds since 1970-01-01 UTC.
    pub date: i64,
    /// Where supports are wanted and where not.
    pub modifiers: ModifierFiles,
    /// How many of the model are laid on the bed, side by side; 0 counts as 1.
    pub copies: u32,
}

/// Meshes in the model's frame that say where supports go.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ModifierFiles {
    /// What hangs in these is supported, however steep.
    pub enforcers: Vec<PathBuf>,
    /// What hangs in these is not supported.
    pub blockers: Vec<PathBuf>,
}

/// A model whose layers are ready to be put in order and written.
#[derive(Debug)]
pub struct Planned {
    /// Walls and fills of every layer, from the bed upwards.
    pub layers: Vec<PrintLayer>,
    /// World position of the layers' zero \[nm\].
    pub origin: [i64; 3],
    /// What was found out about supports.
    pub supports: SupportRecord,
    summary: Summary,
    watch: Stopwatch,
}

/// Reads a model and does everything up to walls, fills, supports and skirt.
///
/// # Errors
/// [`JobError`]: see its variants.
pub fn plan(path: &Path, job: &FilamentJob<'_>, progress: &dyn Progress) -> Result<Planned, JobError> {
    plan_with(path, job, SupportWish::default(), progress)
}

/// [`plan`], with what is wished to be said about supports.
///
/// # Errors
/// As [`plan`].
pub fn plan_with(
    path: &Path,
    job: &FilamentJob<'_>,
    wish: SupportWish,
    progress: &dyn Progress,
) -> Result<Planned, JobError> {
    let mut watch = Stopwatch::default();
    progress.stage("reading");
    watch.stage("load");
    go_on(progress)?;
    let loaded = mesh::load(path)?;
    go_on(progress)?;
    plan_loaded(loaded, &path.display().to_string(), Some(path), job, wish, progress, watch)
}

/// [`plan`] for a mesh in memory; `name` stands for it in messages.
///
/// # Errors
/// [`JobError`]: see its variants.
pub fn plan_mesh(
    loaded: Loaded,
    name: &str,
    job: &FilamentJob<'_>,
    progress: &dyn Progress,
    watch: Stopwatch,
) -> Result<Planned, JobError> {
    plan_mesh_with(loaded, name, job, SupportWish::default(), progress, watch)
}

/// [`plan_mesh`], with what is wished to be said about supports.
///
/// # Errors
/// As [`plan`].
pub fn plan_mesh_with(
    loaded: Loaded,
    name: &str,
    job: &FilamentJob<'_>,
    wish: SupportWish,
    progress: &dyn Progress,
    watch: Stopwatch,
) -> Result<Planned, JobError> {
    plan_loaded(loaded, name, None, job, wish, progress, watch)
}

fn plan_loaded(
    loaded: Loaded,
    name: &str,
    file: Option<&Path>,
    job: &FilamentJob<'_>,
    wish: SupportWish,
    progress: &dyn Progress,
    mut watch: Stopwatch,
) -> Result<Planned, JobError> {
    let settings = job.settings;
    let file_origin = loaded.mesh.origin;
    let mut warnings: Vec<String> = settings.validate()?.iter().map(ToString::to_string).collect();
    warnings.extend(nothing_supported(job));
    let options = PartOptions {
        printer: &settings.printer,
        placement: job.placement,
        must_fit: true,
        mesh: &job.mesh,
        file,
    };
    let part = part::prepare(loaded, name, &options, progress, &mut watch)?;
    let Part { mesh, adjacency, summary: mesh_summary, warnings: found } = part;
    warnings.extend(found);
    let spacing = settings.adhesion.duplicate_distance;
    let Copies { mesh, adjacency, shifts } =
        copies::lay_out(mesh, adjacency, job.copies, spacing, &settings.printer)
            .map_err(|error| JobError::Place { model: name.to_owned(), error })?;
    let raft = Heights::new(settings);
    fits_on_raft(&mesh, &raft, settings, name)?;

    progress.stage("slicing");
    go_on(progress)?;
    watch.stage("slice");
    // What concerns the first layer concerns the raft where there is one.
    let on_raft = (!raft.layers.is_empty()).then(|| raft::part_settings(settings));
    let own = on_raft.as_ref().unwrap_or(settings);
    let mut layers =
        planes::of_mesh(&mesh, own).map_err(|error| JobError::Planes { model: name.to_owned(), error })?;
    let planes = planes::plane_zs(&layers, mesh.origin[2]);
    let options = job.mesh.trace_options(&own.slicing);
    let traced = backend::contours(&mesh, &adjacency, &planes, &job.backend, &options)?;
    warnings.extend(traced.warning);
    let open_contours = OpenContours::new(&traced.layers, &layers, mesh.origin);
    warnings.extend(open_contours.warning(name));
    let triangles = mesh.triangles.len() as u64;
    let origin = mesh.origin;
    let modifiers = modifiers(job, &layers, [file_origin, origin], &shifts, &options, &mut warnings)?;
    drop((mesh, adjacency));
    let contours = traced.layers.iter().map(|l| l.rings.len() as u64).sum();

    progress.stage("walls");
    go_on(progress)?;
    watch.stage("walls");
    let wall_plans: Vec<WallPlan> =
        (0..).zip(&layers).map(|(i, z)| WallPlan::new(own, lattice::mm(z.height), i == 0)).collect();
    let areas = outlines(&traced.layers, wall_plans.first(), own);
    drop(traced.layers);
    let islands = region::layers::all_walls(areas, &wall_plans);
    if islands.iter().flatten().all(|i| i.walls.is_empty() && i.beads.is_empty() && i.infill.is_empty()) {
        let width_mm = WallPlan::new(own, lattice::mm(layers[0].height), true).external_width as f64;
        return Err(JobError::Empty { model: name.to_owned(), width_mm: width_mm / lattice::NM_PER_MM });
    }

    progress.stage("infill");
    go_on(progress)?;
    watch.stage("infill");
    let fill_plan = if settings.slicing.adaptive_layer_height {
        infill::FillPlan::for_heights(own, layers.iter().map(|l| l.height))
    } else {
        infill::FillPlan::new(own)
    };
    let filled = infill::fill(&fill_layers(&islands, &layers), &fill_plan);
    layers.iter_mut().for_each(|l| l.print_z += raft.part_z);

    progress.stage("supports");
    go_on(progress)?;
    watch.stage("supports");
    let bridges = (&filled.bridges[..], &fill_plan.area_frame());
    let make =
        |settings: &Settings| supports::supports(&islands, &layers, bridges, modifiers.modifiers(), settings);
    let mut beside = make(settings);
    let subject = Subject { name, origin, settings, make: &make };
    let in_air = support_report::check(&beside, &subject);
    warnings.extend(in_air.as_ref().and_then(|found| support_report::warning(found, &subject)));
    let record = support_report::record(&beside, wish, &subject);
    let (skirt, brim) = adhesion::skirt_and_brim(&islands, &layers, &beside, settings);
    beside.brim = brim;
    warnings.extend(
        adhesion::beyond_bed(&skirt, &beside, origin, settings).map(|what| format!("{name}: {what}")),
    );
    let print_z_mm = layers.last().map_or(0.0, |l| lattice::mm(l.print_z));
    let layers = assemble::assemble(layers, islands, filled.paths, beside, &skirt, settings);
    let summary = Summary {
        model: name.to_owned(),
        output: String::new(),
        bytes: 0,
        layers: layers.len(),
        print_z_mm,
        triangles,
        segments: traced.segments,
        contours,
        open_contours,
        mesh: mesh_summary,
        in_air,
        filament: FilamentSummary::default(),
        bounds_mm: None,
        time_lower_bound_s: 0.0,
        time_by_role_s: BTreeMap::new(),
        warnings,
        backend: traced.backend,
        ignored_settings: Vec::new(),
        stages: Vec::new(),
    };
    Ok(Planned { layers, origin, supports: record, summary, watch })
}

/// What [`plan`] and [`write()`] would say, without writing anything: same filament, same layers, same bound of
/// the time. `bytes` is 0.
///
/// Everything that decides the filament is done as for a print, because each line's length counts; only the
/// text is not formed.
///
/// # Errors
/// As [`plan`], and for a wrong template as [`write()`].
pub fn estimate(path: &Path, job: &FilamentJob<'_>, progress: &dyn Progress) -> Result<Summary, JobError> {
    count(plan(path, job, progress)?, job, progress)
}

/// [`estimate`] of a model whose layers are ready.
///
/// # Errors
/// A template is wrong.
pub fn count(planned: Planned, job: &FilamentJob<'_>, progress: &dyn Progress) -> Result<Summary, JobError> {
    Ok(count_keeping(planned, job, progress, None)?.0)
}

/// [`count`]; also gives the extrusions of one layer, counted from 0, for a picture.
///
/// # Errors
/// As [`count`].
pub fn count_keeping(
    planned: Planned,
    job: &FilamentJob<'_>,
    progress: &dyn Progress,
    keep: Option<usize>,
) -> Result<(Summary, Option<LayerPlan>), JobError> {
    let nowhere = &mut std::io::sink();
    // Nothing is written, so that no stream can fail; the model stands in for its name.
    put(planned, job, nowhere, progress, Put { text: false, keep }).map_err(|e| e.at(Path::new(&job.stem)))
}

/// Puts the layers in order and writes them, one after the other.
///
/// # Errors
/// [`WriteError`]: the stream failed, or a template is wrong.
pub fn write(
    planned: Planned,
    job: &FilamentJob<'_>,
    out: &mut impl Write,
    progress: &dyn Progress,
) -> Result<Summary, WriteError> {
    Ok(write_keeping(planned, job, out, progress, None)?.0)
}

/// [`write()`]; also gives the extrusions of one layer, counted from 0, for a picture.
///
/// # Errors
/// As [`write()`].
pub fn write_keeping(
    planned: Planned,
    job: &FilamentJob<'_>,
    out: &mut impl Write,
    progress: &dyn Progress,
    keep: Option<usize>,
) -> Result<(Summary, Option<LayerPlan>), WriteError> {
    put(planned, job, out, progress, Put { text: true, keep })
}

/// What becomes of the layers in order.
struct Put {
    /// They are written; otherwise only counted.
    text: bool,
    /// The layer whose extrusions are kept.
    keep: Option<usize>,
}

fn put(
    planned: Planned,
    job: &FilamentJob<'_>,
    out: &mut impl Write,
    progress: &dyn Progress,
    how: Put,
) -> Result<(Summary, Option<LayerPlan>), WriteError> {
    let mut kept = None;
    let Planned { layers, origin, mut summary, mut watch, .. } = planned;
    progress.stage(if how.text { "writing" } else { "counting" });
    watch.stage(if how.text { "order and write" } else { "order and count" });
    let settings = job.settings;
    let text = GcodeText::new(&layers, origin, job)?;
    let before_layer = |l| text.layer("before_layer_gcode", &settings.output.before_layer_gcode, l);
    let layer_text = |l| text.layer("layer_gcode", &settings.output.layer_gcode, l);
    let texts = gcode::Texts {
        date: &text.date,
        start: &text.start,
        end: &text.end,
        before_layer: &before_layer,
        layer: &layer_text,
        config: &text.config,
        ..gcode::Texts::default()
    };
    let mut planner = Planner::new(home(origin), settings);
    let mut writer = gcode::Writer::new(out, layers.len(), origin, settings, &texts)?;
    if !how.text {
        writer = writer.counting_only();
    }
    let mut plan = LayerPlan::default();
    for (index, layer) in layers.into_iter().enumerate() {
        go_on(progress)?;
        planner.layer(&layer, &mut plan);
        writer.layer(&plan)?;
        if how.keep == Some(index) {
            kept = Some(plan.clone());
        }
    }
    let written = writer.finish()?;
    summary.filament = filament_summary(&written, settings);
    summary.bounds_mm = (written.extruded_mm > 0.0).then_some([written.low, written.high]);
    summary.time_lower_bound_s = written.seconds_at_least;
    summary.time_by_role_s = time_by_role(&written);
    summary.bytes = written.bytes;
    summary.stages = watch.finish();
    Ok((summary, kept))
}

/// Where the nozzle starts: at the bed's origin, as after homing, in the mesh's frame and reach.
pub(super) fn home(origin: [i64; 3]) -> Point2 {
    let limit = i64::from(lattice::LIMIT) - 1;
    let clamped = |nm: i64| nm.clamp(-limit, limit) as i32;
    Point2::new(clamped(-origin[0]), clamped(-origin[1]))
}

/// Checks that a part on a raft stays under the printer's ceiling.
fn fits_on_raft(mesh: &Mesh, raft: &Heights, settings: &Settings, name: &str) -> Result<(), JobError> {
    let limit = settings.printer.max_print_height;
    let top = mesh.world_bounds().map_or(0, |[_, high]| high[2]);
    let (raft_mm, height) = (lattice::mm(raft.part_z), lattice::mm(top) + lattice::mm(raft.part_z));
    if raft.part_z > 0 && limit > 0.0 && height > limit + 0.01 {
        return Err(JobError::TooHighOnRaft { model: name.to_owned(), height, raft_mm, limit });
    }
    Ok(())
}

/// A warning when supports are wanted, but neither slopes nor enforcers nor first layers are.
fn nothing_supported(job: &FilamentJob<'_>) -> Option<String> {
    let s = &job.settings.support;
    let nothing = s.support_material
        && !s.support_material_auto
        && s.support_material_enforce_layers == 0
        && job.modifiers.enforcers.is_empty();
    nothing.then(|| {
        "support_material_auto = 0: nothing is supported; give --support-enforcer meshes, or set it to 1"
            .to_owned()
    })
}

fn filament_summary(written: &gcode::Summary, settings: &Settings) -> FilamentSummary {
    let known = |value: f64| Some(value).filter(|v| *v > 0.0);
    let by_role = Role::ALL.into_iter().map(|r| (r.name().to_owned(), written.role_mm[r.index()]));
    FilamentSummary {
        mm: written.filament_mm,
        cm3: written.filament_cm3,
        g: known(settings.filament.filament_density).map(|_| written.filament_g),
        cost: known(settings.filament.filament_cost)
            .and(known(settings.filament.filament_density))
            .map(|_| written.cost),
        mm_by_role: by_role.filter(|(_, mm)| *mm > 0.0).collect(),
    }
}

/// The lower bound of the time by what is printed, and that of `travel` and `retraction`; their sum is the whole.
fn time_by_role(written: &gcode::Summary) -> BTreeMap<String, f64> {
    let roles = Role::ALL.into_iter().map(|r| (r.name(), written.role_seconds[r.index()]));
    let others = [("travel", written.travel_seconds), ("retraction", written.retraction_seconds)];
    let all = roles.chain(others).map(|(name, seconds)| (name.to_owned(), seconds));
    all.filter(|(_, seconds)| *seconds > 0.0).collect()
}

/// What enforcers and blockers cover; `origins` are the part's in its file and on the bed, `copies` where its
/// copies lie.
fn modifiers(
    job: &FilamentJob<'_>,
    layers: &[LayerZ],
    [before, origin]: [[i64; 3]; 2],
    copies: &[[i64; 2]],
    options: &TraceOptions,
    warnings: &mut Vec<String>,
) -> Result<ModifierRows, JobError> {
    let files = &job.modifiers;
    if files.enforcers.is_empty() && files.blockers.is_empty() {
        return Ok(ModifierRows::default());
    }
    if !job.settings.support.support_material {
        let message = "enforcers and blockers change nothing while supports are off; add --support-material";
        warnings.push(message.to_owned());
    }
    let moved = std::array::from_fn(|axis| origin[axis].saturating_sub(before[axis]));
    let frame = SupportPlan::new(job.settings).frame;
    let cuts = Cuts { layers, origin, moved, copies, frame: &frame, options };
    ModifierRows::load(files, &cuts, warnings)
}

fn fill_layers<'a>(islands: &'a [Vec<Island>], layers: &[LayerZ]) -> Vec<FillLayer<'a>> {
    let join = |(islands, z): (&'a Vec<Island>, &LayerZ)| FillLayer {
        islands,
        print_z: z.print_z.into(),
        height: z.height.into(),
    };
    islands.iter().zip(layers).map(join).collect()
}

/// The areas of every layer, grown or shrunk as the settings ask.
fn outlines(
    contours: &[LayerContours],
    first: Option<&WallPlan>,
    settings: &Settings,
) -> Vec<Vec<ExPolygon>> {
    let slicing = &settings.slicing;
    let foot = slicing.elefant_foot_compensation.nm(0);
    let of_layer = |i: usize| {
        let area = areas::areas(&contours[i].rings);
        let area = match lattice::nm(slicing.xy_size_compensation) {
            0 => area,
            grow @ 1.. => outset(&area, grow, Join::Miter),
            shrink => inset(&area, -shrink),
        };
        match first {
            Some(plan) if i == 0 && foot > 0 => foot::compensate(&area, foot, plan.external_width),
            _ => area,
        }
    };
    // The first layer differs from the second by its compensation.
    let repeats = |i: usize| i > 1 && contours[i].rings == contours[i - 1].rings;
    region::layers::once_per_run(contours.len(), repeats, of_layer)
}
