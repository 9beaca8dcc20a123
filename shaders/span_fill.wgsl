// Puts every crossing into its bucket: one invocation per crossing, because a segment may cross one row
// or thousands. The order within a bucket depends on the schedule; span_sort follows.
// Twin: span::twin::fill, up to that order.

// Per segment its first crossing; one more entry than segments.
@group(0) @binding(3) var<storage, read> offset: array<u32>;
@group(0) @binding(4) var<storage, read> bucket: array<u32>;
// Per bucket where its keys begin.
@group(0) @binding(5) var<storage, read> row_offset: array<u32>;
// Per bucket how many keys it still expects.
@group(0) @binding(6) var<storage, read_write> expected: array<atomic<u32>>;
@group(0) @binding(7) var<storage, read_write> keys: array<u32>;

// Where the edge from `low` up to `high`, both (s, t), meets t: rounded to the nearest unit, halves
// towards +s. Differences are below 2^31.
fn crossing(low: vec2<i32>, high: vec2<i32>, t: i32) -> i32 {
    let dt = u32(high.y - low.y);
    let u = u32(t - low.y);
    if high.x >= low.x {
        return low.x + i32(rounded_fraction(u32(high.x - low.x), u, dt));
    }
    // Going left halves are rounded down.
    let product = wide_product(u32(low.x - high.x), u);
    return low.x - i32(wide_quotient(wide_sum(product, (dt - 1u) >> 1u), dt));
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let begin = group_index(group, groups) * GROUP_SIZE;
    find_ends(begin, lane, sizes.crossings, sizes.segments);
    workgroupBarrier();
    let item = begin + lane;
    if item >= sizes.crossings {
        return;
    }
    let slot = owner(item, ends[0], ends[1]);
    let place = bucket[slot] + (item - offset[slot]);
    let row = (place - 1u) % sizes.rows;
    let above = row / sizes.sub_rows * sizes.pitch + row_offset_in_line(row % sizes.sub_rows);
    let t = bitcast<i32>(bitcast<u32>(sizes.base) + above);
    let p = along_and_across(start[slot]);
    let q = along_and_across(start[next[slot]]);
    let up = q.y > p.y;
    let s = crossing(select(q, p, up), select(p, q, up), t);
    // Sorts by s; below it the direction.
    let key = ((bitcast<u32>(s) + 0x40000000u) << 1u) | select(0u, 1u, up);
    keys[row_offset[place] + atomicSub(&expected[place], 1u) - 1u] = key;
}
