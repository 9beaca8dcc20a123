//! Figures and states for people.

use crate::batch::event::Status;
use crate::job::FailureKind;

/// A state in a word.
pub(super) const fn status(status: Status) -> &'static str {
    match status {
        Status::Done => "done",
        Status::Failed => "failed",
        Status::Quarantined => "quarantined",
    }
}

/// A kind of failure, as in JSON.
pub(super) const fn kind(kind: FailureKind) -> &'static str {
    match kind {
        FailureKind::Model => "model",
        FailureKind::Settings => "settings",
        FailureKind::Device => "device",
        FailureKind::Output => "output",
        FailureKind::Defect => "defect",
        FailureKind::Cancelled => "cancelled",
        FailureKind::TimeLimit => "time_limit",
        FailureKind::MemoryLimit => "memory_limit",
        FailureKind::Crashed => "crashed",
    }
}

/// A number with its thousands apart: `1 234 567.80`, with a narrow space that does not break.
pub(super) fn figure(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let (whole, fraction) = text.split_once('.').map_or((text.as_str(), None), |(w, f)| (w, Some(f)));
    let (sign, digits) = whole.strip_prefix('-').map_or(("", whole), |d| ("-", d));
    let mut out = String::from(sign);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && (digits.len() - index) % 3 == 0 && digits.len() > 4 {
            out.push('\u{202f}');
        }
        out.push(digit);
    }
    if let Some(fraction) = fraction {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

/// A number of bytes: `1.2 MB`.
pub(super) fn bytes(value: u64) -> String {
    let mut value = value as f64;
    for unit in ["B", "kB", "MB", "GB"] {
        if value < 999.5 {
            let decimals = usize::from(value < 99.95 && unit != "B");
            return format!("{value:.decimals$}\u{a0}{unit}");
        }
        value /= 1000.0;
    }
    format!("{}\u{a0}TB", figure(value, 1))
}

/// `2d 3h`, `1h 2m`, `3m 4s`, `5.6s`: the two largest units.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round().max(0.0) as u64;
    let (days, hours, minutes, rest) = (whole / 86_400, whole / 3600 % 24, whole / 60 % 60, whole % 60);
    match (days, hours, minutes) {
        (0, 0, 0) if seconds < 9.95 => format!("{:.1}s", seconds.max(0.0)),
        (0, 0, 0) => format!("{rest}s"),
        (0, 0, m) => format!("{m}m {rest}s"),
        (0, h, m) => format!("{h}h {m}m"),
        (d, h, _) => format!("{d}d {h}h"),
    }
}

/// `1 job`, `2 jobs`.
pub fn count(number: usize, one: &str, many: &str) -> String {
    format!("{number} {}", if number == 1 { one } else { many })
}

/// A text in one line that a terminal takes for nothing but text: names of files can hold anything.
pub fn plain(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        // Marks that turn the direction of writing would make a line read as another.
        let turns = matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
        if c.is_control() || turns { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// At most so many characters, with `…` where some were left out.
pub(super) fn shortened(text: &str, most: usize) -> String {
    match text.char_indices().nth(most) {
        None => text.to_owned(),
        Some((end, _)) => format!("{}…", &text[..end]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_read_well() {
        assert_eq!(figure(1_234_567.8, 2), "1\u{202f}234\u{202f}567.80");
        assert_eq!(figure(1234.0, 0), "1234");
        assert_eq!(figure(-12_345.0, 0), "-12\u{202f}345");
        assert_eq!(bytes(999), "999\u{a0}B");
        assert_eq!(bytes(1000), "1.0\u{a0}kB");
        assert_eq!(bytes(999_499_999), "999\u{a0}MB");
        assert_eq!(bytes(5_000_000_000_000_000), "5000.0\u{a0}TB");
        assert_eq!(duration(0.04), "0.0s");
        assert_eq!(duration(59.6), "1m 0s");
        assert_eq!(duration(3723.0), "1h 2m");
        assert_eq!(duration(200_000.0), "2d 7h");
        assert_eq!(shortened("äöü", 2), "äö…");
        assert_eq!(plain("a\u{1b}[2Jb\nc\u{202e}d"), "a\\u{1b}[2Jb\\nc\\u{202e}d");
    }
}
