// Keys for the first half of sorting half-edges by edge and direction: the higher vertex and the direction.

@group(0) @binding(2) var<storage, read_write> keys: array<u32>;
@group(0) @binding(3) var<storage, read_write> values: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let half_edge = item_index(group, groups, lane);
    if half_edge >= sizes.half_edges {
        return;
    }
    let edge = edge_of(half_edge);
    keys[half_edge] = 2u * edge.y + edge.z;
    values[half_edge] = half_edge;
}
