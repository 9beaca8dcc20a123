// What the slicing kernels share: their sizes and the mesh.

struct SliceSizes {
    triangles: u32,
    planes: u32,
    padding_0: u32,
    padding_1: u32,
}

@group(0) @binding(0) var<uniform> sizes: SliceSizes;
// x, y, z of every vertex [nm]; flat, because an array of vec3 would be padded to 16 bytes.
@group(0) @binding(1) var<storage, read> vertices: array<i32>;
// Three vertex ids per triangle.
@group(0) @binding(2) var<storage, read> triangles: array<u32>;
// Heights of the planes [nm], ascending.
@group(0) @binding(3) var<storage, read> planes: array<i32>;

fn vertex(id: u32) -> vec3<i32> {
    return vec3<i32>(vertices[3u * id], vertices[3u * id + 1u], vertices[3u * id + 2u]);
}
