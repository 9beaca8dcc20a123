//! One family of parallel lines, joined in a sweep.

use super::Sparse;
use super::join::{NONE, Piece, join_along};
use crate::infill::FillPath;
use crate::infill::anchor::{Place, Wall};
use crate::infill::border::{Border, INSIDE};
use crate::infill::rectilinear::{Chain, Links, chains};
use crate::span::{Hit, RowFrame};

/// How lines are held together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// Linked up to the longest way allowed, else anchored.
    Linked,
    /// The same, but only as one sweep over the region goes.
    Swept,
    /// Linked however long the way.
    AllLinked,
    /// Anchored alone.
    Anchored,
    /// Not at all.
    Loose,
}

/// Lays parallel lines at `degrees`, `pitch` \[nm\] apart.
///
/// A sweep joins most of them; chains that end beside each other on the wall are then joined too.
pub fn lay(sparse: &Sparse, degrees: f64, pitch: f64, hold: Hold, found: impl FnMut(usize, FillPath)) {
    let lines = RowFrame::new(degrees, 0.0, pitch);
    let trace = sparse.compared.regions.trace(&lines);
    let area = sparse.compared.onto(sparse.area, &trace, &lines);
    let border = sparse.compared.regions.border(&trace, &lines);
    let (open, mut rules) = (sparse.open(), sparse.anchors());
    match hold {
        Hold::Linked | Hold::Swept => {}
        Hold::AllLinked => rules.link = f64::INFINITY,
        Hold::Anchored => rules.link = 0.0,
        Hold::Loose => (rules.link, rules.anchor) = (0.0, 0.0),
    }
    let near = Links::near(pitch, &open);
    let links = Links { border: rules.link, straight: near.straight.min(rules.link), ..near };
    let mut pieces = Vec::new();
    let mut end_at = vec![NONE; trace.hits.len()];
    let used = chains(&border, &area, sparse.least(), links, |Chain { region, points, ends }| {
        for (end, hit) in (2 * pieces.len() as u32..).zip(ends) {
            if hit != INSIDE {
                end_at[hit as usize] = end;
            }
        }
        pieces.push(Piece { region: region as u32, points, ends: [None; 2] });
    });
    if hold == Hold::Swept {
        rules.link = 0.0;
    }
    let mut found = sparse.paths(found);
    if rules.link <= 0.0 && rules.anchor <= 0.0 {
        pieces.into_iter().for_each(|p| found(p.region as usize, p.points));
        return;
    }
    join_along(&pieces, &mut wall(&border, &used), &end_at, &rules, &open, found);
}

/// The wall with all crossings as its places, less the stretches used by links.
fn wall<'a>(border: &Border<'a>, used: &[u32]) -> Wall<'a> {
    let place = |(id, hit): (u32, &Hit)| Place::new(border.rings, hit.ring, hit.edge, border.point(id));
    let mut wall = Wall::new(border.rings, (0..).zip(&border.trace.hits).map(place).collect());
    for &stretch in used {
        wall.take(stretch);
    }
    wall
}
