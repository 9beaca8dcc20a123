//! Bytes to an indexed triangle mesh on the lattice.
//!
//! [`load()`] reads, measures and welds; [`Adjacency::build`] pairs the half-edges; [`audit()`] says what
//! is wrong with a mesh; [`orient::orient`] turns facets that face the wrong way and [`snap::snap`]
//! closes cracks; [`place()`] moves its origin onto the bed. [`shapes`] and [`demo_part()`] make
//! meshes without a file.

mod adjacency;
pub mod audit;
#[cfg(test)]
mod bad_input;
mod blocks;
pub mod demo_part;
mod detect;
pub mod error;
pub mod facing;
mod frame;
pub mod load;
mod nesting;
pub mod orient;
pub mod place;
pub mod plate;
mod propagate;
#[cfg(test)]
mod random;
pub mod shapes;
pub mod snap;
mod stl;
pub mod stl_write;
pub mod transform;
mod weld;

pub use audit::{Audit, audit};
pub use demo_part::demo_part;
pub use error::{MeshError, Place};
pub use load::{Loaded, Warning, load, load_bytes};
pub use place::{PlaceError, Placement, fits, place};
pub use transform::Transform;

use crate::lattice::Point3;

/// An indexed triangle mesh on the lattice.
///
/// World position of a vertex \[nm\] = `origin + vertex`. Moving a part changes `origin` alone, so a
/// part gives the same toolpaths wherever it stands.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mesh {
    /// Vertices \[nm\], relative to `origin`, each coordinate within ±[`crate::lattice::LIMIT`].
    pub vertices: Vec<Point3>,
    /// Vertex ids, counter-clockwise seen from outside; the three ids of a triangle differ.
    pub triangles: Vec<[u32; 3]>,
    /// World position of the lattice's zero \[nm\].
    pub origin: [i64; 3],
}

impl Mesh {
    /// Lowest and highest coordinate of the vertices along x, y, z \[nm\], mesh frame. `None` without
    /// vertices.
    pub fn bounds(&self) -> Option<[Point3; 2]> {
        let first = *self.vertices.first()?;
        // Four vertices at a time are whole vectors of one instruction.
        let (fours, rest) = self.vertices.as_chunks::<4>();
        let mut low: [i32; 12] = bytemuck::cast([first; 4]);
        let mut high = low;
        for four in fours {
            let lanes: &[i32; 12] = bytemuck::cast_ref(four);
            for (i, &c) in lanes.iter().enumerate() {
                low[i] = low[i].min(c);
                high[i] = high[i].max(c);
            }
        }
        let (mut lo, mut hi) = (first, first);
        let lanes: [[Point3; 4]; 2] = [bytemuck::cast(low), bytemuck::cast(high)];
        for v in lanes.as_flattened().iter().chain(rest) {
            lo = Point3::new(lo.x.min(v.x), lo.y.min(v.y), lo.z.min(v.z));
            hi = Point3::new(hi.x.max(v.x), hi.y.max(v.y), hi.z.max(v.z));
        }
        Some([lo, hi])
    }

    /// [`Mesh::bounds`] in the world \[nm\].
    pub fn world_bounds(&self) -> Option<[[i64; 3]; 2]> {
        let [x, y, z] = self.origin;
        let world = |p: Point3| [x + i64::from(p.x), y + i64::from(p.y), z + i64::from(p.z)];
        Some(self.bounds()?.map(world))
    }
}

/// The half-edge that a half-edge meets: half-edge `3 t + i` runs from corner `i` to corner
/// `(i + 1) % 3` of triangle `t`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Adjacency {
    /// Per half-edge the opposite half-edge's id, or [`OPEN`]. Length = 3 × triangles.
    pub twin: Vec<u32>,
}

/// Marks a half-edge without a partner.
pub const OPEN: u32 = u32::MAX;
