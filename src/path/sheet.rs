//! Lines → extrusions: cut open, simplified, with flow and feed rate.

use super::bead::{Pieces, Start};
use super::loops::cut_open;
use super::seam::{Seam, nearest_on};
use super::speed::{Line, Lines, SMALL_PERIMETER};
use super::{Extrusion, LayerPlan, Role, simplify};
use crate::infill::FillPath;
use crate::lattice::{NM_PER_MM, Point2, mm};
use crate::region::Bead;
use crate::settings::Settings;
use crate::support::Strand;

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

    /// Adds a line beside the part as one of `lines`; a closed one is begun where the nozzle is nearest.
    pub fn strand(&mut self, strand: &Strand, reversed: bool, lines: &Lines, from: Point2) -> Point2 {
        let (first, role) = (self.out.points.len(), Role::of_strand(strand.kind));
        if strand.closed {
            return self.around(&strand.points, role, lines, from);
        } else if reversed {
            self.out.points.extend(strand.points.iter().rev());
        } else {
            self.out.points.extend_from_slice(&strand.points);
        }
        self.extrude(first, role, *lines.of(role), from)
    }

    /// Adds a loop beside the part as one of `lines`, begun where the nozzle is nearest.
    pub fn around(&mut self, ring: &[Point2], role: Role, lines: &Lines, from: Point2) -> Point2 {
        let Some((seam, _)) = nearest_on(ring, from) else { return from };
        let first = self.out.points.len();
        cut_open(ring, seam, self.gap(), &mut self.out.points);
        self.extrude(first, role, *lines.of(role), from)
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

#[cfg(test)]
mod tests {
    use super::super::testing::{Random, circle, rectangle};
    use super::super::{PrintIsland, PrintLayer, plan};
    use super::*;
    use crate::infill::FillKind;
    use crate::region::{BeadKind, Wall};
    use crate::slice::planes::LayerZ;

    /// The plan of some layers of one island each, and the settings' flows.
    fn planned(islands: Vec<PrintIsland>, settings: &Settings) -> Vec<LayerPlan> {
        let layer = |(k, island): (i32, PrintIsland)| PrintLayer {
            z: LayerZ { slice_z: k * 200_000 + 100_000, print_z: (k + 1) * 200_000, height: 200_000 },
            islands: vec![island],
            ..PrintLayer::default()
        };
        let layers: Vec<_> = (0..).zip(islands).map(layer).collect();
        plan(&layers, Point2::default(), settings)
    }

    /// The second of two layers, the first of which is empty.
    fn second(island: PrintIsland, settings: &Settings) -> LayerPlan {
        planned(vec![PrintIsland::default(), island], settings).remove(1)
    }

    fn uncooled() -> Settings {
        let mut settings = Settings::default();
        settings.cooling.cooling = false;
        settings
    }

    /// True when no extrusion but the first needs a travel.
    fn is_joined(layer: &LayerPlan) -> bool {
        layer.extrusions.windows(2).all(|w| {
            let (a, b) = (layer.path(&w[0]), layer.path(&w[1]));
            a.last() == b.first() && !w[1].retract
        })
    }

    #[test]
    fn a_loop_keeps_its_line_and_its_overhangs() {
        for seed in 0..200 {
            let mut random = Random::new(seed);
            let n = 4 + random.below(60) as usize;
            let ring = circle(9_000_000, 9_000_000, 8_000_000, n, seed as f64);
            let overhang: Vec<bool> = (0..n).map(|_| random.below(3) == 0).collect();
            let depth = random.below(2) as u32;
            let wall = |overhang| Wall { ring: ring.clone(), depth, hole: false, overhang };
            let with = |wall| PrintIsland { walls: vec![wall], ..PrintIsland::default() };
            let mut settings = uncooled();
            settings.output.gcode_resolution = 0.0;
            settings.perimeters.seam_position = crate::settings::SeamPosition::Rear;
            let flagged = second(with(wall(overhang.clone())), &settings);
            let plain = second(with(wall(Vec::new())), &settings);
            assert!(is_joined(&flagged), "seed {seed}");
            // The same way, point for point.
            let mut way: Vec<_> = flagged.extrusions.iter().flat_map(|e| flagged.path(e).to_vec()).collect();
            way.dedup();
            assert_eq!(way, plain.path(&plain.extrusions[0]), "seed {seed}");
            for e in &flagged.extrusions {
                for w in flagged.path(e).windows(2) {
                    // The middle of each line tells which edge it is on.
                    let middle = Point2::new(w[0].x.midpoint(w[1].x), w[0].y.midpoint(w[1].y));
                    let edge = nearest_on(&ring, middle).map(|s| s.0.edge);
                    let over_air = edge.is_some_and(|i| overhang[i]);
                    assert_eq!(e.role == Role::OverhangPerimeter, over_air, "seed {seed}");
                }
            }
            assert!(flagged.extrusions.windows(2).all(|w| w[0].role != w[1].role), "seed {seed}");
        }
    }

    #[test]
    fn corners_where_the_role_changes_survive_simplification() {
        let mut ring = rectangle(0, 0, 20_000_000, 20_000_000);
        ring.splice(1..1, [Point2::new(5_000_000, 0), Point2::new(9_000_000, 0)]);
        let overhang = vec![false, true, false, false, false, false];
        let wall = Wall { ring: ring.clone(), depth: 0, hole: false, overhang };
        let layer = second(PrintIsland { walls: vec![wall], ..PrintIsland::default() }, &uncooled());
        let over: Vec<_> = layer.extrusions.iter().filter(|e| e.role == Role::OverhangPerimeter).collect();
        assert_eq!(over.len(), 1);
        assert_eq!(layer.path(over[0]), &ring[1..3]);
        // Thick threads at the speed of bridges.
        assert_eq!((over[0].width, over[0].height, over[0].speed), (0.4, 0.4, 60.0));
        assert_eq!(layer.extrusions[0].speed, 30.0);
    }

    #[test]
    fn a_small_loop_is_slow_all_round() {
        let wall = Wall {
            ring: circle(0, 0, 2_000_000, 24, 0.0),
            overhang: (0..24).map(|i| i < 9).collect(),
            ..Wall::default()
        };
        let layer = second(PrintIsland { walls: vec![wall], ..PrintIsland::default() }, &uncooled());
        assert!(layer.extrusions.len() >= 2);
        assert!(layer.extrusions.iter().all(|e| e.speed == 15.0));
    }

    #[test]
    fn a_bead_is_joined_pieces_of_its_volume() {
        let bead = Bead {
            points: vec![Point2::new(0, 0), Point2::new(6_000_000, 0), Point2::new(9_000_000, 4_000_000)],
            widths: vec![300_000, 700_000, 450_000],
            kind: BeadKind::GapFill,
        };
        let mut settings = uncooled();
        settings.speed.max_volumetric_speed = 2.0;
        let layer = second(PrintIsland { beads: vec![bead], ..PrintIsland::default() }, &settings);
        assert!(is_joined(&layer) && layer.extrusions.len() > 10);
        let volume: f64 = layer.extrusions.iter().map(|e| e.length * e.mm3_per_mm).sum();
        let rounding = 0.2 * (1.0 - std::f64::consts::PI / 4.0);
        let wanted = 0.2 * (6.0 * (0.5 - rounding) + 5.0 * (0.575 - rounding));
        assert!((volume / wanted - 1.0).abs() < 1e-6, "{volume} mm³, not {wanted}");
        for e in &layer.extrusions {
            assert_eq!(e.role, Role::GapFill);
            assert!((0.3..0.7).contains(&e.width) && e.height == 0.2);
            assert!((e.speed - (2.0 / e.mm3_per_mm).min(20.0)).abs() < 1e-9);
        }
    }

    #[test]
    fn walls_thin_walls_gaps_and_fills_follow_each_other() {
        let line = |y: i32, kind| Bead {
            points: vec![Point2::new(0, y), Point2::new(8_000_000, y)],
            widths: vec![400_000; 2],
            kind,
        };
        let fill = |y: i32, kind| FillPath {
            points: vec![Point2::new(1_000_000, y), Point2::new(7_000_000, y)],
            kind,
            layers: 1,
        };
        let wall = |depth, d: i32| Wall {
            ring: rectangle(d, d, 8_000_000 - d, 5_000_000),
            depth,
            ..Wall::default()
        };
        let mut closed = line(0, BeadKind::ThinWall);
        closed.points = circle(4_000_000, 9_000_000, 900_000, 12, 0.2);
        closed.points.push(closed.points[0]);
        closed.widths = vec![400_000; 13];
        let island = || PrintIsland {
            walls: vec![wall(0, 0), wall(1, 400_000)],
            beads: vec![
                line(4_000_000, BeadKind::GapFill),
                line(6_000_000, BeadKind::ThinWall),
                closed.clone(),
            ],
            fills: vec![
                fill(1_000_000, FillKind::Solid),
                fill(2_000_000, FillKind::Bridge),
                fill(1_500_000, FillKind::Bridge),
                fill(3_000_000, FillKind::Sparse),
            ],
        };
        use Role::{BridgeInfill, ExternalPerimeter, GapFill, InternalInfill, Perimeter, SolidInfill};
        let mut settings = uncooled();
        // Thin walls and nests come as they lie.
        let roles = |layer: &LayerPlan, walls: std::ops::Range<usize>| {
            let mut roles: Vec<_> = layer.extrusions.iter().map(|e| e.role).collect();
            roles[walls].sort();
            roles
        };
        let walls = [Perimeter, ExternalPerimeter, ExternalPerimeter, ExternalPerimeter];
        let fills = [InternalInfill, BridgeInfill, BridgeInfill, SolidInfill];
        let layer = second(island(), &settings);
        assert_eq!(roles(&layer, 0..4), [&walls[..], &[GapFill], &fills].concat());
        // Bridges keep their order and directions.
        let bridges: Vec<_> = layer.extrusions.iter().filter(|e| e.role == BridgeInfill).collect();
        assert_eq!(bridges.iter().map(|e| layer.path(e)[0].y).collect::<Vec<_>>(), [2_000_000, 1_500_000]);
        // The tube of one bead is a small loop with a gap at its seam; the open wall is not.
        let [tube, open] = [true, false].map(|tube| {
            let above = |e: &&Extrusion| layer.path(e)[0].y > 7_000_000;
            layer
                .extrusions
                .iter()
                .filter(|e| e.width == 0.4 && e.role == ExternalPerimeter)
                .find(|e| above(e) == tube)
        });
        assert_eq!([tube, open].map(|e| e.map_or(0.0, |e| e.speed)), [15.0, 30.0]);
        let ends = tube.map(|e| layer.path(e)).map_or(0.0, |p| p[0].distance(p[p.len() - 1]));
        assert!((ends - 60_000.0).abs() < 100.0, "{ends}");
        settings.infill.infill_first = true;
        assert_eq!(roles(&second(island(), &settings), 4..8), [&fills[..], &walls, &[GapFill]].concat());
    }

    #[test]
    fn combined_infill_is_as_thick_as_its_layers() {
        let fill = |layers| PrintIsland {
            fills: vec![FillPath {
                points: vec![Point2::new(0, 0), Point2::new(9_000_000, 0)],
                kind: FillKind::Sparse,
                layers,
            }],
            ..PrintIsland::default()
        };
        let layers = planned(vec![fill(1), fill(1), fill(2), fill(9)], &uncooled());
        let heights =
            layers.iter().map(|l| (l.extrusions[0].height * 1e6).round() as i64).collect::<Vec<_>>();
        // There are only four layers to be filled by the last.
        assert_eq!(heights, [200_000, 200_000, 400_000, 800_000]);
        assert!(
            (layers[2].extrusions[0].mm3_per_mm - 0.4 * (0.45 - 0.4 * (1.0 - std::f64::consts::PI / 4.0)))
                .abs()
                < 1e-12
        );
    }
}
