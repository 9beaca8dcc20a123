//! What became of contours that did not close, in numbers and words.

use crate::contour::{LayerContours, chains};
use crate::lattice::mm;
use crate::slice::planes::LayerZ;
use serde::Serialize;

/// Open contours of a part. Every one is matched, forced or dropped.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct OpenContours {
    /// Layers with open contours.
    pub layers: usize,
    /// Open contours on them.
    pub chains: u64,
    /// Closed over gaps within the tolerance.
    pub matched: u64,
    /// Closed by a straight line over a wider gap.
    pub forced: u64,
    /// Left out.
    pub dropped: u64,
    /// The widest gap, closed or not.
    pub worst: Option<WorstGap>,
}

/// The widest gap, on the bed \[mm\].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WorstGap {
    /// Index of its layer, from 0.
    pub layer: usize,
    /// Its width.
    pub gap_mm: f64,
    /// Height of the cutting plane.
    pub z_mm: f64,
    /// Where it begins.
    pub x_mm: f64,
    /// Where it begins.
    pub y_mm: f64,
}

impl OpenContours {
    /// Sums up the layers of a part; `origin`: world position of the contours' zero \[nm\].
    pub fn new(found: &[LayerContours], layers: &[LayerZ], origin: [i64; 3]) -> Self {
        let sum = chains::sum(found.iter().map(|l| &l.open));
        let worst = sum.total.worst.map(|gap| WorstGap {
            layer: sum.worst_layer,
            gap_mm: mm(gap.length),
            z_mm: layers.get(sum.worst_layer).map_or(0.0, |l| mm(l.slice_z)),
            x_mm: mm(i64::from(gap.at.x) + origin[0]),
            y_mm: mm(i64::from(gap.at.y) + origin[1]),
        });
        let count = |of: fn(&chains::OpenReport) -> u32| found.iter().map(|l| u64::from(of(&l.open))).sum();
        Self {
            layers: sum.layers,
            chains: count(|r| r.chains),
            matched: count(|r| r.matched),
            forced: count(|r| r.forced),
            dropped: count(|r| r.dropped),
            worst,
        }
    }

    /// One line for people, where there is something to say; `name` stands for the part.
    pub fn warning(&self, name: &str) -> Option<String> {
        let place = self.worst.map_or(String::new(), |w| {
            format!(
                "; the widest gap is {:.3} mm at z = {:.3}, x = {:.3}, y = {:.3}",
                w.gap_mm, w.z_mm, w.x_mm, w.y_mm
            )
        });
        (self.chains > 0).then(|| {
            format!(
                "{name}: {} open contours on {} layers: {} closed within the tolerance, {} closed by a straight line, {} left out{place}; repair the mesh",
                self.chains, self.layers, self.matched, self.forced, self.dropped,
            )
        })
    }
}
