//! Triangle soup to unique vertices.
//!
//! One pass over the facets measures their bounds and welds them. Until the bounds are known,
//! coordinates are kept modulo 2^32 nm, in which no two points of a part fall together.
//!
//! An open-addressing table of vertex ids, filled in file order, so that a vertex keeps the id
//! of its first occurrence whatever the machine. The bits that an id leaves free hold some of the hash,
//! so that hardly any other vertex than the right one is looked at. Facets go through in batches: first
//! all their corners are converted, hashed and their slots read (independent loads that overlap in the
//! memory system), then each is looked up in a warm line.
//!
//! With several threads the file is cut into contiguous blocks, each welded on its own. A block's
//! vertices are then looked up in the blocks before it; those that are new there keep their order, so
//! the ids are again those of the first occurrence, for any number of blocks.

use super::blocks::blocks;
use super::frame::{Bounds, Fault, Frame, LANES, Soup, nm_modulo};
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

/// Facets that are hashed ahead of their look-up; their floats fill whole [`LANES`].
const BATCH: usize = 32;

/// Vertices or triangles of one task while blocks are joined; any value gives the same result.
const RUN: usize = 1 << 13;

/// Measures and welds the facets of a soup, at least one and at most [`super::load::FACET_LIMIT`].
///
/// # Errors
/// The first coordinate without a place on the lattice.
pub(super) fn weld(soup: &impl Soup) -> Result<(Welded, Frame), Fault> {
    weld_in_blocks(soup, blocks(soup.len()))
}

fn weld_in_blocks(soup: &impl Soup, count: usize) -> Result<(Welded, Frame), Fault> {
    let facets = soup.len();
    let size = facets.div_ceil(count).max(1);
    let mut triangles = vec![[0; 3]; facets];
    let mut parts: Vec<Part> =
        triangles.par_chunks_mut(size).enumerate().map(|(k, out)| weld_block(soup, k * size, out)).collect();
    let frame = parts.iter().fold(Bounds::NONE, |all, part| all.join(part.bounds)).frame(soup)?;
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
    vertices.iter_mut().for_each(|v| *v = frame.point(*v));
    Ok((Welded { vertices, triangles, collapsed: (facets - kept) as u64 }, frame))
}

/// A block of facets, welded on its own: ids count from its own first vertex.
struct Part {
    table: Table,
    /// Triangles that did not collapse; they stand at the front of the block's place.
    kept: usize,
    bounds: Bounds,
}

/// Welds as many facets as `out` has places, beginning with facet `first`.
fn weld_block(soup: &impl Soup, first: usize, out: &mut [[u32; 3]]) -> Part {
    let mut table = Table::new(out.len());
    let mut bounds = Bounds::NONE;
    let mut kept = 0;
    let mut floats = [0.0; 9 * BATCH];
    let mut corners = [Point3::default(); 3 * BATCH];
    let mut hashes = [0; 3 * BATCH];
    for from in (0..out.len()).step_by(BATCH) {
        let batch = BATCH.min(out.len() - from);
        table.reserve(3 * batch);
        for (i, facet) in floats.as_chunks_mut::<9>().0.iter_mut().enumerate() {
            // The last batch is filled up with its last facet, which moves no bounds.
            let corners = soup.facet(first + from + i.min(batch - 1));
            facet.copy_from_slice(corners.as_flattened());
        }
        floats.as_chunks::<LANES>().0.iter().for_each(|floats| bounds.add(floats));
        for (c, &v) in bytemuck::cast_slice_mut(&mut corners).iter_mut().zip(&floats) {
            *c = nm_modulo(v);
        }
        for (h, &p) in hashes.iter_mut().zip(&corners) {
            *h = hash(p);
        }
        table.warm(&hashes[..3 * batch]);
        for i in 0..batch {
            let mut t = [0; 3];
            for (k, id) in t.iter_mut().enumerate() {
                *id = table.id(corners[3 * i + k], hashes[3 * i + k]);
            }
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                out[kept] = t;
                kept += 1;
            }
        }
    }
    Part { table, kept, bounds }
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
                let mut hashes = [0; BATCH];
                for (h, &p) in hashes.iter_mut().zip(points) {
                    *h = hash(p);
                }
                for (block, part) in earlier.iter().enumerate() {
                    part.table.warm(&hashes[..points.len()]);
                    for ((found, hash), &p) in found.iter_mut().zip(hashes).zip(points) {
                        if found.is_none() {
                            *found = part.table.find(p, hash).map(|id| (block as u32, id));
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

/// Vertices by their points.
struct Table {
    /// Vertex ids in the low bits, of the hash what the others hold; [`FREE`] where there is none.
    entries: Vec<u32>,
    vertices: Vec<Point3>,
    /// The bits of an entry that are an id.
    id_mask: u32,
    shift: u32,
}

/// No entry: ids have so many bits that none is all ones. Not zero, although the allocator would deliver
/// zeros without a pass over the memory: a page that is read first and written then faults twice.
const FREE: u32 = u32::MAX;

/// Multiplicative hashing; the high bits of the product are the best.
#[inline(always)]
fn hash(p: Point3) -> u64 {
    let xy = u64::from(p.x as u32) | u64::from(p.y as u32) << 32;
    let a = xy.wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let b = u64::from(p.z as u32).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
    let h = (a ^ a >> 32).wrapping_add(b).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    // A second round, without which fine regular grids cluster.
    (h ^ h >> 32).wrapping_mul(0xD6E8_FEB8_6659_FD93)
}

impl Table {
    /// Sized for a closed mesh, which has half as many vertices as facets.
    fn new(facets: usize) -> Self {
        let capacity = facets.next_power_of_two().max(256);
        let vertices = Vec::with_capacity(facets / 2 + 3);
        // Three vertices a facet at most.
        let id_mask = (3 * facets as u64 + 1).next_power_of_two() - 1;
        let shift = 64 - capacity.trailing_zeros();
        Self { entries: vec![FREE; capacity], vertices, id_mask: id_mask as u32, shift }
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
        self.entries = vec![FREE; capacity];
        self.shift = 64 - capacity.trailing_zeros();
        for (id, &p) in self.vertices.iter().enumerate() {
            let hash = hash(p);
            let mut slot = self.slot(hash);
            while self.entries[slot] != FREE {
                slot = (slot + 1) & (capacity - 1);
            }
            self.entries[slot] = self.entry(hash, id);
        }
    }

    /// Where the search for a point begins.
    #[inline(always)]
    fn slot(&self, hash: u64) -> usize {
        (hash >> self.shift) as usize
    }

    #[inline(always)]
    fn entry(&self, hash: u64, id: usize) -> u32 {
        hash as u32 & !self.id_mask | id as u32
    }

    /// Reads slots ahead of their look-up. A loop of its own: short enough that the processor keeps
    /// many of the loads in flight.
    #[inline(always)]
    fn warm(&self, hashes: &[u64]) {
        black_box(hashes.iter().fold(0, |all, &hash| all ^ self.entries[self.slot(hash)]));
    }

    /// Whether an entry is that of a point; then its id.
    #[inline(always)]
    fn is(&self, found: u32, p: Point3, hash: u64) -> Option<u32> {
        let id = found & self.id_mask;
        let same = (found ^ hash as u32) & !self.id_mask == 0 && self.vertices[id as usize] == p;
        same.then_some(id)
    }

    /// The id of a point that is in the table.
    #[inline(always)]
    fn find(&self, p: Point3, hash: u64) -> Option<u32> {
        let mask = self.entries.len() - 1;
        let mut slot = self.slot(hash);
        loop {
            let found = self.entries[slot & mask];
            if found == FREE {
                return None;
            }
            if let Some(id) = self.is(found, p, hash) {
                return Some(id);
            }
            slot += 1;
        }
    }

    /// The id of a point, a new one at its first occurrence.
    #[inline(always)]
    fn id(&mut self, p: Point3, hash: u64) -> u32 {
        let mask = self.entries.len() - 1;
        let mut slot = self.slot(hash);
        loop {
            let found = self.entries[slot & mask];
            if found == FREE {
                let id = self.vertices.len();
                self.entries[slot & mask] = self.entry(hash, id);
                self.vertices.push(p);
                return id as u32;
            }
            if let Some(id) = self.is(found, p, hash) {
                return id;
            }
            slot += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
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

    fn naive(soup: &[[[f32; 3]; 3]]) -> Welded {
        let nm = |v: f32| (f64::from(v) * 1e6).round() as i64;
        let origin = [0, 1, 2].map(|axis| {
            let all = || soup.iter().flatten().map(|corner| nm(corner[axis]));
            let (lo, hi) = (all().min().unwrap_or(0), all().max().unwrap_or(0));
            lo + (hi - lo) / 2
        });
        let mut ids: BTreeMap<Point3, u32> = BTreeMap::new();
        let mut welded = Welded::default();
        for facet in soup {
            let t = facet.map(|corner| {
                let c = [0, 1, 2].map(|axis| (nm(corner[axis]) - origin[axis]) as i32);
                let p = Point3::new(c[0], c[1], c[2]);
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
                let mut corner = || [0; 3].map(|_: i32| random.below(range) as f32 * 0.001 - 0.5);
                let soup: Vec<_> = (0..facets).map(|_| [corner(), corner(), corner()]).collect();
                let mut expected = naive(&soup);
                for count in [1, 2, 3, 8] {
                    let welded = weld_in_blocks(&soup, count).map(|(welded, _)| welded);
                    assert_eq!(welded.as_ref(), Ok(&expected), "seed {seed}, range {range}, {count} blocks");
                }
                expected.vertices[0].x += 1;
                assert_ne!(
                    weld(&soup).map(|(welded, _)| welded),
                    Ok(expected),
                    "a planted fault must be seen"
                );
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
        let expected = naive(&soup);
        assert!(expected.collapsed > 0);
        for threads in [1, 2, 3, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
            let welded = pool.map(|pool| pool.install(|| weld(&soup)));
            assert!(welded.is_ok_and(|welded| welded.is_ok_and(|w| w.0 == expected)), "{threads} threads");
        }
    }

    #[test]
    fn regular_grids_spread_over_the_table() {
        for step in [1, 1000, 125_000, 1 << 20, 200_000] {
            for flat in [false, true] {
                let (nx, nz) = if flat { (256, 1) } else { (40, 41) };
                let mut table = Table::new(100_000);
                table.entries = vec![FREE; 256];
                table.shift = 64 - 8;
                let mut steps = 0;
                for i in 0..nx * nx * nz {
                    let p = Point3::new(i % nx * step, i / nx % nx * step, i / (nx * nx) * step);
                    table.reserve(1);
                    let (first, mask) = (table.slot(hash(p)), table.entries.len() - 1);
                    steps += (first..).take_while(|slot| table.entries[slot & mask] != FREE).count();
                    assert_eq!(table.id(p, hash(p)), i as u32);
                }
                // Random keys at the table's load of 5/16 to 5/8 take below 1.2 steps on average.
                assert!(steps < 2 * table.vertices.len(), "step {step}, flat {flat}: {steps}");
            }
        }
    }
}
