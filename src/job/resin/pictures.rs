//! Pictures of the layers in which the checks found most.

use super::layers::{Wanted, rings_to_edges};
use super::make::{Line, Maker};
use crate::contour;
use crate::job::mask_check::{CheckReport, Reason};
use crate::job::output::OutputError;
use crate::job::toolpaths::save_png;
use crate::job::{JobError, mask_picture};
use crate::mask::MaskLayer;
use crate::mask::check::{CheckSettings, Fates, Marks};
use crate::picture;
use crate::slice::section::Sections;
use std::path::Path;
use std::sync::Arc;

/// Pictures at most.
const PICTURES: usize = 8;

/// Draws the worst layers into a folder, which is made if it is missing: `layer_00123_island.png` and the
/// like. The layers are sliced again, so that they need not have been kept.
///
/// # Errors
/// [`OutputError`]; [`JobError::Section`], [`JobError::Trace`].
pub(super) fn draw(
    report: &CheckReport,
    settings: &CheckSettings,
    wanted: &Wanted<'_>,
    folder: &Path,
) -> Result<(), JobError> {
    let worst = report.worst_layers(PICTURES);
    if worst.is_empty() {
        return Ok(());
    }
    std::fs::create_dir_all(folder).map_err(|e| OutputError::new(folder, e))?;
    for layer in worst {
        let here = layer.layer as usize;
        let mut masks = masks(wanted, here.saturating_sub(1)..here + 1)?;
        let Some(mask) = masks.pop() else { continue };
        let fates = &report.findings.fates;
        let image = mask_picture::draw(
            &mask,
            masks.first().map(Arc::as_ref),
            wanted.maker.panel(),
            settings,
            &layer.marks,
            fates,
        );
        let reason = match layer.reason {
            Reason::Island => "island",
            Reason::Cup => "cup",
            Reason::Trapped => "trapped",
            Reason::Overhang => "overhang",
        };
        let path = folder.join(format!("layer_{here:05}_{reason}.png"));
        save_png(&image, &path)?;
    }
    Ok(())
}

/// Size of a picture of the middle layer \[pixels\].
const SMALL: (u32, u32) = (320, 240);

/// Draws the middle layer. It is sliced again, so that it need not have been kept.
///
/// # Errors
/// [`OutputError`]; [`JobError::Section`], [`JobError::Trace`].
pub(super) fn draw_middle(wanted: &Wanted<'_>, path: &Path) -> Result<(), JobError> {
    let middle = wanted.planes.len() / 2;
    let mask = masks(wanted, middle..middle + 1)?.pop().unwrap_or_default();
    let settings = CheckSettings::default();
    let large = mask_picture::draw(
        &mask,
        None,
        wanted.maker.panel(),
        &settings,
        &Marks::default(),
        &Fates::default(),
    );
    Ok(save_png(&picture::fitted(&large, SMALL.0, SMALL.1), path)?)
}

/// The masks of consecutive planes.
fn masks(wanted: &Wanted<'_>, run: std::ops::Range<usize>) -> Result<Vec<Arc<MaskLayer>>, JobError> {
    let maker = Maker { keep_masks: true, ..*wanted.maker };
    let mut line = Line::new(&maker);
    let planes = &wanted.planes[run.clone()];
    let plate = wanted.plate;
    let mut made = Vec::new();
    if plate.open {
        let mut edges = Vec::new();
        for (plane, contours) in run.zip(contour::trace(&plate.mesh, &plate.adjacency, planes, wanted.trace)?)
        {
            rings_to_edges(&contours, &mut edges);
            made.push(line.layer(wanted.layer(plane), &edges, false));
        }
    } else {
        let sections = Sections::new(&plate.mesh, planes, 1)?;
        let mut sweep = sections.sweep(0);
        while let Some(section) = sweep.next_section() {
            let layer = wanted.layer(run.start + section.plane);
            made.push(line.layer(layer, section.edges, section.unchanged));
        }
    }
    Ok(made.iter().filter_map(|made| made.mask.clone()).collect())
}
