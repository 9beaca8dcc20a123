//! A buffer for codes of few bytes.

/// Bytes that are appended as parts of words: cheaper than byte by byte, as every store is of the same
/// length and only the place of the next one depends on the code.
pub(super) struct Words {
    /// Kept bytes up to `length`, room behind.
    bytes: Vec<u8>,
    length: usize,
}

/// Lengths of runs whose codes are kept in tables: all that fit into a row of most panels.
pub(super) const SHORT: usize = 1 << 14;

/// A code of at most three bytes: they are the lower ones, first byte lowest; the highest byte counts
/// them. The code of an empty run is 0.
pub(super) const fn short(bytes: [u8; 3], count: u8) -> u32 {
    u32::from_le_bytes([bytes[0], bytes[1], bytes[2], count])
}

impl Words {
    /// An empty buffer with memory for `capacity` bytes.
    pub(super) fn new(capacity: usize) -> Self {
        Self { bytes: Vec::with_capacity(capacity), length: 0 }
    }

    /// Makes sure that `count` bytes can be put; they must not be more until the next call.
    pub(super) fn make_room(&mut self, count: usize) {
        self.bytes.resize(self.length + count + 8, 0);
    }

    /// Appends the `count` most significant bytes of `word`, the most significant first.
    #[inline(always)]
    pub(super) fn put(&mut self, word: u64, count: usize) {
        if let Some(room) = self.bytes.get_mut(self.length..self.length + 8) {
            room.copy_from_slice(&word.to_be_bytes());
            self.length += count;
        }
    }

    /// Appends the `count` lowest bytes of `word`, the lowest first.
    #[inline(always)]
    pub(super) fn put_short(&mut self, word: u32, count: u32) {
        if let Some(room) = self.bytes.get_mut(self.length..self.length + 4) {
            room.copy_from_slice(&word.to_le_bytes());
            self.length += count as usize;
        }
    }

    /// What was put.
    pub(super) fn done(mut self) -> Vec<u8> {
        self.bytes.truncate(self.length);
        self.bytes
    }
}
