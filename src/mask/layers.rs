//! A mesh's planes → the masks of its layers, run by run.

use super::MaskLayer;
use super::raster::{Painter, Raster};
use crate::slice::section::{Sections, Sweep};
use std::sync::Arc;

/// The masks of the layers of one run, in order.
#[derive(Debug)]
pub struct Layers<'a> {
    sweep: Sweep<'a>,
    painter: Painter<'a>,
    last: Arc<MaskLayer>,
}

/// Begins to draw the layers of a run (see [`Sections::runs`]). Runs are independent: several threads may
/// draw different ones. A layer that equals the one before it in the run is that one, not a copy.
pub fn layers<'a>(sections: &'a Sections<'a>, run: usize, raster: &'a Raster) -> Layers<'a> {
    Layers { sweep: sections.sweep(run), painter: Painter::new(raster), last: Arc::default() }
}

impl Iterator for Layers<'_> {
    type Item = Arc<MaskLayer>;

    fn next(&mut self) -> Option<Arc<MaskLayer>> {
        let section = self.sweep.next_section()?;
        if !section.unchanged {
            let mask = self.painter.mask(section.edges);
            if mask != *self.last {
                self.last = Arc::new(mask);
            }
        }
        Some(Arc::clone(&self.last))
    }
}
