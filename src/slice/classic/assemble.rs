//! Contours from segments alone: equal end points, found in a hash table.
//!
//! The second half of Minetto et al. (2017), expected time linear in the segments. It needs no
//! adjacency, but a table of end points costs more than the slicing, and where contours touch in a point
//! it cannot know which of them goes where: the rings then differ from those of the links, though never
//! the area that they enclose.

use super::Segment;
use crate::lattice::Point2;

/// The contours of one plane.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Assembled {
    /// Closed ones \[nm\]; the first point is not repeated.
    pub rings: Vec<Vec<Point2>>,
    /// Open ones \[nm\], where the mesh has holes.
    pub chains: Vec<Vec<Point2>>,
}

/// Joins the segments of each plane. Zero-length segments are left out, as in the paper.
pub fn assemble(layers: &[Vec<Segment>]) -> Vec<Assembled> {
    let mut table = Table::default();
    layers.iter().map(|segments| plane(segments, &mut table)).collect()
}

fn plane(segments: &[Segment], table: &mut Table) -> Assembled {
    table.fill(segments);
    let mut out = Assembled::default();
    // Chains from their heads, so that none is entered in its middle; all that is left is closed.
    for (from, segment) in segments.iter().enumerate() {
        if segment.start != segment.end && table.is_head(from) {
            let (points, end) = follow(segments, table, from, None);
            if end == segment.start { &mut out.rings } else { &mut out.chains }.push(points);
        }
    }
    for (from, segment) in segments.iter().enumerate() {
        if segment.start != segment.end && !table.taken[from] {
            out.rings.push(follow(segments, table, from, Some(segment.start)).0);
        }
    }
    out
}

/// The points from a segment on until `stop`, or until no segment goes on; and the point that ended it,
/// which is among the points unless it is the first one again.
fn follow(
    segments: &[Segment],
    table: &mut Table,
    from: usize,
    stop: Option<Point2>,
) -> (Vec<Point2>, Point2) {
    table.taken[from] = true;
    let first = segments[from].start;
    let mut points = vec![first];
    let mut at = segments[from].end;
    while Some(at) != stop {
        let next = table.take_from(at);
        if next.is_some() || at != first {
            points.push(at);
        }
        match next {
            Some(next) => at = segments[next].end,
            None => break,
        }
    }
    (points, at)
}

/// No segment.
const NONE: u32 = u32::MAX;

/// An end point of segments.
#[derive(Clone, Copy)]
struct Entry {
    point: Point2,
    /// The first of the segments that begin here; [`NONE`] with `used` false marks a free entry.
    head: u32,
    /// Segments that begin here minus those that end here.
    surplus: i32,
    used: bool,
}

/// A table of end points with linear probing (Knuth, The Art of Computer Programming 3, 6.4).
#[derive(Default)]
struct Table {
    entries: Vec<Entry>,
    /// Per segment the next one that begins at the same point.
    same: Vec<u32>,
    taken: Vec<bool>,
    /// Per segment the entry of its start.
    start: Vec<u32>,
}

impl Table {
    fn fill(&mut self, segments: &[Segment]) {
        let capacity = (2 * segments.len()).next_power_of_two().max(2);
        let free = Entry { point: Point2::default(), head: NONE, surplus: 0, used: false };
        self.entries.clear();
        self.entries.resize(capacity, free);
        self.same.clear();
        self.same.resize(segments.len(), NONE);
        self.taken.clear();
        self.taken.resize(segments.len(), false);
        self.start.clear();
        self.start.resize(segments.len(), 0);
        // From the last to the first, so that a list begins with its first segment.
        for (i, segment) in segments.iter().enumerate().rev().filter(|(_, s)| s.start != s.end) {
            let start = self.place(segment.start);
            self.same[i] = self.entries[start].head;
            self.start[i] = start as u32;
            self.entries[start].head = i as u32;
            self.entries[start].surplus += 1;
            let end = self.place(segment.end);
            self.entries[end].surplus -= 1;
        }
    }

    /// The entry of a point, made if need be. At most half of the table is in use on closed contours,
    /// and never all of it.
    fn place(&mut self, point: Point2) -> usize {
        let mask = self.entries.len() - 1;
        let key = u64::from(point.x as u32) << 32 | u64::from(point.y as u32);
        let mixed = (key ^ key >> 29).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mut at = (mixed >> 32) as usize & mask;
        while self.entries[at].used && self.entries[at].point != point {
            at = (at + 1) & mask;
        }
        self.entries[at].point = point;
        self.entries[at].used = true;
        at
    }

    /// Whether a chain begins with this segment; each surplus is the head of one.
    fn is_head(&mut self, segment: usize) -> bool {
        let entry = &mut self.entries[self.start[segment] as usize];
        let head = entry.surplus > 0 && !self.taken[segment];
        entry.surplus -= i32::from(head);
        head
    }

    /// Takes a segment that begins at a point.
    fn take_from(&mut self, point: Point2) -> Option<usize> {
        let at = self.place(point);
        let entry = &mut self.entries[at];
        while entry.head != NONE {
            let segment = entry.head as usize;
            entry.head = self.same[segment];
            if !std::mem::replace(&mut self.taken[segment], true) {
                return Some(segment);
            }
        }
        None
    }
}
