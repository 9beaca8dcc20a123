//! A plane that sweeps upwards over sorted vertices, with a status structure of what it cuts.
//!
//! McMains and Séquin, "A coherent sweep plane slicer for layered manufacturing", Proc. 5th ACM Symposium
//! on Solid Modeling and Applications (1999). Between two vertices the plane cuts the same edges, so the
//! status changes at vertices only, and a plane just reads it off. The paper's status also holds the
//! contours' connectivity, from a boundary representation; here it holds the triangles that the plane
//! cuts with the two edges that it crosses in each, since all algorithms hand over segments.
//!
//! Time n log n for sorting, then n + p + m; memory n.

use super::{ALL_BELOW, FOLLOWING, Segment, corners, edges};
use crate::lattice::Point3;
use crate::mesh::Mesh;
use crate::slice::crossing;

/// No place in the status.
const ABSENT: u32 = u32::MAX;

/// The segments on each plane, in the order of the status; `planes` \[nm\], mesh frame, ascending.
pub fn run(mesh: &Mesh, planes: &[i32]) -> Vec<Vec<Segment>> {
    let mut events: Vec<u32> = (0..mesh.vertices.len() as u32).collect();
    events.sort_unstable_by_key(|&v| mesh.vertices[v as usize].z);
    let mut events = events.into_iter().peekable();
    let incidence = Incidence::new(mesh);
    let mut status = Status::new(mesh);
    let mut touched = Vec::new();
    let mut layers = Vec::with_capacity(planes.len());
    for &z in planes {
        while let Some(vertex) = events.next_if(|&v| mesh.vertices[v as usize].z < z) {
            for &corner in incidence.of(vertex) {
                status.below[corner as usize / 3] |= 1 << (corner % 3);
                touched.push(corner / 3);
            }
        }
        for triangle in touched.drain(..) {
            status.update(triangle);
        }
        layers.push(status.active.iter().map(|cut| cut.segment(z)).collect());
    }
    layers
}

/// Which corners of triangles each vertex is.
struct Incidence {
    /// Per vertex its first place; length = vertices + 1.
    base: Vec<u32>,
    /// Three times the triangle plus the corner.
    corners: Vec<u32>,
}

impl Incidence {
    fn new(mesh: &Mesh) -> Self {
        let mut base = vec![0u32; mesh.vertices.len() + 2];
        for &v in mesh.triangles.as_flattened() {
            base[v as usize + 2] += 1;
        }
        for v in 2..base.len() {
            base[v] += base[v - 1];
        }
        let mut corners = vec![0; 3 * mesh.triangles.len()];
        for (corner, &v) in mesh.triangles.as_flattened().iter().enumerate() {
            let cursor = &mut base[v as usize + 1];
            corners[*cursor as usize] = corner as u32;
            *cursor += 1;
        }
        Self { base, corners }
    }

    fn of(&self, vertex: u32) -> &[u32] {
        &self.corners[self.base[vertex as usize] as usize..self.base[vertex as usize + 1] as usize]
    }
}

/// A triangle that the plane cuts.
struct Cut {
    triangle: u32,
    /// The edge over which the contour enters.
    down: [Point3; 2],
    /// The edge over which it leaves.
    up: [Point3; 2],
}

impl Cut {
    fn segment(&self, z: i32) -> Segment {
        let cross = |[a, b]: [Point3; 2]| crossing::point(a, b, z);
        Segment { triangle: self.triangle, start: cross(self.down), end: cross(self.up) }
    }
}

/// What the plane cuts now.
struct Status<'a> {
    mesh: &'a Mesh,
    /// Per triangle a bit for each corner below the plane.
    below: Vec<u8>,
    /// Per triangle its place in `active`, or [`ABSENT`].
    place: Vec<u32>,
    active: Vec<Cut>,
}

impl<'a> Status<'a> {
    fn new(mesh: &'a Mesh) -> Self {
        let triangles = mesh.triangles.len();
        Self { mesh, below: vec![0; triangles], place: vec![ABSENT; triangles], active: Vec::new() }
    }

    /// Brings the status up to date with the corners of a triangle that lie below.
    fn update(&mut self, triangle: u32) {
        let place = self.place[triangle as usize];
        if self.below[triangle as usize] == ALL_BELOW {
            if place != ABSENT {
                self.place[triangle as usize] = ABSENT;
                self.active.swap_remove(place as usize);
                if let Some(moved) = self.active.get(place as usize) {
                    self.place[moved.triangle as usize] = place;
                }
            }
            return;
        }
        let cut = self.cut(triangle);
        if place == ABSENT {
            self.place[triangle as usize] = self.active.len() as u32;
            self.active.push(cut);
        } else {
            self.active[place as usize] = cut;
        }
    }

    fn cut(&self, triangle: u32) -> Cut {
        let corner = corners(self.mesh, triangle);
        let [down, up] = edges(self.below[triangle as usize]);
        let edge = |from: usize| [corner[from], corner[FOLLOWING[from]]];
        Cut { triangle, down: edge(down), up: edge(up) }
    }
}
