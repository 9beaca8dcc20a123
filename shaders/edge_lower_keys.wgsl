// Keys for the second half of sorting half-edges by edge and direction: the lower vertex.

@group(0) @binding(2) var<storage, read> values: array<u32>;
@group(0) @binding(3) var<storage, read_write> keys: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = item_index(group, groups, lane);
    if place < sizes.half_edges {
        keys[place] = edge_of(values[place]).x;
    }
}
