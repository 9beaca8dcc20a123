//! What a job did, for people and for programs. None of it reaches the output file.

use super::open::OpenContours;
use super::support_report::AirSummary;
use serde::Serialize;

/// The machine-readable result of a job, printed by `--json`.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// The input file.
    pub model: String,
    /// The output file, or `-` for standard output.
    pub output: String,
    /// Bytes written.
    pub bytes: u64,
    /// Layers printed.
    pub layers: usize,
    /// Height of the top layer \[mm\].
    pub print_z_mm: f64,
    /// Triangles after welding.
    pub triangles: u64,
    /// (Triangle, plane) pairs.
    pub segments: u64,
    /// Contours after the walk.
    pub contours: u64,
    /// What became of contours that did not close.
    pub open_contours: OpenContours,
    /// What the mesh looked like.
    pub mesh: MeshSummary,
    /// What is extruded.
    pub filament: FilamentSummary,
    /// What of a print with supports is printed in air all the same; absent where supports are off.
    pub in_air: Option<AirSummary>,
    /// Corners of the extruded paths on the bed \[mm\], lowest and highest (x, y, z).
    pub bounds_mm: Option<[[f64; 3]; 2]>,
    /// Lower bound of the print time: path lengths over speeds, no acceleration \[s\].
    pub time_lower_bound_s: f64,
    /// The same by what is printed \[s\], `travel` and `retraction` among them; a lower bound, too.
    pub time_by_role_s: std::collections::BTreeMap<String, f64>,
    /// Everything that deserves a look.
    pub warnings: Vec<String>,
    /// Where planes and triangles were intersected.
    pub backend: BackendSummary,
    /// Settings keys of loaded files that have no effect here.
    pub ignored_settings: Vec<String>,
    /// Seconds of wall time per stage, in order.
    pub stages: Vec<StageTime>,
}

/// The audit's findings.
#[derive(Clone, Debug, Default, Serialize)]
pub struct MeshSummary {
    /// Facets in the file.
    pub facets: u64,
    /// Facets that collapsed on the lattice, or on the snapping grid.
    pub collapsed: u64,
    /// Vertices that fell together on the snapping grid.
    pub snapped: u64,
    /// Edges without a partner.
    pub open_edges: u64,
    /// Edges with more than two triangles.
    pub over_shared_edges: u64,
    /// Edges whose two triangles disagree about the outside.
    pub flipped_edges: u64,
    /// Triangles that occur more than once.
    pub duplicate_triangles: u64,
    /// Connected shells.
    pub shells: u64,
    /// Enclosed volume \[mm³\].
    pub volume_mm3: f64,
    /// Size \[mm\].
    pub size_mm: [f64; 3],
    /// What was done about the orientation; the counts above are those after it.
    pub orientation: OrientationSummary,
}

/// What was done about the orientation of facets.
#[derive(Clone, Debug, Default, Serialize)]
pub struct OrientationSummary {
    /// Edges whose two triangles disagreed about the outside.
    pub flipped_edges_before: u64,
    /// The whole mesh was inside out and was turned.
    pub inside_out: bool,
    /// Triangles turned after their stored normals.
    pub turned_by_normals: u64,
    /// Triangles turned to agree with their neighbours and face outwards.
    pub turned_by_neighbours: u64,
    /// Duplicate triangles dropped.
    pub duplicates_dropped: u64,
    /// Inside-out shells among others that were turned.
    pub shells_turned: u64,
}

/// What is extruded.
#[derive(Clone, Debug, Default, Serialize)]
pub struct FilamentSummary {
    /// Length of filament \[mm\].
    pub mm: f64,
    /// Volume \[cm³\].
    pub cm3: f64,
    /// Mass \[g\]; absent where the filament's density is not set.
    pub g: Option<f64>,
    /// Price; absent where density or cost is not set.
    pub cost: Option<f64>,
    /// Length of filament by what is printed \[mm\].
    pub mm_by_role: std::collections::BTreeMap<String, f64>,
}

/// Where planes and triangles were intersected.
#[derive(Clone, Debug, Serialize)]
pub struct BackendSummary {
    /// `cpu` or `gpu`.
    pub kind: &'static str,
    /// The GPU's name, with its driver.
    pub adapter: Option<String>,
    /// Why this one.
    pub reason: String,
    /// CPU threads.
    pub threads: usize,
}

/// Wall time of one stage.
#[derive(Clone, Debug, Serialize)]
pub struct StageTime {
    /// The stage.
    pub stage: &'static str,
    /// Its wall time \[s\].
    pub seconds: f64,
}

/// Measures stages one after the other.
#[derive(Debug)]
pub struct Stopwatch {
    begun: std::time::Instant,
    stage: Option<&'static str>,
    done: Vec<StageTime>,
}

impl Default for Stopwatch {
    fn default() -> Self {
        Self { begun: std::time::Instant::now(), stage: None, done: Vec::new() }
    }
}

impl Stopwatch {
    /// Ends the stage in hand and begins another.
    pub fn stage(&mut self, name: &'static str) {
        self.end();
        self.stage = Some(name);
        self.begun = std::time::Instant::now();
    }

    fn end(&mut self) {
        if let Some(stage) = self.stage.take() {
            self.done.push(StageTime { stage, seconds: self.begun.elapsed().as_secs_f64() });
        }
    }

    /// All stages measured.
    pub fn finish(mut self) -> Vec<StageTime> {
        self.end();
        self.done
    }
}
