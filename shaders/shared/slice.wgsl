// What the slicing kernels share: their sizes and the mesh.

struct SliceSizes {
    // Triangles of this dispatch.
    triangles: u32,
    planes: u32,
    // Number, in the whole mesh, of the first triangle of the piece that is bound.
    piece: u32,
    // The dispatch's first triangle, counted from the piece's first.
    begin: u32,
    // Slot, in the whole run, of the dispatch's first segment.
    slot: u32,
    // Segments of this dispatch.
    segments: u32,
    padding_0: u32,
    padding_1: u32,
}

@group(0) @binding(0) var<uniform> sizes: SliceSizes;
// x, y, z of every vertex [nm]; flat, because an array of vec3 would be padded to 16 bytes.
@group(0) @binding(1) var<storage, read> vertices: array<i32>;
// Three vertex ids per triangle of the piece.
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
// Heights of the planes [nm], ascending.
@group(0) @binding(3) var<storage, read> planes: array<i32>;

fn vertex(id: u32) -> vec3<i32> {
    return vec3<i32>(vertices[3u * id], vertices[3u * id + 1u], vertices[3u * id + 2u]);
}
