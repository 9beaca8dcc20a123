// Start and successor of every segment, one invocation per triangle: where triangles meet few planes.
// Twin: slice::cpu::emit.

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let item = item_index(group, groups, lane);
    if item >= sizes.triangles {
        return;
    }
    let t = sizes.begin + item;
    let slot = offset[sizes.piece + t];
    let count = offset[sizes.piece + t + 1u] - slot;
    if count == 0u {
        return;
    }
    let a = vertex(triangles[3u * t]);
    let b = vertex(triangles[3u * t + 1u]);
    let c = vertex(triangles[3u * t + 2u]);
    let begin = first[sizes.piece + t];
    for (var i = 0u; i < count; i += 1u) {
        emit(t, a, b, c, begin + i, slot - sizes.slot + i);
    }
}
