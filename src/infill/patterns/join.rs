//! Lines of any directions → chains: linked along the wall, shortest ways first, each stretch of the wall
//! used once; what is left gets anchors.

use crate::infill::anchor::{Anchors, Open, Place, Wall};
use crate::lattice::Point2;

/// A line of a pattern, cut to the area.
#[derive(Clone, Debug)]
pub struct Piece {
    /// The region that it lies in.
    pub region: u32,
    /// At least two points \[nm\].
    pub points: Vec<Point2>,
    /// Where it begins and ends on the wall; `None` inside the region.
    pub ends: [Option<Place>; 2],
}

const NONE: u32 = u32::MAX;

/// Joins lines, which come region by region, and reports each chain with its region, in that order.
pub fn join(
    pieces: &[Piece],
    rings: &[&[Point2]],
    rules: &Anchors,
    open: &impl Open,
    mut found: impl FnMut(usize, Vec<Point2>),
) {
    // End 0 of piece i has number 2 i, end 1 the next.
    let mut ends: Vec<(Place, u32)> = pieces
        .iter()
        .zip((0u32..).step_by(2))
        .flat_map(|(p, i)| (i..).zip(p.ends).filter_map(|(i, end)| end.map(|place| (place, i))))
        .collect();
    ends.sort_unstable_by(|(a, i), (b, j)| {
        (a.ring, a.edge).cmp(&(b.ring, b.edge)).then(a.along.total_cmp(&b.along)).then(i.cmp(j))
    });
    let mut place_of = vec![NONE; 2 * pieces.len()];
    for (place, &(_, end)) in (0..).zip(&ends) {
        place_of[end as usize] = place;
    }
    let mut wall = Wall::new(rings, ends.iter().map(|e| e.0).collect());
    let links = links(&ends, &mut wall, pieces.len(), rules, open);
    let mut done = vec![false; pieces.len()];
    for i in 0..pieces.len() {
        if done[i] {
            continue;
        }
        // Back to where the chain begins, then forwards.
        let mut entry = 2 * i as u32;
        while let Some((_, other)) = links[entry as usize] {
            entry = other ^ 1;
        }
        let mut points = match place_of[entry as usize] {
            NONE => Vec::new(),
            place => wall.anchor(place, rules, open),
        };
        points.reverse();
        loop {
            let piece = &pieces[entry as usize / 2];
            done[entry as usize / 2] = true;
            if entry.is_multiple_of(2) {
                points.extend(&piece.points);
            } else {
                points.extend(piece.points.iter().rev());
            }
            let exit = entry ^ 1;
            let Some((stretch, other)) = links[exit as usize] else {
                if place_of[exit as usize] != NONE {
                    points.extend(wall.anchor(place_of[exit as usize], rules, open));
                }
                break;
            };
            if place_of[exit as usize] == stretch {
                points.extend(wall.vertices(stretch));
            } else {
                points.extend(wall.vertices(stretch).rev());
            }
            entry = other;
        }
        points.dedup();
        found(pieces[i].region as usize, points);
    }
}

/// Per end the stretch by which it is linked and the end to which it leads.
fn links(
    ends: &[(Place, u32)],
    wall: &mut Wall,
    pieces: usize,
    rules: &Anchors,
    open: &impl Open,
) -> Vec<Option<(u32, u32)>> {
    let mut links = vec![None; 2 * pieces];
    if rules.link <= 0.0 {
        return links;
    }
    let mut ways: Vec<(f64, u32)> = (0..ends.len() as u32)
        .filter(|&i| wall.next(i) != i)
        .map(|i| (wall.length(i, rules.link), i))
        .filter(|way| way.0 <= rules.link)
        .collect();
    ways.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut chains = Chains::new(pieces);
    for (_, stretch) in ways {
        let (a, b) = (ends[stretch as usize].1, ends[wall.next(stretch) as usize].1);
        if links[a as usize].is_none()
            && links[b as usize].is_none()
            && wall.is_open(stretch, open)
            && chains.join(a / 2, b / 2)
        {
            links[a as usize] = Some((stretch, b));
            links[b as usize] = Some((stretch, a));
            wall.take(stretch);
        }
    }
    links
}

/// Which pieces hang together: a disjoint-set forest with path halving (Tarjan and van Leeuwen, 1984).
struct Chains(Vec<u32>);

impl Chains {
    fn new(pieces: usize) -> Self {
        Self((0..pieces as u32).collect())
    }

    fn root(&mut self, mut i: u32) -> u32 {
        while self.0[i as usize] != i {
            let up = self.0[self.0[i as usize] as usize];
            self.0[i as usize] = up;
            i = up;
        }
        i
    }

    /// Joins two chains; false where they are one already, and would close to a ring.
    fn join(&mut self, a: u32, b: u32) -> bool {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
        a != b
    }
}
