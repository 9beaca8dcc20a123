// Sorts the keys of every row and pairs them into maximal stretches of non-zero winding, which take the
// place of the keys: start and end, side by side, from the row's first place on.
// Twin: span::twin::sort.

// Rows of more keys are sorted through a heap.
const SHORT: u32 = 24u;

// Per bucket where its keys begin; one more entry than buckets.
@group(0) @binding(1) var<storage, read> row_offset: array<u32>;
@group(0) @binding(2) var<storage, read_write> keys: array<u32>;
// Per row its spans.
@group(0) @binding(3) var<storage, read_write> count: array<u32>;

fn insertion_sort(begin: u32, end: u32) {
    for (var i = begin + 1u; i < end; i += 1u) {
        let key = keys[i];
        var at = i;
        while at > begin && keys[at - 1u] > key {
            keys[at] = keys[at - 1u];
            at -= 1u;
        }
        keys[at] = key;
    }
}

// Lets a key sink from the top of a heap's part to its place.
fn sink(begin: u32, top: u32, length: u32, key: u32) {
    var at = top;
    loop {
        var child = 2u * at + 1u;
        if child >= length {
            break;
        }
        var larger = keys[begin + child];
        if child + 1u < length && keys[begin + child + 1u] > larger {
            child += 1u;
            larger = keys[begin + child];
        }
        if larger <= key {
            break;
        }
        keys[begin + at] = larger;
        at = child;
    }
    keys[begin + at] = key;
}

// Williams 1964, built bottom-up (Floyd 1964).
fn heap_sort(begin: u32, end: u32) {
    let length = end - begin;
    for (var i = length / 2u; i > 0u; i -= 1u) {
        sink(begin, i - 1u, length, keys[begin + i - 1u]);
    }
    for (var left = length - 1u; left > 0u; left -= 1u) {
        let key = keys[begin + left];
        keys[begin + left] = keys[begin];
        sink(begin, 0u, left, key);
    }
}

// The two's complement of a position along the row, from a key without its direction.
fn position(at: u32) -> u32 {
    return at - 0x40000000u;
}

// Pairs the sorted keys of a row and returns the number of spans. What lies at one position counts as a
// whole, so that spans are never empty and never touch.
fn pair(begin: u32, end: u32) -> u32 {
    var winding = 0i;
    var opened = 0u;
    var write = begin;
    var i = begin;
    while i < end {
        let at = keys[i] >> 1u;
        let before = winding;
        while i < end && (keys[i] >> 1u) == at {
            winding += select(1i, -1i, (keys[i] & 1u) == 1u);
            i += 1u;
        }
        if before == 0i && winding != 0i {
            opened = at;
        } else if before != 0i && winding == 0i {
            // A span has had two keys: what is written lies behind what is read.
            keys[write] = position(opened);
            keys[write + 1u] = position(at);
            write += 2u;
        }
    }
    return (write - begin) / 2u;
}

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
    let begin = row_offset[row + 1u];
    let end = row_offset[row + 2u];
    if end - begin <= SHORT {
        insertion_sort(begin, end);
    } else {
        heap_sort(begin, end);
    }
    count[row] = pair(begin, end);
}
