//! Triangle soup to unique vertices.
//!
//! An open-addressing table of 16-byte entries, filled in file order, so that a vertex keeps the id
//! of its first occurrence whatever the machine. Facets go through in batches: first all their corners
//! are converted, hashed and their slots read (independent loads that overlap in the memory system),
//! then each is looked up in a warm line.
//!
//! With several threads the file is cut into contiguous blocks, each welded on its own. A block's
//! vertices are then looked up in the blocks before it; those that are new there keep their order, so
//! the ids are again those of the first occurrence, for any number of blocks.

use super::blocks::blocks;
use super::frame::{Frame, Soup};
use crate::lattice::Point3;
use rayon::prelude::*;
use std::hint::black_box;

/// Unique vertices and the triangles between them.
#[derive(Debug, Default, PartialEq, Eq)]
pub(super) struct Welded {
    /// In order of first occurrence.
    pub(super) vertices: Vec<Point3>,
    /// In file order, without the collapsed ones.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Facets dropped because two of their corners are one vertex.
    pub(super) collapsed: u64,
}

/// Facets that are hashed ahead of their look-up.
const BATCH: usize = 32;

/// Vertices or triangles of one task while blocks are joined; any value gives the same result.
const RUN: usize = 1 << 13;

/// Welds the facets of a soup that `frame` was measured on. At most [`super::load::FACET_LIMIT`]
/// facets.
pub(super) fn weld(soup: &impl Soup, frame: &Frame) -> Welded {
    weld_in_blocks(soup, frame, blocks(soup.len()))
}

fn weld_in_blocks(soup: &impl Soup, frame: &Frame, count: usize) -> Welded {
    let facets = soup.len();
    let size = facets.div_ceil(count).max(1);
    let mut triangles = vec![[0; 3]; facets];
    let mut parts: Vec<Part> = triangles
        .par_chunks_mut(size)
        .enumerate()
        .map(|(k, out)| weld_block(soup, frame, k * size, out))
        .collect();
    let repeated: Vec<Vec<Repeated>> =
        (0..parts.len()).map(|k| repeated(&parts[..k], &parts[k].table.vertices)).collect();
    number(&parts, &repeated, triangles.chunks_mut(size));
    let mut kept = 0;
    let mut vertices = Vec::new();
    for (k, part) in parts.iter_mut().enumerate() {
        if kept < k * size {
            triangles.copy_within(k * size..k * size + part.kept, kept);
        }
        kept += part.kept;
        let own = std::mem::take(&mut part.table.vertices);
        if k == 0 {
            vertices = own;
            continue;
        }
        let mut from = 0;
        for r in &repeated[k] {
            vertices.extend_from_slice(&own[from..r.local as usize]);
            from = r.local as usize + 1;
        }
        vertices.extend_from_slice(&own[from..]);
    }
    triangles.truncate(kept);
    Welded { vertices, triangles, collapsed: (facets - kept) as u64 }
}

/// A block of facets, welded on its own: ids count from its own first vertex.
struct Part {
    table: Table,
    /// Triangles that did not collapse; they stand at the front of the block's place.
    kept: usize,
}

/// Welds as many facets as `out` has places, beginning with facet `first`.
fn weld_block(soup: &impl Soup, frame: &Frame, first: usize, out: &mut [[u32; 3]]) -> Part {
    let mut table = Table::new(out.len());
    let mut kept = 0;
    let mut corners = [Point3::default(); 3 * BATCH];
    let mut slots = [0usize; 3 * BATCH];
    for from in (0..out.len()).step_by(BATCH) {
        let batch = BATCH.min(out.len() - from);
        table.reserve(3 * batch);
        for i in 0..batch {
            for (k, corner) in soup.facet(first + from + i).into_iter().enumerate() {
                let point = frame.point(corner);
                corners[3 * i + k] = point;
                slots[3 * i + k] = table.slot(point);
            }
        }
        table.warm(&slots[..3 * batch]);
        for i in 0..batch {
            let mut t = [0; 3];
            for (k, id) in t.iter_mut().enumerate() {
                *id = table.id(corners[3 * i + k], slots[3 * i + k]);
            }
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                out[kept] = t;
                kept += 1;
            }
        }
    }
    Part { table, kept }
}

/// A vertex of a block that an earlier block has too.
#[derive(Clone, Copy)]
struct Repeated {
    /// Its id in its block.
    local: u32,
    /// The first block that has it, and its id there.
    block: u32,
    id: u32,
}

/// The vertices of a block that are in an earlier one, in ascending order.
fn repeated(earlier: &[Part], vertices: &[Point3]) -> Vec<Repeated> {
    if earlier.is_empty() {
        return Vec::new();
    }
    let runs: Vec<Vec<Repeated>> = vertices
        .par_chunks(RUN)
        .enumerate()
        .map(|(run, points)| {
            let mut all = Vec::new();
            for (batch, points) in points.chunks(BATCH).enumerate() {
                let mut found = [None; BATCH];
                for (block, part) in earlier.iter().enumerate() {
                    let mut slots = [0; BATCH];
                    for (slot, &p) in slots.iter_mut().zip(points) {
                        *slot = part.table.slot(p);
                    }
                    part.table.warm(&slots[..points.len()]);
                    for ((found, slot), &p) in found.iter_mut().zip(slots).zip(points) {
                        if found.is_none() {
                            *found = part.table.find(p, slot).map(|id| (block as u32, id));
                        }
                    }
                }
                let from = (run * RUN + batch * BATCH) as u32;
                all.extend(
                    found
                        .iter()
                        .zip(from..)
                        .filter_map(|(found, local)| found.map(|(block, id)| Repeated { local, block, id })),
                );
            }
            all
        })
        .collect();
    runs.concat()
}

/// Puts the ids of the whole in place of those of the blocks.
fn number<'a>(
    parts: &[Part],
    repeated: &[Vec<Repeated>],
    triangles: impl Iterator<Item = &'a mut [[u32; 3]]>,
) {
    let mut first = Vec::with_capacity(parts.len());
    let mut vertices = 0;
    for (part, repeated) in parts.iter().zip(repeated) {
        first.push(vertices);
        vertices += (part.table.vertices.len() - repeated.len()) as u32;
    }
    let before = |block: usize, local: u32| repeated[block].partition_point(|r| r.local < local);
    // The first block keeps its ids.
    for ((k, part), triangles) in parts.iter().enumerate().zip(triangles).skip(1) {
        let mut ids = vec![0u32; part.table.vertices.len()];
        ids.par_chunks_mut(RUN).enumerate().for_each(|(run, ids)| {
            let from = (run * RUN) as u32;
            let mut passed = before(k, from);
            for (id, local) in ids.iter_mut().zip(from..) {
                *id = match repeated[k].get(passed) {
                    Some(r) if r.local == local => {
                        passed += 1;
                        let block = r.block as usize;
                        first[block] + r.id - before(block, r.id) as u32
                    }
                    _ => first[k] + local - passed as u32,
                };
            }
        });
        triangles[..part.kept]
            .par_chunks_mut(RUN)
            .for_each(|t| t.as_flattened_mut().iter_mut().for_each(|v| *v = ids[*v as usize]));
    }
}

/// Entries are x, y, z as bits, and the vertex id plus one: zero marks a free entry, which the
/// allocator delivers without a pass over the memory.
struct Table {
    entries: Vec<[u32; 4]>,
    vertices: Vec<Point3>,
    shift: u32,
}

impl Table {
    /// Sized for a closed mesh, which has half as many vertices as facets.
    fn new(facets: usize) -> Self {
        let capacity = facets.next_power_of_two().max(256);
        let vertices = Vec::with_capacity(facets / 2 + 3);
        Self { entries: vec![[0; 4]; capacity], vertices, shift: 64 - capacity.trailing_zeros() }
    }

    /// Makes room for `more` vertices at a load of at most five eighths.
    fn reserve(&mut self, more: usize) {
        let mut capacity = self.entries.len();
        while 8 * (self.vertices.len() + more) > 5 * capacity {
            capacity *= 2;
        }
        if capacity == self.entries.len() {
            return;
        }
        self.entries = vec![[0; 4]; capacity];
        self.shift = 64 - capacity.trailing_zeros();
        for (id, &p) in self.vertices.iter().enumerate() {
            let mut slot = self.slot(p);
            while self.entries[slot][3] != 0 {
                slot = (slot + 1) & (capacity - 1);
            }
            self.entries[slot] = entry(p, id);
        }
    }

    /// Where the search for a point begins: multiplicative hashing, the high bits of the product.
    #[inline(always)]
    fn slot(&self, p: Point3) -> usize {
        let xy = u64::from(p.x as u32) | u64::from(p.y as u32) << 32;
        let a = xy.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let b = u64::from(p.z as u32).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        let h = (a ^ a >> 32).wrapping_add(b).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        // A second round, without which fine regular grids cluster.
        let h = (h ^ h >> 32).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        (h >> self.shift) as usize
    }

    /// Reads slots ahead of their look-up. A loop of its own: short enough that the processor keeps
    /// many of the loads in flight.
    #[inline(always)]
    fn warm(&self, slots: &[usize]) {
        black_box(slots.iter().fold(0, |all, &slot| all ^ self.entries[slot][3]));
    }

    /// The id of a point that is in the table.
    #[inline(always)]
    fn find(&self, p: Point3, mut slot: usize) -> Option<u32> {
        let mask = self.entries.len() - 1;
        let wanted = entry(p, 0);
        loop {
            let found = self.entries[slot & mask];
            if found[3] == 0 {
                return None;
            }
            if found[0] == wanted[0] && found[1] == wanted[1] && found[2] == wanted[2] {
                return Some(found[3] - 1);
            }
            slot += 1;
        }
    }

    /// The id of a point, a new one at its first occurrence.
    #[inline(always)]
    fn id(&mut self, p: Point3, mut slot: usize) -> u32 {
        let mask = self.entries.len() - 1;
        let wanted = entry(p, self.vertices.len());
        loop {
            let found = &mut self.entries[slot & mask];
            if found[3] == 0 {
                *found = wanted;
                self.vertices.push(p);
                return wanted[3] - 1;
            }
            if found[0] == wanted[0] && found[1] == wanted[1] && found[2] == wanted[2] {
                return found[3] - 1;
            }
            slot += 1;
        }
    }
}

#[inline(always)]
fn entry(p: Point3, id: usize) -> [u32; 4] {
    [p.x as u32, p.y as u32, p.z as u32, id as u32 + 1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::frame::measure;
    use crate::mesh::random::Random;
    use std::collections::BTreeMap;

    impl Soup for Vec<[[f32; 3]; 3]> {
        fn len(&self) -> usize {
            Vec::len(self)
        }

        fn facet(&self, index: usize) -> [[f32; 3]; 3] {
            self[index]
        }
    }

    fn naive(soup: &[[[f32; 3]; 3]], frame: &Frame) -> Welded {
        let mut ids: BTreeMap<Point3, u32> = BTreeMap::new();
        let mut welded = Welded::default();
        for facet in soup {
            let t = facet.map(|corner| {
                let p = frame.point(corner);
                let new = ids.len() as u32;
                *ids.entry(p).or_insert_with(|| {
                    welded.vertices.push(p);
                    new
                })
            });
            if t[0] == t[1] || t[1] == t[2] || t[0] == t[2] {
                welded.collapsed += 1;
            } else {
                welded.triangles.push(t);
            }
        }
        welded
    }

    #[test]
    fn agrees_with_a_naive_weld_at_every_size_and_density() {
        for (seed, facets) in [1, 2, 31, 32, 33, 64, 65, 500, 3000, 20_000].into_iter().enumerate() {
            // From nearly everything shared to nearly nothing: the latter makes the table grow.
            for range in [2, 5, 20, 1 << 20] {
                let mut random = Random(seed as u64);
                let mut corner = || [0; 3].map(|_: i32| random.below(range) as f32 * 0.01 - 0.5);
                let soup: Vec<_> = (0..facets).map(|_| [corner(), corner(), corner()]).collect();
                let frame = measure(&soup).unwrap_or(Frame { origin: [0; 3] });
                let mut expected = naive(&soup, &frame);
                for count in [1, 2, 3, 8] {
                    let welded = weld_in_blocks(&soup, &frame, count);
                    assert_eq!(welded, expected, "seed {seed}, range {range}, {count} blocks");
                }
                expected.vertices[0].x += 1;
                assert_ne!(weld(&soup, &frame), expected, "a planted fault must be seen");
            }
        }
    }

    #[test]
    fn the_number_of_threads_does_not_matter() {
        let mut random = Random(7);
        // Triangles of a strip, some of them collapsed, and every tenth one far from its neighbours.
        let soup: Vec<_> = (0..300_000)
            .map(|i| {
                let at = if i % 10 == 0 { random.below(100_000) } else { i / 3 };
                [0, 1, 2].map(|_| [(at + random.below(3)) as f32 * 0.001, 0.0, random.below(3) as f32])
            })
            .collect();
        let frame = measure(&soup).unwrap_or(Frame { origin: [0; 3] });
        let expected = naive(&soup, &frame);
        assert!(expected.collapsed > 0);
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let welded = pool.map(|pool| pool.install(|| weld(&soup, &frame)));
            assert!(welded.is_ok_and(|welded| welded == expected), "{threads} threads");
        }
    }

    #[test]
    fn regular_grids_spread_over_the_table() {
        for step in [1, 1000, 125_000, 1 << 20, 200_000] {
            for flat in [false, true] {
                let (nx, nz) = if flat { (256, 1) } else { (40, 41) };
                let mut table = Table::new(0);
                let mut steps = 0;
                for i in 0..nx * nx * nz {
                    let p = Point3::new(i % nx * step, i / nx % nx * step, i / (nx * nx) * step);
                    table.reserve(1);
                    let (first, mask) = (table.slot(p), table.entries.len() - 1);
                    steps += (first..).take_while(|slot| table.entries[slot & mask][3] != 0).count();
                    assert_eq!(table.id(p, first), i as u32);
                }
                // Random keys at the table's load of 5/16 to 5/8 take below 1.2 steps on average.
                assert!(steps < 2 * table.vertices.len(), "step {step}, flat {flat}: {steps}");
            }
        }
    }
}
