// Writes a hash of every item's number and counts up what was there, so that an item missed, done
// twice or done under another number is seen.

struct FoldSizes {
    items: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> sizes: FoldSizes;
@group(0) @binding(1) var<storage, read_write> items: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = item_index(group, groups, lane);
    if i < sizes.items {
        items[i] += i * 2654435761u + 1u;
    }
}
