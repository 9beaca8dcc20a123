//! One family of parallel lines, laid in one sweep.

use super::Sparse;
use crate::infill::anchor::{Place, Wall};
use crate::infill::border::{Border, INSIDE};
use crate::infill::rectilinear::{Chain, Links, chains};
use crate::infill::{FillKind, FillPath};
use crate::span::RowFrame;

/// How lines are held together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hold {
    /// Linked up to the longest way allowed, else anchored.
    Linked,
    /// Linked however long the way.
    AllLinked,
    /// Anchored alone.
    Anchored,
    /// Not at all.
    Loose,
}

/// Lays parallel lines at `degrees`, `pitch` \[nm\] apart.
pub fn lay(sparse: &Sparse, degrees: f64, pitch: f64, hold: Hold, mut found: impl FnMut(usize, FillPath)) {
    let lines = RowFrame::new(degrees, 0.0, pitch);
    let trace = sparse.compared.regions.trace(&lines);
    let area = sparse.compared.onto(sparse.area, &trace, &lines);
    let border = sparse.compared.regions.border(&trace, &lines);
    let (open, mut rules) = (sparse.open(), sparse.anchors());
    let near = Links::near(pitch, &open);
    let links = match hold {
        Hold::AllLinked => Links { border: f64::INFINITY, ..near },
        Hold::Linked if rules.link > 0.0 => {
            Links { border: rules.link, straight: near.straight.min(rules.link), ..near }
        }
        _ => Links { border: 0.0, straight: 0.0, ..near },
    };
    if hold == Hold::Loose {
        rules.anchor = 0.0;
    }
    let mut all = Vec::new();
    let used = chains(&border, &area, sparse.least(), links, |chain| all.push(chain));
    let mut wall = (rules.anchor > 0.0).then(|| wall(&border, &used));
    for Chain { region, mut points, ends } in all {
        if let Some(wall) = &mut wall {
            if ends[0] != INSIDE {
                let anchor = wall.anchor(ends[0], &rules, &open);
                points.splice(0..0, anchor.into_iter().rev());
            }
            if ends[1] != INSIDE {
                points.extend(wall.anchor(ends[1], &rules, &open));
            }
            points.dedup();
        }
        found(region, FillPath { points, kind: FillKind::Sparse, layers: sparse.layers });
    }
}

/// The wall with all crossings as its places, less the stretches used by links.
fn wall<'a>(border: &Border<'a>, used: &[u32]) -> Wall<'a> {
    let place =
        |(id, hit): (u32, &crate::span::Hit)| Place::new(border.rings, hit.ring, hit.edge, border.point(id));
    let mut wall = Wall::new(border.rings, (0..).zip(&border.trace.hits).map(place).collect());
    for &stretch in used {
        wall.take(stretch);
    }
    wall
}
