//! Fields of binary containers: bounded reading with errors that name the place, and writing.
//!
//! [`Source`] hands out blocks of a file, each checked against the file's length before anything is
//! allocated; [`Fields`] walks through the fields of one block; [`Put`] writes such a block.

use super::ReadError;
use std::fmt::Display;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

/// Order of the bytes of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Least significant first.
    Little,
    /// Most significant first.
    Big,
}

/// Where a container is read from.
pub trait ReadSeek: Read + Seek + Send {}

impl<T: Read + Seek + Send> ReadSeek for T {}

/// A container's bytes, of known length.
pub struct Source {
    stream: Box<dyn ReadSeek>,
    at: u64,
    length: u64,
    format: &'static str,
}

impl Source {
    /// Takes a stream whose byte 0 is the file's; best one with a buffer.
    ///
    /// # Errors
    /// [`ReadError::Io`] where its length cannot be found out.
    pub fn new(format: &'static str, mut stream: Box<dyn ReadSeek>) -> Result<Self, ReadError> {
        let length = stream.seek(SeekFrom::End(0))?;
        Ok(Self { stream, at: length, length, format })
    }

    /// Length of the file \[bytes\].
    pub fn length(&self) -> u64 {
        self.length
    }

    /// The `length` bytes at `at`, which are `what`.
    ///
    /// # Errors
    /// [`ReadError::Truncated`], before anything is allocated, where the file ends earlier;
    /// [`ReadError::Io`].
    pub fn block(&mut self, at: u64, length: u64, what: impl Display) -> Result<Vec<u8>, ReadError> {
        let truncated =
            || ReadError::Truncated { format: self.format, what: what.to_string(), end: self.length };
        let end = at.checked_add(length).filter(|end| *end <= self.length).ok_or_else(truncated)?;
        let mut bytes = vec![0; usize::try_from(length).map_err(|_| truncated())?];
        if self.at != at {
            // A relative seek keeps what a buffered stream has already read.
            match i64::try_from(i128::from(at) - i128::from(self.at)) {
                Ok(step) => self.stream.seek(SeekFrom::Current(step))?,
                Err(_) => self.stream.seek(SeekFrom::Start(at))?,
            };
        }
        // Unknown until the read succeeds.
        self.at = u64::MAX;
        match self.stream.read_exact(&mut bytes) {
            Ok(()) => self.at = end,
            Err(e) => {
                self.stream.seek(SeekFrom::Start(0))?;
                self.at = 0;
                return Err(if e.kind() == ErrorKind::UnexpectedEof { truncated() } else { e.into() });
            }
        }
        Ok(bytes)
    }

    /// The block of `length` bytes at `at`, ready to be walked through.
    ///
    /// # Errors
    /// Those of [`Self::block`].
    pub fn fields(
        &mut self,
        at: u64,
        length: u64,
        order: Order,
        what: impl Display,
    ) -> Result<Fields, ReadError> {
        let bytes = self.block(at, length, &what)?;
        Ok(Fields::new(self.format, what.to_string(), order, at, bytes))
    }
}

/// A cursor over the fields of one block.
#[derive(Clone, Debug)]
pub struct Fields {
    format: &'static str,
    block: String,
    order: Order,
    base: u64,
    bytes: Vec<u8>,
    at: usize,
}

impl Fields {
    /// A block named `block` whose first byte is the file's byte `base`.
    pub fn new(format: &'static str, block: String, order: Order, base: u64, bytes: Vec<u8>) -> Self {
        Self { format, block, order, base, bytes, at: 0 }
    }

    /// Goes to byte `at` of the block; the next read fails if that is beyond its end.
    pub fn go(&mut self, at: usize) {
        self.at = at;
    }

    /// Goes `count` bytes on.
    pub fn skip(&mut self, count: usize) {
        self.at = self.at.saturating_add(count);
    }

    /// Number of bytes behind the cursor.
    pub fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// The next `count` bytes.
    ///
    /// # Errors
    /// [`ReadError::Truncated`] where the block ends earlier.
    pub fn bytes(&mut self, count: usize, name: &str) -> Result<&[u8], ReadError> {
        let end = self.at.checked_add(count).filter(|end| *end <= self.bytes.len());
        let Some(end) = end else {
            return Err(ReadError::Truncated {
                format: self.format,
                what: format!("{}, {name}", self.block),
                end: self.base.saturating_add(self.bytes.len() as u64),
            });
        };
        let start = std::mem::replace(&mut self.at, end);
        Ok(self.bytes.get(start..end).unwrap_or_default())
    }

    fn array<const N: usize>(&mut self, name: &str) -> Result<[u8; N], ReadError> {
        let order = self.order;
        let mut array = [0; N];
        // `bytes` gave exactly N.
        array.copy_from_slice(self.bytes(N, name)?);
        if order == Order::Big {
            array.reverse();
        }
        Ok(array)
    }

    /// A byte.
    ///
    /// # Errors
    /// [`ReadError::Truncated`], here and below, where the block ends earlier.
    pub fn u8(&mut self, name: &str) -> Result<u8, ReadError> {
        Ok(u8::from_le_bytes(self.array(name)?))
    }

    /// A number of two bytes.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn u16(&mut self, name: &str) -> Result<u16, ReadError> {
        Ok(u16::from_le_bytes(self.array(name)?))
    }

    /// A number of four bytes.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn u32(&mut self, name: &str) -> Result<u32, ReadError> {
        Ok(u32::from_le_bytes(self.array(name)?))
    }

    /// A number of eight bytes.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn u64(&mut self, name: &str) -> Result<u64, ReadError> {
        Ok(u64::from_le_bytes(self.array(name)?))
    }

    /// A float of four bytes.
    ///
    /// # Errors
    /// As [`Self::u8`], and [`ReadError::Damaged`] where it is infinite or not a number.
    pub fn f32(&mut self, name: &str) -> Result<f64, ReadError> {
        let value = f32::from_le_bytes(self.array(name)?);
        if value.is_finite() {
            return Ok(plain(value));
        }
        Err(self.damaged(name, value, "a finite number"))
    }

    /// A float as [`Self::f32`] that is a length, time or speed: not negative, below 10^9.
    ///
    /// # Errors
    /// As [`Self::f32`].
    pub fn quantity(&mut self, name: &str) -> Result<f64, ReadError> {
        let value = self.f32(name)?;
        if (0.0..1e9).contains(&value) {
            return Ok(value);
        }
        Err(self.damaged(name, value, "at least 0 and below 1e9"))
    }

    /// Text of `length` bytes that a zero byte may end early. What is not printable ASCII becomes `?`.
    ///
    /// # Errors
    /// As [`Self::u8`].
    pub fn text(&mut self, length: usize, name: &str) -> Result<String, ReadError> {
        let bytes = self.bytes(length, name)?;
        let visible = |b: &u8| if matches!(b, b' '..=b'~') { char::from(*b) } else { '?' };
        Ok(bytes.iter().take_while(|b| **b != 0).map(visible).collect())
    }

    /// Checks that the next bytes are `expected`.
    ///
    /// # Errors
    /// As [`Self::u8`], and [`ReadError::Damaged`] where they differ.
    pub fn expect(&mut self, expected: &[u8], name: &str) -> Result<(), ReadError> {
        let found = self.bytes(expected.len(), name)?;
        if found == expected {
            return Ok(());
        }
        let found = format!("{found:02x?}");
        Err(self.damaged(name, found, format_args!("{expected:02x?}")))
    }

    /// The error that field `name` of this block is `value` but should be `expected`.
    pub fn damaged(&self, name: &str, value: impl Display, expected: impl Display) -> ReadError {
        ReadError::Damaged {
            format: self.format,
            what: format!("{}, {name}", self.block),
            value: value.to_string(),
            expected: expected.to_string(),
        }
    }
}

/// A block that is being written.
#[derive(Clone, Debug)]
pub struct Put {
    order: Order,
    bytes: Vec<u8>,
    unfit: Option<String>,
}

impl Put {
    /// An empty block.
    pub fn new(order: Order) -> Self {
        Self { order, bytes: Vec::new(), unfit: None }
    }

    /// Number of bytes so far.
    pub fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Nothing written yet.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    fn array<const N: usize>(&mut self, mut little: [u8; N]) {
        if self.order == Order::Big {
            little.reverse();
        }
        self.bytes.extend_from_slice(&little);
    }

    /// Appends bytes as they are.
    pub fn bytes(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Appends `count` zero bytes.
    pub fn zeros(&mut self, count: usize) {
        self.bytes.resize(self.bytes.len() + count, 0);
    }

    /// Appends a byte.
    pub fn u8(&mut self, value: u8) {
        self.array([value]);
    }

    /// Appends a number of two bytes.
    pub fn u16(&mut self, value: u16) {
        self.array(value.to_le_bytes());
    }

    /// Appends a number of four bytes.
    pub fn u32(&mut self, value: u32) {
        self.array(value.to_le_bytes());
    }

    /// Appends a number of eight bytes.
    pub fn u64(&mut self, value: u64) {
        self.array(value.to_le_bytes());
    }

    /// Appends a float of four bytes; [`Self::done`] fails if it is infinite or not a number.
    pub fn f32(&mut self, name: &str, value: f64) {
        let short = value as f32;
        if !short.is_finite() && self.unfit.is_none() {
            self.unfit =
                Some(format!("{name} is {value}, which a container cannot hold; give a finite number"));
        }
        self.array(short.to_le_bytes());
    }

    /// Appends text in a field of `length` bytes, filled up with zeros, at least one. What is not
    /// printable ASCII becomes `?`; what does not fit is cut off.
    pub fn text(&mut self, length: usize, text: &str) {
        let end = self.bytes.len() + length;
        let visible = |c: char| if matches!(c, ' '..='~') { c as u8 } else { b'?' };
        self.bytes.extend(text.chars().map(visible).take(length.saturating_sub(1)));
        self.bytes.resize(end, 0);
    }

    /// The block.
    ///
    /// # Errors
    /// `InvalidInput` where a number was infinite or none, with its name.
    pub fn done(self) -> io::Result<Vec<u8>> {
        match self.unfit {
            None => Ok(self.bytes),
            Some(reason) => Err(io::Error::new(ErrorKind::InvalidInput, reason)),
        }
    }
}

/// The shortest decimal that is this float: 0.05, as its writer meant, and not 0.05000000074.
pub fn plain(value: f32) -> f64 {
    value.to_string().parse().unwrap_or_else(|_| value.into())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn source(bytes: &[u8]) -> Source {
        Source::new("test", Box::new(Cursor::new(bytes.to_vec()))).unwrap()
    }

    #[test]
    fn what_is_put_is_read_in_both_orders() {
        for order in [Order::Little, Order::Big] {
            let mut put = Put::new(order);
            put.u8(1);
            put.u16(0x0203);
            put.u32(0x0405_0607);
            put.u64(0x0809_0a0b_0c0d_0e0f);
            put.f32("a", 1.5);
            put.text(6, "Mär-long");
            put.zeros(2);
            put.bytes(b"xy");
            let bytes = put.done().unwrap();
            assert_eq!(bytes[1], if order == Order::Big { 2 } else { 3 });
            assert_eq!(bytes.len(), 1 + 2 + 4 + 8 + 4 + 6 + 2 + 2);

            let mut f = source(&bytes).fields(0, bytes.len() as u64, order, "head").unwrap();
            assert_eq!((f.u8("").unwrap(), f.u16("").unwrap()), (1, 0x0203));
            assert_eq!((f.u32("").unwrap(), f.u64("").unwrap()), (0x0405_0607, 0x0809_0a0b_0c0d_0e0f));
            assert_eq!(f.quantity("").unwrap(), 1.5);
            assert_eq!(f.text(6, "").unwrap(), "M?r-l");
            f.skip(2);
            f.expect(b"xy", "tail").unwrap();
            assert_eq!(f.left(), 0);
            f.go(usize::MAX);
            assert_eq!(
                f.u8("mark").unwrap_err().to_string(),
                "test: ends at byte 29 within head, mark; the file is truncated, write or copy it again"
            );
        }
    }

    #[test]
    fn blocks_are_checked_before_they_are_allocated() {
        let mut source = source(&[1, 2, 3, 4]);
        assert_eq!(source.block(1, 2, "").unwrap(), [2, 3]);
        assert_eq!(source.block(3, 1, "").unwrap(), [4]);
        assert_eq!(source.block(0, 4, "").unwrap(), [1, 2, 3, 4]);
        assert!(source.block(4, 0, "").unwrap().is_empty());
        for (at, length) in [(0, 5), (5, 0), (4, 1), (0, u64::MAX), (u64::MAX, 2), (u64::MAX, u64::MAX)] {
            let error = source.block(at, length, "layer 7").unwrap_err();
            assert!(matches!(error, ReadError::Truncated { end: 4, .. }), "{error}");
        }
        assert_eq!(source.block(0, 1, "").unwrap(), [1], "an error leaves it usable");
    }

    #[test]
    fn numbers_that_are_none_are_refused() {
        for value in [f64::NAN, f64::INFINITY, 1e300] {
            let mut put = Put::new(Order::Little);
            put.f32("exposure", value);
            let error = put.done().unwrap_err();
            assert_eq!(error.kind(), ErrorKind::InvalidInput);
            assert!(error.to_string().starts_with("exposure is "), "{error}");
        }
        for value in [f32::NAN, f32::NEG_INFINITY, -1.0, 1e9] {
            let bytes = value.to_le_bytes();
            let mut f = Fields::new("test", "head".into(), Order::Little, 0, bytes.to_vec());
            let error = f.quantity("exposure").unwrap_err();
            assert!(error.to_string().starts_with("test: head, exposure is "), "{error}");
        }
    }

    #[test]
    fn expected_bytes_are_compared() {
        let mut f = Fields::new("test", "head".into(), Order::Big, 0, vec![7, 0xd]);
        let error = f.expect(&[7, 0xa], "mark").unwrap_err();
        assert_eq!(
            error.to_string(),
            "test: head, mark is [07, 0d], expected [07, 0a]; the file is damaged or of another version"
        );
    }
}
