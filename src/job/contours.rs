//! From a model to its contours on a family of planes, in a format for other programs.

use super::JobError;
use super::backend::{self, Backend, BackendOptions, Traced};
use super::open::OpenContours;
use super::output::{OutputError, OutputFile};
use super::part::{self, MeshOptions, Part, PartOptions};
use super::progress::Progress;
use super::summary::{BackendSummary, MeshSummary, StageTime, Stopwatch};
use crate::contour::{self, LayerContours};
use crate::export::png::Raster;
use crate::export::{self, Drawing, Format, Frame, Sheet};
use crate::lattice::{NM_PER_MM, mm};
use crate::mesh::{self, Adjacency, Mesh, PlaceError, Placement};
use crate::settings::Settings;
use crate::slice::chunk;
use crate::slice::classic::{self, Algorithm};
use crate::slice::direction::Direction;
use crate::slice::planes::{self, LayerZ, PlaneError, list};
use glam::DVec3;
use rayon::prelude::*;
use serde::Serialize;
use std::io::{self, Write};
use std::path::Path;

/// What is to be cut and how.
#[derive(Clone, Debug)]
pub struct ContoursJob<'a> {
    /// All settings.
    pub settings: &'a Settings,
    /// Where the part, turned to the planes' normal, comes to stand.
    pub placement: Placement,
    /// The planes' normal.
    pub direction: Direction,
    /// A file with their heights, in place of layers.
    pub planes: Option<&'a Path>,
    /// How to intersect.
    pub algorithm: Algorithm,
    /// Where to intersect.
    pub backend: BackendOptions,
    /// How faulty meshes are dealt with.
    pub mesh: MeshOptions,
    /// What to write.
    pub format: Format,
    /// Pixels per millimetre of pictures.
    pub scale: f64,
}

/// The machine-readable result of the job, printed by `--json`.
#[derive(Clone, Debug, Serialize)]
pub struct ContoursSummary {
    /// The input file.
    pub model: String,
    /// The output file or folder.
    pub output: String,
    /// The output's format.
    pub format: &'static str,
    /// Files written.
    pub files: usize,
    /// Bytes written.
    pub bytes: u64,
    /// Triangles after welding.
    pub triangles: u64,
    /// Planes.
    pub planes: usize,
    /// Planes with contours.
    pub layers: usize,
    /// (Triangle, plane) pairs, those whose segment has no length included.
    pub segments: u64,
    /// Closed cycles of successors, before segments without length are removed.
    pub contours: u64,
    /// Chains of successors that end at an open edge.
    pub open_chains: u64,
    /// What became of the open chains.
    pub open_contours: OpenContours,
    /// Per plane its height \[mm\].
    pub z_mm: Vec<f64>,
    /// Per plane the signed sum of its contours' areas \[mm²\].
    pub areas_mm2: Vec<f64>,
    /// What the mesh looked like.
    pub mesh: MeshSummary,
    /// Everything that deserves a look.
    pub warnings: Vec<String>,
    /// Where planes and triangles were intersected.
    pub backend: BackendSummary,
    /// Settings keys of loaded files that have no effect here.
    pub ignored_settings: Vec<String>,
    /// Seconds of wall time per stage, in order.
    pub times: Vec<StageTime>,
}

/// Reads a model, cuts it and writes the contours.
///
/// Heights are those of `slice`: above the bed, on which the part stands after it was turned so that
/// the planes' normal points up. The part need not fit the printer. With [`Placement::Keep`] the
/// height of a plane is its distance d from the model file's zero, n·x = d.
///
/// # Errors
/// [`JobError`]: see its variants. A single file is then as it was before; of a folder, pictures
/// written before the failure stay.
pub fn run(
    model: &Path,
    output: &Path,
    job: &ContoursJob<'_>,
    progress: &dyn Progress,
) -> Result<ContoursSummary, JobError> {
    let mut watch = Stopwatch::default();
    let name = model.display().to_string();
    progress.stage("reading");
    watch.stage("load");
    let mut loaded = mesh::load(model)?;
    let file_origin = loaded.mesh.origin;
    watch.stage("turn");
    loaded.mesh = job.direction.turn(loaded.mesh)?;
    let options = PartOptions {
        printer: &job.settings.printer,
        placement: job.placement,
        must_fit: false,
        mesh: &job.mesh,
        file: Some(model),
    };
    let part = part::prepare(loaded, &name, &options, progress, &mut watch)?;
    let Part { mesh, adjacency, summary: mesh_summary, mut warnings } = part;

    progress.stage("slicing");
    watch.stage("planes");
    let layers = layers(&mesh, &name, job)?;
    let planes = planes::plane_zs(&layers, mesh.origin[2]);
    watch.stage("slice");
    let traced = trace(&mesh, &adjacency, &planes, job)?;
    let Traced { layers: found, segments, backend, warning } = traced;
    warnings.extend(warning);
    let sum_of = |count: fn(&LayerContours) -> u32| found.iter().map(|l| u64::from(count(l))).sum();
    let (contours, open_chains) = (sum_of(|l| l.walked.closed), sum_of(|l| l.walked.open));
    let open_contours = OpenContours::new(&found, &layers, mesh.origin);
    warnings.extend(open_contours.warning(&name));

    progress.stage("writing");
    watch.stage("write");
    let origin = mesh.origin;
    let drawing = drawing(&name, &layers, &found, origin, frame(&job.direction, file_origin, origin));
    let written = match job.format {
        Format::Png => pictures(&drawing, output, job.scale)?,
        format => Written { files: 1, bytes: file(&drawing, format, output)? },
    };
    Ok(ContoursSummary {
        model: name.clone(),
        output: output.display().to_string(),
        format: job.format.name(),
        files: written.files,
        bytes: written.bytes,
        triangles: mesh.triangles.len() as u64,
        planes: layers.len(),
        layers: found.iter().filter(|l| !l.rings.is_empty()).count(),
        segments,
        contours,
        open_chains,
        open_contours,
        z_mm: layers.iter().map(|l| mm(l.slice_z)).collect(),
        areas_mm2: drawing.sheets.par_iter().map(Sheet::area_mm2).collect(),
        mesh: mesh_summary,
        warnings,
        backend,
        ignored_settings: Vec::new(),
        times: watch.finish(),
    })
}

/// The planes asked for: a list, or layers.
fn layers(mesh: &Mesh, name: &str, job: &ContoursJob<'_>) -> Result<Vec<LayerZ>, JobError> {
    let no_planes = |error| JobError::Planes { model: name.to_owned(), error };
    let [lo, hi] = mesh.world_bounds().unwrap_or_default();
    let Some(path) = job.planes else {
        // What lies below the bed would be left out without a word; a list says what it wants.
        let depth = -mm(lo[2]);
        if depth > 0.01 {
            return Err(JobError::Place { model: name.to_owned(), error: PlaceError::BelowBed { depth } });
        }
        return planes::of_mesh(mesh, job.settings).map_err(no_planes);
    };
    let text = std::fs::read_to_string(path)
        .map_err(|source| JobError::PlaneFile { path: path.to_owned(), source })?;
    let layers = list::parse(&text, path)?;
    let cuts = |l: &LayerZ| i64::from(l.slice_z) > lo[2] && i64::from(l.slice_z) <= hi[2];
    if !layers.iter().any(cuts) {
        let at = |l: Option<&LayerZ>| l.map_or(0.0, |l| mm(l.slice_z));
        return Err(no_planes(PlaneError::Missed {
            planes: layers.len(),
            first_mm: at(layers.first()),
            last_mm: at(layers.last()),
            bottom_mm: mm(lo[2]),
            top_mm: mm(hi[2]),
        }));
    }
    Ok(layers)
}

/// Segments made at once by the algorithms of the literature: bounds their memory.
const SEGMENTS_AT_ONCE: u64 = 1 << 22;

/// The contours by the algorithm asked for. Those of the literature run on the CPU, on one thread.
fn trace(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    job: &ContoursJob<'_>,
) -> Result<Traced, JobError> {
    let options = job.mesh.trace_options(&job.settings.slicing);
    let algorithm = job.algorithm;
    if algorithm == Algorithm::Main {
        return backend::contours(mesh, adjacency, planes, &job.backend, &options);
    }
    let per_plane = chunk::segments_per_plane(mesh, planes);
    let mut layers = Vec::with_capacity(planes.len());
    for run in chunk::runs(&per_plane, SEGMENTS_AT_ONCE) {
        let segments = classic::slice(algorithm, mesh, adjacency, &planes[run.clone()]);
        layers.extend(contour::contours_of(mesh, &planes[run], &segments, &options));
    }
    let on_gpu = job.backend.backend == Backend::Gpu || job.backend.adapter.is_some();
    Ok(Traced {
        layers,
        segments: per_plane.iter().sum(),
        backend: BackendSummary {
            kind: "cpu",
            adapter: None,
            reason: format!("--algorithm {algorithm}"),
            threads: 1,
        },
        warning: on_gpu.then(|| format!("--algorithm {algorithm} runs on the CPU; no GPU was used")),
    })
}

/// How the planes lie in the model file, whose zero was `file_origin` away from the lattice's before
/// turning and is `placed_origin` away after placing \[nm\].
fn frame(direction: &Direction, file_origin: [i64; 3], placed_origin: [i64; 3]) -> Frame {
    let vector = |p: [i64; 3]| DVec3::from_array(p.map(|c| c as f64));
    let origin = (vector(file_origin) - direction.from_frame(vector(placed_origin))) / NM_PER_MM;
    // No minus zero in the file.
    let plain = |v: DVec3| v.to_array().map(|c| c + 0.0);
    Frame { u: plain(direction.u), v: plain(direction.v), n: plain(direction.n), origin: plain(origin) }
}

fn drawing<'a>(
    model: &'a str,
    layers: &[LayerZ],
    found: &'a [LayerContours],
    origin: [i64; 3],
    frame: Frame,
) -> Drawing<'a> {
    let sheet = |(z, contours): (&LayerZ, &'a LayerContours)| Sheet {
        z: z.slice_z.into(),
        top: z.print_z.into(),
        height: z.height.into(),
        rings: &contours.rings,
        open: contours.open,
    };
    let sheets = layers.iter().zip(found).map(sheet).collect();
    Drawing { model, sheets, offset: [origin[0], origin[1]], frame }
}

struct Written {
    files: usize,
    bytes: u64,
}

/// Writes one file and returns its length.
fn file(drawing: &Drawing<'_>, format: Format, path: &Path) -> Result<u64, JobError> {
    let mut out = Counting { inner: OutputFile::create(path)?, bytes: 0 };
    match format {
        Format::Svg => export::svg::write(drawing, &mut out),
        Format::Json => export::json::write(drawing, &mut out),
        Format::Wkt => export::wkt::write(drawing, &mut out),
        // Pictures are many files and written elsewhere.
        Format::Cli | Format::Png => export::cli::write(drawing, &mut out),
    }
    .map_err(|e| OutputError::new(path, e))?;
    let bytes = out.bytes;
    out.inner.commit()?;
    Ok(bytes)
}

/// Writes a picture per plane into a folder, which is made if it is missing; other files there stay.
fn pictures(drawing: &Drawing<'_>, folder: &Path, scale: f64) -> Result<Written, JobError> {
    let raster = Raster::new(drawing, scale)?;
    if !folder.is_dir() {
        std::fs::create_dir(folder).map_err(|e| OutputError::new(folder, e))?;
    }
    let digits = drawing.sheets.len().to_string().len().max(5);
    let picture = |(i, sheet): (usize, &Sheet<'_>)| -> Result<u64, JobError> {
        let path = folder.join(format!("layer_{i:0digits$}.png"));
        let mut bytes = io::Cursor::new(Vec::new());
        let image = raster.draw(sheet, drawing.offset);
        image
            .write_to(&mut bytes, image::ImageFormat::Png)
            .map_err(|e| OutputError::new(&path, io::Error::other(e)))?;
        let mut out = OutputFile::create(&path)?;
        out.write_all(bytes.get_ref()).map_err(|e| OutputError::new(&path, e))?;
        out.commit()?;
        Ok(bytes.get_ref().len() as u64)
    };
    let bytes: Vec<u64> = drawing.sheets.par_iter().enumerate().map(picture).collect::<Result<_, _>>()?;
    Ok(Written { files: bytes.len(), bytes: bytes.iter().sum() })
}

/// Passes bytes on and counts them.
struct Counting {
    inner: OutputFile,
    bytes: u64,
}

impl Write for Counting {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let n = self.inner.write(bytes)?;
        self.bytes += n as u64;
        Ok(n)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.flush()
    }
}
