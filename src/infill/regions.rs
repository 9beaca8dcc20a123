//! The infill areas of a layer, flattened, and what their lines need to know of them.

use super::border::Border;
use super::onto::{onto, outline};
use crate::lattice::Point2;
use crate::region::Island;
use crate::span::{RowFrame, Rows, Trace, trace};
use std::ops::Range;

/// The infill areas of a layer.
#[derive(Debug, Default)]
pub struct Regions<'a> {
    /// Rings \[nm\], region by region.
    pub rings: Vec<&'a [Point2]>,
    /// Per region (one `ExPolygon`) its rings.
    pub regions: Vec<Range<usize>>,
    /// Per ring its region.
    pub region_of_ring: Vec<u32>,
    /// Per region the island that it belongs to.
    pub island_of_region: Vec<usize>,
}

impl<'a> Regions<'a> {
    /// Those of a layer's islands.
    pub fn new(islands: &'a [Island]) -> Self {
        let mut all = Self::default();
        for (i, island) in islands.iter().enumerate() {
            for area in &island.infill {
                let begin = all.rings.len();
                all.rings.extend(area.rings().map(|r| &r[..]));
                all.region_of_ring.resize(all.rings.len(), all.regions.len() as u32);
                all.regions.push(begin..all.rings.len());
                all.island_of_region.push(i);
            }
        }
        all
    }

    /// Their crossings with rows of any direction.
    pub fn trace(&self, lines: &RowFrame) -> Trace {
        trace(self.rings.iter().copied(), lines)
    }

    /// The border on the rows that `trace` was made with.
    pub fn border<'b>(&'b self, trace: &'b Trace, lines: &'b RowFrame) -> Border<'b> {
        Border {
            rings: &self.rings,
            regions: &self.regions,
            region_of_ring: &self.region_of_ring,
            trace,
            frame: lines,
        }
    }
}

/// Regions with the rows on which their areas are compared.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// The regions.
    pub regions: &'a Regions<'a>,
    /// All of them on the rows of `frame`.
    pub own: &'a Rows,
    /// The rows of all layers' areas.
    pub frame: &'a RowFrame,
}

impl Compared<'_> {
    /// An area, a part of `own`, on other rows; `trace` holds the regions' crossings with these.
    pub fn onto(&self, area: &Rows, trace: &Trace, lines: &RowFrame) -> Rows {
        onto(area, self.own, self.frame, &trace.rows, lines)
    }

    /// The border of an area, a part of `own`, inside the regions: directed edges \[nm\] with the area on
    /// their left, which run outside of the regions where these bound it.
    pub fn outline(&self, area: &Rows) -> Vec<[Point2; 2]> {
        outline(area, self.own, self.frame)
    }
}
