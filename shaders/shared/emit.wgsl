// Start and successor of a segment, for the kernels that emit them. The arithmetic is that of
// slice::crossing.

const OPEN: u32 = 0xffffffffu;

// Per half-edge of the piece the opposite one in the whole mesh, or OPEN.
@group(0) @binding(4) var<storage, read> twin: array<u32>;
// Per triangle of the whole mesh.
@group(0) @binding(5) var<storage, read> first: array<u32>;
// The same; one more entry than triangles: the last is the total.
@group(0) @binding(6) var<storage, read> offset: array<u32>;
// The segments of this dispatch.
@group(0) @binding(7) var<storage, read_write> start: array<vec2<i32>>;
@group(0) @binding(8) var<storage, read_write> next: array<u32>;

// One coordinate of a crossing, from the lower end of the edge, halves away from it.
fn along(lower: i32, upper: i32, rise: u32, dz: u32) -> i32 {
    let run = u32(max(lower, upper) - min(lower, upper));
    let step = i32(rounded_fraction(run, rise, dz));
    return select(lower - step, lower + step, upper >= lower);
}

// Where the edge between two vertices crosses a plane; the order of the vertices does not matter.
fn crossing(a: vec3<i32>, b: vec3<i32>, z: i32) -> vec2<i32> {
    let swap = a.z >= z;
    let lower = select(a, b, swap);
    let upper = select(b, a, swap);
    let dz = u32(upper.z - lower.z);
    let rise = u32(z - lower.z);
    return vec2<i32>(along(lower.x, upper.x, rise, dz), along(lower.y, upper.y, rise, dz));
}

// Writes the segment of a triangle of the piece, with these corners, on plane k into a place.
fn emit(t: u32, a: vec3<i32>, b: vec3<i32>, c: vec3<i32>, k: u32, place: u32) {
    let z = planes[k];
    // A vertex is above a plane iff z_vertex >= z_plane.
    let above_a = a.z >= z;
    let above_b = b.z >= z;
    let above_c = c.z >= z;
    // The half-edge that goes down through the plane is the way in, the one going up the way out.
    var tail = c;
    var head = a;
    if above_a && !above_b {
        tail = a;
        head = b;
    } else if above_b && !above_c {
        tail = b;
        head = c;
    }
    var up = 2u;
    if !above_a && above_b {
        up = 0u;
    } else if !above_b && above_c {
        up = 1u;
    }
    start[place] = crossing(tail, head, z);
    var successor = OPEN;
    let across = twin[3u * t + up];
    if across != OPEN {
        let neighbour = across / 3u;
        successor = offset[neighbour] + (k - first[neighbour]);
    }
    next[place] = successor;
}
