//! Which way facets face: decided by their winding, by the normals in the file, or by their neighbours.

use super::audit::{Shells, audit_shells};
use super::nesting::{self, Lies};
use super::propagate::{drop_duplicates, flip, propagate};
use super::{Adjacency, Audit, Mesh, OPEN};

/// Where the outside of a mesh is taken from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orient {
    /// The winding where it is consistent; else the stored normals or the neighbours, whichever leave
    /// fewer contradictions. Shells that are inside out are turned.
    #[default]
    Auto,
    /// The winding, as it is.
    Winding,
    /// The stored normals: a facet whose corners run clockwise about its normal is turned.
    Normals,
    /// Neighbours and nesting: consistent over all edges, outwards by volume, cavities inwards.
    Repair,
}

/// What was done about the orientation.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Oriented {
    /// Triangles turned after their stored normals.
    pub by_normals: u64,
    /// Triangles turned to agree with their neighbours, or to face outwards with them.
    pub by_neighbours: u64,
    /// Duplicate triangles dropped.
    pub duplicates_dropped: u64,
    /// The whole mesh was inside out and was turned.
    pub inside_out: bool,
    /// Inside-out shells among others that were turned.
    pub shells_turned: u64,
    /// Normals were asked for and there are none that can be used.
    pub no_normals: bool,
    /// Contradicting edges before and after.
    pub flipped_edges: [u64; 2],
}

impl Oriented {
    /// Whether the mesh is another one than before.
    pub fn changed(&self) -> bool {
        self.by_normals > 0
            || self.by_neighbours > 0
            || self.duplicates_dropped > 0
            || self.inside_out
            || self.shells_turned > 0
    }
}

/// A mesh with its adjacency and the audit's findings.
#[derive(Debug)]
pub struct Audited {
    /// The mesh.
    pub mesh: Mesh,
    /// Its half-edges paired.
    pub adjacency: Adjacency,
    /// Its state.
    pub audit: Audit,
    /// Its shells.
    pub shells: Shells,
}

impl Audited {
    /// Joins and examines a mesh.
    pub fn new(mesh: Mesh) -> Self {
        let adjacency = Adjacency::build(&mesh);
        Self::of(mesh, adjacency)
    }

    /// Examines a mesh with its adjacency.
    pub fn of(mesh: Mesh, adjacency: Adjacency) -> Self {
        let (audit, shells) = audit_shells(&mesh, &adjacency);
        Self { mesh, adjacency, audit, shells }
    }

    fn renew(&mut self) {
        *self = Self::new(std::mem::take(&mut self.mesh));
    }
}

/// Orients a mesh as wished. `facing` gives, per triangle, how its stored normal lies to its winding
/// (see [`super::facing::facing`]); it is asked only when needed, and `None` or a list of another
/// length counts as no normals.
///
/// Costs nothing on a mesh whose winding is consistent and whose shells enclose positive volumes.
pub fn orient(part: &mut Audited, wish: Orient, facing: impl FnOnce() -> Option<Vec<i8>>) -> Oriented {
    let before = part.audit.flipped_edges;
    let mut done = Oriented::default();
    match wish {
        Orient::Winding => {}
        Orient::Normals => {
            by_normals(part, facing(), false, &mut done);
        }
        Orient::Repair => by_neighbours(part, false, &mut done),
        Orient::Auto => {
            if before > 0 {
                by_normals(part, facing(), true, &mut done);
                // Nothing was asked for, so nothing is missing.
                done.no_normals = false;
            }
            if part.audit.duplicate_triangles > 0 && part.audit.open_edges > 0 {
                without_duplicates(part, &mut done);
            }
            if part.audit.flipped_edges > 0 {
                by_neighbours(part, true, &mut done);
            }
            turn_inside_out(part, &mut done);
        }
    }
    done.flipped_edges = [before, part.audit.flipped_edges];
    done
}

/// Turns what faces against its normal; with `if_better` only where that leaves fewer contradictions.
fn by_normals(part: &mut Audited, facing: Option<Vec<i8>>, if_better: bool, done: &mut Oriented) {
    let usable = facing.filter(|f| f.len() == part.mesh.triangles.len() && f.iter().any(|s| *s != 0));
    let Some(facing) = usable else {
        done.no_normals = true;
        return;
    };
    let turn: Vec<bool> = facing.iter().map(|sign| *sign < 0).collect();
    let count = turn.iter().filter(|t| **t).count() as u64;
    if count == 0 {
        return;
    }
    let before = part.audit.flipped_edges;
    flip(&mut part.mesh, &turn);
    part.renew();
    if if_better && part.audit.flipped_edges >= before {
        // Swapping the same corners again undoes it.
        flip(&mut part.mesh, &turn);
        part.renew();
    } else {
        done.by_normals = count;
    }
}

fn by_neighbours(part: &mut Audited, if_better: bool, done: &mut Oriented) {
    let mut mesh = part.mesh.clone();
    let report = propagate(&mut mesh);
    if report.turned == 0 && report.duplicates == 0 {
        return;
    }
    let mended = Audited::new(mesh);
    if !if_better || mended.audit.flipped_edges < part.audit.flipped_edges {
        *part = mended;
        done.by_neighbours = report.turned;
        done.duplicates_dropped += report.duplicates;
    }
}

/// Drops facets that lie on others, where that leaves fewer open edges. A surplus facet has no
/// neighbours, so its contours are open.
fn without_duplicates(part: &mut Audited, done: &mut Oriented) {
    let mut mesh = part.mesh.clone();
    let dropped = drop_duplicates(&mut mesh);
    let mended = Audited::new(mesh);
    if mended.audit.open_edges < part.audit.open_edges {
        *part = mended;
        done.duplicates_dropped = dropped;
    }
}

/// Turns a mesh of negative volume whole, then single closed shells that are inside out.
fn turn_inside_out(part: &mut Audited, done: &mut Oriented) {
    if part.shells.volume6.iter().sum::<i128>() < 0 {
        part.mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        part.renew();
        done.inside_out = true;
    }
    let shells = &part.shells;
    if shells.volume6.len() < 2 || shells.volume6.iter().all(|v| *v >= 0) {
        return;
    }
    let turned = inside_out(&part.mesh, &part.adjacency, shells);
    done.shells_turned = turned.iter().filter(|t| **t).count() as u64;
    if done.shells_turned > 0 {
        let turn: Vec<bool> = shells.of.iter().map(|&shell| turned[shell as usize]).collect();
        flip(&mut part.mesh, &turn);
        part.renew();
    }
}

/// Per shell whether it must be turned. Only closed shells are, and only inside closed ones counts.
///
/// A negative shell is a cavity where the shells around it wind about it at least once; elsewhere it
/// is inside out. What lies in a shell that is turned has most likely been turned with it, and is
/// oriented by depth: outwards inside an even number of shells.
fn inside_out(mesh: &Mesh, adjacency: &Adjacency, shells: &Shells) -> Vec<bool> {
    let count = shells.volume6.len();
    let mut closed = vec![true; count];
    for (twins, &shell) in adjacency.twin.as_chunks::<3>().0.iter().zip(&shells.of) {
        closed[shell as usize] &= !twins.contains(&OPEN);
    }
    let negative = |shell: usize| shells.volume6[shell] < 0;
    let suspects: Vec<u32> = (0..count).filter(|&s| closed[s] && negative(s)).map(|s| s as u32).collect();
    let mut turned = decide(mesh, shells, &closed, &suspects);
    if turned.contains(&true) {
        // Now also what lies inside the shells that are turned.
        let all: Vec<u32> = (0..count).filter(|&s| closed[s]).map(|s| s as u32).collect();
        turned = decide(mesh, shells, &closed, &all);
    }
    turned
}

fn decide(mesh: &Mesh, shells: &Shells, closed: &[bool], ask: &[u32]) -> Vec<bool> {
    let found = nesting::lies(mesh, &shells.of, closed.len(), ask);
    // In doubt (on the surface of the other) a shell counts as inside and is left alone.
    let around: Vec<&Lies> = found.iter().filter(|l| l.outside == 0 && closed[l.other as usize]).collect();
    let around_of = |shell: u32| {
        let from = around.partition_point(|l| l.shell < shell);
        let to = around.partition_point(|l| l.shell <= shell);
        &around[from..to]
    };
    let mut turned = vec![false; closed.len()];
    let mut order: Vec<(usize, u32)> = ask.iter().map(|&shell| (around_of(shell).len(), shell)).collect();
    // What is around a shell is around less itself.
    order.sort_unstable();
    for (depth, shell) in order {
        let negative = shells.volume6[shell as usize] < 0;
        let others = around_of(shell);
        turned[shell as usize] = if others.iter().any(|l| turned[l.other as usize]) {
            negative == depth.is_multiple_of(2)
        } else {
            let winding: i64 = others.iter().map(|l| shells.volume6[l.other as usize].signum() as i64).sum();
            negative && winding <= 0
        };
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::random::Random;
    use crate::mesh::shapes::{self, cuboid, merge, moved, torus};

    /// About the origin.
    fn sphere(radius: f64, around: usize, rings: usize) -> Mesh {
        moved(shapes::sphere(radius, around, rings), [0.0, 0.0, -radius])
    }

    fn turned(mut mesh: Mesh) -> Mesh {
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        mesh
    }

    fn auto(mesh: Mesh) -> (Mesh, Oriented) {
        let mut part = Audited::new(mesh);
        let done = orient(&mut part, Orient::Auto, || None);
        assert_eq!(part.adjacency, Adjacency::build(&part.mesh));
        (part.mesh, done)
    }

    /// Turns a random half; returns what normals made from the whole mesh say.
    fn half_flipped(mesh: &mut Mesh, seed: u64) -> Vec<i8> {
        let mut random = Random(seed);
        let mut facing = vec![1; mesh.triangles.len()];
        for (t, sign) in mesh.triangles.iter_mut().zip(&mut facing) {
            if random.next().is_multiple_of(2) {
                t.swap(1, 2);
                *sign = -1;
            }
        }
        facing
    }

    #[test]
    fn good_meshes_stay_as_they_are() {
        let hollow = merge(&[sphere(5.0, 30, 15), turned(sphere(4.0, 30, 15))]);
        for mesh in [torus(9.0, 2.0, 40, 20), hollow] {
            let mut part = Audited::new(mesh.clone());
            let done = orient(&mut part, Orient::Auto, || unreachable!("normals are not needed"));
            assert_eq!((part.mesh, done), (mesh, Oriented::default()));
        }
    }

    #[test]
    fn inside_out_shells_are_turned_and_cavities_stay() {
        let ball = sphere(5.0, 30, 15);
        let hole = turned(sphere(4.0, 30, 15));
        let core = sphere(2.0, 30, 15);
        let block = moved(cuboid([0.0; 3], [20.0; 3]), [30.0, 0.0, 0.0]);
        let good = merge(&[ball.clone(), hole.clone(), core.clone(), block.clone()]);
        let cases = [
            (merge(&[turned(ball.clone()), turned(hole.clone()), turned(core.clone()), block.clone()]), 3),
            (merge(&[turned(ball.clone()), hole.clone(), core.clone(), block.clone()]), 1),
            (merge(&[ball.clone(), hole.clone(), turned(core), block]), 1),
        ];
        for (mesh, shells) in cases {
            let (mesh, done) = auto(mesh);
            assert_eq!(mesh, good);
            assert_eq!(done, Oriented { shells_turned: shells, ..Oriented::default() });
        }
        let hollow = merge(&[ball, hole]);
        let (mesh, done) = auto(turned(hollow.clone()));
        assert_eq!((mesh, done), (hollow, Oriented { inside_out: true, ..Oriented::default() }));
    }

    #[test]
    fn random_flips_are_mended_by_normals_or_without() {
        let body = merge(&[torus(9.0, 2.0, 40, 20), moved(cuboid([0.0; 3], [3.0; 3]), [40.0, 0.0, 0.0])]);
        for seed in 0..5 {
            let mut mesh = body.clone();
            let facing = half_flipped(&mut mesh, seed);
            let wrong = facing.iter().filter(|s| **s < 0).count() as u64;
            for wish in [Orient::Auto, Orient::Normals] {
                let mut part = Audited::new(mesh.clone());
                let done = orient(&mut part, wish, || Some(facing.clone()));
                assert_eq!(part.mesh, body, "seed {seed}");
                assert_eq!((done.by_normals, done.by_neighbours, done.flipped_edges[1]), (wrong, 0, 0));
            }
            let lies = facing.iter().map(|_| 1).collect::<Vec<i8>>();
            for no_use in [None, Some(vec![]), Some(vec![0; lies.len()]), Some(lies)] {
                let mut part = Audited::new(mesh.clone());
                let done = orient(&mut part, Orient::Auto, || no_use);
                assert_eq!(part.mesh, body, "seed {seed}");
                assert_eq!((done.by_normals, done.by_neighbours), (0, wrong));
            }
            let mut part = Audited::new(mesh.clone());
            assert!(!orient(&mut part, Orient::Winding, || Some(facing)).changed());
            assert_eq!(part.mesh, mesh);
            let done = orient(&mut part, Orient::Normals, || None);
            assert!(done.no_normals && !done.changed());
        }
    }

    #[test]
    fn an_open_shell_is_not_turned_by_itself() {
        let mut cup = turned(sphere(5.0, 30, 15));
        cup.triangles.truncate(300);
        let block = moved(cuboid([0.0; 3], [20.0; 3]), [30.0, 0.0, 0.0]);
        let mesh = merge(&[cup, block]);
        assert_eq!(auto(mesh.clone()).0, mesh);
    }
}
