// 64-bit arithmetic on pairs of u32, exact on every device: no SHADER_INT64, no floats.

struct Wide {
    low: u32,
    high: u32,
}

// a * b, all 64 bits, by 16-bit digits (Knuth, TAOCP vol. 2, 4.3.1, algorithm M).
fn wide_product(a: u32, b: u32) -> Wide {
    let a0 = a & 0xffffu;
    let a1 = a >> 16u;
    let b0 = b & 0xffffu;
    let b1 = b >> 16u;
    let low = a0 * b0;
    let cross_1 = a1 * b0;
    let cross_2 = a0 * b1;
    let middle = (low >> 16u) + (cross_1 & 0xffffu) + (cross_2 & 0xffffu);
    return Wide(
        (middle << 16u) | (low & 0xffffu),
        a1 * b1 + (cross_1 >> 16u) + (cross_2 >> 16u) + (middle >> 16u),
    );
}

// n + a, modulo 2^64.
fn wide_sum(n: Wide, a: u32) -> Wide {
    let low = n.low + a;
    return Wide(low, n.high + select(0u, 1u, low < a));
}

// One base-2^16 digit of a quotient: (top * 2^16 + next) / divisor for a divisor >= 2^31 and a
// quotient < 2^16. The first estimate is at most 2 too large (TAOCP vol. 2, 4.3.1, theorem B).
fn quotient_digit(top: u32, next: u32, divisor: u32) -> u32 {
    let d1 = divisor >> 16u;
    let d0 = divisor & 0xffffu;
    var digit = top / d1;
    var rest = top - digit * d1;
    // digit <= 2^16 + 1, so digit * d0 does not overflow; rest < 2^16 wherever it is shifted.
    if digit > 0xffffu || digit * d0 > ((rest << 16u) | next) {
        digit -= 1u;
        rest += d1;
        if rest <= 0xffffu && (digit > 0xffffu || digit * d0 > ((rest << 16u) | next)) {
            digit -= 1u;
        }
    }
    return digit;
}

// floor(n / divisor) for n.high < divisor, so that the quotient fits 32 bits (TAOCP vol. 2, 4.3.1,
// algorithm D with two 16-bit digits). The divisor must be below 2^31.
fn wide_quotient(n: Wide, divisor: u32) -> u32 {
    // 1 <= shift <= 31 because the divisor is neither zero nor has its top bit set.
    let shift = countLeadingZeros(divisor);
    let d = divisor << shift;
    let high = (n.high << shift) | (n.low >> (32u - shift));
    let low = n.low << shift;
    let q1 = quotient_digit(high, low >> 16u, d);
    let rest = ((high << 16u) | (low >> 16u)) - q1 * d;
    let q0 = quotient_digit(rest, low & 0xffffu, d);
    return (q1 << 16u) + q0;
}

// floor((a * b + divisor / 2) / divisor): a * b / divisor rounded, halves up.
// For a < 2^31 and b <= divisor < 2^31, divisor > 0.
fn rounded_fraction(a: u32, b: u32, divisor: u32) -> u32 {
    return wide_quotient(wide_sum(wide_product(a, b), divisor >> 1u), divisor);
}
