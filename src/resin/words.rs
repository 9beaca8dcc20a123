//! A buffer for codes of few bytes.

/// Bytes that are appended as parts of words: cheaper than byte by byte, as every store is of the same
/// length and only the place of the next one depends on the code.
pub(super) struct Words {
    /// Kept bytes up to `length`, room behind.
    bytes: Vec<u8>,
    length: usize,
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

    /// What was put.
    pub(super) fn done(mut self) -> Vec<u8> {
        self.bytes.truncate(self.length);
        self.bytes
    }
}
