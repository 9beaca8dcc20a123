//! The order of everything on a layer.

use super::loops::{Nest, cut_open, nests};
use super::nearest::NearestSet;
use super::seam::{Seam, SeamPlacer, nearest_on};
use super::speed::{Line, SMALL_PERIMETER, lines};
use super::{Extrusion, LayerPlan, PrintIsland, PrintLayer, Role, cooling, simplify};
use crate::infill::{FillKind, FillPath};
use crate::lattice::{NM_PER_MM, Point2, mm};
use crate::settings::{SeamPosition, Settings};

/// The gap at a loop's end, as a share of the nozzle's bore (PrusaSlicer's).
const SEAM_GAP: f64 = 0.15;

/// Plans layers one after the other; remembers where the nozzle is and where the seams were.
///
/// Islands are visited by nearest neighbour; in each of them walls go from the innermost to the
/// external one (`external_perimeters_first` turns that round), nest by nest, then the infill (or
/// the infill first, by `infill_first`): sparse, solid and top lines, each by nearest end.
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
    /// The nests of all islands.
    nests: Vec<(Nest, Seam)>,
    found: Vec<Nest>,
    /// First nest of each island, and one past the last of all.
    first_nest: Vec<u32>,
    used: Vec<bool>,
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
            let own = scratch.first_nest[i] as usize..scratch.first_nest[i + 1] as usize;
            let island = &layer.islands[i];
            if self.settings.infill.infill_first {
                self.fills(&island.fills, &mut scratch.used, &mut sheet);
                self.walls(island, &scratch.nests[own], &mut sheet);
            } else {
                self.walls(island, &scratch.nests[own], &mut sheet);
                self.fills(&island.fills, &mut scratch.used, &mut sheet);
            }
        }
        self.scratch = scratch;
        self.seams.next_layer();
        cooling::cool(out, self.index, &self.settings.cooling);
        self.index += 1;
    }

    /// Finds the nests of every island and, in the islands' given order, their seams.
    fn place_seams(&mut self, islands: &[PrintIsland], scratch: &mut Scratch) {
        scratch.nests.clear();
        scratch.first_nest.clear();
        let late = self.settings.perimeters.seam_position == SeamPosition::Nearest;
        for island in islands {
            scratch.first_nest.push(scratch.nests.len() as u32);
            nests(&island.walls, &mut scratch.found);
            for nest in scratch.found.drain(..) {
                let Some(wall) = nest.walls.first().and_then(|&w| island.walls.get(w as usize)) else {
                    continue;
                };
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

    fn walls(&mut self, island: &PrintIsland, nests: &[(Nest, Seam)], sheet: &mut Sheet<'_>) {
        if let [only] = nests {
            return self.nest(island, only, sheet);
        }
        self.ends.fill(nests.iter().map(|n| n.1.at));
        while let Some((i, _)) = self.ends.take(self.at) {
            self.nest(island, &nests[i as usize], sheet);
        }
    }

    /// Prints an external wall and those that follow it, all starting abreast of its seam.
    fn nest(&mut self, island: &PrintIsland, (nest, seam): &(Nest, Seam), sheet: &mut Sheet<'_>) {
        let perimeters = &self.settings.perimeters;
        let Some(external) = nest.walls.first().map(|&w| &island.walls[w as usize]) else { return };
        let seam = if perimeters.seam_position == SeamPosition::Nearest {
            self.seams.place(&external.ring, external.hole, self.at, self.index).unwrap_or(*seam)
        } else {
            *seam
        };
        for k in 0..nest.walls.len() {
            let k = if perimeters.external_perimeters_first { k } else { nest.walls.len() - 1 - k };
            let wall = &island.walls[nest.walls[k] as usize];
            let start = if k == 0 { Some(seam) } else { nearest_on(&wall.ring, seam.at).map(|s| s.0) };
            if let Some(start) = start {
                self.at = sheet.closed(&wall.ring, start, Role::of_wall(wall.depth), self.at);
            }
        }
    }

    /// Prints the infill lines, kind by kind, each kind by nearest end.
    fn fills(&mut self, fills: &[FillPath], used: &mut Vec<bool>, sheet: &mut Sheet<'_>) {
        for kind in [FillKind::Sparse, FillKind::Solid, FillKind::TopSolid] {
            let own = || fills.iter().filter(|f| f.kind == kind && f.points.len() >= 2);
            let count = own().count();
            if count == 0 {
                continue;
            }
            let paths: Vec<&[Point2]> = own().map(|f| f.points.as_slice()).collect();
            used.clear();
            used.resize(count, false);
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
            mm3_per_mm: line.mm3_per_mm,
            speed: if may_be_small && length <= SMALL_PERIMETER { line.small_speed } else { line.speed },
            length,
            retract: travel > 0.0 && travel >= self.settings.retraction.retract_before_travel,
        });
        end
    }
}
