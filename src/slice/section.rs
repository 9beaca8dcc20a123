//! Mesh × a run of ascending planes → the directed edges of each section, without links.
//!
//! What fills areas row by row needs no contours, so no adjacency either. Between its lowest, middle
//! and highest vertex a triangle is two slabs; the same two edges bound a slab on all its planes. Slabs
//! are kept with the slopes of their edges while planes pass through them.

use super::chunk::{self, PlaneSearch};
use super::crossing::{exact_point, moved};
use crate::lattice::{Point2, Point3};
use crate::mesh::Mesh;
use rayon::prelude::*;
use std::ops::Range;
use thiserror::Error;

/// Why a mesh cannot be cut by a list of planes.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum SectionError {
    /// A triangle names a vertex that does not exist.
    #[error("triangle {triangle} has vertex {vertex}, but there are only {vertices}")]
    Vertex {
        /// Index of the triangle.
        triangle: usize,
        /// Its vertex id.
        vertex: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// More triangles or planes than 31-bit ids can name.
    #[error("{what} exceed 2^31; split the model")]
    TooMany {
        /// What there are too many of.
        what: &'static str,
    },
    /// The planes are not in ascending order.
    #[error("plane {index} lies below the one before it; sort the planes")]
    Order {
        /// Index of the plane.
        index: usize,
    },
}

/// A mesh and planes, cut into runs of planes of about equal work that can be swept independently.
#[derive(Debug)]
pub struct Sections<'a> {
    mesh: &'a Mesh,
    planes: &'a [i32],
    runs: Vec<Range<usize>>,
    /// Per run the slabs that meet it, in blocks.
    slabs: Vec<Vec<Vec<Slab>>>,
    /// Per plane whether its section may differ from the one before.
    changes: Vec<bool>,
}

/// The section of one plane.
#[derive(Clone, Copy, Debug)]
pub struct Section<'s> {
    /// Index of the plane.
    pub plane: usize,
    /// The edges \[nm, mesh frame\] in no particular order, solid on their left: from where the triangle's
    /// edge that goes down crosses the plane to where the one that goes up does, both as by
    /// [`super::crossing::point`].
    pub edges: &'s [[Point2; 2]],
    /// The section covers the same area as that of the plane before, on every row along x, y or a
    /// diagonal; `edges` are then that plane's. Known without looking at any edge: no triangle begins or
    /// ends between the two, and all that meet them stand upright along x or y without a gap. Never set
    /// on a run's first plane.
    pub unchanged: bool,
}

/// Half of a triangle: the part below or above its middle vertex, on the planes `from..to`.
#[derive(Clone, Copy, Debug)]
struct Slab {
    triangle: u32,
    from: u32,
    to: u32,
}

impl<'a> Sections<'a> {
    /// Prepares to cut a mesh by ascending planes \[nm, mesh frame\], in about that many runs.
    ///
    /// # Errors
    /// [`SectionError`] when mesh and planes do not fit together.
    pub fn new(mesh: &'a Mesh, planes: &'a [i32], runs: usize) -> Result<Self, SectionError> {
        for (what, n) in [("triangles", mesh.triangles.len()), ("planes", planes.len())] {
            if n >= 1 << 31 {
                return Err(SectionError::TooMany { what });
            }
        }
        if let Some(i) = planes.windows(2).position(|w| w[0] > w[1]) {
            return Err(SectionError::Order { index: i + 1 });
        }
        let search = PlaneSearch::new(planes);
        let level: Vec<u32> =
            mesh.vertices.par_iter().with_min_len(1 << 12).map(|v| search.at_or_below(v.z)).collect();
        // Every block counts all planes: no more blocks than pay for that.
        let block =
            (mesh.triangles.len() / (4 * rayon::current_num_threads())).max(1 << 14).max(planes.len());
        let blocks: Vec<Block> = mesh
            .triangles
            .par_chunks(block)
            .enumerate()
            .map(|(b, triangles)| Block::new(mesh, &level, planes.len(), b * block, triangles))
            .collect::<Result<_, _>>()?;
        let (mut weight, mut changes) = (Vec::with_capacity(planes.len()), Vec::with_capacity(planes.len()));
        let (mut count, mut moving, mut open) = (0u64, 0u64, 0u64);
        for k in 0..planes.len() {
            let mut changed = false;
            for step in blocks.iter().filter_map(|b| b.steps.get(k)) {
                count = count.wrapping_add(step.count);
                moving = moving.wrapping_add(step.moving);
                open = open.wrapping_add(step.open);
                changed |= step.changes;
            }
            changed |= moving != 0 || open != 0;
            changes.push(changed);
            weight.push(if changed { count } else { 0 });
        }
        // What follows has a price per plane too.
        let total: u64 = weight.iter().sum();
        let least = total / (4 * planes.len().max(1) as u64) + 1;
        weight.iter_mut().for_each(|w| *w += least);
        let total: u64 = weight.iter().sum();
        let runs = chunk::runs(&weight, total.div_ceil(runs.max(1) as u64));
        let slabs = blocks.into_iter().map(|b| b.slabs).collect();
        let slabs = chunk::by_run(slabs, planes.len(), &runs, |slab: &Slab| slab.from..slab.to);
        Ok(Self { mesh, planes, runs, slabs, changes })
    }

    /// The runs: all planes in order.
    pub fn runs(&self) -> &[Range<usize>] {
        &self.runs
    }

    /// Begins the sweep of a run; nothing for a run that does not exist.
    pub fn sweep(&self, run: usize) -> Sweep<'_> {
        let planes = self.runs.get(run).cloned().unwrap_or(0..0);
        let lists = self.slabs.get(run).map_or(&[][..], |lists| lists);
        Sweep::new(self, planes, lists)
    }
}

/// What a block of triangles has to do with the planes.
struct Block {
    slabs: Vec<Slab>,
    steps: Vec<Step>,
}

/// Changes from the plane before; sums wrap.
#[derive(Clone, Copy, Default)]
struct Step {
    /// Slabs.
    count: u64,
    /// Slabs that do not stand upright along x or y.
    moving: u64,
    /// Sum over the slabs that do: a hash of the sloping edge by which the section enters, minus that of
    /// the one by which it leaves. Where none has a gap the sum is zero; otherwise it is so for one in
    /// 2^64.
    open: u64,
    /// A slab begins or ends.
    changes: bool,
}

impl Block {
    fn new(
        mesh: &Mesh,
        level: &[u32],
        planes: usize,
        first: usize,
        triangles: &[[u32; 3]],
    ) -> Result<Self, SectionError> {
        let mut block =
            Self { slabs: Vec::with_capacity(2 * triangles.len()), steps: vec![Step::default(); planes + 1] };
        for (t, corners) in (first..).zip(triangles) {
            let [a, b, c] = *corners;
            let get = |v: u32| level.get(v as usize).copied();
            let (Some(a), Some(b), Some(c)) = (get(a), get(b), get(c)) else {
                let vertex = corners[0].max(corners[1]).max(corners[2]);
                return Err(SectionError::Vertex { triangle: t, vertex, vertices: level.len() });
            };
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let middle = a.max(b).min(a.min(b).max(c));
            for (from, to) in [(low, middle), (middle, high)] {
                if from < to {
                    block.push(mesh, level, Slab { triangle: t as u32, from, to });
                }
            }
        }
        Ok(block)
    }

    #[inline(always)]
    fn push(&mut self, mesh: &Mesh, level: &[u32], slab: Slab) {
        self.slabs.push(slab);
        let (moving, open) = if slab.to - slab.from > 1 { upright(mesh, level, slab) } else { (0, 0) };
        let from = &mut self.steps[slab.from as usize];
        from.count = from.count.wrapping_add(1);
        from.moving = from.moving.wrapping_add(moving);
        from.open = from.open.wrapping_add(open);
        from.changes = true;
        let to = &mut self.steps[slab.to as usize];
        to.count = to.count.wrapping_sub(1);
        to.moving = to.moving.wrapping_sub(moving);
        to.open = to.open.wrapping_sub(open);
        to.changes = true;
    }
}

/// What a slab adds to [`Step::moving`] and [`Step::open`].
fn upright(mesh: &Mesh, level: &[u32], slab: Slab) -> (u64, u64) {
    let ids = mesh.triangles[slab.triangle as usize];
    let corner = ids.map(|v| mesh.vertices[v as usize]);
    let along = |get: fn(Point3) -> i32| get(corner[0]) == get(corner[1]) && get(corner[1]) == get(corner[2]);
    if !along(|p| p.x) && !along(|p| p.y) {
        return (1, 0);
    }
    let above = ids.map(|v| level[v as usize] > slab.from);
    let (down, up) = down_up(above);
    // Edges that stand upright do not move.
    let hash = |i: usize| {
        let (a, b) = (i, NEXT[i]);
        let upright = corner[a].xy() == corner[b].xy();
        if upright { 0 } else { mix(u64::from(ids[a].min(ids[b])) << 32 | u64::from(ids[a].max(ids[b]))) }
    };
    (0, hash(down).wrapping_sub(hash(up)))
}

/// Steele, Lea and Flood, "Fast splittable pseudorandom number generators" (2014).
fn mix(mut x: u64) -> u64 {
    x = (x ^ x >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ x >> 31
}

/// The corner behind a corner.
const NEXT: [usize; 3] = [1, 2, 0];

/// [`super::crossing::down_up`] without a jump that depends on the data, from which corners lie above.
#[inline(always)]
fn down_up(above: [bool; 3]) -> (usize, usize) {
    const DOWN: [u8; 8] = [0, 0, 1, 1, 2, 0, 2, 0];
    const UP: [u8; 8] = [0, 2, 0, 2, 1, 1, 0, 0];
    let set = usize::from(above[0]) | usize::from(above[1]) << 1 | usize::from(above[2]) << 2;
    (DOWN[set].into(), UP[set].into())
}

/// A sweep over a run of planes.
#[derive(Debug)]
pub struct Sweep<'a> {
    sections: &'a Sections<'a>,
    run: Range<usize>,
    /// The next plane.
    next: usize,
    /// Slabs sorted by the plane of the run where they begin.
    waiting: Vec<Waiting>,
    /// Per plane the end of its slabs.
    begun: Vec<u32>,
    /// The slabs that meet the last plane.
    active: Vec<Active>,
    edges: Vec<[Point2; 2]>,
}

/// A slab that planes have yet to meet.
#[derive(Clone, Copy, Debug, Default)]
struct Waiting {
    /// Its triangle's vertices.
    ids: [u32; 3],
    to: u32,
}

/// A slab that planes pass through: start and end of its section as x, y, x, y.
#[derive(Clone, Copy, Debug)]
struct Active {
    /// dx/dz and dy/dz.
    slope: [f64; 4],
    /// Of the lower vertices.
    low: [i32; 4],
    low_z: [i32; 2],
    to: u32,
    /// Where it waited.
    slab: u32,
}

impl<'a> Sweep<'a> {
    fn new(sections: &'a Sections<'a>, run: Range<usize>, lists: &[Vec<Slab>]) -> Self {
        let from = run.start as u32;
        let slabs = || lists.iter().flatten();
        let place = |slab: &Slab| (slab.from.max(from) - from) as usize;
        let mut begun = vec![0u32; run.len() + 1];
        for slab in slabs() {
            begun[place(slab) + 1] += 1;
        }
        for k in 1..begun.len() {
            begun[k] += begun[k - 1];
        }
        let mut waiting = vec![Waiting::default(); begun.last().map_or(0, |&n| n as usize)];
        for slab in slabs() {
            let cursor = &mut begun[place(slab)];
            let ids = sections.mesh.triangles[slab.triangle as usize];
            waiting[*cursor as usize] = Waiting { ids, to: slab.to };
            *cursor += 1;
        }
        Self { sections, next: run.start, run, waiting, begun, active: Vec::new(), edges: Vec::new() }
    }

    /// The section of the next plane; `None` behind the run's last.
    pub fn next_section(&mut self) -> Option<Section<'_>> {
        let k = self.next;
        if k >= self.run.end {
            return None;
        }
        self.next += 1;
        let unchanged = k > self.run.start && !self.sections.changes[k];
        if !unchanged {
            self.begin(k);
            self.cut(k);
        }
        Some(Section { plane: k, edges: &self.edges, unchanged })
    }

    /// Prepares the slabs that begin at a plane.
    fn begin(&mut self, k: usize) {
        let here = k - self.run.start;
        let from = if here == 0 { 0 } else { self.begun[here - 1] };
        let z = self.sections.planes[k];
        let mesh = self.sections.mesh;
        let waiting = self.waiting.get(from as usize..self.begun[here] as usize).unwrap_or_default();
        self.active.reserve(waiting.len());
        for (i, slab) in (from..).zip(waiting) {
            self.active.push(Active::new(corners(mesh, slab.ids), z, i, slab.to));
        }
    }

    /// Computes the section, and leaves out the slabs that have ended.
    fn cut(&mut self, k: usize) {
        let z = self.sections.planes[k];
        self.edges.clear();
        self.edges.reserve(self.active.len());
        let mut i = 0;
        while let Some(slab) = self.active.get(i) {
            if slab.to as usize <= k {
                self.active.swap_remove(i);
                continue;
            }
            let (edge, certain) = slab.cut(z);
            self.edges.push(if certain {
                edge
            } else {
                exact(self.sections.mesh, self.waiting[slab.slab as usize].ids, z)
            });
            i += 1;
        }
    }
}

// Written out below: as maps over arrays these few lines take twice the time.

#[inline(always)]
fn corners(mesh: &Mesh, [a, b, c]: [u32; 3]) -> [Point3; 3] {
    [mesh.vertices[a as usize], mesh.vertices[b as usize], mesh.vertices[c as usize]]
}

#[inline(always)]
fn above(corner: &[Point3; 3], z: i32) -> [bool; 3] {
    [corner[0].z >= z, corner[1].z >= z, corner[2].z >= z]
}

impl Active {
    #[inline(always)]
    fn new(corner: [Point3; 3], z: i32, slab: u32, to: u32) -> Self {
        let (down, up) = down_up(above(&corner, z));
        let (start, start_high) = (corner[NEXT[down]], corner[down]);
        let (end, end_high) = (corner[up], corner[NEXT[up]]);
        // Below 2^31, as coordinates are below 2^30.
        let difference = |to: i32, from: i32| f64::from(to.wrapping_sub(from));
        let start_inverse = 1.0 / difference(start_high.z, start.z);
        let end_inverse = 1.0 / difference(end_high.z, end.z);
        Self {
            slope: [
                difference(start_high.x, start.x) * start_inverse,
                difference(start_high.y, start.y) * start_inverse,
                difference(end_high.x, end.x) * end_inverse,
                difference(end_high.y, end.y) * end_inverse,
            ],
            low: [start.x, start.y, end.x, end.y],
            low_z: [start.z, end.z],
            to,
            slab,
        }
    }

    /// The section, and whether it is certain. Three roundings of a value below 2^31 err by less than
    /// 2^-20, which [`moved`] allows for.
    #[inline(always)]
    fn cut(&self, z: i32) -> ([Point2; 2], bool) {
        let start_rise = f64::from(z.wrapping_sub(self.low_z[0]));
        let end_rise = f64::from(z.wrapping_sub(self.low_z[1]));
        let (x0, certain_x0) = moved(self.low[0], self.slope[0] * start_rise);
        let (y0, certain_y0) = moved(self.low[1], self.slope[1] * start_rise);
        let (x1, certain_x1) = moved(self.low[2], self.slope[2] * end_rise);
        let (y1, certain_y1) = moved(self.low[3], self.slope[3] * end_rise);
        let certain = certain_x0 & certain_y0 & certain_x1 & certain_y1;
        ([Point2::new(x0, y0), Point2::new(x1, y1)], certain)
    }
}

#[cold]
fn exact(mesh: &Mesh, ids: [u32; 3], z: i32) -> [Point2; 2] {
    let corner = corners(mesh, ids);
    let (down, up) = down_up(above(&corner, z));
    [exact_point(corner[NEXT[down]], corner[down], z), exact_point(corner[up], corner[NEXT[up]], z)]
}
