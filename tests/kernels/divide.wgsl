// The rounded 64-bit fraction of shared/wide.wgsl, one per item, for its own test.

struct DivideSizes {
    items: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

@group(0) @binding(0) var<uniform> sizes: DivideSizes;
// a, b, divisor.
@group(0) @binding(1) var<storage, read> operands: array<u32>;
// rounded_fraction(a, b, divisor), then the low and the high half of a * b.
@group(0) @binding(2) var<storage, read_write> results: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let i = item_index(group, groups, lane);
    if i >= sizes.items {
        return;
    }
    let a = operands[3u * i];
    let b = operands[3u * i + 1u];
    let product = wide_product(a, b);
    results[3u * i] = rounded_fraction(a, b, operands[3u * i + 2u]);
    results[3u * i + 1u] = product.low;
    results[3u * i + 2u] = product.high;
}
