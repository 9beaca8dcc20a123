// Adds to every sum what lies before its block of 2,048. Sums wrap modulo 2^32.
// Twin: gpu::scan::twin::add.

struct AddSizes {
    sums: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

const BLOCK: u32 = 2048u;

@group(0) @binding(0) var<uniform> sizes: AddSizes;
// Exclusive sums over whole blocks.
@group(0) @binding(1) var<storage, read> before: array<u32>;
@group(0) @binding(2) var<storage, read_write> sums: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = item_index(group, groups, lane);
    if i < sizes.sums {
        sums[i] += before[i / BLOCK];
    }
}
