//! The plane-intersection algorithms of the literature, side by side with the main core.
//!
//! All take the same mesh and planes, compute crossings with the exact arithmetic of
//! [`super::crossing`], and give the same segments; they differ in how they find the triangles that a
//! plane meets. They are here to be compared, and run on one thread as published.
//!
//! n triangles, p planes, m segments:
//!
//! | algorithm | time |
//! |---|---|
//! | [`trivial`] | p n |
//! | [`sweep`] | n log n + p + m |
//! | [`grouping`] | n log n + p √n + m |
//! | [`incremental`], uniform planes | n + p + m |
//! | [`incremental`], other planes: [`interval_tree`] | n log n + p log n + m |

pub mod assemble;
pub mod grouping;
pub mod incremental;
pub mod interval_tree;
mod link;
pub mod sweep;
#[cfg(test)]
mod tests;
pub mod trivial;

pub use assemble::{Assembled, assemble};

use super::{Segments, cpu, crossing};
use crate::lattice::{Point2, Point3};
use crate::mesh::{Adjacency, Mesh};
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// A way to find the triangles that each plane meets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Algorithm {
    /// The project's own: count, scan, emit. See [`super::cpu`].
    #[default]
    Main,
    /// Every plane against every triangle. See [`trivial`].
    Trivial,
    /// A sweep plane with a status structure. See [`sweep`].
    Sweep,
    /// Triangles grouped by their lowest and highest z. See [`grouping`].
    Grouping,
    /// Buckets of planes, or an interval tree where planes are not evenly spaced. See [`incremental`].
    Incremental,
}

impl Algorithm {
    /// All of them, the main one first.
    pub const ALL: [Self; 5] = [Self::Main, Self::Trivial, Self::Sweep, Self::Grouping, Self::Incremental];

    /// The name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Main => "main",
            Self::Trivial => "trivial",
            Self::Sweep => "sweep",
            Self::Grouping => "grouping",
            Self::Incremental => "incremental",
        }
    }
}

impl fmt::Display for Algorithm {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no algorithm has.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("there is no algorithm \"{0}\"; choose main, trivial, sweep, grouping or incremental")]
pub struct UnknownAlgorithm(String);

impl FromStr for Algorithm {
    type Err = UnknownAlgorithm;

    fn from_str(name: &str) -> Result<Self, UnknownAlgorithm> {
        Self::ALL.into_iter().find(|a| a.name() == name).ok_or_else(|| UnknownAlgorithm(name.to_owned()))
    }
}

/// Where a plane cuts a triangle; solid lies on the left of the way from start to end.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Segment {
    /// The triangle's index in the mesh.
    pub triangle: u32,
    /// Where the contour enters the triangle \[nm\], mesh frame.
    pub start: Point2,
    /// Where it leaves it \[nm\], mesh frame.
    pub end: Point2,
}

impl Segment {
    /// The segment of a triangle on plane `z` \[nm\], which the triangle must meet.
    #[inline]
    fn cut(triangle: u32, corner: [Point3; 3], z: i32) -> Self {
        let [down, up] = edges(below(corner, z));
        let cross = |edge: usize| crossing::point(corner[edge], corner[FOLLOWING[edge]], z);
        Self { triangle, start: cross(down), end: cross(up) }
    }
}

/// The corner after each, around a triangle.
const FOLLOWING: [usize; 3] = [1, 2, 0];

/// All three corners below the plane.
const ALL_BELOW: u8 = 0b111;

/// A bit for each corner that lies below plane `z`, by the rule of [`crossing::plane_range`].
#[inline]
fn below(corner: [Point3; 3], z: i32) -> u8 {
    u8::from(corner[0].z < z) | u8::from(corner[1].z < z) << 1 | u8::from(corner[2].z < z) << 2
}

/// [`crossing::down_up`] from the bits of [`below`]: a table, since which corners lie below is as good as
/// random to the processor's branch predictor.
#[inline]
fn edges(below: u8) -> [usize; 2] {
    const EDGES: [[usize; 2]; 8] = [[0, 0], [2, 0], [0, 1], [2, 1], [1, 2], [1, 0], [0, 2], [0, 0]];
    EDGES[usize::from(below & ALL_BELOW)]
}

/// The corners of a triangle.
fn corners(mesh: &Mesh, triangle: u32) -> [Point3; 3] {
    mesh.triangles[triangle as usize].map(|v| mesh.vertices[v as usize])
}

/// The lowest and the highest z of a triangle \[nm\].
fn extent(corner: [Point3; 3]) -> (i32, i32) {
    let [a, b, c] = corner.map(|c| c.z);
    (a.min(b).min(c), a.max(b).max(c))
}

/// The segments on each plane in the order in which the algorithm finds them; `planes` \[nm\], mesh frame,
/// ascending. Length = planes.
pub fn run(algorithm: Algorithm, mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    match algorithm {
        Algorithm::Main => main(mesh, planes),
        Algorithm::Trivial => trivial::run(mesh, planes),
        Algorithm::Sweep => sweep::run(mesh, planes),
        Algorithm::Grouping => grouping::run(mesh, planes),
        Algorithm::Incremental => incremental::run(mesh, planes),
    }
}

/// The segments on each plane, ordered by triangle: the same from every algorithm. Arguments as [`run`].
pub fn segments(algorithm: Algorithm, mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    let mut layers = run(algorithm, mesh, planes);
    for layer in &mut layers {
        layer.sort_unstable();
    }
    layers
}

/// The common buffers with links, the same from every algorithm: what `contour::contours_of` takes.
///
/// `adjacency` must be that of the mesh; `planes` \[nm\], mesh frame, ascending; fewer than 2^32 segments.
pub fn slice(algorithm: Algorithm, mesh: &Mesh, adjacency: &Adjacency, planes: &[i32]) -> Segments {
    match algorithm {
        Algorithm::Main => cpu::slice(mesh, adjacency, planes),
        _ => link(mesh, adjacency, planes, &run(algorithm, mesh, planes)),
    }
}

pub use link::link;

/// The main core's way without its links: triangle after triangle, each on its range of planes.
fn main(mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    let mut layers = vec![Vec::new(); planes.len()];
    for triangle in 0..mesh.triangles.len() as u32 {
        let corner = corners(mesh, triangle);
        let (z_min, z_max) = extent(corner);
        let (first, end) = crossing::plane_range(z_min, z_max, planes);
        for k in first..end {
            layers[k].push(Segment::cut(triangle, corner, planes[k]));
        }
    }
    layers
}
