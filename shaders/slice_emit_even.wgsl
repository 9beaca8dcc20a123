// Start and successor of every segment, one invocation per segment: where some triangles meet many
// planes, so that invocations per triangle would differ widely in their work, or be few.
// Twin: slice::cpu::emit, the same bits as slice_emit.

// The triangles of the workgroup's first and last segment.
var<workgroup> ends: array<u32, 2>;

// The triangle that owns a slot: the last one whose offset is not above it. It is known to lie
// between `least` and `most`, counted from the piece's first triangle.
fn owner(slot: u32, least: u32, most: u32) -> u32 {
    var low = least;
    var high = most;
    while low < high {
        let middle = low + ((high - low + 1u) >> 1u);
        if offset[sizes.piece + middle] <= slot {
            low = middle;
        } else {
            high = middle - 1u;
        }
    }
    return low;
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let begin = group_index(group, groups) * GROUP_SIZE;
    // Two searches among all triangles per workgroup, the others among the few in between.
    if lane < 2u {
        let edge = min(begin + lane * (GROUP_SIZE - 1u), sizes.segments - 1u);
        ends[lane] = owner(sizes.slot + edge, sizes.begin, sizes.begin + sizes.triangles - 1u);
    }
    workgroupBarrier();
    let place = begin + lane;
    if place >= sizes.segments {
        return;
    }
    let slot = sizes.slot + place;
    let t = owner(slot, ends[0], ends[1]);
    let a = vertex(triangles[3u * t]);
    let b = vertex(triangles[3u * t + 1u]);
    let c = vertex(triangles[3u * t + 2u]);
    let k = first[sizes.piece + t] + (slot - offset[sizes.piece + t]);
    emit(t, a, b, c, k, place);
}
