//! Which branches lean towards which.
//!
//! Branches pair off, the closest first, and the two of a pair lean towards each other. What is left over leans
//! towards its nearest neighbour.

use super::grow::{Node, in_order};

/// Neighbours that a branch looks at.
const LOOKED_AT: usize = 6;
/// Part of the way to the plate on which two should have met.
const EARLY: f64 = 0.85;

/// For each branch where it leans: the direction, and how far \[units\]. `step` is how far a branch may move now
/// and `most` how far until it reaches the plate.
pub fn gather(nodes: &[Node], step: f64, most: f64) -> Vec<[f64; 2]> {
    let mut edges = edges(nodes, 2.0 * EARLY * most);
    edges.sort_by(|a, b| a.square.total_cmp(&b.square).then(a.rank.cmp(&b.rank)));
    let mut other: Vec<Option<usize>> = vec![None; nodes.len()];
    for e in &edges {
        if other[e.from].is_none() && other[e.to].is_none() {
            (other[e.from], other[e.to]) = (Some(e.to), Some(e.from));
        }
    }
    // Ascending, so the first edge of a branch is its shortest.
    for e in &edges {
        other[e.from].get_or_insert(e.to);
    }
    let lean = |(own, other): (&Node, &Option<usize>)| {
        let Some(to) = other.map(|k| &nodes[k]) else { return [0.0; 2] };
        let (u, v) = (to.at[0] - own.at[0], to.at[1] - own.at[1]);
        let apart = (u * u + v * v).sqrt();
        if apart == 0.0 {
            return [0.0; 2];
        }
        // They meet nearer to the heavier one.
        let far = (step * (to.load / own.load).min(1.0)).min(apart * to.load / (to.load + own.load));
        [u / apart * far, v / apart * far]
    };
    nodes.iter().zip(&other).map(lean).collect()
}

/// From a branch to a neighbour.
struct Edge {
    square: f64,
    /// Of both, in the order of their places.
    rank: [usize; 2],
    from: usize,
    to: usize,
}

/// From each branch to its nearest neighbours that end where it does, at most `most` away.
fn edges(nodes: &[Node], most: f64) -> Vec<Edge> {
    let order = in_order(nodes.iter().map(|n| n.at));
    let mut out = Vec::with_capacity(nodes.len() * LOOKED_AT);
    for (place, &i) in order.iter().enumerate() {
        let own = &nodes[i];
        let mut best: Vec<Edge> = Vec::with_capacity(LOOKED_AT + 1);
        let mut look = |rank: usize| {
            let k = order[rank];
            let (u, v) = (nodes[k].at[0] - own.at[0], nodes[k].at[1] - own.at[1]);
            let square = u * u + v * v;
            let least = match best.get(LOOKED_AT - 1) {
                Some(last) => last.square,
                None => most * most,
            };
            if square < least && nodes[k].to_plate == own.to_plate {
                let at = best.partition_point(|b| b.square <= square);
                best.insert(at, Edge { square, rank: [place, rank], from: i, to: k });
                best.truncate(LOOKED_AT);
            }
            u * u < least
        };
        // Both ways until the distance along the rows alone is too great.
        let _ = (0..place).rev().all(&mut look);
        let _ = (place + 1..order.len()).all(&mut look);
        out.extend(best);
    }
    out
}
