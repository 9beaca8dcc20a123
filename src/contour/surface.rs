//! Steps of a contour from triangle to triangle.

use crate::lattice::Point3;
use crate::mesh::{Adjacency, Mesh};
use crate::slice::crossing::down_up;

/// What a walk reads of a mesh.
#[derive(Clone, Copy)]
pub(super) struct Surface<'a> {
    pub(super) vertices: &'a [Point3],
    /// Vertex of each half-edge's corner.
    pub(super) corners: &'a [u32],
    pub(super) twin: &'a [u32],
}

/// An edge that the plane crosses: a half-edge of it and its two vertices.
#[derive(Clone, Copy)]
pub(super) struct Crossing {
    pub(super) edge: usize,
    pub(super) below: Point3,
    pub(super) above: Point3,
}

impl<'a> Surface<'a> {
    pub(super) fn new(mesh: &'a Mesh, adjacency: &'a Adjacency) -> Self {
        Self { vertices: &mesh.vertices, corners: mesh.triangles.as_flattened(), twin: &adjacency.twin }
    }

    /// Reads what a walk will need of some triangles. The walk waits for each read before it knows the
    /// next; these wait for none, so the caches fill several times faster.
    pub(super) fn touch(&self, triangles: &[u32]) {
        let mut sum = 0;
        for &t in triangles {
            let edge = 3 * t as usize;
            sum ^= self.twin[edge];
            for &vertex in &self.corners[edge..edge + 3] {
                sum ^= self.vertices[vertex as usize].x as u32;
            }
        }
        std::hint::black_box(sum);
    }

    /// The vertex from which a half-edge runs.
    #[inline(always)]
    pub(super) fn corner(&self, half_edge: usize) -> Point3 {
        self.vertices[self.corners[half_edge] as usize]
    }

    /// Where the contour enters a triangle that plane `z` meets.
    pub(super) fn entry(&self, triangle: usize, z: i32) -> Crossing {
        let first = 3 * triangle;
        let corner = [self.corner(first), self.corner(first + 1), self.corner(first + 2)];
        let (down, _) = down_up([corner[0].z, corner[1].z, corner[2].z], z);
        Crossing { edge: 3 * triangle + down, below: corner[(down + 1) % 3], above: corner[down] }
    }

    /// From the edge by which the contour enters a triangle to the one by which it enters the next;
    /// [`crate::mesh::OPEN`] as its half-edge where there is none.
    #[inline(always)]
    pub(super) fn forward(&self, at: &mut Crossing, z: i32) {
        // Behind the third corner lies the up edge: on its far side if it is above, on its near
        // side if it is below.
        let far = previous(at.edge);
        let third = self.corner(far);
        let up = if third.z >= z {
            at.above = third;
            following(at.edge)
        } else {
            at.below = third;
            far
        };
        at.edge = self.twin[up] as usize;
    }

    /// From the edge by which the contour leaves a triangle to the one by which it enters it.
    #[inline(always)]
    pub(super) fn backward(&self, at: &mut Crossing, z: i32) {
        let far = previous(at.edge);
        let third = self.corner(far);
        if third.z >= z {
            at.above = third;
            at.edge = far;
        } else {
            at.below = third;
            at.edge = following(at.edge);
        }
    }
}

/// The next half-edge around a triangle.
fn following(edge: usize) -> usize {
    if edge % 3 == 2 { edge - 2 } else { edge + 1 }
}

/// The one before.
fn previous(edge: usize) -> usize {
    if edge.is_multiple_of(3) { edge + 2 } else { edge - 1 }
}
