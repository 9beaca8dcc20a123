//! Lattice lengths as decimal text, exact.

use crate::lattice::Point2;

/// Appends a length \[nm\] in millimetres, without trailing zeros: `-0.0005`, `12`.
pub(super) fn mm(out: &mut Vec<u8>, nm: i64) {
    if nm < 0 {
        out.push(b'-');
    }
    let (whole, mut rest) = (nm.unsigned_abs() / 1_000_000, nm.unsigned_abs() % 1_000_000);
    let mut digits = [0; 20];
    let mut at = digits.len();
    let mut left = whole;
    loop {
        at -= 1;
        digits[at] = b'0' + (left % 10) as u8;
        left /= 10;
        if left == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
    if rest > 0 {
        out.push(b'.');
        let mut unit = 100_000;
        while rest > 0 {
            out.push(b'0' + (rest / unit) as u8);
            rest %= unit;
            unit /= 10;
        }
    }
}

/// Appends x, a separator and y \[mm\] of a point \[nm\] moved by `offset` \[nm\].
pub(super) fn point(out: &mut Vec<u8>, p: Point2, offset: [i64; 2], separator: u8) {
    mm(out, i64::from(p.x) + offset[0]);
    out.push(separator);
    mm(out, i64::from(p.y) + offset[1]);
}

/// A length \[nm\] in millimetres as a text.
pub(super) fn text(nm: i64) -> String {
    let mut out = Vec::new();
    mm(&mut out, nm);
    String::from_utf8_lossy(&out).into_owned()
}

#[cfg(test)]
mod tests {
    #[test]
    fn lengths_are_exact() {
        for (nm, mm) in [
            (0, "0"),
            (1, "0.000001"),
            (-1, "-0.000001"),
            (100_000, "0.1"),
            (-12_000_000, "-12"),
            (1_073_741_823, "1073.741823"),
            (-10_500_020, "-10.50002"),
            (i64::MIN, "-9223372036854.775808"),
        ] {
            assert_eq!(super::text(nm), mm);
        }
    }
}
