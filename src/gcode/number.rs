//! Decimal numbers from integers, fast.
//!
//! Coordinates are counts of micrometres and filament lengths counts of 10 nm, so formatting is exact
//! and needs no float printer. Trailing zeros are left out, and the point with them.

/// Bytes to be written at once: text in the low half, first character lowest, length in the high one.
type Piece = u64;

/// `0` to `999`.
static WHOLE: [Piece; 1000] = whole();
/// `.000` to `.999` without trailing zeros; nothing for 0.
static FRACTION: [Piece; 1000] = fraction();
/// Powers of ten.
const TEN: [u32; 10] =
    [1, 10, 100, 1_000, 10_000, 100_000, 1_000_000, 10_000_000, 100_000_000, 1_000_000_000];

const fn whole() -> [Piece; 1000] {
    let mut table = [0; 1000];
    let mut i = 0;
    while i < 1000 {
        let (a, b, c) = digits(i);
        table[i as usize] = if i < 10 {
            c | 1 << 32
        } else if i < 100 {
            b | c << 8 | 2 << 32
        } else {
            a | b << 8 | c << 16 | 3 << 32
        };
        i += 1;
    }
    table
}

const fn fraction() -> [Piece; 1000] {
    let mut table = [0; 1000];
    let mut i = 0;
    while i < 1000 {
        let (a, b, c) = digits(i);
        let length = if i == 0 {
            0
        } else if !i.is_multiple_of(10) {
            4
        } else if !i.is_multiple_of(100) {
            3
        } else {
            2
        };
        table[i as usize] = b'.' as u64 | a << 8 | b << 16 | c << 24 | length << 32;
        i += 1;
    }
    table
}

/// The three digits of a number below 1000, as characters.
const fn digits(i: u64) -> (u64, u64, u64) {
    (48 + i / 100, 48 + i / 10 % 10, 48 + i % 10)
}

/// A text of up to [`Line::SIZE`] bytes; what does not fit is left out.
#[derive(Clone, Debug)]
pub struct Line {
    bytes: [u8; Self::SIZE],
    length: usize,
}

impl Default for Line {
    fn default() -> Self {
        Self { bytes: [0; Self::SIZE], length: 0 }
    }
}

impl Line {
    /// Longest text.
    pub const SIZE: usize = 128;

    /// What was written so far.
    #[inline]
    pub fn as_bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Appends the text to `out`.
    #[inline]
    pub fn append_to(&self, out: &mut Vec<u8>) {
        // Most lines are short, and a copy of constant length needs no call.
        const SHORT: usize = 64;
        match self.bytes.first_chunk::<SHORT>() {
            Some(short) if self.length <= SHORT => {
                let end = out.len() + self.length;
                out.extend_from_slice(short);
                out.truncate(end);
            }
            _ => out.extend_from_slice(self.as_bytes()),
        }
    }

    /// Forgets the text.
    #[inline]
    pub fn clear(&mut self) {
        self.length = 0;
    }

    /// Appends four bytes, of which `length` count.
    #[inline]
    fn put(&mut self, piece: Piece) {
        if let Some(room) = self.bytes.get_mut(self.length..).and_then(|b| b.first_chunk_mut::<4>()) {
            *room = (piece as u32).to_le_bytes();
            self.length += (piece >> 32) as usize;
        }
    }

    /// Appends a text.
    #[inline]
    pub fn text(&mut self, text: &[u8]) {
        if let Some(room) = self.bytes.get_mut(self.length..self.length + text.len()) {
            room.copy_from_slice(text);
            self.length += text.len();
        }
    }

    /// Appends ` X`, ` Y` ...: a blank and a letter.
    #[inline]
    pub fn word(&mut self, letter: u8) {
        self.put(32 | u64::from(letter) << 8 | 2 << 32);
    }

    /// Appends a natural number.
    #[inline]
    pub fn natural(&mut self, value: u32) {
        if let Some(piece) = WHOLE.get(value as usize) {
            return self.put(*piece);
        }
        let count = 1 + (value.max(1)).ilog10() as usize;
        for k in (0..count).rev() {
            self.put(u64::from(48 + value / TEN[k] % 10) | 1 << 32);
        }
    }

    /// Appends a count of thousandths as a decimal number: 1500 is `1.5`, -20 is `-0.02`.
    #[inline]
    pub fn thousandths(&mut self, value: i64) {
        let size = self.sign(value);
        let whole = size / 1000;
        self.natural(whole.min(u64::from(u32::MAX)) as u32);
        self.put(FRACTION[(size % 1000) as usize]);
    }

    /// Appends a count of hundred-thousandths as a decimal number: 150000 is `1.5`.
    #[inline]
    pub fn hundred_thousandths(&mut self, value: i64) {
        let size = self.sign(value);
        let (whole, part) = (size / 100_000, (size % 100_000) as usize);
        self.natural(whole.min(u64::from(u32::MAX)) as u32);
        let (high, low) = (part / 100, part % 100);
        if low == 0 {
            self.put(FRACTION[high]);
        } else {
            self.put(FRACTION[high] & 0xffff_ffff | 4 << 32);
            // The digits of `low` without the point before them.
            let piece = FRACTION[low * 10];
            self.put((piece & 0xffff_ffff) >> 8 | ((piece >> 32) - 1) << 32);
        }
    }

    #[inline]
    fn sign(&mut self, value: i64) -> u64 {
        if value < 0 {
            self.put(u64::from(b'-') | 1 << 32);
        }
        value.unsigned_abs()
    }
}

/// A length in millimetres with up to `places` decimals, for the places where speed does not matter.
pub fn plain(value: f64, places: usize) -> String {
    let text = format!("{value:.places$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if short == "-0" { "0".to_owned() } else { short.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::path::testing::Random;

    fn text(write: impl Fn(&mut Line)) -> String {
        let mut line = Line::default();
        write(&mut line);
        String::from_utf8_lossy(line.as_bytes()).into_owned()
    }

    /// The same by the standard library.
    fn reference(value: i64, places: u32) -> String {
        let unit = 10i64.pow(places);
        let sign = if value < 0 { "-" } else { "" };
        let (whole, part) = (value.abs() / unit, value.abs() % unit);
        let all = format!("{sign}{whole}.{part:0width$}", width = places as usize);
        all.trim_end_matches('0').trim_end_matches('.').to_owned()
    }

    #[test]
    fn numbers_are_those_of_the_standard_library() {
        let mut random = Random::new(7);
        let check = |value: i64| {
            assert_eq!(text(|l| l.thousandths(value)), reference(value, 3));
            assert_eq!(text(|l| l.hundred_thousandths(value)), reference(value, 5));
        };
        for value in -12_000..12_000 {
            check(value);
        }
        for _ in 0..300_000 {
            let digits = random.below(12) as u32;
            check(random.below(10u64.pow(digits)) as i64 * if random.below(2) == 0 { 1 } else { -1 });
        }
        for value in [999, 1000, 1001, 99_999, 100_000, 999_999, 1_000_000, 99_999_999, 2_147_483_647_000] {
            check(value);
            check(-value);
        }
    }

    #[test]
    fn three_decimals_match_the_float_printer() {
        let mut random = Random::new(8);
        for _ in 0..500_000 {
            let value = random.below(4_000_000) as i64 - 1_000_000;
            assert_eq!(text(|l| l.thousandths(value)), plain(value as f64 / 1000.0, 3), "{value}");
        }
    }

    #[test]
    fn a_full_line_takes_no_more() {
        let mut line = Line::default();
        for _ in 0..100 {
            line.word(b'X');
            line.thousandths(-123_456_789);
        }
        assert!(line.as_bytes().len() <= Line::SIZE);
    }

    #[test]
    fn plain_numbers_are_short() {
        assert_eq!(
            [plain(0.45, 6), plain(10.0, 2), plain(-0.0001, 2), plain(100.0, 0)],
            ["0.45", "10", "0", "100"]
        );
    }
}
