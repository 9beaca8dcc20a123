// The dispatch grid folded into two dimensions: one dimension reaches only 65,535 groups.
// The twin of this arithmetic is `Grid` in src/gpu/dispatch.rs.

const GROUP_SIZE: u32 = 256u;

// Serial number of a workgroup. The grid's last row may be longer than needed: callers compare the
// item against the length.
fn group_index(group: vec3<u32>, groups: vec3<u32>) -> u32 {
    return group.y * groups.x + group.x;
}

// Serial number of an invocation.
fn item_index(group: vec3<u32>, groups: vec3<u32>, lane: u32) -> u32 {
    return group_index(group, groups) * GROUP_SIZE + lane;
}
