// What the kernels that pair half-edges share. Half-edge 3 t + i runs from corner i of triangle t to the
// next corner.

struct EdgeSizes {
    half_edges: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> sizes: EdgeSizes;
@group(0) @binding(1) var<storage, read> triangles: array<u32>;

// Lower and higher vertex of a half-edge's edge, and 1 if it runs from the lower to the higher.
fn edge_of(half_edge: u32) -> vec3<u32> {
    let from_vertex = triangles[half_edge];
    let to_vertex = triangles[select(half_edge + 1u, half_edge - 2u, half_edge % 3u == 2u)];
    let forth = select(0u, 1u, from_vertex < to_vertex);
    return vec3<u32>(min(from_vertex, to_vertex), max(from_vertex, to_vertex), forth);
}
