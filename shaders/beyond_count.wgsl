// How many spans of each row are left.
// Twin: span::beyond::twin::count.

@group(0) @binding(7) var<storage, read_write> count: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let row = item_index(group, groups, lane);
    if row >= sizes.rows {
        return;
    }
    let place = places[row];
    var left = 0u;
    for (var i = offset[row]; i < offset[row + 1u]; i += 1u) {
        let span = spans[i];
        var at = span.x;
        while at < span.y {
            let ahead = look(place, at);
            if ahead.x > at {
                at = ahead.x;
            } else {
                left += 1u;
                at = min(ahead.y, span.y);
            }
        }
    }
    count[row] = left;
}
