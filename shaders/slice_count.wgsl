// Per triangle the first plane that it meets and how many it meets. `first` and `count` are those of
// the whole mesh.
// Twin: slice::cpu::count.

@group(0) @binding(4) var<storage, read_write> first: array<u32>;
@group(0) @binding(5) var<storage, read_write> count: array<u32>;

// How many planes lie at or below a height, known to be at least `low` and at most `high`.
fn planes_up_to(z: i32, least: u32, most: u32) -> u32 {
    var low = least;
    var high = most;
    while low < high {
        let middle = low + ((high - low) >> 1u);
        if planes[middle] <= z {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    return low;
}

// The same, when the answer is likely to be close to `least`: most triangles meet few planes.
fn planes_up_to_nearby(z: i32, least: u32) -> u32 {
    var low = least;
    var high = least;
    var step = 1u;
    while high < sizes.planes && planes[high] <= z {
        low = high + 1u;
        high += step;
        step <<= 1u;
    }
    return planes_up_to(z, low, min(high, sizes.planes));
}

fn height(corner: u32) -> i32 {
    return vertices[3u * triangles[corner] + 2u];
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let item = item_index(group, groups, lane);
    if item >= sizes.triangles {
        return;
    }
    let t = sizes.begin + item;
    let a = height(3u * t);
    let b = height(3u * t + 1u);
    let c = height(3u * t + 2u);
    let begin = planes_up_to(min(a, min(b, c)), 0u, sizes.planes);
    first[sizes.piece + t] = begin;
    count[sizes.piece + t] = planes_up_to_nearby(max(a, max(b, c)), begin) - begin;
}
