//! The order of everything on a layer.

use super::loops::{cut_open, nests};
use super::nearest::NearestSet;
use super::seam::{Seam, SeamPlacer, nearest_on};
use super::speed::{Line, SMALL_PERIMETER, lines};
use super::{Extrusion, LayerPlan, PrintIsland, PrintLayer, Role, cooling, simplify};
use crate::infill::{FillKind, FillPath};
use crate::lattice::{NM_PER_MM, Point2, mm};
use crate::region::Wall;
use crate::settings::{FillPattern, SeamPosition, Settings};
use std::ops::Range;

/// The gap at a loop's end, as a share of the nozzle's bore (PrusaSlicer's).
const SEAM_GAP: f64 = 0.15;

/// Plans layers one after the other; remembers where the nozzle is and where the seams were.
///
/// Islands are visited by nearest neighbour; in each of them walls go from the innermost to the
/// external one (`external_perimeters_first` turns that round), nest by nest, then the infill (or
/// the infill first, by `infill_first`): sparse, solid and top lines, each by nearest end. Monotonic
/// top lines keep their given order and directions.
#[derive(Clone, Debug)]
pub struct Planner<'a> {
    settings: &'a Settings,
    seams: SeamPlacer,
    at: Point2,
    index: usize,
    islands: NearestSet,
    ends: NearestSet,
    scratch: Scratch,
}

/// Buffers kept from layer to layer.
#[derive(Clone, Debug, Default)]
struct Scratch {
    /// Indices of the walls in their islands, nest by nest.
    walls: Vec<u32>,
    /// The nests of all islands, as ranges of `walls`, and their seams.
    nests: Vec<(Range<u32>, Seam)>,
    found: Vec<Range<u32>>,
    /// First nest of each island, and one past the last of all.
    first_nest: Vec<u32>,
}

/// The layer being planned.
struct Sheet<'a> {
    out: &'a mut LayerPlan,
    lines: [Line; Role::COUNT],
    settings: &'a Settings,
}

impl<'a> Planner<'a> {
    /// A planner whose nozzle stands at `start` \[nm, the mesh's frame\].
    pub fn new(start: Point2, settings: &'a Settings) -> Self {
        Self {
            settings,
            seams: SeamPlacer::new(settings.perimeters.seam_position),
            at: start,
            index: 0,
            islands: NearestSet::default(),
            ends: NearestSet::default(),
            scratch: Scratch::default(),
        }
    }

    /// Plans the next layer into `out`, whose content is replaced and whose buffers are reused.
    pub fn layer(&mut self, layer: &PrintLayer, out: &mut LayerPlan) {
        out.extrusions.clear();
        out.points.clear();
        (out.print_z, out.height) = (layer.z.print_z, layer.z.height);
        (out.fan, out.travel_seconds) = (0.0, 0.0);
        let lines = lines(mm(layer.z.height), self.index == 0, self.settings);
        let mut sheet = Sheet { out, lines, settings: self.settings };
        for ring in &layer.skirt {
            if let Some((seam, _)) = nearest_on(ring, self.at) {
                self.at = sheet.closed(ring, seam, Role::Skirt, self.at);
            }
        }
        let mut scratch = std::mem::take(&mut self.scratch);
        self.place_seams(&layer.islands, &mut scratch);
        self.islands.fill((0..layer.islands.len()).map(|i| entry(i, &layer.islands[i], &scratch)));
        while let Some((i, _)) = self.islands.take(self.at) {
            let i = i as usize;
            let island = &layer.islands[i];
            if self.settings.infill.infill_first {
                self.fills(&island.fills, &mut sheet);
                self.walls(island, i, &scratch, &mut sheet);
            } else {
                self.walls(island, i, &scratch, &mut sheet);
                self.fills(&island.fills, &mut sheet);
            }
        }
        self.scratch = scratch;
        self.seams.next_layer();
        cooling::cool(out, self.index, &self.settings.cooling);
        self.index += 1;
    }

    /// Finds the nests of every island and, in the islands' given order, their seams.
    fn place_seams(&mut self, islands: &[PrintIsland], scratch: &mut Scratch) {
        scratch.walls.clear();
        scratch.nests.clear();
        scratch.first_nest.clear();
        let late = self.settings.perimeters.seam_position == SeamPosition::Nearest;
        for island in islands {
            scratch.first_nest.push(scratch.nests.len() as u32);
            nests(&island.walls, &mut scratch.walls, &mut scratch.found);
            for nest in scratch.found.drain(..) {
                let wall = &island.walls[scratch.walls[nest.start as usize] as usize];
                let seam = if late {
                    wall.ring.first().map(|&at| Seam { edge: 0, at })
                } else {
                    self.seams.place(&wall.ring, wall.hole, self.at, self.index)
                };
                scratch.nests.extend(seam.map(|seam| (nest, seam)));
            }
        }
        scratch.first_nest.push(scratch.nests.len() as u32);
    }

    /// Prints the walls of island `index`.
    fn walls(&mut self, island: &PrintIsland, index: usize, scratch: &Scratch, sheet: &mut Sheet<'_>) {
        let own = scratch.first_nest[index] as usize..scratch.first_nest[index + 1] as usize;
        let nests = &scratch.nests[own];
        let mut print = |planner: &mut Self, (nest, seam): &(Range<u32>, Seam)| {
            let order = &scratch.walls[nest.start as usize..nest.end as usize];
            planner.nest(&island.walls, order, *seam, sheet);
        };
        if let [only] = nests {
            return print(self, only);
        }
        self.ends.fill(nests.iter().map(|n| n.1.at));
        while let Some((i, _)) = self.ends.take(self.at) {
            print(self, &nests[i as usize]);
        }
    }

    /// Prints an external wall and those that follow it, all starting abreast of its seam; `order`
    /// holds their indices from the external one inwards.
    fn nest(&mut self, walls: &[Wall], order: &[u32], seam: Seam, sheet: &mut Sheet<'_>) {
        let perimeters = &self.settings.perimeters;
        let seam = match order.first().map(|&w| &walls[w as usize]) {
            Some(w) if perimeters.seam_position == SeamPosition::Nearest => {
                self.seams.place(&w.ring, w.hole, self.at, self.index).unwrap_or(seam)
            }
            _ => seam,
        };
        for k in 0..order.len() {
            let k = if perimeters.external_perimeters_first { k } else { order.len() - 1 - k };
            let wall = &walls[order[k] as usize];
            let start = if k == 0 { Some(seam) } else { nearest_on(&wall.ring, seam.at).map(|s| s.0) };
            if let Some(start) = start {
                self.at = sheet.closed(&wall.ring, start, Role::of_wall(wall.depth), self.at);
            }
        }
    }

    /// Prints the infill lines, kind by kind, each kind by nearest end.
    fn fills(&mut self, fills: &[FillPath], sheet: &mut Sheet<'_>) {
        if fills.is_empty() {
            return;
        }
        for kind in [FillKind::Sparse, FillKind::Solid, FillKind::TopSolid] {
            let own = fills.iter().filter(|f| f.kind == kind && f.points.len() >= 2);
            let paths: Vec<&[Point2]> = own.map(|f| f.points.as_slice()).collect();
            if kind == FillKind::TopSolid && self.settings.infill.top_fill_pattern == FillPattern::Monotonic {
                for path in paths {
                    self.at = sheet.open(path, false, Role::of_fill(kind), self.at);
                }
                continue;
            }
            // Ends 2i and 2i + 1 belong to path i.
            self.ends.fill(paths.iter().flat_map(|p| [p[0], p[p.len() - 1]]));
            while let Some((end, _)) = self.ends.take(self.at) {
                let path = paths[end as usize / 2];
                let reversed = end % 2 == 1;
                let other = if reversed { path[0] } else { path[path.len() - 1] };
                self.ends.remove(end ^ 1, other);
                self.at = sheet.open(path, reversed, Role::of_fill(kind), self.at);
            }
        }
    }
}

/// Where an island is likely to be entered.
fn entry(index: usize, island: &PrintIsland, scratch: &Scratch) -> Point2 {
    let first = scratch.first_nest[index] as usize;
    if first < scratch.first_nest[index + 1] as usize {
        return scratch.nests[first].1.at;
    }
    island.fills.iter().find_map(|f| f.points.first().copied()).unwrap_or_default()
}

impl Sheet<'_> {
    /// Adds a loop; the nozzle comes from `from`. Returns where it ends.
    fn closed(&mut self, ring: &[Point2], seam: Seam, role: Role, from: Point2) -> Point2 {
        let first = self.out.points.len();
        let gap = SEAM_GAP * self.settings.printer.nozzle_diameter * NM_PER_MM;
        cut_open(ring, seam, gap, &mut self.out.points);
        self.extrude(first, role, from, matches!(role, Role::Perimeter | Role::ExternalPerimeter))
    }

    /// Adds an open line; the nozzle comes from `from`. Returns where it ends.
    fn open(&mut self, path: &[Point2], reversed: bool, role: Role, from: Point2) -> Point2 {
        let first = self.out.points.len();
        if reversed {
            self.out.points.extend(path.iter().rev());
        } else {
            self.out.points.extend_from_slice(path);
        }
        self.extrude(first, role, from, false)
    }

    /// Makes an extrusion of the points from `first` on.
    fn extrude(&mut self, first: usize, role: Role, from: Point2, may_be_small: bool) -> Point2 {
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
        let line = self.lines[role.index()];
        self.out.travel_seconds += travel / self.settings.speed.travel_speed.max(1e-3);
        self.out.extrusions.push(Extrusion {
            role,
            points: first as u32..points.len() as u32,
            width: line.width,
            height: mm(self.out.height),
            mm3_per_mm: line.mm3_per_mm,
            speed: if may_be_small && length <= SMALL_PERIMETER { line.small_speed } else { line.speed },
            length,
            retract: travel > 0.0 && travel >= self.settings.retraction.retract_before_travel,
            fan: None,
        });
        end
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Random, circle, rectangle};
    use super::super::{Role, plan};
    use super::*;
    use crate::slice::planes::LayerZ;

    fn layer(islands: Vec<PrintIsland>) -> PrintLayer {
        let z = LayerZ { slice_z: 100_000, print_z: 200_000, height: 200_000 };
        PrintLayer { z, islands, skirt: Vec::new() }
    }

    fn walls(rings: Vec<(Vec<Point2>, u32, bool)>) -> PrintIsland {
        let wall = |(ring, depth, hole)| Wall { ring, depth, hole, overhang: Vec::new() };
        PrintIsland { walls: rings.into_iter().map(wall).collect(), ..PrintIsland::default() }
    }

    fn travel(layer: &LayerPlan, start: Point2) -> f64 {
        let mut at = start;
        let mut sum = 0.0;
        for e in &layer.extrusions {
            let path = layer.path(e);
            sum += at.distance(path[0]);
            at = path[path.len() - 1];
        }
        sum / NM_PER_MM
    }

    #[test]
    fn islands_on_a_grid_are_visited_without_detours() {
        let mut random = Random::new(5);
        let mut islands: Vec<_> = (0..900)
            .map(|i| {
                walls(vec![(circle(i % 30 * 6_000_000, i / 30 * 6_000_000, 1_500_000, 16, 0.0), 0, false)])
            })
            .collect();
        for i in (1..islands.len()).rev() {
            islands.swap(i, random.below(i as u64 + 1) as usize);
        }
        let plans = plan(&[layer(islands)], Point2::default(), &Settings::default());
        assert_eq!(plans[0].extrusions.len(), 900);
        // At best every island is 6 mm from the one before it; greedy tours are about a quarter longer.
        let length = travel(&plans[0], Point2::default());
        assert!(length < 1.4 * 899.0 * 6.0, "{length} mm");
    }

    #[test]
    fn fills_are_turned_round_where_that_is_shorter() {
        let line = |y: i32| FillPath {
            points: vec![Point2::new(0, y), Point2::new(20_000_000, y)],
            kind: FillKind::Sparse,
            layers: 1,
        };
        let fills = (0..60).rev().map(|i| line(i * 1_000_000)).collect();
        let island = PrintIsland { fills, ..PrintIsland::default() };
        let plans = plan(&[layer(vec![island])], Point2::default(), &Settings::default());
        assert!((travel(&plans[0], Point2::default()) - 59.0).abs() < 1e-9);
        assert!(plans[0].extrusions.iter().all(|e| !e.retract));
    }

    #[test]
    fn monotonic_top_lines_keep_their_order() {
        let line = |y: i32| FillPath {
            points: vec![Point2::new(0, y), Point2::new(9_000_000, y)],
            kind: FillKind::TopSolid,
            layers: 1,
        };
        let fills: Vec<_> = (0..9).rev().map(|i| line(i * 1_000_000)).collect();
        let printed = layer(vec![PrintIsland { fills: fills.clone(), ..PrintIsland::default() }]);
        let plans = plan(&[printed], Point2::default(), &Settings::default());
        let paths: Vec<_> = plans[0].extrusions.iter().map(|e| plans[0].path(e).to_vec()).collect();
        assert!(paths.iter().eq(fills.iter().map(|f| &f.points)));
    }

    fn roles(settings: &Settings) -> Vec<Role> {
        let mut island = walls(vec![
            (rectangle(0, 0, 30_000_000, 30_000_000), 0, false),
            (rectangle(500_000, 500_000, 29_500_000, 29_500_000), 1, false),
        ]);
        let points = vec![Point2::new(1_000_000, 1_000_000), Point2::new(29_000_000, 1_000_000)];
        for kind in [FillKind::TopSolid, FillKind::Solid, FillKind::Sparse] {
            island.fills.push(FillPath { points: points.clone(), kind, layers: 1 });
        }
        let mut printed = layer(vec![island]);
        printed.skirt.push(rectangle(-9_000_000, -9_000_000, 39_000_000, 39_000_000));
        let plans = plan(&[printed], Point2::default(), settings);
        plans[0].extrusions.iter().map(|e| e.role).collect()
    }

    #[test]
    fn the_order_of_roles_is_the_settings() {
        use Role::{ExternalPerimeter, InternalInfill, Perimeter, Skirt, SolidInfill, TopSolidInfill};
        let mut s = Settings::default();
        let fills = [InternalInfill, SolidInfill, TopSolidInfill];
        assert_eq!(roles(&s), [&[Skirt, Perimeter, ExternalPerimeter][..], &fills].concat());
        s.perimeters.external_perimeters_first = true;
        assert_eq!(roles(&s), [&[Skirt, ExternalPerimeter, Perimeter][..], &fills].concat());
        s.infill.infill_first = true;
        assert_eq!(roles(&s), [&[Skirt][..], &fills, &[ExternalPerimeter, Perimeter]].concat());
    }

    #[test]
    fn inner_walls_start_abreast_of_the_seam() {
        for position in
            [SeamPosition::Aligned, SeamPosition::Rear, SeamPosition::Random, SeamPosition::Nearest]
        {
            let mut s = Settings::default();
            s.perimeters.seam_position = position;
            let rings = (0..3).map(|d| (circle(0, 0, 20_000_000 - 450_000 * d, 90, 0.1), d as u32, false));
            let plans = plan(&[layer(vec![walls(rings.collect())])], Point2::default(), &s);
            let starts: Vec<_> = plans[0].extrusions.iter().map(|e| plans[0].path(e)[0]).collect();
            assert!(starts.windows(2).all(|w| w[0].distance(w[1]) < 0.5e6), "{position:?}: {starts:?}");
            for e in &plans[0].extrusions {
                let path = plans[0].path(e);
                let gap = path[0].distance(path[path.len() - 1]);
                assert!((gap - 0.06e6).abs() < 2.0, "{gap} nm");
            }
        }
    }

    #[test]
    fn small_walls_have_a_speed_of_their_own() {
        let mut s = Settings::default();
        s.speed.external_perimeter_speed = crate::settings::FloatOrPercent::Float(33.0);
        s.cooling.cooling = false;
        let islands = || {
            let ring = |x, radius| walls(vec![(circle(x, 0, radius, 200, 0.0), 0, false)]);
            vec![ring(0, 6_400_000), ring(40_000_000, 6_600_000)]
        };
        let plans = plan(&[layer(Vec::new()), layer(islands())], Point2::default(), &s);
        let speeds: Vec<_> = plans[1].extrusions.iter().map(|e| e.speed).collect();
        assert_eq!(speeds, [15.0, 33.0]);
    }

    #[test]
    fn reused_buffers_change_nothing() {
        let s = Settings::default();
        let layers: Vec<_> = (0..20)
            .map(|k| {
                let ring = |i: i32| circle(i * 9_000_000, 0, 4_000_000 - k * 50_000, 40, 0.0);
                layer((0..40 - k).map(|i| walls(vec![(ring(i), 0, false)])).collect())
            })
            .collect();
        let mut planner = Planner::new(Point2::default(), &s);
        let mut out = LayerPlan::default();
        for (layer, whole) in layers.iter().zip(plan(&layers, Point2::default(), &s)) {
            planner.layer(layer, &mut out);
            assert_eq!(out, whole);
        }
    }
}
