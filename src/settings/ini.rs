//! PrusaSlicer's flat `.ini`: `key = value` lines, `#` and `;` comments, no sections.

use super::load::{Entry, Malformed, no_assignment};

/// The assignments of an `.ini` text.
///
/// # Errors
/// A line that is neither an assignment nor a comment, and a section of a vendor bundle.
pub fn entries(text: &str) -> Result<Vec<Entry>, Malformed> {
    let mut entries = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let (number, line) = (i + 1, line.trim());
        if line.is_empty() || line.starts_with(['#', ';']) {
            continue;
        }
        if line.starts_with('[') {
            let message = "starts a section; bundles of profiles are not supported yet: export one \
                           configuration (in PrusaSlicer: File > Export > Export Config) and load that";
            return Err(Malformed { line: number, message: message.to_owned() });
        }
        entries.push(entry(number, line)?);
    }
    Ok(entries)
}

/// The assignments in the config block at the end of a G-code file; `None` if there is no such block.
///
/// # Errors
/// A line in the block that is not an assignment.
pub fn config_block(bytes: &[u8]) -> Result<Option<Vec<Entry>>, Malformed> {
    let mut entries: Option<Vec<Entry>> = None;
    for (i, line) in bytes.split(|b| *b == b'\n').enumerate() {
        let comment = match line.strip_prefix(b";") {
            Some(comment) => comment.trim_ascii(),
            // Inside the block every line is a comment; anything else is not for us.
            None => continue,
        };
        match (&mut entries, comment) {
            (None, b"prusaslicer_config = begin") => entries = Some(Vec::new()),
            (None, _) => {}
            (Some(_), b"prusaslicer_config = end") => break,
            (Some(_), b"") => {}
            (Some(list), comment) => {
                let number = i + 1;
                let not_text = |_| Malformed { line: number, message: "is not UTF-8 text".to_owned() };
                list.push(entry(number, std::str::from_utf8(comment).map_err(not_text)?)?);
            }
        }
    }
    Ok(entries)
}

fn entry(line: usize, text: &str) -> Result<Entry, Malformed> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => {
            Ok(Entry { line, key: key.trim().to_owned(), value: value.trim().to_owned() })
        }
        _ => Err(no_assignment(line, text)),
    }
}
