//! What is asked for.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// How the print is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Technology {
    /// G-code for a filament printer.
    #[default]
    Filament,
    /// Layer masks for a resin printer.
    Resin,
}

/// One model to be sliced.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Request {
    /// The model's file.
    pub model: PathBuf,
    /// Where the output goes; `None` only with `estimate`.
    pub output: Option<PathBuf>,
    /// How it is printed.
    pub technology: Technology,
    /// A resin printer by name, or a file that describes one.
    pub printer: Option<String>,
    /// Files of settings, later ones win.
    pub load: Vec<PathBuf>,
    /// Settings by key, over those of files.
    pub settings: BTreeMap<String, String>,
    /// How many of the model are laid on the bed.
    pub copies: u32,
    /// Which way facets face: `auto`, `winding`, `normals`, `repair`.
    pub orient: String,
    /// Gaps in open contours are closed up to this \[mm\].
    pub match_tolerance: Option<f64>,
    /// Vertices are rounded to multiples of this \[mm\].
    pub snap_grid: Option<f64>,
    /// Keep the model's coordinates.
    pub no_place: bool,
    /// Meshes in which all that hangs is supported; filament only.
    pub support_enforcers: Vec<PathBuf>,
    /// Meshes in which nothing is supported; filament only.
    pub support_blockers: Vec<PathBuf>,
    /// Turn about the vertical \[degrees\]; resin only.
    pub rotate: f64,
    /// Look for islands, cups and trapped resin; resin only.
    pub check: bool,
    /// Only say what would be printed; nothing is written.
    pub estimate: bool,
    /// A small picture of the middle layer goes here, as PNG.
    pub picture: Option<PathBuf>,
    /// CPU threads; `None` = as many as there are.
    pub threads: Option<u16>,
    /// The model's size \[bytes\] and time of modification \[ns since 1970\] as known to the caller; a file
    /// that has changed since is refused.
    pub expect: Option<[i64; 2]>,
    /// The date in the output, seconds since 1970-01-01 UTC.
    pub date: i64,
}

impl Default for Request {
    fn default() -> Self {
        Self {
            model: PathBuf::new(),
            output: None,
            technology: Technology::default(),
            printer: None,
            load: Vec::new(),
            settings: BTreeMap::new(),
            copies: 1,
            orient: "auto".to_owned(),
            match_tolerance: None,
            snap_grid: None,
            no_place: false,
            support_enforcers: Vec::new(),
            support_blockers: Vec::new(),
            rotate: 0.0,
            check: false,
            estimate: false,
            picture: None,
            threads: None,
            expect: None,
            date: 0,
        }
    }
}
