// The segments of a run, for the kernels that read them.

// Where each segment begins [nm].
@group(0) @binding(1) var<storage, read> start: array<vec2<i32>>;
// The segment that begins where this one ends, or OPEN.
@group(0) @binding(2) var<storage, read> next: array<u32>;

// Coordinates along and across the rows; |x| and |y| are below 2^30.
fn along_and_across(p: vec2<i32>) -> vec2<i32> {
    return vec2<i32>(sizes.a * p.x + sizes.b * p.y, sizes.a * p.y - sizes.b * p.x);
}
