//! A run of planes on a mesh whose triangles span few of them: all segments first, plane by plane.
//!
//! One pass over the triangles in their order puts each segment in its plane's list; reads run
//! forward through the mesh and no read waits for another. The links are then followed within one
//! plane's list, which the cache holds.

use super::finish::Finish;
use super::spans::Span;
use super::surface::Surface;
use super::walk::Plane;
use crate::lattice::{Point2, Point3};
use crate::mesh::OPEN;
use crate::slice::crossing;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;

/// The segments of a run of planes, plane by plane.
pub(super) struct Layered<'a> {
    surface: Surface<'a>,
    planes: &'a [i32],
    run: Range<usize>,
    /// Per plane of the run its first piece; one more entry than planes.
    base: Vec<usize>,
    /// Each a [`Piece`].
    pieces: Vec<[u32; 4]>,
    /// Per triangle the place of its piece on the plane in hand.
    place: Vec<u32>,
    plane: Plane,
}

/// A segment.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Piece {
    start: Point2,
    triangle: u32,
    /// The triangle in which the contour goes on; beyond all ids at an open edge.
    next: u32,
}

/// Segments read before they are computed.
const BLOCK: usize = 64;

/// A segment about to be computed.
#[derive(Clone, Copy, Default)]
struct Cut {
    /// The edge by which the contour enters the triangle.
    low: Point3,
    high: Point3,
    z: i32,
    triangle: u32,
    /// The half-edge behind the one by which the contour leaves.
    next: u32,
    /// Where the segment goes.
    piece: usize,
}

impl<'a> Layered<'a> {
    /// Bytes that each segment of the run takes.
    pub(super) const SEGMENT_BYTES: u64 = size_of::<Piece>() as u64;

    /// `lists` hold the spans that meet the run, and maybe others; `place` has a word per triangle, of
    /// any content.
    pub(super) fn new(
        surface: Surface<'a>,
        planes: &'a [i32],
        lists: &[Vec<Span>],
        run: Range<usize>,
        place: Vec<u32>,
    ) -> Self {
        let (from, to) = (run.start as u32, run.end as u32);
        let mut base = vec![0usize; run.len() + 1];
        for span in lists.iter().flatten().filter(|s| s.meets(&run)) {
            // Steps up and down, summed below; wrapping, as a sum may pass below zero on its way.
            let (first, end) = (span.first.max(from) - from, span.end.min(to) - from);
            base[first as usize] = base[first as usize].wrapping_add(1);
            base[end as usize] = base[end as usize].wrapping_sub(1);
        }
        let (mut count, mut total) = (0usize, 0usize);
        for b in &mut base {
            count = count.wrapping_add(*b);
            *b = total;
            total += count;
        }
        // Memory that the system hands out as zeros is not written twice; this type asks for it.
        let mut pieces = vec![[0u32; 4]; total];
        let filling: &mut [Piece] = bytemuck::cast_slice_mut(&mut pieces);
        let mut cursor = base.clone();
        // Block by block: first all reads, which then do not wait for the arithmetic.
        let mut block = [Cut::default(); BLOCK];
        let mut filled = 0;
        for span in lists.iter().flatten().filter(|s| s.meets(&run)) {
            // Written out: as maps over arrays these few lines take twice the time.
            let t = span.triangle as usize;
            let (Some(&[a, b, c]), Some(&[ab, bc, ca])) =
                (surface.corners.as_chunks().0.get(t), surface.twin.as_chunks().0.get(t))
            else {
                continue;
            };
            let vertices = surface.vertices;
            let corner = [vertices[a as usize], vertices[b as usize], vertices[c as usize]];
            let twin = [ab, bc, ca];
            for k in span.first.max(from)..span.end.min(to) {
                let z = planes[k as usize];
                let (down, up) = down_up(corner[0].z, corner[1].z, corner[2].z, z);
                let cursor = &mut cursor[(k - from) as usize];
                block[filled] = Cut {
                    low: corner[NEXT[down]],
                    high: corner[down],
                    z,
                    triangle: span.triangle,
                    next: twin[up],
                    piece: *cursor,
                };
                *cursor += 1;
                filled += 1;
                if filled == BLOCK {
                    cut(&block, filling);
                    filled = 0;
                }
            }
        }
        cut(&block[..filled], filling);
        Self { surface, planes, run, base, pieces, place, plane: Plane::default() }
    }

    /// Gives the words back.
    pub(super) fn into_words(self) -> Vec<u32> {
        self.place
    }

    /// Hands the contours of plane `k` to `finish`.
    pub(super) fn plane(&mut self, k: usize, finish: &mut Finish<'_>) {
        let here = k - self.run.start;
        let pieces: &[Piece] = bytemuck::cast_slice(&self.pieces[self.base[here]..self.base[here + 1]]);
        for (i, piece) in pieces.iter().enumerate() {
            self.place[piece.triangle as usize] = i as u32;
        }
        // What other planes left in the table is told by the triangle.
        let next = |piece: &Piece| match self.place.get(piece.next as usize) {
            Some(&i) if pieces.get(i as usize).is_some_and(|p| p.triangle == piece.next) => i,
            _ => OPEN,
        };
        self.plane.fill(pieces.iter().map(|p| p.start), pieces.iter().map(next));
        let (surface, z) = (self.surface, self.planes[k]);
        self.plane.walk(finish, |i| {
            let t = pieces[i].triangle as usize;
            let corner = [0, 1, 2].map(|i| surface.corner(3 * t + i));
            let (_, up) = crossing::down_up(corner.map(|c| c.z), z);
            Some(crossing::point(corner[up], corner[(up + 1) % 3], z))
        });
    }
}

/// Computes a block of segments.
fn cut(block: &[Cut], pieces: &mut [Piece]) {
    for cut in block {
        if let Some(piece) = pieces.get_mut(cut.piece) {
            let start = crossing::point_between(cut.low, cut.high, cut.z);
            *piece = Piece { start, triangle: cut.triangle, next: cut.next / 3 };
        }
    }
}

/// The corner behind a corner.
const NEXT: [usize; 3] = [1, 2, 0];

/// [`crossing::down_up`] without a jump that depends on the data.
#[inline(always)]
fn down_up(a: i32, b: i32, c: i32, z: i32) -> (usize, usize) {
    // By the set of corners above the plane, one bit each.
    const DOWN: [u8; 8] = [0, 0, 1, 1, 2, 0, 2, 0];
    const UP: [u8; 8] = [0, 2, 0, 2, 1, 1, 0, 0];
    let (a, b, c) = (usize::from(a >= z), usize::from(b >= z), usize::from(c >= z));
    let above = a | b << 1 | c << 2;
    (DOWN[above].into(), UP[above].into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_that_of_the_rule() {
        for bits in 1..7 {
            let corner_z = [0, 1, 2].map(|i| if bits >> i & 1 == 1 { 5 } else { -5 });
            let [a, b, c] = corner_z;
            assert_eq!(down_up(a, b, c, 0), crossing::down_up(corner_z, 0), "{corner_z:?}");
        }
    }
}
