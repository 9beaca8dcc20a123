// The vertices in the order of their first corners.
// Twin: mesh::weld.

// Per corner the number of new ones before it; one more entry than corners.
@group(0) @binding(4) var<storage, read> number: array<u32>;
@group(0) @binding(5) var<storage, read_write> vertices: array<i32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = item_index(group, groups, lane);
    if corner >= sizes.items {
        return;
    }
    let id = number[corner];
    if number[corner + 1u] != id {
        vertices[3u * id] = xs[corner];
        vertices[3u * id + 1u] = ys[corner];
        vertices[3u * id + 2u] = zs[corner];
    }
}
