//! Lines of an input, of bounded length.

use std::io::{self, BufRead};

/// Longer lines are passed over \[bytes\].
pub const LONGEST: usize = 16 << 20;

/// Reads line by line.
pub struct Lines<R> {
    input: R,
    line: Vec<u8>,
    longest: usize,
}

/// One line.
#[derive(Debug, PartialEq, Eq)]
pub enum Line<'a> {
    /// Without its end.
    Whole(&'a [u8]),
    /// It was passed over.
    TooLong,
}

impl<R: BufRead> Lines<R> {
    /// Lines up to [`LONGEST`].
    pub fn new(input: R) -> Self {
        Self { input, line: Vec::new(), longest: LONGEST }
    }

    /// The next line that is not blank; the last one need not have an end. `None` at the end of the input.
    ///
    /// # Errors
    /// Those of the input.
    pub fn next_line(&mut self) -> io::Result<Option<Line<'_>>> {
        loop {
            let (read, too_long) = self.fill()?;
            if too_long {
                self.line = Vec::new();
                return Ok(Some(Line::TooLong));
            }
            if !self.line.trim_ascii().is_empty() {
                // Found again below: a borrow that is returned cannot be held over a loop.
                break;
            }
            if read == 0 {
                return Ok(None);
            }
        }
        Ok(Some(Line::Whole(self.line.trim_ascii())))
    }

    /// Reads a line into `line`, without its end: the bytes it took of the input, and whether there were too many
    /// to keep.
    fn fill(&mut self) -> io::Result<(u64, bool)> {
        self.line.clear();
        let (mut read, mut too_long) = (0, false);
        loop {
            let chunk = match self.input.fill_buf() {
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                chunk => chunk?,
            };
            let end = chunk.iter().position(|b| *b == b'\n');
            let part = chunk.get(..end.unwrap_or(chunk.len())).unwrap_or_default();
            too_long |= self.line.len() + part.len() > self.longest;
            if too_long {
                self.line.clear();
            } else {
                self.line.extend_from_slice(part);
            }
            let taken = part.len() + usize::from(end.is_some());
            self.input.consume(taken);
            read += taken as u64;
            if end.is_some() || taken == 0 {
                return Ok((read, too_long));
            }
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::io::BufReader;

    /// The lines of a text, read in pieces of `piece` bytes; `*` for those too long.
    fn lines(text: &str, piece: usize) -> Vec<String> {
        let input = BufReader::with_capacity(piece, text.as_bytes());
        let mut lines = Lines { longest: 8, ..Lines::new(input) };
        let mut found = Vec::new();
        while let Some(line) = lines.next_line().unwrap() {
            found.push(match line {
                Line::Whole(bytes) => String::from_utf8(bytes.to_vec()).unwrap(),
                Line::TooLong => "*".to_owned(),
            });
        }
        found
    }

    #[test]
    fn blank_lines_are_left_out_and_long_ones_passed_over() {
        for piece in [1, 3, 100] {
            assert!(lines("", piece).is_empty() && lines("\n \r\n\n", piece).is_empty());
            assert_eq!(lines("a\r\n\nbc", piece), ["a", "bc"]);
            assert_eq!(lines("12345678\n123456789\nx\n1234567890123", piece), ["12345678", "*", "x", "*"]);
            assert_eq!(lines("123456789012345678\n\ny", piece), ["*", "y"]);
        }
    }
}
