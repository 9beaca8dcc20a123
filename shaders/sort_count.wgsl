// How often each digit occurs in each block of 2,048 keys, digit by digit.

@group(0) @binding(2) var<storage, read_write> counts: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group_index(group, groups);
    tally_keys((block * GROUP_SIZE + lane) * PER_LANE, lane);
    sum_words(lane);
    if lane < 2u * WORDS && block < sizes.blocks {
        counts[lane * sizes.blocks + block] = count_in(sums[(lane >> 1u) * 32u + 31u], lane);
    }
}
