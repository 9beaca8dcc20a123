//! Counts of symbols → a Huffman code, and its description at the head of a block (RFC 1951, 3.2.7).

use super::bits::Bits;

/// Symbols of the literal and length alphabet that may be used.
pub const LITERALS: usize = 286;
/// Order in which the lengths of the code of code lengths are stored.
const ORDER: [usize; 19] = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];

/// Length symbol, number of extra bits and their value for a match of 3 to 258 bytes.
pub fn length_symbol(length: usize) -> (usize, u32, u32) {
    if length >= 258 {
        return (285, 0, 0);
    }
    let offset = length.saturating_sub(3) as u32;
    if offset < 8 {
        return (257 + offset as usize, 0, 0);
    }
    // Four symbols for every power of two: extra bits are what is behind the three leading ones.
    let extra = 29 - offset.leading_zeros();
    let symbol = 257 + 4 * extra as usize + (offset >> extra) as usize;
    (symbol, extra, offset & ((1 << extra) - 1))
}

/// A prefix code: for every symbol its length in bits (0 = not used) and its bits, first bit lowest.
pub struct Code {
    /// Lengths.
    pub lengths: Vec<u8>,
    /// Bits.
    pub bits: Vec<u16>,
}

impl Code {
    /// The best code with lengths up to `limit` or nearly so; complete if at least two counts are not
    /// zero.
    pub fn new(counts: &[u64], limit: u8) -> Self {
        let mut counts = counts.to_vec();
        let mut lengths = huffman(&counts);
        // Flatter counts make a flatter tree; at equal counts it is as deep as their number's logarithm.
        while lengths.iter().any(|l| *l > limit) {
            for count in counts.iter_mut().filter(|c| **c > 0) {
                *count = *count / 2 + 1;
            }
            lengths = huffman(&counts);
        }
        let bits = canonical(&lengths);
        Self { lengths, bits }
    }

    /// Length and bits of a symbol.
    #[inline]
    pub fn symbol(&self, symbol: usize) -> (u32, u32) {
        let length = self.lengths.get(symbol).map_or(0, |l| u32::from(*l));
        (self.bits.get(symbol).map_or(0, |b| u32::from(*b)), length)
    }
}

/// Depths of the leaves of a Huffman tree; of equal counts the smaller symbol comes first.
fn huffman(counts: &[u64]) -> Vec<u8> {
    let mut leaves: Vec<(u64, usize)> =
        counts.iter().enumerate().filter(|(_, c)| **c > 0).map(|(s, c)| (*c, s)).collect();
    leaves.sort_unstable();
    let mut lengths = vec![0u8; counts.len()];
    let n = leaves.len();
    if n < 2 {
        for (_, symbol) in &leaves {
            if let Some(length) = lengths.get_mut(*symbol) {
                *length = 1;
            }
        }
        return lengths;
    }
    // Two queues: leaves by count, and inner nodes, whose counts ascend by themselves.
    let mut inner: Vec<u64> = Vec::with_capacity(n - 1);
    let mut parent = vec![0usize; 2 * n - 1];
    let (mut leaf, mut node) = (0, 0);
    for made in 0..n - 1 {
        let mut sum = 0;
        for _ in 0..2 {
            let of_leaf = leaves.get(leaf).map(|l| l.0);
            let of_node = inner.get(node).copied();
            let child = match (of_leaf, of_node) {
                (Some(l), Some(i)) if i < l => {
                    sum += i;
                    node += 1;
                    n + node - 1
                }
                (Some(l), _) => {
                    sum += l;
                    leaf += 1;
                    leaf - 1
                }
                (None, i) => {
                    sum += i.unwrap_or(0);
                    node += 1;
                    n + node - 1
                }
            };
            parent[child] = n + made;
        }
        inner.push(sum);
    }
    let mut depth = vec![0u8; 2 * n - 1];
    for child in (0..2 * n - 2).rev() {
        depth[child] = depth[parent[child]].saturating_add(1);
    }
    for ((_, symbol), depth) in leaves.iter().zip(depth) {
        lengths[*symbol] = depth;
    }
    lengths
}

/// The bits that follow from the lengths (RFC 1951, 3.2.2), reversed for a writer of lowest bits first.
fn canonical(lengths: &[u8]) -> Vec<u16> {
    let mut number = [0u16; 17];
    for length in lengths.iter().filter(|l| **l > 0) {
        number[usize::from(*length).min(16)] += 1;
    }
    let mut next = [0u16; 17];
    for length in 1..17 {
        next[length] = (next[length - 1].wrapping_add(number[length - 1])) << 1;
    }
    lengths
        .iter()
        .map(|length| {
            if *length == 0 {
                return 0;
            }
            let code = next[usize::from(*length).min(16)];
            next[usize::from(*length).min(16)] = code.wrapping_add(1);
            code.reverse_bits() >> (16 - u32::from(*length).min(16))
        })
        .collect()
}

/// Writes the head of a last block with `code` for literals and lengths and one distance, coded in one
/// bit.
pub fn write_head(bits: &mut Bits<'_>, code: &Code) {
    let used = code.lengths.iter().rposition(|l| *l > 0).map_or(257, |last| (last + 1).max(257));
    let mut lengths: Vec<u8> = code.lengths.iter().copied().take(used).collect();
    lengths.push(1);
    let symbols = run_lengths(&lengths);
    let mut counts = [0u64; 19];
    for (symbol, _, _) in &symbols {
        counts[*symbol] += 1;
    }
    // Decoders refuse an incomplete code of code lengths.
    if counts.iter().filter(|c| **c > 0).count() < 2 {
        counts[0] += 1;
        counts[1] += 1;
    }
    let of_lengths = Code::new(&counts, 7);
    let stored = ORDER.iter().rposition(|s| of_lengths.lengths[*s] > 0).map_or(4, |last| (last + 1).max(4));
    bits.put(1, 1);
    bits.put(2, 2);
    bits.put(used as u32 - 257, 5);
    bits.put(0, 5);
    bits.put(stored as u32 - 4, 4);
    for symbol in ORDER.iter().take(stored) {
        bits.put(u32::from(of_lengths.lengths[*symbol]), 3);
    }
    for (symbol, extra, count) in symbols {
        let (code, length) = of_lengths.symbol(symbol);
        bits.put(code, length);
        bits.put(extra, count);
    }
}

/// Lengths as (symbol, extra bits, their number).
fn run_lengths(lengths: &[u8]) -> Vec<(usize, u32, u32)> {
    let mut symbols = Vec::new();
    let mut at = 0;
    while let Some(length) = lengths.get(at) {
        let same = lengths[at..].iter().take_while(|l| *l == length).count();
        let mut left = same;
        if *length == 0 {
            while left >= 3 {
                let part = left.min(138);
                symbols.push(if part < 11 { (17, part as u32 - 3, 3) } else { (18, part as u32 - 11, 7) });
                left -= part;
            }
        } else {
            symbols.push((usize::from(*length), 0, 0));
            left -= 1;
            while left >= 3 {
                let part = left.min(6);
                symbols.push((16, part as u32 - 3, 2));
                left -= part;
            }
        }
        symbols.extend((0..left).map(|_| (usize::from(*length), 0, 0)));
        at += same;
    }
    symbols
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn length_symbols_are_those_of_the_standard() {
        let expected = [
            (3, (257, 0, 0)),
            (10, (264, 0, 0)),
            (11, (265, 1, 0)),
            (12, (265, 1, 1)),
            (18, (268, 1, 1)),
            (19, (269, 2, 0)),
            (34, (272, 2, 3)),
            (35, (273, 3, 0)),
            (114, (279, 4, 15)),
            (115, (280, 4, 0)),
            (130, (280, 4, 15)),
            (131, (281, 5, 0)),
            (257, (284, 5, 30)),
            (258, (285, 0, 0)),
        ];
        for (length, symbol) in expected {
            assert_eq!(length_symbol(length), symbol, "length {length}");
        }
    }

    #[test]
    fn codes_are_complete_and_within_their_limit() {
        let mut fibonacci = vec![1u64, 1];
        while fibonacci.len() < 40 {
            fibonacci.push(fibonacci[fibonacci.len() - 1] + fibonacci[fibonacci.len() - 2]);
        }
        for counts in [vec![5, 0, 1], vec![1; 286], fibonacci, vec![1_000_000_000, 1, 1, 1]] {
            for limit in [9, 15] {
                let code = Code::new(&counts, limit);
                let kraft: u64 = code.lengths.iter().filter(|l| **l > 0).map(|l| 1 << (32 - l)).sum();
                assert_eq!(kraft, 1 << 32, "{counts:?}");
                assert!(code.lengths.iter().all(|l| *l <= limit));
                assert!(code.lengths.iter().zip(&counts).all(|(l, c)| (*l > 0) == (*c > 0)));
            }
        }
    }
}
