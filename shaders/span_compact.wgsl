// Moves the spans of all rows together.
// Twin: span::twin::compact.

// Per bucket where its keys began, and its spans now.
@group(0) @binding(1) var<storage, read> row_offset: array<u32>;
@group(0) @binding(2) var<storage, read> keys: array<u32>;
// Per row its first span; one more entry than rows.
@group(0) @binding(3) var<storage, read> span_offset: array<u32>;
@group(0) @binding(4) var<storage, read_write> spans: array<vec2<u32>>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = item_index(group, groups, lane);
    if row >= sizes.planes * sizes.rows {
        return;
    }
    let begin = span_offset[row];
    let count = span_offset[row + 1u] - begin;
    let from_place = row_offset[row + 1u];
    for (var i = 0u; i < count; i += 1u) {
        spans[begin + i] = vec2<u32>(keys[from_place + 2u * i], keys[from_place + 2u * i + 1u]);
    }
}
