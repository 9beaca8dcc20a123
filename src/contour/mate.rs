//! Which ends of open chains belong together: the nearest free one, found in a grid of buckets.

use super::chains::Piece;
use crate::lattice::Point2;

/// No mate.
pub(super) const NONE: u32 = u32::MAX;

/// How many free ends in a column of three cells are looked at. A crowd of ends within one cell has
/// no right answer, and must not take quadratic time to get a wrong one.
const LOOK_AT: usize = 64;

/// Which ends may be joined in a round.
#[derive(Clone, Copy)]
pub(super) struct Candidates {
    /// Largest gap \[nm\].
    pub(super) reach: i64,
    /// Also join starts to starts and ends to ends.
    pub(super) reversal: bool,
    /// Join two pieces only over a gap of at most their mean length.
    pub(super) relative: bool,
}

/// For each end (`2 i + side` of piece `i`; side 0 is its start) the end to join it to, or [`NONE`].
///
/// Ends choose in the order of the pieces, each the nearest free one, so the result depends on
/// nothing but the pieces. Linear in their number but for one sort.
pub(super) fn mates(pieces: &[Piece], candidates: Candidates) -> Vec<u32> {
    let mut mates = vec![NONE; 2 * pieces.len()];
    let mut grid = Grid::new(pieces, candidates);
    for id in 0..mates.len() as u32 {
        let seeks = candidates.reversal || id % 2 == 1;
        if seeks
            && mates[id as usize] == NONE
            && let Some(found) = grid.nearest(pieces, id, candidates)
        {
            mates[id as usize] = found;
            mates[found as usize] = id;
            grid.remove(id);
            grid.remove(found);
        }
    }
    mates
}

/// Ends sorted by cell; a cell is at least as wide as the reach.
struct Grid {
    shift: u32,
    /// Cell and id of each end that may be found, sorted.
    ends: Vec<((i32, i32), u32)>,
    /// Per place in `ends` a place at or behind it that may still be free: removed ends are skipped in
    /// almost constant time (path compression).
    skip: Vec<u32>,
    /// Place in `ends` of each id.
    place: Vec<u32>,
}

impl Grid {
    fn new(pieces: &[Piece], candidates: Candidates) -> Self {
        // The smallest power of two not below the reach; coordinates have 31 bits.
        let shift = (64 - (candidates.reach - 1).max(0).leading_zeros()).min(31);
        let sides = if candidates.reversal { 0..2 } else { 0..1 };
        let mut ends: Vec<_> = pieces
            .iter()
            .enumerate()
            .flat_map(|(i, piece)| {
                sides.clone().map(move |side| (cell(piece.end(side), shift), (2 * i + side) as u32))
            })
            .collect();
        ends.sort_unstable();
        let mut place = vec![NONE; 2 * pieces.len()];
        for (at, &(_, id)) in ends.iter().enumerate() {
            place[id as usize] = at as u32;
        }
        let skip = (0..=ends.len() as u32).collect();
        Self { shift, ends, skip, place }
    }

    fn remove(&mut self, id: u32) {
        let at = self.place[id as usize];
        if at != NONE {
            self.skip[at as usize] = at + 1;
        }
    }

    /// The first free place at or behind `at`.
    fn free(&mut self, mut at: usize) -> usize {
        while self.skip[at] as usize != at {
            let next = self.skip[at] as usize;
            self.skip[at] = self.skip[next];
            at = next;
        }
        at
    }

    /// The nearest free end that `id` may be joined to; a piece's own other end wins a tie, then the
    /// smallest id.
    fn nearest(&mut self, pieces: &[Piece], id: u32, candidates: Candidates) -> Option<u32> {
        let own = &pieces[id as usize / 2];
        let from = own.end(id as usize % 2);
        let (cx, cy) = cell(from, self.shift);
        let mut best: Option<(i64, bool, u32)> = None;
        for x in cx - 1..=cx + 1 {
            let begin = self.ends.partition_point(|e| e.0 < (x, cy - 1));
            let end = self.ends.partition_point(|e| e.0 <= (x, cy + 1));
            let mut at = self.free(begin);
            for _ in 0..LOOK_AT {
                if at >= end {
                    break;
                }
                let other = self.ends[at].1;
                if other != id {
                    let piece = &pieces[other as usize / 2];
                    let (dx, dy) = piece.end(other as usize % 2).minus(from);
                    let square = dx * dx + dy * dy;
                    let same = other / 2 == id / 2;
                    let gap = (square as f64).sqrt();
                    let fits = if same {
                        gap <= 0.5 * own.length
                    } else {
                        !candidates.relative || gap <= 0.5 * (own.length + piece.length)
                    };
                    let rank = (square, !same, other);
                    // Beyond the lattice's diagonal, and the square still fits.
                    let reach = candidates.reach.min(3_037_000_499);
                    if fits && square <= reach * reach && best.is_none_or(|b| rank < b) {
                        best = Some(rank);
                    }
                }
                at = self.free(at + 1);
            }
        }
        best.map(|(_, _, other)| other)
    }
}

/// The grid cell of a point.
fn cell(p: Point2, shift: u32) -> (i32, i32) {
    (p.x >> shift, p.y >> shift)
}
