//! A mesh that stays on the device.

use crate::gpu::{Buffer, Device, GpuError};
use crate::lattice::Point3;
use crate::mesh::{Adjacency, Mesh};
use std::ops::Range;

/// Bytes of a triangle's vertex ids, also of its half-edges' links.
const PER_TRIANGLE: u64 = 12;

/// A mesh on the device, to be sliced as often as wished.
///
/// Where an array exceeds a binding, the triangles lie in pieces of consecutive ones; links lead from
/// piece to piece by the numbers that triangles have in the whole mesh.
pub struct GpuMesh {
    /// One for all pieces, or one for each.
    pub(super) vertices: Vec<Buffer<Point3>>,
    pub(super) pieces: Vec<Piece>,
    triangles: usize,
}

/// Consecutive triangles that fit a binding.
pub(super) struct Piece {
    /// Their numbers in the whole mesh.
    pub range: Range<usize>,
    /// Which of the mesh's vertex arrays their ids mean.
    pub vertices: usize,
    pub triangles: Buffer<[u32; 3]>,
    /// Half-edges in the whole mesh.
    pub twin: Buffer<u32>,
}

impl GpuMesh {
    /// A mesh without triangles, and without memory.
    pub(super) const fn empty() -> Self {
        Self { vertices: Vec::new(), pieces: Vec::new(), triangles: 0 }
    }

    /// A mesh of one piece.
    pub(super) fn of(vertices: Buffer<Point3>, piece: Piece) -> Self {
        let triangles = piece.range.len();
        Self { vertices: vec![vertices], pieces: vec![piece], triangles }
    }

    /// Number of triangles.
    pub const fn triangles(&self) -> usize {
        self.triangles
    }

    /// Bytes of device memory.
    pub fn bytes(&self) -> u64 {
        let pieces = self.pieces.iter().map(|piece| piece.triangles.held() + piece.twin.held());
        self.vertices.iter().map(Buffer::held).chain(pieces).sum()
    }

    /// Number of pieces in which the triangles lie.
    pub const fn pieces(&self) -> usize {
        self.pieces.len()
    }

    /// Makes this a copy of a mesh, in the memory that it has.
    pub(super) fn replace(
        &mut self,
        device: &Device,
        mesh: &Mesh,
        adjacency: &Adjacency,
    ) -> Result<(), GpuError> {
        let (edges, triangles) = (adjacency.twin.len(), mesh.triangles.len());
        if edges != 3 * triangles {
            return Err(GpuError::Validation(format!("{edges} half-edges for {triangles} triangles")));
        }
        let limit = device.limits().binding;
        let needs = 4 * (triangles as u64 + 1);
        if needs > limit {
            return Err(GpuError::TooLarge { what: "the plane counts", unit: "bytes", needs, limit });
        }
        let shared = mesh.vertices.len() as u64 * size_of::<Point3>() as u64 <= limit;
        let ranges = cut(mesh, limit, shared);
        self.pieces.truncate(ranges.len());
        self.vertices.truncate(if shared { 1 } else { ranges.len() });
        self.triangles = triangles;
        let mut local =
            Local { ids: vec![u32::MAX; if shared { 0 } else { mesh.vertices.len() }], points: Vec::new() };
        if shared {
            put(device, &mut self.vertices, 0, "the mesh's vertices", &mesh.vertices)?;
        }
        for (i, range) in ranges.into_iter().enumerate() {
            let triangles = &mesh.triangles[range.clone()];
            let own = if shared { Vec::new() } else { local.triangles(mesh, triangles) };
            if !shared {
                put(device, &mut self.vertices, i, "the vertices of a piece", &local.points)?;
            }
            let triangles = if shared { triangles } else { &own };
            let twin = &adjacency.twin[3 * range.start..3 * range.end];
            let vertices = if shared { 0 } else { i };
            match self.pieces.get_mut(i) {
                Some(piece) => {
                    piece.triangles.replace(device, triangles)?;
                    piece.twin.replace(device, twin)?;
                    (piece.range, piece.vertices) = (range, vertices);
                }
                None => self.pieces.push(Piece {
                    triangles: Buffer::upload(device, "the mesh's triangles", triangles)?,
                    twin: Buffer::upload(device, "the mesh's adjacency", twin)?,
                    range,
                    vertices,
                }),
            }
        }
        Ok(())
    }
}

fn put(
    device: &Device,
    buffers: &mut Vec<Buffer<Point3>>,
    at: usize,
    what: &'static str,
    data: &[Point3],
) -> Result<(), GpuError> {
    match buffers.get_mut(at) {
        Some(buffer) => buffer.replace(device, data),
        None => {
            buffers.push(Buffer::upload(device, what, data)?);
            Ok(())
        }
    }
}

/// Cuts the triangles into pieces that fit a binding, with their vertices where these are not shared.
fn cut(mesh: &Mesh, limit: u64, shared: bool) -> Vec<Range<usize>> {
    let count = mesh.triangles.len();
    let most = ((limit / PER_TRIANGLE) as usize).max(1);
    if shared {
        let pieces = count.div_ceil(most).max(1);
        return (0..pieces).map(|i| i * most..count.min((i + 1) * most)).collect();
    }
    let most_vertices = ((limit / size_of::<Point3>() as u64) as usize).max(3);
    // Per vertex the last piece that has it, counted from 1.
    let mut last = vec![0u32; mesh.vertices.len()];
    let mut ranges = Vec::new();
    let (mut from, mut vertices, mut piece) = (0, 0, 1);
    for (t, triangle) in mesh.triangles.iter().enumerate() {
        let new = triangle.iter().filter(|&&v| last[v as usize] != piece).count();
        if t - from == most || vertices + new > most_vertices {
            ranges.push(from..t);
            (from, vertices, piece) = (t, 0, piece + 1);
        }
        for &v in triangle {
            vertices += usize::from(last[v as usize] != piece);
            last[v as usize] = piece;
        }
    }
    ranges.push(from..count);
    ranges
}

/// The vertices of one piece under numbers of their own.
struct Local {
    /// Per vertex of the mesh its number here, or `u32::MAX`.
    ids: Vec<u32>,
    points: Vec<Point3>,
}

impl Local {
    /// The triangles of a piece under the piece's vertex numbers; `points` are then its vertices.
    fn triangles(&mut self, mesh: &Mesh, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
        self.points.clear();
        let mut renumber = |v: u32| {
            let id = &mut self.ids[v as usize];
            if *id == u32::MAX {
                *id = self.points.len() as u32;
                self.points.push(mesh.vertices[v as usize]);
            }
            *id
        };
        let own = triangles.iter().map(|t| t.map(&mut renumber)).collect();
        triangles.iter().flatten().for_each(|&v| self.ids[v as usize] = u32::MAX);
        own
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn pieces_cover_all_triangles_and_fit() {
        let mesh = shapes::sphere(10.0, 30, 20);
        for limit in [36, 48, 1_000, 4_096, 1 << 20] {
            for shared in [false, true] {
                let ranges = cut(&mesh, limit, shared);
                assert_eq!((ranges[0].start, ranges[ranges.len() - 1].end), (0, mesh.triangles.len()));
                assert!(ranges.windows(2).all(|w| w[0].end == w[1].start));
                let mut local = Local { ids: vec![u32::MAX; mesh.vertices.len()], points: Vec::new() };
                for range in ranges {
                    let triangles = &mesh.triangles[range];
                    assert!(12 * triangles.len() as u64 <= limit);
                    let own = local.triangles(&mesh, triangles);
                    assert!(shared || 12 * local.points.len() as u64 <= limit, "{limit}");
                    for (own, whole) in own.iter().zip(triangles) {
                        let points = own.map(|v| local.points[v as usize]);
                        assert_eq!(points, whole.map(|v| mesh.vertices[v as usize]));
                    }
                }
            }
        }
        assert_eq!(cut(&Mesh::default(), 100, true), vec![0..0]);
    }
}
