// The corners of all facets on the lattice, and a table of them. Corner 3 t + i is corner i of facet t.

@group(0) @binding(1) var<storage, read> xs: array<i32>;
@group(0) @binding(2) var<storage, read> ys: array<i32>;
@group(0) @binding(3) var<storage, read> zs: array<i32>;

fn same_place(a: u32, b: u32) -> bool {
    return xs[a] == xs[b] && ys[a] == ys[b] && zs[a] == zs[b];
}

// Mixes all bits into all bits (the finisher of Appleby's MurmurHash3).
fn mixed(bits: u32) -> u32 {
    var h = bits;
    h = (h ^ (h >> 16u)) * 0x85ebca6bu;
    h = (h ^ (h >> 13u)) * 0xc2b2ae35u;
    return h ^ (h >> 16u);
}

// Where the search for a corner's place in the table begins.
fn table_slot(corner: u32) -> u32 {
    let x = mixed(bitcast<u32>(xs[corner]) + 0x9e3779b9u);
    let y = mixed(bitcast<u32>(ys[corner]) + x);
    return wide_product(mixed(bitcast<u32>(zs[corner]) + y), sizes.capacity).high;
}

fn table_after(slot: u32) -> u32 {
    return select(slot + 1u, 0u, slot + 1u == sizes.capacity);
}
