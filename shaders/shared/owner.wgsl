// Which of consecutive ranges an item lies in. `offset` holds where each range begins; the kernel
// declares it.

// The ranges of the workgroup's first and last item.
var<workgroup> ends: array<u32, 2>;

// The last range whose beginning is not above an item, known to lie between `least` and `most`.
fn owner(item: u32, least: u32, most: u32) -> u32 {
    var low = least;
    var high = most;
    while low < high {
        let middle = low + ((high - low + 1u) >> 1u);
        if offset[middle] <= item {
            low = middle;
        } else {
            high = middle - 1u;
        }
    }
    return low;
}

// Searches among all ranges for the workgroup's ends alone; behind a barrier each item's range is then
// found among the few in between.
fn find_ends(begin: u32, lane: u32, items: u32, ranges: u32) {
    if lane < 2u {
        let item = min(begin + lane * (GROUP_SIZE - 1u), items - 1u);
        ends[lane] = owner(item, 0u, ranges - 1u);
    }
}
