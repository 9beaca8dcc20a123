//! What a file is, judged by its content: the word "solid" opens binary files too, and extensions lie.

/// What the first bytes and the length of a file say about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Binary STL whose facet count agrees with the file's length to the byte.
    Binary,
    /// ASCII STL.
    Ascii,
    /// ASCII STL in UTF-16 with a byte order mark, little or big endian.
    Utf16 { big_endian: bool },
    /// A web page.
    Html,
    /// Something else, recognised.
    Other(&'static str),
    /// Too short to be anything.
    Short,
    /// Binary data: an STL whose count disagrees with its length, or noise.
    Unclear,
}

/// Bytes of a binary STL before its facets: 80 of free text and a 32-bit count.
pub(super) const HEADER: usize = 84;
/// Bytes of a binary facet: normal, three corners, two attribute bytes.
pub(super) const FACET: usize = 50;

/// The facet count in a binary header. `None` when the file is shorter than the header.
pub(super) fn claimed(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(80..HEADER)?;
    Some(u64::from(u32::from_le_bytes([count[0], count[1], count[2], count[3]])))
}

/// Judges a non-empty file.
pub(super) fn detect(bytes: &[u8]) -> Kind {
    let exact = |n: u64| HEADER as u64 + n * FACET as u64 == bytes.len() as u64;
    if claimed(bytes).is_some_and(|n| n > 0 && exact(n)) {
        return Kind::Binary;
    }
    match bytes {
        [0xFF, 0xFE, ..] => return Kind::Utf16 { big_endian: false },
        [0xFE, 0xFF, ..] => return Kind::Utf16 { big_endian: true },
        [b'P', b'K', 3, 4, ..] => return Kind::Other("a ZIP archive (perhaps a 3MF model or a packed STL)"),
        [0x1F, 0x8B, ..] => return Kind::Other("a gzip archive"),
        [0x89, b'P', b'N', b'G', ..] | [0xFF, 0xD8, 0xFF, ..] => return Kind::Other("a picture"),
        [b'%', b'P', b'D', b'F', ..] => return Kind::Other("a PDF document"),
        [0x7F, b'E', b'L', b'F', ..] | [b'M', b'Z', ..] => return Kind::Other("a program"),
        [b'p', b'l', b'y', b'\n' | b'\r', ..] => return Kind::Other("a PLY model"),
        _ => {}
    }
    let text = text_start(bytes);
    let head = &text[..text.len().min(1024)];
    let binary = head.iter().any(|&b| b < 0x20 && !b.is_ascii_whitespace() && b != 0x0B);
    if !binary && starts_with(text, "solid") && text.get(5).is_none_or(|&b| b <= b' ') {
        return Kind::Ascii;
    }
    if !binary && is_html(head) {
        return Kind::Html;
    }
    if !binary && starts_with(text, "version https://git-lfs") {
        return Kind::Other("a Git LFS pointer (run `git lfs pull`)");
    }
    if !binary && head.first() == Some(&b'<') {
        return Kind::Other("an XML document");
    }
    if !binary && head.is_ascii() {
        return Kind::Other("plain text");
    }
    if bytes.len() < HEADER + FACET && claimed(bytes) != Some(0) { Kind::Short } else { Kind::Unclear }
}

/// The bytes after a UTF-8 byte order mark and leading white space.
pub(super) fn text_start(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(&[0xEF, 0xBB, 0xBF]).unwrap_or(bytes).trim_ascii_start()
}

fn starts_with(bytes: &[u8], word: &str) -> bool {
    bytes.get(..word.len()).is_some_and(|b| b.eq_ignore_ascii_case(word.as_bytes()))
}

fn is_html(head: &[u8]) -> bool {
    let tag = |at: &[u8]| ["<!doctype html", "<html", "<head", "<body"].iter().any(|t| starts_with(at, t));
    head.first() == Some(&b'<') && (0..head.len()).any(|i| tag(&head[i..]))
}
