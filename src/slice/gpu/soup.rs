//! Raw triangles to a resident mesh, on the device from the first to the last step.
//!
//! Twins: [`crate::mesh::load()`] for vertices and triangles, [`Adjacency::build`] for the links.

use super::GpuSlicer;
use super::flight::kernels_alone;
use super::mesh::{GpuMesh, Piece};
use super::nanoseconds;
use crate::gpu::dispatch::Recording;
use crate::gpu::scan::{self, Scratch};
use crate::gpu::sort::Sorter;
use crate::gpu::{Buffer, Device, GpuError};
use crate::lattice::Point3;
use crate::mesh::Adjacency;
use crate::mesh::load::FACET_LIMIT;
use crate::shaders::{
    EDGE_KEYS, EDGE_LOWER_KEYS, EDGE_PAIRS, EdgeSizes, WELD_CORNERS, WELD_FACETS, WELD_FIND, WELD_INSERT,
    WELD_TRIANGLES, WELD_VERTICES, WeldSizes,
};
use std::time::Instant;

/// Device memory per facet while welding \[bytes\]: floats, lattice points, table, four arrays per corner and
/// two per facet; afterwards less.
const BYTES_PER_FACET: u64 = 36 + 36 + 16 + 4 * 12 + 8;

/// A mesh built on the device.
pub struct Built {
    /// The mesh.
    pub mesh: GpuMesh,
    /// Unique vertices.
    pub vertices: u64,
    /// Facets dropped because two of their corners are one point of the lattice.
    pub collapsed: u64,
}

/// The arrays of a mesh, brought back from the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Arrays {
    /// As in [`crate::mesh::Mesh`].
    pub vertices: Vec<Point3>,
    /// As in [`crate::mesh::Mesh`].
    pub triangles: Vec<[u32; 3]>,
    /// The links.
    pub adjacency: Adjacency,
}

impl GpuSlicer {
    /// Builds a mesh from raw facets \[mm\]: puts the corners on the lattice, welds them and pairs the
    /// half-edges. `origin` is the world position of the lattice's zero \[nm\], as
    /// [`crate::mesh::load()`] finds it; every corner must lie within the lattice's reach of it.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] when an array exceeds a binding, [`GpuError::Budget`] when all of them exceed
    /// the budget (144 bytes a facet); [`Self::upload`] takes larger meshes.
    pub fn build(&mut self, facets: &[[[f32; 3]; 3]], origin: [i64; 3]) -> Result<Built, GpuError> {
        let count = facets.len() as u64;
        let (needs, budget) = (count * BYTES_PER_FACET, self.budget);
        if needs > budget {
            return Err(GpuError::Budget { what: "joining the facets", needs, budget });
        }
        if count > FACET_LIMIT {
            return Err(GpuError::TooLarge {
                what: "a mesh",
                unit: "facets",
                needs: count,
                limit: FACET_LIMIT,
            });
        }
        let corners = Corners::upload(self, facets, origin)?;
        let (vertices, triangles) = corners.weld(self)?;
        let twin = pair(self, vertices.len(), &triangles)?;
        let (found, kept) = (vertices.len() as u64, triangles.len());
        let piece = Piece { range: 0..kept, vertices: 0, triangles, twin };
        let mesh = GpuMesh::of(vertices, piece);
        Ok(Built { mesh, vertices: found, collapsed: count - kept as u64 })
    }

    /// Brings a mesh back.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] for a mesh whose vertices lie in several pieces; a lost or hung device.
    pub fn download(&mut self, mesh: &GpuMesh) -> Result<Arrays, GpuError> {
        let device = &*self.device;
        let [vertices] = &mesh.vertices[..] else {
            let (needs, limit) = (mesh.vertices.len() as u64, 1);
            return Err(GpuError::TooLarge { what: "a mesh to bring back", unit: "pieces", needs, limit });
        };
        let mut recording = Recording::new(device, false)?;
        let vertices = recording.read_back(vertices)?;
        let mut pieces = Vec::new();
        for piece in &mesh.pieces {
            pieces.push((recording.read_back(&piece.triangles)?, recording.read_back(&piece.twin)?));
        }
        let submission = recording.submit()?;
        let mut arrays = Arrays {
            vertices: vertices.take(device, &submission)?,
            triangles: Vec::new(),
            adjacency: Adjacency::default(),
        };
        for (triangles, twin) in pieces {
            triangles.take_into(device, &submission, &mut arrays.triangles)?;
            twin.take_into(device, &submission, &mut arrays.adjacency.twin)?;
        }
        Ok(arrays)
    }
}

/// The corners of all facets on the lattice.
struct Corners {
    facets: usize,
    x: Buffer<i32>,
    y: Buffer<i32>,
    z: Buffer<i32>,
}

impl Corners {
    /// Sends the floats, in parts where they exceed a binding, and rounds them to the lattice.
    fn upload(slicer: &mut GpuSlicer, facets: &[[[f32; 3]; 3]], origin: [i64; 3]) -> Result<Self, GpuError> {
        let GpuSlicer { device, times, .. } = slicer;
        let array = |what| Buffer::zeroed(device, what, 3 * facets.len());
        let (x, y, z) = (array("the corners' x")?, array("the corners' y")?, array("the corners' z")?);
        let [origin_x, origin_y, origin_z] = origin.map(|nm| nm as u32);
        let most = ((device.limits().binding / 36) as usize).max(1);
        for (i, part) in facets.chunks(most).enumerate() {
            let begun = Instant::now();
            let raw = Buffer::upload(device, "the facets", part)?;
            if let Some(times) = times {
                device.flush()?;
                times.copies.uploaded += size_of_val(part) as u64;
                times.copies.upload += nanoseconds(begun);
            }
            let begun = Instant::now();
            let mut recording = Recording::new(device, times.is_some())?;
            let sizes = WeldSizes {
                items: 9 * part.len() as u32,
                corner: 3 * (i * most) as u32,
                origin_x,
                origin_y,
                origin_z,
                ..WeldSizes::default()
            };
            recording.dispatch(&WELD_CORNERS, &sizes, &[&raw, &x, &y, &z], u64::from(sizes.items))?;
            kernels_alone(device, recording, begun, times)?.submit()?;
        }
        Ok(Self { facets: facets.len(), x, y, z })
    }

    /// Unique vertices in the order of their first corners, and the triangles between them.
    fn weld(self, slicer: &mut GpuSlicer) -> Result<(Buffer<Point3>, Buffer<[u32; 3]>), GpuError> {
        let GpuSlicer { device, times, .. } = slicer;
        let device: &Device = device;
        let Self { facets, x, y, z } = self;
        let corners = 3 * facets;
        // One third more than could ever be needed: a closed mesh fills an eighth of it.
        let capacity = corners + facets + 1;
        let table = Buffer::<u32>::zeroed(device, "the corners' table", capacity)?;
        let array = |what, len| Buffer::<u32>::zeroed(device, what, len);
        let (earliest, is_new) = (array("first corners", corners)?, array("new corners", corners)?);
        let (number, ids) = (array("vertex numbers", corners + 1)?, array("vertex ids", corners)?);
        let (keep, place) = (array("facets kept", facets)?, array("triangle numbers", facets + 1)?);
        let sizes = |items: usize| WeldSizes {
            items: items as u32,
            capacity: capacity as u32,
            ..WeldSizes::default()
        };
        let mut scratch = Scratch::default();
        let begun = Instant::now();
        let mut recording = Recording::new(device, times.is_some())?;
        let each_corner = corners as u64;
        recording.dispatch(&WELD_INSERT, &sizes(corners), &[&x, &y, &z, &table], each_corner)?;
        let arrays: [&dyn crate::gpu::dispatch::Bind; 6] = [&x, &y, &z, &table, &earliest, &is_new];
        recording.dispatch(&WELD_FIND, &sizes(corners), &arrays, each_corner)?;
        scan::record(device, &mut recording, &mut scratch, &is_new, &number)?;
        let arrays: [&dyn crate::gpu::dispatch::Bind; 4] = [&earliest, &number, &ids, &keep];
        recording.dispatch(&WELD_FACETS, &sizes(facets), &arrays, facets as u64)?;
        scan::record(device, &mut recording, &mut scratch, &keep, &place)?;
        let mut recording = kernels_alone(device, recording, begun, times)?;
        let found = recording.read_back_part(&number, corners..corners + 1)?;
        let kept = recording.read_back_part(&place, facets..facets + 1)?;
        let submission = recording.submit()?;
        let last = |counts: Vec<u32>| counts.last().copied().unwrap_or(0) as usize;
        let found = last(found.take(device, &submission)?);
        let kept = last(kept.take(device, &submission)?);
        let vertices = Buffer::zeroed(device, "the mesh's vertices", found)?;
        let triangles = Buffer::zeroed(device, "the mesh's triangles", kept)?;
        let begun = Instant::now();
        let mut recording = Recording::new(device, times.is_some())?;
        let arrays: [&dyn crate::gpu::dispatch::Bind; 5] = [&x, &y, &z, &number, &vertices];
        recording.dispatch(&WELD_VERTICES, &sizes(corners), &arrays, each_corner)?;
        recording.dispatch(&WELD_TRIANGLES, &sizes(facets), &[&ids, &place, &triangles], facets as u64)?;
        kernels_alone(device, recording, begun, times)?.submit()?;
        Ok((vertices, triangles))
    }
}

/// Pairs the half-edges of triangles between `vertices` vertices.
fn pair(
    slicer: &mut GpuSlicer,
    vertices: usize,
    triangles: &Buffer<[u32; 3]>,
) -> Result<Buffer<u32>, GpuError> {
    let GpuSlicer { device, times, .. } = slicer;
    let device: &Device = device;
    let half_edges = 3 * triangles.len();
    let twin = Buffer::zeroed(device, "the mesh's adjacency", half_edges)?;
    let sizes = EdgeSizes { half_edges: half_edges as u32, padding: [0; 3] };
    let items = half_edges as u64;
    // Of a vertex id; a key of the first sort is one longer.
    let bits = usize::BITS - vertices.saturating_sub(1).leading_zeros();
    if bits > 31 {
        let (what, unit, limit) = ("a mesh to be paired", "vertices", 1 << 31);
        return Err(GpuError::TooLarge { what, unit, needs: vertices as u64, limit });
    }
    let mut sorter = Sorter::new(device, half_edges)?;
    let begun = Instant::now();
    let mut recording = Recording::new(device, times.is_some())?;
    let arrays: [&dyn crate::gpu::dispatch::Bind; 3] = [triangles, sorter.keys(), sorter.values()];
    recording.dispatch(&EDGE_KEYS, &sizes, &arrays, items)?;
    sorter.record(device, &mut recording, bits + 1)?;
    let arrays: [&dyn crate::gpu::dispatch::Bind; 3] = [triangles, sorter.values(), sorter.keys()];
    recording.dispatch(&EDGE_LOWER_KEYS, &sizes, &arrays, items)?;
    sorter.record(device, &mut recording, bits)?;
    recording.dispatch(&EDGE_PAIRS, &sizes, &[triangles, sorter.values(), &twin], items)?;
    kernels_alone(device, recording, begun, times)?.submit()?;
    Ok(twin)
}
