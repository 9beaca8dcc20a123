// Per facet its three vertex ids, and whether they differ.

@group(0) @binding(1) var<storage, read> earliest: array<u32>;
// Per corner the number of new ones before it: the vertex id of a new one.
@group(0) @binding(2) var<storage, read> number: array<u32>;
@group(0) @binding(3) var<storage, read_write> ids: array<u32>;
@group(0) @binding(4) var<storage, read_write> keep: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let t = item_index(group, groups, lane);
    if t >= sizes.items {
        return;
    }
    let a = number[earliest[3u * t]];
    let b = number[earliest[3u * t + 1u]];
    let c = number[earliest[3u * t + 2u]];
    ids[3u * t] = a;
    ids[3u * t + 1u] = b;
    ids[3u * t + 2u] = c;
    keep[t] = select(0u, 1u, a != b && b != c && c != a);
}
