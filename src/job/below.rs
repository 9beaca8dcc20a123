//! From a model to the part as printed so far.

use super::JobError;
use super::open::OpenContours;
use super::part::{self, Part, PartOptions};
use super::progress::Progress;
use super::summary::{MeshSummary, StageTime, Stopwatch};
use crate::contour::{self, TraceOptions, cap};
use crate::lattice::{self, LIMIT, Point3, area2};
use crate::mesh::{self, Adjacency, Loaded, Mesh};
use crate::settings::SlicingSettings;
use crate::slice::below;
use crate::slice::planes::LayerZ;
use serde::Serialize;
use std::path::Path;

/// What is to be cut off, and where.
#[derive(Clone, Copy, Debug)]
pub struct BelowJob<'a> {
    /// Height of the cut above the bed \[nm\].
    pub z: i64,
    /// Whether the cut is closed.
    pub cap: bool,
    /// How the part is prepared.
    pub part: PartOptions<'a>,
}

/// The machine-readable result.
#[derive(Clone, Debug, Serialize)]
pub struct BelowSummary {
    /// The input file.
    pub model: String,
    /// The output file.
    pub output: String,
    /// Height of the cut above the bed \[mm\].
    pub z_mm: f64,
    /// Triangles written, those of the cap included.
    pub triangles: u64,
    /// Triangles of the cap.
    pub cap_triangles: u64,
    /// Area of the section \[mm²\]; absent without a cap.
    pub section_mm2: Option<f64>,
    /// Volume of what was written \[mm³\]; absent where it is open.
    pub volume_mm3: Option<f64>,
    /// What became of contours of the section that did not close.
    pub open_contours: OpenContours,
    /// What the whole mesh looked like.
    pub mesh: MeshSummary,
    /// Everything that deserves a look.
    pub warnings: Vec<String>,
    /// Seconds of wall time per stage, in order.
    pub stages: Vec<StageTime>,
}

/// Reads a model and cuts it off at a height above the bed; see [`below::below`] and [`cap::cap`].
///
/// # Errors
/// [`JobError`]; [`JobError::NothingBelow`] where the whole part lies above the cut.
pub fn below(
    path: &Path,
    job: &BelowJob<'_>,
    progress: &dyn Progress,
) -> Result<(Mesh, BelowSummary), JobError> {
    let mut watch = Stopwatch::default();
    progress.stage("reading");
    watch.stage("load");
    let loaded = mesh::load(path)?;
    below_mesh(loaded, &path.display().to_string(), job, progress, watch)
}

/// [`below()`] for a mesh in memory; `name` stands for it in messages.
///
/// # Errors
/// As [`below()`].
pub fn below_mesh(
    loaded: Loaded,
    name: &str,
    job: &BelowJob<'_>,
    progress: &dyn Progress,
    mut watch: Stopwatch,
) -> Result<(Mesh, BelowSummary), JobError> {
    let part = part::prepare(loaded, name, &job.part, progress, &mut watch)?;
    let Part { mesh, adjacency, summary, mut warnings } = part;
    progress.stage("cutting");
    watch.stage("cut");
    // No vertex lies beyond the lattice, so a plane moved to its end cuts the same.
    let limit = i64::from(LIMIT);
    let z = job.z.saturating_sub(mesh.origin[2]).clamp(-limit, limit) as i32;
    let mut cut = below::below(&mesh, z);
    if cut.mesh.triangles.is_empty() {
        let [lo, _] = mesh.world_bounds().unwrap_or_default();
        let (z_mm, bottom_mm) = (lattice::mm(job.z), lattice::mm(lo[2]));
        return Err(JobError::NothingBelow { model: name.to_owned(), z_mm, bottom_mm });
    }
    let mut open_contours = OpenContours::default();
    let mut section_mm2 = None;
    let walls = cut.mesh.triangles.len();
    if job.cap {
        progress.stage("closing");
        watch.stage("cap");
        let options = TraceOptions {
            // The cap must have every point of the walls.
            simplify_tolerance: None,
            ..job.part.mesh.trace_options(&SlicingSettings::default())
        };
        let sections = contour::trace(&mesh, &adjacency, &[z], &options)?;
        let at = |nm: i64| nm.clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32;
        let layer = LayerZ { slice_z: at(job.z), print_z: at(job.z), height: 0 };
        open_contours = OpenContours::new(&sections, &[layer], mesh.origin);
        warnings.extend(open_contours.warning(name));
        let rings: Vec<_> = sections.into_iter().flat_map(|l| l.rings).collect();
        let twice: i128 = rings.iter().map(|r| area2(r)).sum();
        section_mm2 = Some(twice as f64 * 0.5e-12);
        let cap = cap::cap(&rings);
        let ids: Vec<u32> = cap
            .points
            .iter()
            .map(|&p| {
                cut.on_cut(p).unwrap_or_else(|| {
                    cut.mesh.vertices.push(Point3::new(p.x, p.y, z));
                    cut.mesh.vertices.len() as u32 - 1
                })
            })
            .collect();
        cut.mesh.triangles.extend(cap.triangles.iter().map(|t| t.map(|v| ids[v as usize])));
    }
    watch.stage("audit the result");
    let found = mesh::audit(&cut.mesh, &Adjacency::build(&cut.mesh));
    let triangles = cut.mesh.triangles.len();
    let summary = BelowSummary {
        model: name.to_owned(),
        output: String::new(),
        z_mm: lattice::mm(job.z),
        triangles: triangles as u64,
        cap_triangles: (triangles - walls) as u64,
        section_mm2,
        volume_mm3: (found.open_edges == 0).then_some(found.volume_mm3),
        open_contours,
        mesh: summary,
        warnings,
        stages: watch.finish(),
    };
    Ok((cut.mesh, summary))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::job::part::MeshOptions;
    use crate::mesh::shapes::{cuboid, cylinder, merge, moved, sphere, torus};
    use crate::mesh::{Placement, audit, demo_part};
    use crate::settings::PrinterSettings;

    struct Silent;
    impl Progress for Silent {
        fn stage(&self, _: &'static str) {}
    }

    fn cut(mesh: &Mesh, z_mm: f64, cap: bool) -> Result<(Mesh, BelowSummary), JobError> {
        let loaded = Loaded {
            facets: mesh.triangles.len() as u64,
            mesh: mesh.clone(),
            collapsed: 0,
            warnings: Vec::new(),
        };
        let part = PartOptions {
            printer: &PrinterSettings::default(),
            placement: Placement::DropAndCentre,
            must_fit: false,
            mesh: &MeshOptions::default(),
            file: None,
        };
        let job = BelowJob { z: lattice::nm(z_mm), cap, part };
        below_mesh(loaded, "test", &job, &Silent, Stopwatch::default())
    }

    fn bodies() -> Vec<(&'static str, Mesh, f64)> {
        vec![
            ("box", cuboid([0.0; 3], [10.0, 20.0, 6.0]), 6.0),
            ("sphere", sphere(5.0, 60, 30), 10.0),
            ("torus", torus(10.0, 3.0, 60, 30), 6.0),
            ("two that overlap", merge(&[cuboid([0.0; 3], [5.0; 3]), cylinder(4.0, 5.0, 40)]), 5.0),
            (
                "two that share a wall",
                merge(&[cuboid([0.0; 3], [5.0; 3]), moved(cuboid([0.0; 3], [5.0; 3]), [5.0, 2.0, 0.0])]),
                5.0,
            ),
            ("demo part", demo_part(), {
                let [lo, hi] = demo_part().bounds().unwrap();
                lattice::mm(hi.z - lo.z)
            }),
        ]
    }

    #[test]
    fn with_a_cap_the_result_is_watertight_and_has_the_right_volume() {
        const STEPS: i64 = 20;
        const SLABS: i64 = 40;
        for (name, mesh, height) in bodies() {
            // Sections in the middles of thin slabs.
            let adjacency = Adjacency::build(&mesh);
            let (bottom, height) = (i64::from(mesh.bounds().unwrap()[0].z), lattice::nm(height));
            let slabs = STEPS * SLABS;
            let planes: Vec<i32> =
                (0..slabs).map(|i| (bottom + (2 * i + 1) * height / (2 * slabs)) as i32).collect();
            let options = TraceOptions::new(&SlicingSettings::default());
            let sections = contour::trace(&mesh, &adjacency, &planes, &options).unwrap();
            let areas: Vec<f64> = sections
                .iter()
                .map(|l| l.rings.iter().map(|r| area2(r)).sum::<i128>() as f64 * 0.5e-12)
                .collect();
            let whole = audit(&mesh, &adjacency).volume_mm3;
            for step in 1..=STEPS {
                let z = lattice::mm(height * step / STEPS);
                let (part, summary) = cut(&mesh, z, true).unwrap();
                let found = audit(&part, &Adjacency::build(&part));
                assert_eq!((found.open_edges, summary.open_contours.chains), (0, 0), "{name} at {z}");
                let volume = summary.volume_mm3.unwrap();
                let under: f64 = areas[..(step * SLABS) as usize].iter().sum();
                let integral = under * lattice::mm(height) / slabs as f64;
                assert!((volume - integral).abs() < 0.005 * whole, "{name} at {z}: {volume} {integral}");
            }
        }
    }

    #[test]
    fn without_a_cap_it_is_open_and_above_the_top_it_is_the_whole_mesh() {
        let mesh = sphere(5.0, 60, 30);
        let (part, summary) = cut(&mesh, 4.0, false).unwrap();
        assert!(summary.volume_mm3.is_none() && summary.section_mm2.is_none());
        assert_eq!(summary.triangles, part.triangles.len() as u64);
        let (whole, summary) = cut(&mesh, 10.5, true).unwrap();
        assert_eq!((whole.triangles, summary.cap_triangles), (mesh.triangles, 0));
    }

    #[test]
    fn a_plane_under_the_part_is_an_error() {
        let mesh = sphere(5.0, 60, 30);
        for z in [0.0, -3.0, -1e9] {
            let error = cut(&mesh, z, true).unwrap_err();
            assert!(matches!(error, JobError::NothingBelow { .. }));
            assert!(error.to_string().contains("nothing"), "{error}");
        }
    }

    #[test]
    fn an_open_mesh_is_capped_as_well_as_it_goes() {
        let mut mesh = sphere(5.0, 60, 30);
        let mut index = 0;
        mesh.triangles.retain(|_| {
            index += 1;
            index % 10 != 0
        });
        let (_, summary) = cut(&mesh, 4.0, true).unwrap();
        assert!(summary.open_contours.chains > 0);
        let area = std::f64::consts::PI * 24.0;
        assert!((summary.section_mm2.unwrap() / area - 1.0).abs() < 0.05, "{:?}", summary.section_mm2);
    }
}
