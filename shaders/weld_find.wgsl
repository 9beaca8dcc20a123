// Per corner the first corner at its place, and whether that is itself.
// Twin: the order in which mesh::weld numbers vertices.

@group(0) @binding(4) var<storage, read> table: array<u32>;
@group(0) @binding(5) var<storage, read_write> earliest: array<u32>;
@group(0) @binding(6) var<storage, read_write> is_new: array<u32>;

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
    var slot = table_slot(corner);
    var found = ~table[slot];
    // All corners are in the table: the search ends.
    while !same_place(found, corner) {
        slot = table_after(slot);
        found = ~table[slot];
    }
    earliest[corner] = found;
    is_new[corner] = select(0u, 1u, found == corner);
}
