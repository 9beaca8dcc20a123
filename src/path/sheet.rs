//! Lines → extrusions: cut open, simplified, with flow and feed rate.

use super::bead::{Pieces, Start};
use super::loops::cut_open;
use super::seam::Seam;
use super::speed::{Line, Lines, SMALL_PERIMETER};
use super::{Extrusion, LayerPlan, Role, simplify};
use crate::infill::FillPath;
use crate::lattice::{NM_PER_MM, Point2, mm};
use crate::region::Bead;
use crate::settings::Settings;

/// The gap at a loop's end, as a share of the nozzle's bore (PrusaSlicer's).
const SEAM_GAP: f64 = 0.15;

/// The layer being planned. Every method takes where the nozzle comes from and returns where it ends.
pub(super) struct Sheet<'a> {
    out: &'a mut LayerPlan,
    lines: Lines<'a>,
    settings: &'a Settings,
    buffers: &'a mut Buffers,
}

/// Buffers kept from layer to layer.
#[derive(Clone, Debug, Default)]
pub(super) struct Buffers {
    /// A loop cut open.
    cut: Vec<Point2>,
    pieces: Pieces,
}

impl<'a> Sheet<'a> {
    pub fn new(
        out: &'a mut LayerPlan,
        lines: Lines<'a>,
        settings: &'a Settings,
        buffers: &'a mut Buffers,
    ) -> Self {
        Self { out, lines, settings, buffers }
    }

    /// Way left out at the end of a loop \[nm\].
    pub fn gap(&self) -> f64 {
        SEAM_GAP * self.settings.printer.nozzle_diameter * NM_PER_MM
    }

    /// Adds a loop; edges with `overhang` become overhanging walls, without a travel in between.
    pub fn closed(
        &mut self,
        ring: &[Point2],
        overhang: &[bool],
        seam: Seam,
        role: Role,
        from: Point2,
    ) -> Point2 {
        let (first, printed) = (self.out.points.len(), self.out.extrusions.len());
        cut_open(ring, seam, self.gap(), &mut self.out.points);
        let end = if overhang.contains(&true) {
            self.in_runs(first, overhang, seam.edge, role, from)
        } else {
            self.extrude(first, role, *self.lines.of(role), from)
        };
        if matches!(role, Role::Perimeter | Role::ExternalPerimeter) {
            self.slow_if_small(printed);
        }
        end
    }

    /// Makes extrusions of the open loop from `first` on, one for each stretch of edges alike. Its first
    /// edge is part of the ring's `edge`, and so on around.
    fn in_runs(&mut self, first: usize, overhang: &[bool], edge: usize, role: Role, from: Point2) -> Point2 {
        let mut cut = std::mem::take(&mut self.buffers.cut);
        cut.clear();
        cut.extend(self.out.points.drain(first..));
        let hangs = |k: usize| overhang[(edge + k) % overhang.len()];
        let (mut at, mut start) = (from, 0);
        for end in 1..cut.len() {
            if end + 1 < cut.len() && hangs(end) == hangs(start) {
                continue;
            }
            let role = if hangs(start) { Role::OverhangPerimeter } else { role };
            let first = self.out.points.len();
            self.out.points.extend_from_slice(&cut[start..=end]);
            at = self.extrude(first, role, *self.lines.of(role), at);
            start = end;
        }
        self.buffers.cut = cut;
        at
    }

    /// Adds a bead of varying width as consecutive extrusions.
    pub fn bead(&mut self, bead: &Bead, start: Start, from: Point2) -> Point2 {
        let (role, printed) = (Role::of_bead(bead.kind), self.out.extrusions.len());
        let mut pieces = std::mem::take(&mut self.buffers.pieces);
        pieces.cut(bead, start, |width| self.lines.section(width / NM_PER_MM));
        let (mut at, mut first) = (from, 0);
        for piece in &pieces.pieces {
            let points = self.out.points.len();
            self.out.points.extend_from_slice(&pieces.points[first..piece.end]);
            // Whole micrometres, so that equal widths are written once.
            let width = (piece.width / 1e3).round() / 1e3;
            let line = self.lines.varied(role, width, piece.volume / piece.length);
            at = self.extrude(points, role, line, at);
            first = piece.end;
        }
        self.buffers.pieces = pieces;
        if matches!(start, Start::Seam(..)) && role == Role::ExternalPerimeter {
            self.slow_if_small(printed);
        }
        at
    }

    /// Adds an infill line; one that fills several layers at once is `thickness` thick \[nm\].
    pub fn open(&mut self, fill: &FillPath, reversed: bool, thickness: i64, from: Point2) -> Point2 {
        let first = self.out.points.len();
        if reversed {
            self.out.points.extend(fill.points.iter().rev());
        } else {
            self.out.points.extend_from_slice(&fill.points);
        }
        let role = Role::of_fill(fill.kind);
        let line = if thickness > 0 && role == Role::InternalInfill {
            self.lines.combined(mm(thickness))
        } else {
            *self.lines.of(role)
        };
        self.extrude(first, role, line, from)
    }

    /// Makes an extrusion of the points from `first` on.
    fn extrude(&mut self, first: usize, role: Role, line: Line, from: Point2) -> Point2 {
        let points = &mut self.out.points;
        simplify::simplify(points, first, self.settings.output.gcode_resolution * NM_PER_MM);
        let path = &points[first..];
        let length = path.windows(2).map(|w| w[0].distance(w[1])).sum::<f64>() / NM_PER_MM;
        let (Some(&start), Some(&end)) = (path.first(), path.last()) else { return from };
        if path.len() < 2 || length <= 0.0 {
            points.truncate(first);
            return from;
        }
        let travel = from.distance(start) / NM_PER_MM;
        self.out.travel_seconds += travel / self.settings.speed.travel_speed.max(1e-3);
        self.out.extrusions.push(Extrusion {
            role,
            points: first as u32..points.len() as u32,
            width: line.width,
            height: line.height,
            mm3_per_mm: line.mm3_per_mm,
            speed: line.speed,
            length,
            retract: travel > 0.0 && travel >= self.settings.retraction.retract_before_travel,
            fan: None,
        });
        end
    }

    /// Gives the extrusions from `first` on, which are one loop, the speed of small perimeters if they are
    /// one. That goes for what hangs in air, too, as in PrusaSlicer.
    fn slow_if_small(&mut self, first: usize) {
        let own = &mut self.out.extrusions[first..];
        if own.iter().map(|e| e.length).sum::<f64>() <= SMALL_PERIMETER {
            for e in own {
                e.speed = self.lines.small_speed(e.mm3_per_mm);
            }
        }
    }
}
