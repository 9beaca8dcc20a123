//! A picture of one layer of a job.

use super::filament::{FilamentJob, Planned, home};
use super::output::{OutputError, OutputFile};
use crate::path::{LayerPlan, Planner};
use std::io::{self, Write};
use std::path::Path;

/// The extrusions of layer `index`, counted from 0, as they will be written; `None` where there is no such
/// layer. Plans all layers up to it, because seams follow those below.
pub fn toolpaths(planned: &Planned, job: &FilamentJob<'_>, index: usize) -> Option<LayerPlan> {
    let layers = planned.layers.get(..=index)?;
    let mut planner = Planner::new(home(planned.origin), job.settings);
    let mut plan = LayerPlan::default();
    for layer in layers {
        planner.layer(layer, &mut plan);
    }
    Some(plan)
}

/// Writes a picture as PNG.
///
/// # Errors
/// The file cannot be written; it is then as it was before.
pub fn save_png(image: &image::RgbImage, path: &Path) -> Result<(), OutputError> {
    let failed = |e: io::Error| OutputError::new(path, e);
    let mut bytes = io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).map_err(|e| failed(io::Error::other(e)))?;
    let mut out = OutputFile::create(path)?;
    out.write_all(bytes.get_ref()).map_err(failed)?;
    out.commit()
}
