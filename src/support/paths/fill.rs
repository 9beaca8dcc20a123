//! Lines in areas.

use crate::contour::ExPolygon;
use crate::infill::anchor::{Anchors, Everywhere};
use crate::infill::patterns::clip::clip;
use crate::infill::patterns::join::join;
use crate::infill::patterns::{Spec, honeycomb};
use crate::infill::rectilinear::{Chain, Links, chains};
use crate::infill::regions::Regions;
use crate::lattice::Point2;
use crate::span::RowFrame;

/// A way between the ends of two lines along the border may be this many times their distance.
const LINK_LIMIT: f64 = 3.0;

/// How an area is filled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fill {
    /// Parallel lines, joined to zig-zags.
    Lines {
        /// Direction \[degrees\].
        degrees: f64,
        /// Distance \[nm\]; one of them runs through the zero of the mesh frame.
        pitch: f64,
    },
    /// Hexagonal cells.
    Honeycomb {
        /// Direction \[degrees\].
        degrees: f64,
        /// Distance of lines of full density \[nm\].
        spacing: f64,
        /// Share that is filled, above 0.
        density: f64,
        /// Which of three directions a cell's double walls have.
        turn: usize,
    },
}

/// Fills areas to their borders: reports each path, of at least two points, with the index of its area, area
/// by area. Paths shorter than `least` \[nm\] are left out.
pub fn fill(areas: &[ExPolygon], how: Fill, least: f64, mut found: impl FnMut(usize, Vec<Point2>)) {
    if areas.is_empty() {
        return;
    }
    let regions = regions(areas);
    match how {
        Fill::Lines { degrees, pitch } => {
            let rows = RowFrame::new(degrees, 0.0, pitch);
            let trace = regions.trace(&rows);
            let border = regions.border(&trace, &rows);
            let links = Links::near(pitch, &Everywhere);
            chains(&border, &trace.rows, least, links, |Chain { region, points, .. }| found(region, points));
        }
        Fill::Honeycomb { degrees, spacing, density, turn } => {
            let spec = Spec { angle: degrees, spacing, density, layer: turn, z: 0.0 };
            let pieces = clip(&honeycomb::strands(&spec), &regions, None, least);
            let rules = Anchors { link: LINK_LIMIT * spacing / density, anchor: 0.0, gap: least };
            join(&pieces, &regions.rings, &rules, &Everywhere, found);
        }
    }
}

/// The areas as the infill stage takes them.
fn regions(areas: &[ExPolygon]) -> Regions<'_> {
    let mut all = Regions::default();
    for (i, area) in areas.iter().enumerate() {
        let begin = all.rings.len();
        all.rings.extend(area.rings().map(|r| &r[..]));
        all.region_of_ring.resize(all.rings.len(), i as u32);
        all.regions.push(begin..all.rings.len());
        all.island_of_region.push(i);
    }
    all
}
