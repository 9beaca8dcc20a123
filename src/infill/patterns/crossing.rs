//! Several families of parallel lines that cross on every layer.

use super::Sparse;
use super::join::{Piece, join};
use crate::infill::FillPath;
use crate::infill::anchor::Place;
use crate::infill::border::INSIDE;
use crate::infill::rectilinear::lines;
use crate::span::RowFrame;

/// One family: its direction \[degrees\], and how far its lines lie to the left of the mesh frame's zero
/// \[nm\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Family {
    /// Counter-clockwise from +x.
    pub degrees: f64,
    /// Of one of the lines.
    pub phase: f64,
}

impl Family {
    /// Its lines as rows, `pitch` \[nm\] apart.
    pub fn rows(&self, pitch: f64) -> RowFrame {
        // Rows know half a turn; left is right behind it.
        let turn = self.degrees.rem_euclid(360.0);
        let phase = if turn < 180.0 { self.phase } else { -self.phase };
        RowFrame::new(turn, phase, pitch)
    }
}

/// Lays families of parallel lines, `pitch` \[nm\] apart in each.
pub fn lay(sparse: &Sparse, families: &[Family], pitch: f64, found: impl FnMut(usize, FillPath)) {
    let mut pieces = Vec::new();
    for family in families {
        cut(sparse, &family.rows(pitch), &mut pieces);
    }
    pieces.sort_by_key(|p| p.region);
    let rings = &sparse.compared.regions.rings;
    join(&pieces, rings, &sparse.anchors(), &sparse.open(), sparse.paths(found));
}

/// The parts of one family's lines in the area.
fn cut(sparse: &Sparse, rows: &RowFrame, pieces: &mut Vec<Piece>) {
    let trace = sparse.compared.regions.trace(rows);
    let area = sparse.compared.onto(sparse.area, &trace, rows);
    let border = sparse.compared.regions.border(&trace, rows);
    let (lines, offset) = lines(&border, &area);
    for (region, range) in (0..).zip(offset.windows(2)) {
        for line in &lines[range[0] as usize..range[1] as usize] {
            let points = line.s.map(|s| rows.xy(s, rows.t(line.row)));
            if points[0].distance(points[1]) < sparse.least() {
                continue;
            }
            let place = |end: usize| {
                let id = line.hit[end];
                (id != INSIDE).then(|| {
                    let hit = border.hit(id);
                    Place::new(border.rings, hit.ring, hit.edge, points[end])
                })
            };
            pieces.push(Piece { region, points: points.to_vec(), ends: [place(0), place(1)] });
        }
    }
}
