// What the kernels share that keep of an area what another one does not reach: their arrays, and the step
// along a row. Spans are half-open, ascend within a row and do not touch; ends and widths are below 2^30,
// so that a longer span stays within 32 bits.

struct BeyondSizes {
    // Rows of all areas.
    rows: u32,
    padding_0: u32,
    padding_1: u32,
    padding_2: u32,
}

// Where a row meets the other area.
struct Place {
    // The first of the other area's rows in reach, as a number of its offsets.
    first: u32,
    // Rows in reach to either side.
    reach: u32,
    // Half width for the row itself; those further away follow.
    width: u32,
    padding: u32,
}

@group(0) @binding(0) var<uniform> sizes: BeyondSizes;
// Per row its first span; one more entry than rows.
@group(0) @binding(1) var<storage, read> offset: array<u32>;
@group(0) @binding(2) var<storage, read> spans: array<vec2<i32>>;
@group(0) @binding(3) var<storage, read> places: array<Place>;
// Per row of the other areas its first span; each area has one more entry than rows.
@group(0) @binding(4) var<storage, read> cover_offset: array<u32>;
@group(0) @binding(5) var<storage, read> cover: array<vec2<i32>>;
@group(0) @binding(6) var<storage, read> widths: array<i32>;

// From a position on a row: the end of what covers it, or the position itself, and where what lies behind
// it begins.
fn look(place: Place, at: i32) -> vec2<i32> {
    var covered = at;
    var next = 0x7fffffffi;
    for (var j = 0u; j <= 2u * place.reach; j += 1u) {
        let by = widths[place.width + select(j - place.reach, place.reach - j, j < place.reach)];
        let end = cover_offset[place.first + j + 1u];
        var low = cover_offset[place.first + j];
        var high = end;
        // The first span that ends behind the position.
        while low < high {
            let middle = low + ((high - low) >> 1u);
            if cover[middle].y + by > at {
                high = middle;
            } else {
                low = middle + 1u;
            }
        }
        if low < end {
            let span = cover[low];
            if span.x - by <= at {
                covered = max(covered, span.y + by);
            } else {
                next = min(next, span.x - by);
            }
        }
    }
    return vec2<i32>(covered, next);
}
