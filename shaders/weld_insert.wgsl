// Enters every corner into an open-addressing table that keeps, for each place on the lattice, the first
// corner there. Which slot a place gets depends on the schedule, what it holds in the end does not; the
// table is read by weld_find alone.

// The bitwise complement of a corner, so that an empty slot is 0 and the first corner is the largest.
@group(0) @binding(4) var<storage, read_write> table: array<atomic<u32>>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let corner = item_index(group, groups, lane);
    if corner >= sizes.items {
        return;
    }
    var slot = table_slot(corner);
    // The table has more slots than there are corners, so a free one is always found.
    loop {
        var held = atomicLoad(&table[slot]);
        if held == 0u {
            let outcome = atomicCompareExchangeWeak(&table[slot], 0u, ~corner);
            if outcome.exchanged {
                return;
            }
            held = outcome.old_value;
            if held == 0u {
                // It may fail for no reason.
                continue;
            }
        }
        // A slot once taken only ever holds corners at one place.
        if same_place(~held, corner) {
            if held < ~corner {
                atomicMax(&table[slot], ~corner);
            }
            return;
        }
        slot = table_after(slot);
    }
}
