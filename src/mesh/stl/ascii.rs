//! ASCII STL, read as a stream of words so that any white space will do.
//!
//! The text is cut where a line begins with `facet`, and the pieces are read in parallel. Normals are
//! skipped: a facet's corners say which way it faces.

use crate::mesh::frame::Soup;
use rayon::prelude::*;

/// The facets of an ASCII file.
#[derive(Debug, Default, PartialEq)]
pub(in crate::mesh) struct Ascii {
    facets: Vec<[[f32; 3]; 3]>,
    /// Whether the last solid was closed by `endsolid`.
    pub(in crate::mesh) ended: bool,
}

/// Text that breaks the format, at a byte of the file.
#[derive(Debug, PartialEq, Eq)]
pub(in crate::mesh) struct Fault {
    /// Offset into the text.
    pub(in crate::mesh) at: usize,
    /// What should stand there.
    pub(in crate::mesh) expected: &'static str,
    /// The word found, or `None` at the end of the file.
    pub(in crate::mesh) found: Option<String>,
}

/// Bytes that one task reads; any value gives the same result.
const PIECE: usize = 1 << 19;

/// Reads a whole text. The earliest fault in the file wins.
pub(in crate::mesh) fn parse(text: &[u8]) -> Result<Ascii, Fault> {
    parse_pieces(text, PIECE)
}

fn parse_pieces(text: &[u8], piece: usize) -> Result<Ascii, Fault> {
    let cuts = cuts(text, piece);
    let parts: Vec<Result<Ascii, Fault>> = cuts
        .par_windows(2)
        .map(|w| {
            Words { text: &text[..w[1]], at: w[0] }.facets().map_err(|fault| match fault.found {
                // A piece that ends inside a facet, with more text behind it.
                None if w[1] < text.len() => Fault { found: Some("facet".into()), at: w[1], ..fault },
                _ => fault,
            })
        })
        .collect();
    let mut whole = Ascii::default();
    if let [Ok(_)] = parts.as_slice() {
        return parts.into_iter().next().unwrap_or(Ok(whole));
    }
    for part in parts {
        let mut part = part?;
        whole.facets.append(&mut part.facets);
        whole.ended = part.ended;
    }
    Ok(whole)
}

/// Line of a byte offset, from 1.
pub(in crate::mesh) fn line(text: &[u8], at: usize) -> u64 {
    let before = &text[..at.min(text.len())];
    let count = |end: u8| before.iter().filter(|&&b| b == end).count() as u64;
    1 + if text.contains(&b'\n') { count(b'\n') } else { count(b'\r') }
}

/// Line of a corner, both counted from 0; for messages about files that were read without a fault.
pub(in crate::mesh) fn line_of_corner(text: &[u8], facet: usize, corner: usize) -> u64 {
    let mut words = Words { text, at: 0 };
    let mut left = 3 * facet + corner;
    while let Some((word, at)) = words.next() {
        if is(word, "solid") || is(word, "endsolid") {
            words.skip_name();
        } else if is(word, "vertex") {
            if left == 0 {
                return line(text, at);
            }
            left -= 1;
        }
    }
    line(text, text.len())
}

/// The stored normals of a text that was read without a fault, one per facet; what is no number is
/// NaN, what is missing 0.
pub(in crate::mesh) fn normals(text: &[u8]) -> Vec<[f32; 3]> {
    let mut words = Words { text, at: 0 };
    let mut normals = Vec::new();
    while let Some((word, _)) = words.next() {
        if is(word, "solid") || is(word, "endsolid") {
            words.skip_name();
        } else if is(word, "facet") {
            let mut normal = [0.0; 3];
            words.next();
            for number in &mut normal {
                match words.next() {
                    Some((word, _)) if !is(word, "outer") => {
                        let parsed = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
                        *number = parsed.unwrap_or(f32::NAN);
                    }
                    _ => break,
                }
            }
            normals.push(normal);
        }
    }
    normals
}

impl Soup for Ascii {
    fn len(&self) -> usize {
        self.facets.len()
    }

    #[inline(always)]
    fn facet(&self, index: usize) -> [[f32; 3]; 3] {
        self.facets[index]
    }
}

/// Offsets at which pieces begin, from 0 to the text's length.
fn cuts(text: &[u8], piece: usize) -> Vec<usize> {
    let mut cuts = vec![0];
    let mut at = piece;
    while at < text.len() {
        let Some(end) = text[at..].iter().position(|&b| b == b'\n' || b == b'\r') else { break };
        let start = at + end + 1;
        let mut words = Words { text, at: start };
        match words.next() {
            // Only on the same line: what follows a name's line end is not part of the name.
            Some((word, begin)) if is(word, "facet") => {
                cuts.push(begin);
                at = begin + piece;
            }
            _ => at = start,
        }
    }
    cuts.push(text.len());
    cuts
}

fn is(word: &[u8], keyword: &str) -> bool {
    word.eq_ignore_ascii_case(keyword.as_bytes())
}

struct Words<'a> {
    text: &'a [u8],
    at: usize,
}

impl<'a> Words<'a> {
    /// The next word and its offset. Anything up to a space separates, NUL and tabs included.
    fn next(&mut self) -> Option<(&'a [u8], usize)> {
        let rest = self.text.get(self.at..)?;
        let start = rest.iter().position(|&b| b > b' ')?;
        let rest = &rest[start..];
        let length = rest.iter().position(|&b| b <= b' ').unwrap_or(rest.len());
        let begin = self.at + start;
        self.at = begin + length;
        Some((&rest[..length], begin))
    }

    /// Skips a solid's name: the rest of the line, or less if a facet begins on it.
    fn skip_name(&mut self) {
        loop {
            let rest = &self.text[self.at..];
            let start = rest.iter().position(|&b| b > b' ' || b == b'\n' || b == b'\r').unwrap_or(rest.len());
            self.at += start;
            if rest.get(start).is_none_or(|&b| b <= b' ') {
                return;
            }
            let begin = self.at;
            let Some((word, _)) = self.next() else { return };
            if is(word, "facet") {
                let mut ahead = Words { text: self.text, at: self.at };
                if ahead.next().is_some_and(|(word, _)| is(word, "normal")) {
                    self.at = begin;
                    return;
                }
            }
        }
    }

    fn expect(&mut self, keyword: &'static str) -> Result<(), Fault> {
        match self.next() {
            Some((word, _)) if is(word, keyword) => Ok(()),
            other => Err(fault(self.text, other, keyword)),
        }
    }

    fn number(&mut self) -> Result<f32, Fault> {
        let word = self.next();
        word.and_then(|(w, _)| std::str::from_utf8(w).ok()?.parse().ok())
            .ok_or_else(|| fault(self.text, word, "a number"))
    }

    fn facets(&mut self) -> Result<Ascii, Fault> {
        let mut read = Ascii::default();
        while let Some((word, at)) = self.next() {
            if is(word, "facet") {
                read.facets.push(self.facet()?);
                read.ended = false;
            } else if is(word, "solid") {
                self.skip_name();
                read.ended = false;
            } else if is(word, "endsolid") {
                self.skip_name();
                read.ended = true;
            } else if self.at == self.text.len() && "endsolid".starts_with(&*String::from_utf8_lossy(word)) {
                break;
            } else {
                return Err(fault(self.text, Some((word, at)), "`facet`, `endsolid` or `solid`"));
            }
        }
        Ok(read)
    }

    /// Everything of a facet after its first word.
    fn facet(&mut self) -> Result<[[f32; 3]; 3], Fault> {
        self.expect("normal")?;
        // Whatever stands for the normal, up to three words of it.
        for _ in 0..4 {
            match self.next() {
                Some((word, _)) if is(word, "outer") => break,
                Some(_) => {}
                None => return Err(fault(self.text, None, "outer")),
            }
        }
        self.expect("loop")?;
        let mut corners = [[0.0; 3]; 3];
        for corner in &mut corners {
            self.expect("vertex")?;
            *corner = [self.number()?, self.number()?, self.number()?];
        }
        self.expect("endloop")?;
        self.expect("endfacet")?;
        Ok(corners)
    }
}

fn fault(text: &[u8], word: Option<(&[u8], usize)>, expected: &'static str) -> Fault {
    match word {
        // A word that ends with the file may have been cut with it.
        Some((word, at)) if at + word.len() < text.len() => {
            // It may also be the rest of a binary file: show its beginning only.
            let shown = String::from_utf8_lossy(&word[..word.len().min(40)]).escape_debug().to_string();
            Fault { at, expected, found: Some(shown) }
        }
        _ => Fault { at: text.len(), expected, found: None },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ONE: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n\
        endloop\nendfacet\nendsolid a\n";

    fn facets(text: &str) -> Result<usize, Fault> {
        parse(text.as_bytes()).map(|a| a.facets.len())
    }

    #[test]
    fn any_white_space_case_and_name_will_do() {
        let expected = parse(ONE.as_bytes());
        assert!(expected.as_ref().is_ok_and(|a| a.ended && a.facets[0][1] == [1.0, 0.0, 0.0]));
        for variant in [
            ONE.to_uppercase(),
            ONE.replace('\n', "\r\n"),
            ONE.replace('\n', "\r"),
            ONE.replace('\n', "\n\n\t "),
            ONE.replace("solid a\nf", "solid a f").replace("\nv", " v").replace("p\nendf", "p endf"),
            ONE.replace('\n', " "),
            ONE.replace("solid a", "solid facet vertex endsolid 1"),
            ONE.replace("solid a", "solid"),
            ONE.replace("0 0 1", "nan -nan(ind) 1,0"),
            ONE.replace("vertex 1 0 0", "vertex +1.e0 .0 0e-3"),
        ] {
            assert_eq!(parse(variant.as_bytes()), expected, "{variant}");
        }
        assert!(parse(ONE.replace("endsolid a", "").as_bytes()).is_ok_and(|a| !a.ended));
        assert!(parse(&ONE.as_bytes()[..ONE.len() - 6]).is_ok_and(|a| !a.ended), "cut in `endsolid`");
        assert_eq!(facets(&ONE.repeat(3)), Ok(3));
        assert_eq!(facets("solid x\nendsolid x"), Ok(0));
    }

    #[test]
    fn faults_name_their_line() {
        let check = |from: &str, to: &str, expected: &str, at_line: u64| {
            let text = ONE.replacen(from, to, 1);
            let fault = parse(text.as_bytes()).err();
            let found = fault.map(|f| (f.expected, line(text.as_bytes(), f.at)));
            assert_eq!(found, Some((expected, at_line)), "{to}");
        };
        check("vertex 1 0 0", "vertex 1,0 0 0", "a number", 5);
        check("vertex 1 0 0", "vertex 1 0", "a number", 6);
        check("vertex 1 0 0", "vertex 1 0 0 0", "vertex", 5);
        check("vertex 0 1 0\n", "", "vertex", 6);
        check("vertex 0 1 0", "vertex 0 1 0\nvertex 0 0 0", "endloop", 7);
        check("endfacet\n", "", "endfacet", 8);
        check("facet", "facets", "`facet`, `endsolid` or `solid`", 2);
        for cut in ONE.find("normal").into_iter().chain([60, 70, 80, 90]) {
            let fault = parse(&ONE.as_bytes()[..cut]).err();
            assert!(fault.is_some_and(|f| f.found.is_none()), "{cut}");
        }
    }

    #[test]
    fn pieces_of_any_size_read_the_same() {
        let mut text = String::new();
        for i in 0..40 {
            text += &ONE
                .replace("vertex 1 0 0", &format!("vertex {i}.5 0 {i}e-3"))
                .replace("solid a", "solid facet");
        }
        let whole = parse_pieces(text.as_bytes(), usize::MAX / 2);
        assert!(whole.as_ref().is_ok_and(|a| a.facets.len() == 40));
        let broken = text.replace("vertex 17.5", "vertex 17.5.");
        let fault = parse_pieces(broken.as_bytes(), usize::MAX / 2);
        for piece in 1..400 {
            assert_eq!(parse_pieces(text.as_bytes(), piece), whole, "{piece}");
            assert_eq!(parse_pieces(broken.as_bytes(), piece), fault, "{piece}");
        }
        let unfinished = text.replacen("endfacet\n", "", 1);
        let lines = |piece| {
            parse_pieces(unfinished.as_bytes(), piece).err().map(|f| line(unfinished.as_bytes(), f.at))
        };
        assert!((1..400).all(|piece| lines(piece) == Some(8) || lines(piece) == Some(9)));
    }

    #[test]
    fn a_corners_line_is_found_again() {
        let text = ONE.replace("solid a", "solid vertex").repeat(2);
        assert_eq!(line_of_corner(text.as_bytes(), 0, 2), 6);
        assert_eq!(line_of_corner(text.as_bytes(), 1, 0), 13);
    }
}
