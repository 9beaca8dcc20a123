// Pairs, on every edge, the i-th half-edge one way with the i-th the other way, by half-edge id.
// Twin: mesh::Adjacency::build.

const OPEN: u32 = 0xffffffffu;

// Half-edges sorted by lower vertex, higher vertex, direction and id.
@group(0) @binding(2) var<storage, read> values: array<u32>;
@group(0) @binding(3) var<storage, read_write> twin: array<u32>;

fn is_at(place: u32, edge: vec3<u32>) -> bool {
    return place < sizes.half_edges && all(edge_of(values[place]) == edge);
}

// The first place of the run of equal edges that contains a place: doubling steps, then halving ones, so
// that a run of thousands takes tens of looks.
fn run_begin(within: u32, edge: vec3<u32>) -> u32 {
    var place = within;
    var step = 1u;
    while place >= step && is_at(place - step, edge) {
        place -= step;
        step <<= 1u;
    }
    for (step >>= 1u; step > 0u; step >>= 1u) {
        if place >= step && is_at(place - step, edge) {
            place -= step;
        }
    }
    return place;
}

// The place behind the run.
fn run_end(within: u32, edge: vec3<u32>) -> u32 {
    var place = within;
    var step = 1u;
    while is_at(place + step, edge) {
        place += step;
        step <<= 1u;
    }
    for (step >>= 1u; step > 0u; step >>= 1u) {
        if is_at(place + step, edge) {
            place += step;
        }
    }
    return place + 1u;
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let place = item_index(group, groups, lane);
    if place >= sizes.half_edges {
        return;
    }
    let half_edge = values[place];
    let edge = edge_of(half_edge);
    let begin = run_begin(place, edge);
    let rank = place - begin;
    var across = OPEN;
    if edge.z == 0u {
        // Those that run the other way follow.
        let partner = run_end(place, edge) + rank;
        if is_at(partner, vec3<u32>(edge.xy, 1u)) {
            across = values[partner];
        }
    } else {
        // Those that run the other way precede.
        let other = vec3<u32>(edge.xy, 0u);
        if begin > 0u && is_at(begin - 1u, other) {
            let partner = run_begin(begin - 1u, other) + rank;
            if partner < begin {
                across = values[partner];
            }
        }
    }
    twin[half_edge] = across;
}
