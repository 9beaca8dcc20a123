// Millimetres as 32-bit floats to nanometres on the lattice, halves away from zero, by integers alone.
// Twin: mesh::frame::Frame::point.

// Bits of nine floats per facet: x, y, z of three corners [mm], below 2^20 in size.
@group(0) @binding(1) var<storage, read> raw: array<u32>;
@group(0) @binding(2) var<storage, read_write> xs: array<i32>;
@group(0) @binding(3) var<storage, read_write> ys: array<i32>;
@group(0) @binding(4) var<storage, read_write> zs: array<i32>;

// The value in nanometres, modulo 2^32: the origin is still to be subtracted.
fn nanometres(bits: u32) -> u32 {
    let exponent = (bits >> 23u) & 0xffu;
    // The value is mantissa * 2^-shift; from 2^-46 down the product below is under a quarter.
    let shift = 150u - exponent;
    if exponent <= 104u || exponent >= 150u {
        return 0u;
    }
    let exact = wide_product((bits & 0x7fffffu) | 0x800000u, 1000000u);
    var size = 0u;
    if shift <= 32u {
        let n = wide_sum(exact, 1u << (shift - 1u));
        if shift == 32u {
            size = n.high;
        } else {
            size = (n.low >> shift) | (n.high << (32u - shift));
        }
    } else {
        size = (exact.high + (1u << (shift - 33u))) >> (shift - 32u);
    }
    return select(size, 0u - size, (bits >> 31u) == 1u);
}

@compute @workgroup_size(256)
fn main(
    @builtin(workgroup_id) group: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
    @builtin(local_invocation_index) lane: u32,
) {
    let item = item_index(group, groups, lane);
    if item >= sizes.items {
        return;
    }
    let corner = sizes.corner + item / 3u;
    let value = nanometres(raw[item]);
    switch item % 3u {
        case 0u: {
            xs[corner] = bitcast<i32>(value - sizes.origin_x);
        }
        case 1u: {
            ys[corner] = bitcast<i32>(value - sizes.origin_y);
        }
        default: {
            zs[corner] = bitcast<i32>(value - sizes.origin_z);
        }
    }
}
