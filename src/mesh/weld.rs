//! Triangle soup to unique vertices.
//!
//! An open-addressing table of 16-byte entries, filled in file order, so that a vertex keeps the id
//! of its first occurrence whatever the machine. Facets go through in blocks: first all their corners
//! are converted, hashed and their slots read (independent loads that overlap in the memory system),
//! then each is looked up in a warm line.

use super::frame::{Frame, Soup};
use crate::lattice::Point3;
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
const BLOCK: usize = 32;

/// Welds the facets of a soup that `frame` was measured on. At most [`super::load::FACET_LIMIT`]
/// facets.
pub(super) fn weld(soup: &impl Soup, frame: &Frame) -> Welded {
    let facets = soup.len();
    let mut table = Table::new(facets);
    let mut triangles = Vec::with_capacity(facets);
    let mut corners = [Point3::default(); 3 * BLOCK];
    let mut slots = [0usize; 3 * BLOCK];
    for from in (0..facets).step_by(BLOCK) {
        let block = BLOCK.min(facets - from);
        table.reserve(3 * block);
        let mut touched = 0;
        for i in 0..block {
            for (k, corner) in soup.facet(from + i).into_iter().enumerate() {
                let point = frame.point(corner);
                let slot = table.slot(point);
                touched ^= table.entries[slot][3];
                corners[3 * i + k] = point;
                slots[3 * i + k] = slot;
            }
        }
        black_box(touched);
        for i in 0..block {
            let t = [0, 1, 2].map(|k| table.id(corners[3 * i + k], slots[3 * i + k]));
            if t[0] != t[1] && t[1] != t[2] && t[2] != t[0] {
                triangles.push(t);
            }
        }
    }
    let collapsed = (facets - triangles.len()) as u64;
    Welded { vertices: table.vertices, triangles, collapsed }
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
    fn slot(&self, p: Point3) -> usize {
        let xy = u64::from(p.x as u32) | u64::from(p.y as u32) << 32;
        let a = xy.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let b = u64::from(p.z as u32).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        let h = (a ^ a >> 32).wrapping_add(b).wrapping_mul(0xD6E8_FEB8_6659_FD93);
        (h >> self.shift) as usize
    }

    /// The id of a point, a new one at its first occurrence.
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

fn entry(p: Point3, id: usize) -> [u32; 4] {
    [p.x as u32, p.y as u32, p.z as u32, id as u32 + 1]
}
