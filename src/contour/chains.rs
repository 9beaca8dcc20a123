//! Open chains of a mesh with holes: joined end to end, and what cannot be joined is reported.
//!
//! Joining goes in rounds of growing reach, so that near ends find each other first: exact matches,
//! then up to the tolerance, then, where nothing else is left, gaps that are small against the chains
//! they join. Each round first joins ends to starts and then, for flipped facets, equal ends.

use super::Ring;
use super::mate::{self, Candidates};
use crate::lattice::Point2;

/// What became of the open chains of a layer. Every chain counts once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenReport {
    /// Open chains found.
    pub chains: u32,
    /// Of these, closed over gaps within the tolerance.
    pub matched: u32,
    /// Of these, closed over a wider gap by a straight line.
    pub forced: u32,
    /// Of these, left out of the print.
    pub dropped: u32,
    /// The widest gap, bridged or left open.
    pub worst: Option<Gap>,
}

/// A gap in a contour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Gap {
    /// Distance to be bridged \[nm\].
    pub length: i64,
    /// Where it begins \[nm\], mesh frame.
    pub at: Point2,
}

/// What became of the open chains of a whole part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OpenSummary {
    /// Layers with open chains.
    pub layers: usize,
    /// Sums over all layers, and the widest gap of all.
    pub total: OpenReport,
    /// Index of the layer of the widest gap; the lowest one where several are as wide.
    pub worst_layer: usize,
}

/// Sums up the reports of all layers, given from the bottom up.
pub fn sum<'a>(reports: impl IntoIterator<Item = &'a OpenReport>) -> OpenSummary {
    let mut sum = OpenSummary::default();
    for (layer, report) in reports.into_iter().enumerate() {
        sum.layers += usize::from(report.chains > 0);
        sum.total.chains = sum.total.chains.saturating_add(report.chains);
        sum.total.matched = sum.total.matched.saturating_add(report.matched);
        sum.total.forced = sum.total.forced.saturating_add(report.forced);
        sum.total.dropped = sum.total.dropped.saturating_add(report.dropped);
        if report.worst.map(|gap| gap.length) > sum.total.worst.map(|gap| gap.length) {
            sum.total.worst = report.worst;
            sum.worst_layer = layer;
        }
    }
    sum
}

/// Joins the chains of one layer to rings; solid lies on the left of most of them.
///
/// Gaps up to `tolerance` \[nm\] are closed wherever they are; wider ones only while the chains on
/// either side are on average as long as the gap, and a chain is bent onto itself only over a gap
/// of at most half its length. A ring that joins chains of both directions takes that of the greater
/// length.
pub fn close(mut chains: Vec<Vec<Point2>>, tolerance: i64) -> (Vec<Ring>, OpenReport) {
    // The order found by the walk depends on its route; this one does not.
    chains.sort_unstable();
    let mut report = OpenReport { chains: chains.len() as u32, ..OpenReport::default() };
    let mut pieces: Vec<Piece> = chains.into_iter().map(Piece::new).collect();
    let mut rings = Vec::new();
    let tolerance = tolerance.max(0);
    let near = [0, tolerance / 64, tolerance / 16, tolerance / 4, tolerance];
    // Beyond the tolerance up to the size of the lattice.
    let far =
        std::iter::successors(Some(tolerance.max(1000) * 4), |&r| Some(r * 4)).take_while(|&r| r < 1 << 34);
    for reach in near.into_iter().chain(far) {
        for reversal in [false, true] {
            if pieces.is_empty() {
                break;
            }
            let candidates = Candidates { reach, reversal, relative: reach > tolerance };
            let mates = mate::mates(&pieces, candidates);
            pieces = join(pieces, &mates, &mut rings);
        }
    }
    let mut worst = None;
    let rings = rings
        .into_iter()
        .map(|ring| {
            worst = worst.max(ring.gap);
            let count = if ring.gap.is_none_or(|gap| gap.length <= tolerance) {
                &mut report.matched
            } else {
                &mut report.forced
            };
            *count += ring.chains;
            ring.points
        })
        .collect();
    for piece in pieces {
        report.dropped += piece.chains;
        worst = worst.max(piece.gap).max(Some(gap(piece.end(1), piece.end(0))));
    }
    report.worst = worst;
    (rings, report)
}

/// One or more chains joined so far.
pub(super) struct Piece {
    points: Vec<Point2>,
    /// Length along the chain \[nm\].
    pub(super) length: f64,
    /// Chains in it.
    chains: u32,
    /// The widest gap bridged in it.
    gap: Option<Gap>,
}

impl Piece {
    fn new(points: Vec<Point2>) -> Self {
        let length = points.windows(2).map(|w| w[0].distance(w[1])).sum();
        Self { points, length, chains: 1, gap: None }
    }

    /// Its start (side 0) or its end (side 1).
    pub(super) fn end(&self, side: usize) -> Point2 {
        let at = if side == 0 { 0 } else { self.points.len() - 1 };
        self.points[at]
    }
}

/// The gap between two points. Rounded up, so that no gap reads as closed.
fn gap(from: Point2, to: Point2) -> Gap {
    Gap { length: from.distance(to).ceil() as i64, at: from }
}

/// Joins pieces at their mates (`mates[2 i + side]` is the end joined to that of piece `i`); closed
/// ones go to `rings`, the others are returned.
fn join(pieces: Vec<Piece>, mates: &[u32], rings: &mut Vec<Piece>) -> Vec<Piece> {
    if mates.iter().all(|&m| m == mate::NONE) {
        return pieces;
    }
    let mut open = Vec::new();
    let mut taken = vec![false; pieces.len()];
    // Paths first, from a free end; what is left then are cycles.
    for cycles in [false, true] {
        for head in 0..pieces.len() {
            let free = [0, 1].into_iter().find(|side| mates[2 * head + side] == mate::NONE);
            let enter = if cycles { Some(0) } else { free };
            if let (false, Some(side)) = (taken[head], enter) {
                let joined = follow(&pieces, mates, 2 * head + side, &mut taken);
                if cycles { rings.push(joined) } else { open.push(joined) }
            }
        }
    }
    open
}

/// Follows the mates from the end `from` (`2 i + side`), entering the first piece there.
fn follow(pieces: &[Piece], mates: &[u32], from: usize, taken: &mut [bool]) -> Piece {
    let mut joined = Piece { points: vec![], length: 0.0, chains: 0, gap: None };
    let (mut enter, mut forward, mut backward) = (from, 0.0, 0.0);
    loop {
        let (i, side) = (enter / 2, enter % 2);
        let piece = &pieces[i];
        taken[i] = true;
        joined.chains += piece.chains;
        joined.gap = joined.gap.max(piece.gap);
        if side == 0 {
            forward += piece.length;
            joined.points.extend_from_slice(&piece.points);
        } else {
            backward += piece.length;
            joined.points.extend(piece.points.iter().rev());
        }
        let next = mates[2 * i + 1 - side];
        if next == mate::NONE {
            break;
        }
        enter = next as usize;
        let bridge = gap(piece.end(1 - side), pieces[enter / 2].end(enter % 2));
        if bridge.length > 0 {
            joined.gap = joined.gap.max(Some(bridge));
            joined.length += bridge.length as f64;
        }
        if taken[enter / 2] {
            break;
        }
    }
    joined.length += forward + backward;
    if backward > forward {
        joined.points.reverse();
    }
    joined.points.dedup();
    joined
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::area2;

    fn chain(points: &[(i32, i32)]) -> Vec<Point2> {
        points.iter().map(|&(x, y)| Point2::new(x, y)).collect()
    }

    /// A square of side 1000 in chains of one side each, displaced and perhaps reversed.
    fn square(gap: i32, flipped: &[usize]) -> Vec<Vec<Point2>> {
        let s = 1000;
        let mut sides = vec![
            chain(&[(gap, 0), (s, 0)]),
            chain(&[(s, gap), (s, s)]),
            chain(&[(s - gap, s), (0, s)]),
            chain(&[(0, s - gap), (0, 0)]),
        ];
        for &i in flipped {
            sides[i].reverse();
        }
        sides
    }

    #[test]
    fn touching_ends_join() {
        let (rings, report) = close(square(0, &[]), 0);
        assert_eq!(rings.iter().map(|r| area2(r)).collect::<Vec<_>>(), [2_000_000]);
        assert_eq!(report, OpenReport { chains: 4, matched: 4, ..OpenReport::default() });
    }

    #[test]
    fn near_ends_join_within_the_tolerance() {
        let (rings, report) = close(square(30, &[]), 50);
        assert_eq!(rings.len(), 1);
        assert_eq!((report.matched, report.forced, report.dropped), (4, 0, 0));
        assert_eq!(report.worst.map(|gap| gap.length), Some(30));
        let (rings, report) = close(square(30, &[]), 20);
        assert_eq!(rings.len(), 1);
        assert_eq!((report.matched, report.forced, report.dropped), (0, 4, 0));
    }

    #[test]
    fn flipped_facets_are_turned_around() {
        for flipped in [&[0][..], &[1], &[2], &[3]] {
            let (rings, report) = close(square(0, flipped), 0);
            assert_eq!(rings.iter().map(|r| area2(r)).collect::<Vec<_>>(), [2_000_000], "{flipped:?}");
            assert_eq!(report.matched, 4);
            let (rings, _) = close(square(10, flipped), 50);
            assert!(rings.len() == 1 && area2(&rings[0]) > 1_900_000, "{flipped:?}");
        }
    }

    #[test]
    fn a_missing_wall_is_closed_by_a_line_and_a_lone_wall_is_dropped() {
        let u = chain(&[(0, 1000), (0, 0), (1000, 0), (1000, 1000)]);
        let (rings, report) = close(vec![u], 50);
        assert_eq!(rings.iter().map(|r| area2(r)).collect::<Vec<_>>(), [2_000_000]);
        assert_eq!(report.forced, 1);
        assert_eq!(report.worst, Some(Gap { length: 1000, at: Point2::new(1000, 1000) }));
        let (rings, report) = close(vec![chain(&[(0, 0), (500, 3), (1000, 0)])], 50);
        assert!(rings.is_empty());
        assert_eq!((report.chains, report.dropped), (1, 1));
        assert_eq!(report.worst, Some(Gap { length: 1000, at: Point2::new(1000, 0) }));
    }

    #[test]
    fn the_order_of_the_chains_does_not_matter() {
        let mut chains: Vec<_> = (0..20)
            .flat_map(|i| {
                let shift = i * 400;
                square(i * 7, &[(i % 4) as usize]).into_iter().map(move |c| {
                    c.into_iter().map(|p| Point2::new(p.x + shift, p.y - shift)).collect::<Vec<_>>()
                })
            })
            .collect();
        let expected = close(chains.clone(), 60);
        for i in 0..chains.len() {
            chains.rotate_left(7);
            chains.swap(0, i);
            assert_eq!(close(chains.clone(), 60), expected);
        }
    }

    #[test]
    fn thousands_of_chains_in_one_spot_are_no_trouble() {
        // All ends within one cell of every reach, starts in another: the worst case of a bucket grid.
        let chains: Vec<_> =
            (0..20_000).map(|i| chain(&[(i % 150, i / 150), (500_000 + i % 140, 1000 + i / 140)])).collect();
        let (_, report) = close(chains, 1_000);
        assert_eq!(report.matched + report.forced + report.dropped, 20_000);
    }

    #[test]
    fn sums_name_the_worst_layer() {
        let gap = |length| Some(Gap { length, at: Point2::new(1, 2) });
        let report = |worst| OpenReport { chains: 1, dropped: 1, worst, ..OpenReport::default() };
        let sum = sum(&[OpenReport::default(), report(gap(5)), report(gap(9)), report(gap(9))]);
        assert_eq!((sum.layers, sum.total.dropped, sum.worst_layer), (3, 3, 2));
        assert_eq!(sum.total.worst, gap(9));
    }
}
