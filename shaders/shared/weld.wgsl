// What the welding kernels share: their sizes.

struct WeldSizes {
    // Items of the dispatch: coordinates, corners or facets.
    items: u32,
    // First corner of the part that is bound.
    corner: u32,
    // Places in the table.
    capacity: u32,
    // World position of the lattice's zero [nm], modulo 2^32.
    origin_x: u32,
    origin_y: u32,
    origin_z: u32,
    padding_0: u32,
    padding_1: u32,
}

@group(0) @binding(0) var<uniform> sizes: WeldSizes;
