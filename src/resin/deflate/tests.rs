#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
use super::*;

/// A list of stretches.
struct List(Vec<(u64, u8)>);

impl Stretches for List {
    fn visit(&self, mut each: impl FnMut(u64, u8)) {
        for (length, byte) in &self.0 {
            each(*length, *byte);
        }
    }
}

impl List {
    fn bytes(&self) -> Vec<u8> {
        self.0.iter().flat_map(|(n, v)| std::iter::repeat_n(*v, *n as usize)).collect()
    }
}

/// The sum as RFC 1950 defines it.
fn plain_adler(bytes: &[u8]) -> u32 {
    let (mut a, mut b) = (1u32, 0u32);
    for byte in bytes {
        a = (a + u32::from(*byte)) % 65521;
        b = (b + a) % 65521;
    }
    b << 16 | a
}

#[test]
fn the_sum_by_stretches_is_the_sum_by_bytes() {
    for list in [
        List(vec![]),
        List(vec![(1, 255), (2, 0), (3, 7)]),
        List(vec![(65520, 255), (65521, 3), (65522, 255), (131_041, 9), (131_042, 255), (131_043, 255)]),
        List(vec![(1_000_000, 255), (3_000_017, 254), (999, 0), (1, 1)]),
    ] {
        let mut sum = Adler::default();
        list.visit(|n, v| sum.add(n, v));
        assert_eq!(sum.finish(), plain_adler(&list.bytes()), "{:?}", list.0);
    }
}

#[test]
fn long_stretches_reach_the_bound_of_deflate() {
    let mut out = Vec::new();
    zlib(&mut out, &List(vec![(1032 * 10_000, 0)]));
    assert!(out.len() < 10_100, "{} bytes", out.len());
}
