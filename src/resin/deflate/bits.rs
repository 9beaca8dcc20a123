//! Bits → bytes, the lowest bit of a byte first.

/// A writer of bits at the end of a list of bytes.
pub struct Bits<'a> {
    out: &'a mut Vec<u8>,
    held: u64,
    /// Bits in `held`, below 32 between calls.
    count: u32,
}

impl<'a> Bits<'a> {
    /// Begins at the next byte of `out`.
    pub fn new(out: &'a mut Vec<u8>) -> Self {
        Self { out, held: 0, count: 0 }
    }

    /// Appends the lowest `count` <= 32 bits; those above must be zero.
    #[inline]
    pub fn put(&mut self, bits: u32, count: u32) {
        self.held |= u64::from(bits) << self.count;
        self.count += count;
        if self.count >= 32 {
            self.out.extend_from_slice(&(self.held as u32).to_le_bytes());
            self.held >>= 32;
            self.count -= 32;
        }
    }

    /// Appends `times` copies of the lowest `count` bits, 1 <= `count` <= 32.
    #[inline]
    pub fn repeat(&mut self, bits: u32, count: u32, times: u64) {
        let at_once = 32 / count;
        let mut left = times;
        if left >= u64::from(2 * at_once) {
            let mut pattern = 0u64;
            for i in 0..at_once {
                pattern |= u64::from(bits) << (i * count);
            }
            if matches!(count, 1 | 2 | 4 | 8) {
                // The pattern fills a word, so all words behind the first are the same byte four times.
                self.put(pattern as u32, 32);
                left -= u64::from(at_once);
                let words = (left / u64::from(at_once)) as usize;
                let byte = ((pattern as u32).rotate_left(self.count) & 0xFF) as u8;
                self.out.resize(self.out.len() + 4 * words, byte);
            } else {
                for _ in 0..left / u64::from(at_once) {
                    self.put(pattern as u32, count * at_once);
                }
            }
            left %= u64::from(at_once);
        }
        for _ in 0..left {
            self.put(bits, count);
        }
    }

    /// Fills the last byte with zeros.
    pub fn finish(self) {
        let bytes = self.held.to_le_bytes();
        let used = self.count.div_ceil(8) as usize;
        self.out.extend_from_slice(bytes.get(..used).unwrap_or(&[]));
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn repeats_are_the_same_as_single_bits() {
        for count in 1..=12u32 {
            for before in 0..9 {
                for times in [0, 1, 2, 15, 16, 31, 32, 33, 63, 64, 65, 100, 1000] {
                    let bits = 0xB6D & ((1 << count) - 1);
                    let (mut a, mut b) = (vec![7], vec![7]);
                    let (mut fast, mut slow) = (Bits::new(&mut a), Bits::new(&mut b));
                    fast.put(0, before);
                    slow.put(0, before);
                    fast.repeat(bits, count, times);
                    for _ in 0..times {
                        for bit in 0..count {
                            slow.put(bits >> bit & 1, 1);
                        }
                    }
                    fast.put(5, 3);
                    slow.put(5, 3);
                    fast.finish();
                    slow.finish();
                    assert_eq!(a, b, "count {count} before {before} times {times}");
                }
            }
        }
    }
}
