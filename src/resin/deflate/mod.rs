//! Stretches of equal bytes → a zlib stream (RFC 1950, RFC 1951), without the bytes.
//!
//! One block with a Huffman code made for the data. A stretch is its byte as a literal, then matches of
//! length 258 at distance 1, then the rest: deflate's bound of 1032 bytes in one is reached where
//! stretches are long. The cost is by stretches and by bytes written, never by bytes described.

mod bits;
mod code;

use bits::Bits;
use code::{Code, LITERALS, length_symbol, write_head};

/// Longest match of deflate.
const LONGEST: usize = 258;
/// Shortest match of deflate.
const SHORTEST: usize = 3;
/// Symbol of the block's end.
const END: usize = 256;
/// Modulus of the Adler-32 sum.
const ADLER: u64 = 65521;

/// Bytes, described by stretches of equal ones.
pub trait Stretches {
    /// Calls `each` with (length, byte) of every stretch in order, the same every time. Lengths are not
    /// 0, and neighbours differ in their byte (equal ones are right, but cost more).
    fn visit(&self, each: impl FnMut(u64, u8));
}

/// Appends the zlib stream of `bytes` to `out`.
pub fn zlib(out: &mut Vec<u8>, bytes: &impl Stretches) {
    let counts = Counts::new(bytes);
    let code = Code::new(&counts.symbols(), 15);
    let tokens = Tokens::new(&code);
    out.reserve(tokens.bytes(&counts));
    // Method 8, window of 32 KiB, fastest.
    out.extend_from_slice(&[0x78, 0x01]);
    let mut bits = Bits::new(out);
    write_head(&mut bits, &code);
    let (longest, longest_count) = tokens.matches[LONGEST];
    bytes.visit(|length, byte| {
        let (literal, literal_count) = tokens.literals[usize::from(byte)];
        bits.put(literal, literal_count);
        let (times, rest) = split(length);
        if times > 0 {
            bits.repeat(longest, longest_count, times);
        }
        if rest >= SHORTEST {
            let (token, count) = tokens.matches[rest];
            bits.put(token, count);
        } else {
            for _ in 0..rest {
                bits.put(literal, literal_count);
            }
        }
    });
    let (end, end_count) = code.symbol(END);
    bits.put(end, end_count);
    bits.finish();
    out.extend_from_slice(&counts.sum.finish().to_be_bytes());
}

/// Number of longest matches behind the literal of a stretch, and the bytes behind them.
#[inline]
fn split(length: u64) -> (u64, usize) {
    let behind = length.saturating_sub(1);
    // Nearly all stretches fit 32 bits, whose division is the faster one.
    match u32::try_from(behind) {
        Ok(behind) => (u64::from(behind / LONGEST as u32), (behind % LONGEST as u32) as usize),
        Err(_) => (behind / LONGEST as u64, (behind % LONGEST as u64) as usize),
    }
}

/// How often what is written, and the sum of the bytes.
struct Counts {
    literals: [u64; 256],
    /// By length of the match.
    matches: [u64; LONGEST + 1],
    sum: Adler,
}

impl Counts {
    fn new(bytes: &impl Stretches) -> Self {
        let mut counts = Self { literals: [0; 256], matches: [0; LONGEST + 1], sum: Adler::default() };
        bytes.visit(|length, byte| {
            let (times, rest) = split(length);
            counts.matches[LONGEST] += times;
            counts.literals[usize::from(byte)] += 1;
            if rest >= SHORTEST {
                counts.matches[rest] += 1;
            } else {
                counts.literals[usize::from(byte)] += rest as u64;
            }
            counts.sum.add(length, byte);
        });
        counts
    }

    fn symbols(&self) -> [u64; LITERALS] {
        let mut symbols = [0; LITERALS];
        symbols[..256].copy_from_slice(&self.literals);
        symbols[END] = 1;
        for (length, count) in self.matches.iter().enumerate().skip(SHORTEST) {
            symbols[length_symbol(length).0] += count;
        }
        symbols
    }
}

/// What stands for a literal and for a match with its distance: (bits, their number).
struct Tokens {
    literals: [(u32, u32); 256],
    matches: [(u32, u32); LONGEST + 1],
}

impl Tokens {
    fn new(code: &Code) -> Self {
        let mut tokens = Self { literals: [(0, 0); 256], matches: [(0, 0); LONGEST + 1] };
        for (symbol, token) in tokens.literals.iter_mut().enumerate() {
            *token = code.symbol(symbol);
        }
        for (length, token) in tokens.matches.iter_mut().enumerate().skip(SHORTEST) {
            let (symbol, extra, value) = length_symbol(length);
            let (bits, count) = code.symbol(symbol);
            // The only distance is one 0 behind the rest.
            *token = (bits | value << count, count + extra + 1);
        }
        tokens
    }

    /// Length of the stream, or a little more.
    fn bytes(&self, counts: &Counts) -> usize {
        let sum = |tokens: &[(u32, u32)], counts: &[u64]| -> u64 {
            tokens.iter().zip(counts).map(|((_, length), count)| u64::from(*length) * count).sum()
        };
        let bits = sum(&self.literals, &counts.literals) + sum(&self.matches, &counts.matches);
        (bits / 8) as usize + 512
    }
}

/// The Adler-32 sum by stretches: of n bytes v behind sums (a, b), a grows by n v and b by
/// n a + v n (n + 1) / 2.
struct Adler {
    a: u64,
    b: u64,
}

impl Default for Adler {
    fn default() -> Self {
        Self { a: 1, b: 0 }
    }
}

impl Adler {
    #[inline]
    fn add(&mut self, length: u64, byte: u8) {
        // Both sums depend on the length modulo the prime only (which is odd, so halving is sound: one of
        // n and n + 1 is even before as after the reduction by an even multiple).
        let n = if length < ADLER { length } else { length % (2 * ADLER) };
        let v = u64::from(byte);
        self.b = (self.b + n * self.a + v * (n * (n + 1) / 2)) % ADLER;
        self.a = (self.a + n * v) % ADLER;
    }

    fn finish(&self) -> u32 {
        ((self.b << 16) | self.a) as u32
    }
}

#[cfg(test)]
mod tests;
