// Moves every key with its value to where it belongs by one digit, keeping the order of equal digits:
// a pass of a radix sort (Knuth, TAOCP vol. 3, 5.2.5).

@group(0) @binding(2) var<storage, read> values: array<u32>;
// Per digit and block the keys before them: the exclusive sums of what sort_count counts.
@group(0) @binding(3) var<storage, read> places: array<u32>;
@group(0) @binding(4) var<storage, read_write> sorted_keys: array<u32>;
@group(0) @binding(5) var<storage, read_write> sorted_values: array<u32>;

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let block = group_index(group, groups);
    let begin = (block * GROUP_SIZE + lane) * PER_LANE;
    tally_keys(begin, lane);
    var before = sum_words(lane);
    for (var i = 0u; i < PER_LANE; i += 1u) {
        let count = tally[lane * PER_LANE + i];
        tally[lane * PER_LANE + i] = before;
        before += count;
    }
    workgroupBarrier();
    // The tally now holds what the lanes before have of each digit; own keys are added one by one.
    for (var i = 0u; i < PER_LANE; i += 1u) {
        if begin + i < sizes.length {
            let key = keys[begin + i];
            let digit = digit_of(key);
            let at = (digit >> 1u) * GROUP_SIZE + lane;
            let place = places[digit * sizes.blocks + block] + count_in(tally[at], digit);
            tally[at] += one_of(digit);
            sorted_keys[place] = key;
            sorted_values[place] = values[begin + i];
        }
    }
}
