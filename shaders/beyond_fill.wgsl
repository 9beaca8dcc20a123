// The spans that are left, row by row.
// Twin: span::beyond::twin::fill.

// Per row its first span that is left; one more entry than rows.
@group(0) @binding(7) var<storage, read> left_offset: array<u32>;
@group(0) @binding(8) var<storage, read_write> left: array<vec2<i32>>;

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
    var to = left_offset[row];
    for (var i = offset[row]; i < offset[row + 1u]; i += 1u) {
        let span = spans[i];
        var at = span.x;
        while at < span.y {
            let ahead = look(place, at);
            if ahead.x > at {
                at = ahead.x;
            } else {
                let end = min(ahead.y, span.y);
                left[to] = vec2<i32>(at, end);
                to += 1u;
                at = end;
            }
        }
    }
}
