//! The order of everything on a layer.

use super::bead::{self, Start};
use super::loops::nests;
use super::nearest::NearestSet;
use super::seam::{Loop, Seam, SeamPlacer, nearest_on};
use super::sheet::{Buffers, Sheet};
use super::speed::Lines;
use super::{LayerPlan, PrintIsland, PrintLayer, Role, cooling};
use crate::infill::{FillKind, FillPath};
use crate::lattice::{Point2, mm};
use crate::region::{Bead, BeadKind, Wall};
use crate::settings::{FillPattern, SeamPosition, Settings};
use crate::support::{Strand, StrandKind};
use std::ops::Range;

/// The order of infill. Bridges come before the solid lines beside them, which then hold their ends.
const FILL_ORDER: [FillKind; 5] =
    [FillKind::Sparse, FillKind::Bridge, FillKind::InternalBridge, FillKind::Solid, FillKind::TopSolid];

/// Plans layers one after the other; remembers where the nozzle is and where the seams were.
///
/// On each layer the skirt and the brim come first, then supports, and then the part, which leans on them:
/// first what is loose, then what is dense, each by nearest end.
///
/// Islands are visited by nearest neighbour; in each of them walls go from the innermost to the
/// external one (`external_perimeters_first` turns that round), nest by nest with the thin walls
/// among them, then gap fill, then the infill (or the infill first, by `infill_first`): sparse lines,
/// bridges, solid and top lines, each by nearest end. Bridges and monotonic lines keep their given
/// order and directions, because each line leans on the one before it.
#[derive(Clone, Debug)]
pub struct Planner<'a> {
    settings: &'a Settings,
    seams: SeamPlacer,
    at: Point2,
    /// Number of layers so far.
    layers: usize,
    /// Thickness of the part's layers so far \[nm\].
    heights: Vec<i32>,
    islands: NearestSet,
    ends: NearestSet,
    scratch: Scratch,
    buffers: Buffers,
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
    /// Seams of the closed thin walls of all islands, in their order.
    bead_seams: Vec<Seam>,
    /// First of each island, and one past the last of all.
    first_bead_seam: Vec<u32>,
    /// Indices of the infill lines of one kind.
    lines: Vec<u32>,
    /// Supports' strands and where they may be entered.
    entries: Vec<(u32, Point2)>,
}

impl<'a> Planner<'a> {
    /// A planner whose nozzle stands at `start` \[nm, the mesh's frame\].
    pub fn new(start: Point2, settings: &'a Settings) -> Self {
        Self {
            settings,
            seams: SeamPlacer::new(settings.perimeters.seam_position),
            at: start,
            layers: 0,
            heights: Vec::new(),
            islands: NearestSet::default(),
            ends: NearestSet::default(),
            scratch: Scratch::default(),
            buffers: Buffers::default(),
        }
    }

    /// Plans the next layer into `out`, whose content is replaced and whose buffers are reused.
    pub fn layer(&mut self, layer: &PrintLayer, out: &mut LayerPlan) {
        out.extrusions.clear();
        out.points.clear();
        (out.print_z, out.height) = (layer.z.print_z, layer.z.height);
        (out.fan, out.travel_seconds) = (0.0, 0.0);
        let index = self.layers;
        self.layers += 1;
        let is_part = !layer.is_beside();
        if is_part {
            self.heights.push(layer.z.height);
        }
        let mut buffers = std::mem::take(&mut self.buffers);
        let lines = match mm(layer.z.height) {
            height if layer.on_raft => Lines::on_raft(height, self.settings),
            height => Lines::new(height, index == 0, self.settings),
        };
        let mut sheet = Sheet::new(out, lines, self.settings, &mut buffers);
        // A draft shield closes the gap between raft and part, which the part's own lines leave.
        let skirt_lines = match layer.skirt_height {
            height if height > layer.z.height => Lines::new(mm(height), index == 0, self.settings),
            _ => lines,
        };
        for ring in &layer.skirt {
            self.at = sheet.around(ring, Role::Skirt, &skirt_lines, self.at);
        }
        for strand in layer.brim.iter() {
            self.at = sheet.strand(strand, false, &lines, self.at);
        }
        let mut scratch = std::mem::take(&mut self.scratch);
        if !layer.supports.is_empty() {
            let lines = Lines::new(mm(layer.support_height), index == 0, self.settings);
            self.supports(&layer.supports, &lines, &mut scratch.entries, &mut sheet);
        }
        self.place_seams(&layer.islands, &mut scratch);
        self.islands.fill((0..layer.islands.len()).map(|i| entry(i, &layer.islands[i], &scratch)));
        while let Some((i, _)) = self.islands.take(self.at) {
            let i = i as usize;
            let island = &layer.islands[i];
            if self.settings.infill.infill_first {
                self.fills(&island.fills, &mut scratch.lines, &mut sheet);
                self.walls(island, i, &scratch, &mut sheet);
                self.gaps(&island.beads, &mut sheet);
            } else {
                self.walls(island, i, &scratch, &mut sheet);
                self.gaps(&island.beads, &mut sheet);
                self.fills(&island.fills, &mut scratch.lines, &mut sheet);
            }
        }
        (self.scratch, self.buffers) = (scratch, buffers);
        if is_part {
            self.seams.next_layer();
        }
        cooling::cool(out, index, &self.settings.cooling);
    }

    /// Number of the layer in hand among the part's.
    fn index(&self) -> usize {
        self.heights.len().saturating_sub(1)
    }

    /// Prints supports or raft, kind by kind, by nearest end; loops are entered near one of a few corners.
    fn supports(
        &mut self,
        strands: &[Strand],
        lines: &Lines,
        entries: &mut Vec<(u32, Point2)>,
        sheet: &mut Sheet<'_>,
    ) {
        for kind in [StrandKind::Base, StrandKind::Interface, StrandKind::Brim] {
            entries.clear();
            for (i, strand) in (0..).zip(strands).filter(|(_, s)| s.kind == kind) {
                entries.extend(entry_points(strand).map(|at| (i, at)));
            }
            self.ends.fill(entries.iter().map(|e| e.1));
            while let Some((entry, _)) = self.ends.take(self.at) {
                let i = entries[entry as usize].0;
                let first = entries.partition_point(|e| e.0 < i) as u32;
                for (other, e) in (first..).zip(&entries[first as usize..]).take_while(|(_, e)| e.0 == i) {
                    self.ends.remove(other, e.1);
                }
                self.at = sheet.strand(&strands[i as usize], entry > first, lines, self.at);
            }
        }
    }

    /// Finds the nests of every island and, in the islands' given order, their seams and those of closed
    /// thin walls.
    fn place_seams(&mut self, islands: &[PrintIsland], scratch: &mut Scratch) {
        scratch.walls.clear();
        scratch.nests.clear();
        scratch.first_nest.clear();
        scratch.bead_seams.clear();
        scratch.first_bead_seam.clear();
        let late = self.settings.perimeters.seam_position == SeamPosition::Nearest;
        for island in islands {
            scratch.first_nest.push(scratch.nests.len() as u32);
            nests(&island.walls, &mut scratch.walls, &mut scratch.found);
            for nest in scratch.found.drain(..) {
                let wall = &island.walls[scratch.walls[nest.start as usize] as usize];
                let seam = if late {
                    wall.ring.first().map(|&at| Seam { edge: 0, at })
                } else {
                    self.seams.place(around(wall), self.at, self.index())
                };
                scratch.nests.extend(seam.map(|seam| (nest, seam)));
            }
            scratch.first_bead_seam.push(scratch.bead_seams.len() as u32);
            for bead in island.beads.iter().filter(|b| b.kind == BeadKind::ThinWall) {
                if let Some(ring) = bead::ring(bead) {
                    let around = Loop { ring, hole: false, overhang: &[] };
                    let seam = self.seams.place(around, self.at, self.index());
                    scratch.bead_seams.push(seam.unwrap_or(Seam { edge: 0, at: ring[0] }));
                }
            }
        }
        scratch.first_nest.push(scratch.nests.len() as u32);
        scratch.first_bead_seam.push(scratch.bead_seams.len() as u32);
    }

    /// Prints the walls of island `index`, thin ones among them.
    fn walls(&mut self, island: &PrintIsland, index: usize, scratch: &Scratch, sheet: &mut Sheet<'_>) {
        let own = scratch.first_nest[index] as usize..scratch.first_nest[index + 1] as usize;
        let nests = &scratch.nests[own];
        let mut print = |planner: &mut Self, (nest, seam): &(Range<u32>, Seam)| {
            let order = &scratch.walls[nest.start as usize..nest.end as usize];
            planner.nest(&island.walls, order, *seam, sheet);
        };
        if island.beads.is_empty() {
            if let [only] = nests {
                return print(self, only);
            }
            self.ends.fill(nests.iter().map(|n| n.1.at));
            while let Some((i, _)) = self.ends.take(self.at) {
                print(self, &nests[i as usize]);
            }
            return;
        }
        let own = scratch.first_bead_seam[index] as usize..scratch.first_bead_seam[index + 1] as usize;
        let mut seams = scratch.bead_seams[own].iter();
        let is_thin = |b: &&Bead| b.kind == BeadKind::ThinWall && b.points.len() > 1;
        let seam_of = |b| (b, bead::ring(b).and_then(|_| seams.next().copied()));
        let thin: Vec<(&Bead, Option<Seam>)> = island.beads.iter().filter(is_thin).map(seam_of).collect();
        let ends = thin.iter().flat_map(|(b, seam)| match seam {
            Some(seam) => [seam.at; 2],
            None => bead::ends(b),
        });
        self.ends.fill(nests.iter().map(|n| n.1.at).chain(ends));
        while let Some((i, _)) = self.ends.take(self.at) {
            if let Some(nest) = nests.get(i as usize) {
                let order = &scratch.walls[nest.0.start as usize..nest.0.end as usize];
                self.nest(&island.walls, order, nest.1, sheet);
            } else {
                let end = i as usize - nests.len();
                let (bead, seam) = thin[end / 2];
                let [first, last] = seam.map_or(bead::ends(bead), |s| [s.at; 2]);
                let back = end % 2 == 1;
                self.ends.remove((nests.len() + (end ^ 1)) as u32, if back { first } else { last });
                let start = match seam {
                    Some(seam) => Start::Seam(seam, sheet.gap()),
                    None if back => Start::Last,
                    None => Start::First,
                };
                self.at = sheet.bead(bead, start, self.at);
            }
        }
    }

    /// Prints gap fill, by nearest end.
    fn gaps(&mut self, beads: &[Bead], sheet: &mut Sheet<'_>) {
        if beads.is_empty() {
            return;
        }
        let is_gap = |b: &&Bead| b.kind == BeadKind::GapFill && b.points.len() > 1;
        let gaps: Vec<&Bead> = beads.iter().filter(is_gap).collect();
        self.ends.fill(gaps.iter().flat_map(|b| bead::ends(b)));
        while let Some((end, _)) = self.ends.take(self.at) {
            let bead = gaps[end as usize / 2];
            let back = end % 2 == 1;
            let [first, last] = bead::ends(bead);
            self.ends.remove(end ^ 1, if back { first } else { last });
            let start = match bead::ring(bead).and_then(|ring| nearest_on(ring, self.at)) {
                Some((seam, _)) => Start::Seam(seam, sheet.gap()),
                None if back => Start::Last,
                None => Start::First,
            };
            self.at = sheet.bead(bead, start, self.at);
        }
    }

    /// Prints an external wall and those that follow it, all starting abreast of its seam; `order`
    /// holds their indices from the external one inwards.
    fn nest(&mut self, walls: &[Wall], order: &[u32], seam: Seam, sheet: &mut Sheet<'_>) {
        let perimeters = &self.settings.perimeters;
        let seam = match order.first().map(|&w| &walls[w as usize]) {
            Some(w) if perimeters.seam_position == SeamPosition::Nearest => {
                let index = self.index();
                self.seams.place(around(w), self.at, index).unwrap_or(seam)
            }
            _ => seam,
        };
        for k in 0..order.len() {
            let k = if perimeters.external_perimeters_first { k } else { order.len() - 1 - k };
            let wall = &walls[order[k] as usize];
            let start = if k == 0 { Some(seam) } else { nearest_on(&wall.ring, seam.at).map(|s| s.0) };
            if let Some(start) = start {
                let role = Role::of_wall(wall.depth);
                self.at = sheet.closed(&wall.ring, &wall.overhang, start, role, self.at);
            }
        }
    }

    /// Prints the infill lines, kind by kind.
    fn fills(&mut self, fills: &[FillPath], own: &mut Vec<u32>, sheet: &mut Sheet<'_>) {
        if fills.is_empty() {
            return;
        }
        for kind in FILL_ORDER {
            own.clear();
            let of_kind = |i: &u32| fills[*i as usize].kind == kind && fills[*i as usize].points.len() >= 2;
            own.extend((0..fills.len() as u32).filter(of_kind));
            if own.is_empty() {
                continue;
            }
            if self.keeps_order(kind) {
                for &i in own.iter() {
                    self.fill(&fills[i as usize], false, sheet);
                }
                continue;
            }
            // Ends 2i and 2i + 1 belong to line i.
            self.ends.fill(own.iter().flat_map(|&i| line_ends(&fills[i as usize].points)));
            while let Some((end, _)) = self.ends.take(self.at) {
                let fill = &fills[own[end as usize / 2] as usize];
                let reversed = end % 2 == 1;
                let [first, last] = line_ends(&fill.points);
                self.ends.remove(end ^ 1, if reversed { first } else { last });
                self.fill(fill, reversed, sheet);
            }
        }
    }

    fn fill(&mut self, fill: &FillPath, reversed: bool, sheet: &mut Sheet<'_>) {
        let thickness = if fill.layers > 1 {
            let layers = self.heights.iter().rev().take(fill.layers as usize);
            layers.map(|h| i64::from(*h)).sum()
        } else {
            0
        };
        self.at = sheet.open(fill, reversed, thickness, self.at);
    }

    /// True when lines of a kind are printed as they were given.
    fn keeps_order(&self, kind: FillKind) -> bool {
        let monotonic = |p| matches!(p, FillPattern::Monotonic | FillPattern::MonotonicLines);
        match kind {
            FillKind::Sparse => false,
            FillKind::Solid => monotonic(self.settings.infill.bottom_fill_pattern),
            FillKind::TopSolid => monotonic(self.settings.infill.top_fill_pattern),
            FillKind::Bridge | FillKind::InternalBridge => true,
        }
    }
}

/// A wall as the seams see it.
fn around(wall: &Wall) -> Loop<'_> {
    Loop { ring: &wall.ring, hole: wall.hole, overhang: &wall.overhang }
}

/// Both ends of a line; the origin for one without points.
fn line_ends(points: &[Point2]) -> [Point2; 2] {
    [points.first(), points.last()].map(|p| p.copied().unwrap_or_default())
}

/// Most places where a closed strand may be entered.
const ENTRIES: usize = 8;

/// Where a strand may be entered: its ends, or some of its corners.
fn entry_points(strand: &Strand) -> impl Iterator<Item = Point2> {
    let n = strand.points.len();
    let count = if strand.closed { n.min(ENTRIES) } else { n.min(2) };
    let index = move |i| if strand.closed { i * n / count } else { i * (n - 1) };
    (0..count).map(move |i| strand.points[index(i)])
}

/// Where an island is likely to be entered.
fn entry(index: usize, island: &PrintIsland, scratch: &Scratch) -> Point2 {
    let first = scratch.first_nest[index] as usize;
    if first < scratch.first_nest[index + 1] as usize {
        return scratch.nests[first].1.at;
    }
    let beads = island.beads.iter().find_map(|b| b.points.first());
    let fills = || island.fills.iter().find_map(|f| f.points.first());
    beads.or_else(fills).copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Random, circle, rectangle};
    use super::super::{Role, plan};
    use super::*;
    use crate::lattice::NM_PER_MM;
    use crate::slice::planes::LayerZ;

    fn layer(islands: Vec<PrintIsland>) -> PrintLayer {
        let z = LayerZ { slice_z: 100_000, print_z: 200_000, height: 200_000 };
        PrintLayer { z, islands, ..PrintLayer::default() }
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
