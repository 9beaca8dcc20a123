// What the sorting kernels share: digits of four bits, counted in pairs of 16 bits.

struct SortSizes {
    length: u32,
    // Lowest bit of the digit.
    shift: u32,
    // Blocks of 2,048 keys.
    blocks: u32,
    padding: u32,
}

const PER_LANE: u32 = 8u;
// Sixteen digits, two to a word.
const WORDS: u32 = 8u;

@group(0) @binding(0) var<uniform> sizes: SortSizes;
@group(0) @binding(1) var<storage, read> keys: array<u32>;

// Per word and lane; a block's 2,048 keys never overflow 16 bits.
var<workgroup> tally: array<u32, 2048>;
// Sums of eight neighbours in `tally`, 32 for each word, then summed up within the word.
var<workgroup> sums: array<u32, GROUP_SIZE>;

fn digit_of(key: u32) -> u32 {
    return (key >> sizes.shift) & 15u;
}

// What one key adds to the word of its digit.
fn one_of(digit: u32) -> u32 {
    return 1u << ((digit & 1u) << 4u);
}

fn count_in(word: u32, digit: u32) -> u32 {
    return (word >> ((digit & 1u) << 4u)) & 0xffffu;
}

// Counts a lane's keys, from `begin` on, in its column of the tally.
fn tally_keys(begin: u32, lane: u32) {
    for (var w = 0u; w < WORDS; w += 1u) {
        tally[w * GROUP_SIZE + lane] = 0u;
    }
    for (var i = 0u; i < PER_LANE; i += 1u) {
        if begin + i < sizes.length {
            let digit = digit_of(keys[begin + i]);
            tally[(digit >> 1u) * GROUP_SIZE + lane] += one_of(digit);
        }
    }
}

// Leaves in `sums` the inclusive sums within each word (Hillis and Steele 1986) and returns what lies
// before the eight neighbours of this lane.
fn sum_words(lane: u32) -> u32 {
    workgroupBarrier();
    var own = 0u;
    for (var i = 0u; i < PER_LANE; i += 1u) {
        own += tally[lane * PER_LANE + i];
    }
    sums[lane] = own;
    for (var reach = 1u; reach < 32u; reach <<= 1u) {
        workgroupBarrier();
        var before = 0u;
        if (lane & 31u) >= reach {
            before = sums[lane - reach];
        }
        workgroupBarrier();
        sums[lane] += before;
    }
    workgroupBarrier();
    return sums[lane] - own;
}
