// The triangles that have not collapsed, in the order of the facets.
// Twin: mesh::weld.

@group(0) @binding(1) var<storage, read> ids: array<u32>;
// Per facet the number of those kept before it; one more entry than facets.
@group(0) @binding(2) var<storage, read> place: array<u32>;
@group(0) @binding(3) var<storage, read_write> triangles: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let t = item_index(group, groups, lane);
    if t >= sizes.items {
        return;
    }
    let at = place[t];
    if place[t + 1u] != at {
        triangles[3u * at] = ids[3u * t];
        triangles[3u * at + 1u] = ids[3u * t + 1u];
        triangles[3u * at + 2u] = ids[3u * t + 2u];
    }
}
