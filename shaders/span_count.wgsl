// Per segment how many rows it crosses and the bucket of the lowest; per bucket the difference to the
// number of crossings of the bucket before.
// Twin: span::twin::count.

const OPEN: u32 = 0xffffffffu;

// Per triangle the first plane that it meets.
@group(0) @binding(3) var<storage, read> first: array<u32>;
// Per triangle its first segment; one more entry than triangles.
@group(0) @binding(4) var<storage, read> offset: array<u32>;
@group(0) @binding(5) var<storage, read_write> count: array<u32>;
@group(0) @binding(6) var<storage, read_write> bucket: array<u32>;
// One entry more than there are rows. Sums, whatever their order.
@group(0) @binding(7) var<storage, read_write> steps: array<atomic<u32>>;
// Crossings of the run, 64 bits; the largest coordinate that is too large; 0; per plane its open segments.
@group(0) @binding(8) var<storage, read_write> totals: array<atomic<u32>>;

var<workgroup> group_sum: atomic<u32>;

// How many rows of a plane lie at or below t.
fn rows_up_to(t: i32) -> u32 {
    if t < sizes.base {
        return 0u;
    }
    let above = bitcast<u32>(t) - bitcast<u32>(sizes.base);
    let line = above / sizes.pitch;
    if line >= sizes.lines {
        return sizes.rows;
    }
    let rest = above - line * sizes.pitch;
    var within = 0u;
    while within < sizes.sub_rows && row_offset_in_line(within) <= rest {
        within += 1u;
    }
    return line * sizes.sub_rows + within;
}

// From here on neither a key nor a difference fits; only diagonals reach so far.
const REACH: u32 = 0x40000000u;

// The largest distance of a coordinate from 0.
fn reach_of(p: vec2<i32>, q: vec2<i32>) -> u32 {
    let larger = vec2<u32>(max(abs(p), abs(q)));
    return max(larger.x, larger.y);
}

// Counts a segment on a plane and returns its crossings.
fn count_segment(slot: u32, plane: u32) -> u32 {
    let successor = next[slot];
    if successor == OPEN {
        atomicAdd(&totals[4u + plane], 1u);
        count[slot] = 0u;
        bucket[slot] = 0u;
        return 0u;
    }
    let p = along_and_across(start[slot]);
    let q = along_and_across(start[successor]);
    // A row through a vertex runs below it: crossed are the rows above the lower end, up to the upper.
    let begin = rows_up_to(min(p.y, q.y));
    let end = rows_up_to(max(p.y, q.y));
    count[slot] = end - begin;
    bucket[slot] = select(0u, 1u + plane * sizes.rows + begin, end > begin);
    if end > begin {
        atomicAdd(&steps[plane * sizes.rows + begin], 1u);
        atomicSub(&steps[plane * sizes.rows + end], 1u);
        let reach = reach_of(p, q);
        if reach >= REACH {
            atomicMax(&totals[2], reach);
        }
    }
    return end - begin;
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let begin = group_index(group, groups) * GROUP_SIZE;
    find_ends(begin, lane, sizes.segments, sizes.triangles);
    if lane == 0u {
        atomicStore(&group_sum, 0u);
    }
    workgroupBarrier();
    let slot = begin + lane;
    if slot < sizes.segments {
        let t = owner(slot, ends[0], ends[1]);
        // Rows are fewer than 2^24, so that a workgroup's sum fits.
        atomicAdd(&group_sum, count_segment(slot, first[t] + (slot - offset[t])));
    }
    workgroupBarrier();
    if lane == 0u {
        let sum = atomicLoad(&group_sum);
        let before = atomicAdd(&totals[0], sum);
        // The carry: however the sums follow each other, they wrap equally often.
        if before + sum < before {
            atomicAdd(&totals[1], 1u);
        }
    }
}
