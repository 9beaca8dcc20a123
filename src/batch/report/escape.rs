//! Texts inside HTML and URLs.

use std::fmt;
use std::path::{Component, Path};

/// A text as content of an element or of a quoted attribute.
pub(super) struct Html<'a>(pub &'a str);

impl fmt::Display for Html<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut rest = self.0;
        while let Some(at) = rest.find(|c: char| matches!(c, '&' | '<' | '>' | '"' | '\'') || hidden(c)) {
            let (before, from) = rest.split_at(at);
            f.write_str(before)?;
            let c = from.chars().next().unwrap_or_default();
            match c {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                // HTML knows no other control characters; these show what is there.
                _ => f.write_str("\u{fffd}")?,
            }
            rest = &from[c.len_utf8()..];
        }
        f.write_str(rest)
    }
}

/// Characters that are not seen but change what is.
fn hidden(c: char) -> bool {
    (c.is_control() && !matches!(c, '\n' | '\t'))
        || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// A relative URL from a folder to a file, if both are on the same root.
pub(super) fn link(folder: &Path, file: &Path) -> Option<String> {
    let (folder, file) = (std::path::absolute(folder).ok()?, std::path::absolute(file).ok()?);
    let (mut from, mut to) = (folder.components().peekable(), file.components().peekable());
    if from.peek() != to.peek() {
        return None;
    }
    while from.peek().is_some() && from.peek() == to.peek() {
        from.next();
        to.next();
    }
    // Without `./` a name with a colon would be taken for a scheme.
    let mut url = String::from("./");
    for _ in from {
        url.push_str("../");
    }
    let parts: Vec<String> = to
        .map(|part| match part {
            Component::Normal(name) => encoded(name.as_encoded_bytes()),
            _ => "..".to_owned(),
        })
        .collect();
    Some(url + &parts.join("/"))
}

/// Everything but unreserved characters (RFC 3986) percent-encoded.
fn encoded(bytes: &[u8]) -> String {
    let mut out = String::with_capacity(bytes.len());
    for byte in bytes {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => out.push(*byte as char),
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_gets_out_of_an_attribute() {
        let text = Html("<script>\"x'&\u{0}\u{202e}ä\n").to_string();
        assert_eq!(text, "&lt;script&gt;&quot;x&#39;&amp;\u{fffd}\u{fffd}ä\n");
        assert_eq!(Html("").to_string(), "");
        assert_eq!(Html("&&").to_string(), "&amp;&amp;");
    }

    #[test]
    fn links_are_relative() {
        let link = |folder: &str, file: &str| link(Path::new(folder), Path::new(file));
        assert_eq!(link("/a/b", "/a/b/c d/é.gcode").as_deref(), Some("./c%20d/%C3%A9.gcode"));
        assert_eq!(link("/a/b", "/a/c/x").as_deref(), Some("./../c/x"));
        assert_eq!(link("/a", "/a/javascript:alert(1)").as_deref(), Some("./javascript%3Aalert%281%29"));
    }
}
