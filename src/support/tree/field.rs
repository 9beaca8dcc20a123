//! From where the plate can be reached.
//!
//! Layers are put together into slabs, a slab is divided into square cells, and each cell is one bit: a branch
//! as thin as a tip that stands in it finds a way down to the plate without leaning more than it may. A cell is
//! blocked when any of it is, so the field promises nothing that is not so.

use super::Stage;
use crate::span::Rows;
use crate::span::algebra::or;
use crate::span::morph::dilate_disc;
use rayon::prelude::*;
use std::sync::Arc;

/// Least side of a cell \[nm\].
const CELL: f64 = 300_000.0;
/// Most bits of a field: 32 MB.
const MOST_BITS: f64 = 268_435_456.0;
/// What a branch may move within a slab, in cells.
const STEP: i32 = 3;

/// The field.
pub struct Field {
    grid: Grid,
    /// Per layer its slab.
    slab: Vec<usize>,
    /// Per slab its cells, lowest first.
    free: Vec<Bits>,
}

/// The cells.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Grid {
    origin: [f64; 2],
    cell: f64,
    size: [i32; 2],
}

/// One bit per cell, rows of whole words.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Bits {
    words: Vec<u64>,
    stride: usize,
    size: [i32; 2],
}

impl Field {
    /// Looks at all layers.
    pub fn new(stage: &Stage) -> Self {
        let frame = &stage.plan.frame;
        let lean = libm::tan(stage.plan.tree.angle.clamp(0.0, 80.0).to_radians());
        let high: f64 = stage.layers.iter().map(|l| stage.units(f64::from(l.height))).sum();
        let mut low = [f64::INFINITY; 2];
        let mut most = [f64::NEG_INFINITY; 2];
        for rows in stage.keep_out.iter().filter(|r| !r.is_empty()) {
            low[1] = low[1].min(frame.t(rows.first()) as f64);
            most[1] = most[1].max(frame.t(rows.end()) as f64);
            for s in rows.spans() {
                low[0] = low[0].min(f64::from(s.start));
                most[0] = most[0].max(f64::from(s.end));
            }
        }
        if low[0] > most[0] {
            return Self {
                grid: Grid { origin: [0.0; 2], cell: 1.0, size: [0; 2] },
                slab: Vec::new(),
                free: Vec::new(),
            };
        }
        let tip = stage.units(stage.plan.tree.tip_radius);
        let grow = tip + 2.0 * stage.units(CELL);
        let extent = [most[0] - low[0] + 2.0 * grow, most[1] - low[1] + 2.0 * grow];
        // A slab is as high as a branch needs to lean over so many cells.
        let slabs =
            |cell: f64| (high * lean / (f64::from(STEP) * cell)).max(high / stage.units(2e6)).max(1.0);
        let mut cell = stage.units(CELL);
        while extent[0] / cell * (extent[1] / cell) * slabs(cell) > MOST_BITS {
            cell *= 1.25;
        }
        let size = [(extent[0] / cell).ceil() as i32 + 1, (extent[1] / cell).ceil() as i32 + 1];
        let grid = Grid { origin: [low[0] - grow, low[1] - grow], cell, size };
        let thick = (f64::from(STEP) * cell / lean.max(1e-9)).min(stage.units(2e6));
        let (mut slab, mut begun, mut number) = (Vec::new(), 0.0, 0);
        for l in stage.layers {
            let height = stage.units(f64::from(l.height));
            if begun > 0.0 && begun + height > thick {
                (begun, number) = (0.0, number + 1);
            }
            begun += height;
            slab.push(number);
        }
        let step = ((thick * lean / cell) as i32).min(STEP);
        let blocked: Vec<Bits> = (0..=number)
            .into_par_iter()
            .map(|n| {
                let own = slab.partition_point(|&s| s < n)..slab.partition_point(|&s| s <= n);
                let mut all = Rows::default();
                let mut last: Option<&Arc<Rows>> = None;
                for rows in &stage.keep_out[own] {
                    if !last.is_some_and(|l| Arc::ptr_eq(l, rows)) {
                        all = or(&all, rows);
                    }
                    last = Some(rows);
                }
                grid.touched(&dilate_disc(&all, tip as i64, |k| frame.t(k)), frame)
            })
            .collect();
        let mut free: Vec<Bits> = Vec::with_capacity(blocked.len());
        for mut blocked in blocked {
            blocked.words.iter_mut().for_each(|w| *w = !*w);
            if let Some(below) = free.last() {
                blocked.and(&below.grown(step));
            }
            free.push(blocked);
        }
        Self { grid, slab, free }
    }

    /// Whether the plate can be reached from a point of layer `i` when that is left downwards: in the slab below
    /// its own.
    pub fn leads_down(&self, i: usize, at: [f64; 2]) -> bool {
        let Some(&slab) = self.slab.get(i) else { return true };
        let Some(free) = slab.checked_sub(1).and_then(|s| self.free.get(s)) else { return true };
        let [x, y] = self.grid.cell_of(at);
        free.get(x, y)
    }

    /// The middle of the cell nearest to a point of layer `i`, at most `cells` away, that leads down; the lower
    /// row and column of equals.
    pub fn way_down(&self, i: usize, at: [f64; 2], cells: i32) -> Option<[f64; 2]> {
        let slab = *self.slab.get(i)?;
        let free = slab.checked_sub(1).and_then(|s| self.free.get(s))?;
        let [x, y] = self.grid.cell_of(at);
        let mut best: Option<(f64, [f64; 2])> = None;
        for dy in -cells..=cells {
            for dx in -cells..=cells {
                if !free.get(x + dx, y + dy) {
                    continue;
                }
                let middle = self.grid.middle(x + dx, y + dy);
                let (u, v) = (middle[0] - at[0], middle[1] - at[1]);
                let square = u * u + v * v;
                if best.is_none_or(|b| square < b.0) {
                    best = Some((square, middle));
                }
            }
        }
        best.map(|b| b.1)
    }

    /// Side of a cell \[units\].
    pub fn cell(&self) -> f64 {
        self.grid.cell
    }
}

impl Grid {
    fn cell_of(&self, at: [f64; 2]) -> [i32; 2] {
        [0, 1].map(|k| ((at[k] - self.origin[k]) / self.cell).floor().clamp(-1e6, 1e6) as i32)
    }

    fn middle(&self, x: i32, y: i32) -> [f64; 2] {
        let at = |k: usize, i: i32| self.origin[k] + (f64::from(i) + 0.5) * self.cell;
        [at(0, x), at(1, y)]
    }

    /// The cells that an area touches.
    fn touched(&self, area: &Rows, frame: &crate::span::RowFrame) -> Bits {
        let mut bits = Bits::new(self.size);
        for (k, row) in area.iter() {
            let y = self.cell_of([0.0, frame.t(k) as f64])[1];
            for s in row {
                let x = |s: i32| self.cell_of([f64::from(s), 0.0])[0];
                bits.set(x(s.start), x(s.end), y);
            }
        }
        bits
    }
}

impl Bits {
    fn new(size: [i32; 2]) -> Self {
        let stride = (size[0].max(0) as usize).div_ceil(64);
        Self { words: vec![0; stride * size[1].max(0) as usize], stride, size }
    }

    /// Cells beyond the grid are free: nothing of the part is there.
    fn get(&self, x: i32, y: i32) -> bool {
        if x < 0 || y < 0 || x >= self.size[0] || y >= self.size[1] {
            return true;
        }
        self.words[y as usize * self.stride + x as usize / 64] >> (x % 64) & 1 == 1
    }

    /// Sets cells `from..=to` of a row.
    fn set(&mut self, from: i32, to: i32, y: i32) {
        if y < 0 || y >= self.size[1] {
            return;
        }
        for x in from.max(0)..=to.min(self.size[0] - 1) {
            self.words[y as usize * self.stride + x as usize / 64] |= 1 << (x % 64);
        }
    }

    fn and(&mut self, other: &Self) {
        self.words.iter_mut().zip(&other.words).for_each(|(a, b)| *a &= b);
    }

    /// Dilation by a disc of `radius` cells; from beyond the grid all may come.
    fn grown(&self, radius: i32) -> Self {
        let mut out = Self::new(self.size);
        for dy in -radius..=radius {
            let half = i64::from(radius * radius - dy * dy).isqrt() as i32;
            for y in 0..self.size[1] {
                let to = y as usize * self.stride..(y as usize + 1) * self.stride;
                let from = y + dy;
                if from < 0 || from >= self.size[1] {
                    out.words[to].fill(u64::MAX);
                    continue;
                }
                let row = &self.words[from as usize * self.stride..(from as usize + 1) * self.stride];
                for (i, word) in out.words[to].iter_mut().enumerate() {
                    let left = i.checked_sub(1).map_or(u64::MAX, |i| row[i]);
                    let right = row.get(i + 1).copied().unwrap_or(u64::MAX);
                    let mut own = row[i];
                    for d in 1..=half {
                        own |= row[i] << d | left >> (64 - d) | row[i] >> d | right << (64 - d);
                    }
                    *word |= own;
                }
            }
        }
        out
    }
}
