//! What a resin job did, for people and for programs. None of it reaches the output file.

use super::plate::ModelSummary;
use crate::job::mask_check::CheckReport;
use crate::job::open::OpenContours;
use crate::job::summary::{BackendSummary, StageTime};
use serde::Serialize;

/// The machine-readable result of a job, printed by `--json`.
#[derive(Clone, Debug, Serialize)]
pub struct ResinSummary {
    /// The models.
    pub models: Vec<ModelSummary>,
    /// The output file or folder.
    pub output: String,
    /// Its format.
    pub format: &'static str,
    /// The printer's name; empty where the settings name none.
    pub printer: String,
    /// Bytes written.
    pub bytes: u64,
    /// The panel.
    pub panel: PanelSummary,
    /// Layers written.
    pub layers: u32,
    /// Height of the top layer \[mm\].
    pub print_z_mm: f64,
    /// Triangles after welding.
    pub triangles: u64,
    /// Lit pixels of all layers.
    pub lit_pixels: u64,
    /// Resin \[ml\].
    pub volume_ml: f64,
    /// Resin \[g\]; absent where its density is not set.
    pub weight_g: Option<f64>,
    /// Price; absent where it is not set.
    pub cost: Option<f64>,
    /// Lower bound of the print time: exposures, lifts and rests, no acceleration \[s\].
    pub time_lower_bound_s: f64,
    /// The layer with the greatest lit area.
    pub largest_layer: LargestLayer,
    /// What became of contours that did not close.
    pub open_contours: OpenContours,
    /// Islands, cups, trapped resin; absent where they were not looked for.
    pub check: Option<CheckReport>,
    /// Everything that deserves a look.
    pub warnings: Vec<String>,
    /// Where planes and triangles were intersected.
    pub backend: BackendSummary,
    /// Settings keys of loaded files that have no effect here.
    pub ignored_settings: Vec<String>,
    /// Seconds of wall time per stage, in order.
    pub stages: Vec<StageTime>,
}

/// The panel's pixels.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct PanelSummary {
    /// Pixels in a row of the stored image.
    pub width: u32,
    /// Rows of the stored image.
    pub height: u32,
    /// Distance of pixels along a row and of rows \[µm\].
    pub pitch_um: [f64; 2],
    /// Sub-rows of anti-aliasing; 1 = none.
    pub anti_aliasing: u32,
}

/// A layer and its area.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct LargestLayer {
    /// Counted from 0.
    pub layer: u32,
    /// Lit area \[mm²\].
    pub area_mm2: f64,
}
