// Exclusive prefix sums within blocks of 2,048, and each block's sum. Sums wrap modulo 2^32.
// Twin: gpu::scan::twin::block.
//
// A multi-level scan: this kernel runs on the values, then on the block sums, and so on until one
// block is left; scan_add carries the sums back down. No look-back between running groups, because
// forward progress between groups is promised by no portable device.

struct ScanSizes {
    // Values to read; those beyond count as 0.
    input: u32,
    // Sums to write.
    output: u32,
    padding_0: u32,
    padding_1: u32,
}

const PER_LANE: u32 = 8u;

@group(0) @binding(0) var<uniform> sizes: ScanSizes;
@group(0) @binding(1) var<storage, read> values: array<u32>;
@group(0) @binding(2) var<storage, read_write> sums: array<u32>;
@group(0) @binding(3) var<storage, read_write> block_sums: array<u32>;

var<workgroup> lane_sums: array<u32, GROUP_SIZE>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group_index(group, groups);
    let begin = (block * GROUP_SIZE + lane) * PER_LANE;
    var own: array<u32, PER_LANE>;
    var sum = 0u;
    for (var i = 0u; i < PER_LANE; i += 1u) {
        own[i] = sum;
        if begin + i < sizes.input {
            sum += values[begin + i];
        }
    }
    // Inclusive sums over the lanes (Hillis and Steele 1986): eight doubling steps.
    lane_sums[lane] = sum;
    for (var reach = 1u; reach < GROUP_SIZE; reach <<= 1u) {
        workgroupBarrier();
        var before = 0u;
        if lane >= reach {
            before = lane_sums[lane - reach];
        }
        workgroupBarrier();
        lane_sums[lane] += before;
    }
    workgroupBarrier();
    let before = lane_sums[lane] - sum;
    for (var i = 0u; i < PER_LANE; i += 1u) {
        if begin + i < sizes.output {
            sums[begin + i] = before + own[i];
        }
    }
    if lane == GROUP_SIZE - 1u && begin - lane * PER_LANE < sizes.output {
        block_sums[block] = lane_sums[lane];
    }
}
