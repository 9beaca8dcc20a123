//! "Did you mean": the nearest known name.

use super::types::PrinterTechnology;
use super::{foreign, keys};

/// The known setting of a technology most like `name`, honoured ones first; `None` if nothing is near.
pub fn nearest(name: &str, technology: PrinterTechnology) -> Option<&'static str> {
    let honoured = keys::of(technology).map(|k| k.name);
    nearest_of(name, honoured.chain(foreign::of(technology).iter().map(|f| f.name)), '_')
}

/// The name most like `name`, the first of equals; `None` if nothing is near. Names are of lower case and
/// have `joint` between their words.
pub fn nearest_of<'a>(name: &str, known: impl Iterator<Item = &'a str>, joint: char) -> Option<&'a str> {
    let typed: Vec<char> = name
        .chars()
        .take(80)
        .map(|c| if c == '-' || c == '_' || c == ' ' { joint } else { c.to_ascii_lowercase() })
        .collect();
    let limit = (typed.len() / 4).clamp(2, 3);
    // `min_by_key` keeps the first of equals.
    known
        .map(|k| (distance(&typed, k), k))
        .filter(|(d, _)| *d <= limit)
        .min_by_key(|(d, _)| *d)
        .map(|(_, k)| k)
}

/// Levenshtein's edit distance: insertions, deletions and substitutions that turn one name into the other.
fn distance(a: &[char], b: &str) -> usize {
    let mut row: Vec<usize> = (0..=a.len()).collect();
    for (i, cb) in b.chars().enumerate() {
        let mut diagonal = i;
        let mut left = i + 1;
        for (ca, cell) in a.iter().zip(row.iter_mut().skip(1)) {
            let up = *cell;
            left = (diagonal + usize::from(*ca != cb)).min(up + 1).min(left + 1);
            diagonal = up;
            *cell = left;
        }
        if let Some(first) = row.first_mut() {
            *first = i + 1;
        }
    }
    row.last().copied().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distances_are_the_textbooks() {
        let d = |a: &str, b: &str| distance(&a.chars().collect::<Vec<_>>(), b);
        assert_eq!(d("kitten", "sitting"), 3);
        assert_eq!(d("", "abc"), 3);
        assert_eq!(d("abc", ""), 3);
        assert_eq!(d("layer_height", "layer_height"), 0);
    }

    #[test]
    fn a_slip_finds_the_key_meant() {
        let nearest = |name| nearest(name, PrinterTechnology::Fff);
        assert_eq!(nearest("layer_hieght"), Some("layer_height"));
        assert_eq!(nearest("layer-height"), Some("layer_height"));
        assert_eq!(nearest("suport_material"), Some("support_material"));
        assert_eq!(nearest("quite_something_else"), None);
        assert_eq!(nearest("exposure_tiem"), None);
        assert_eq!(super::nearest("exposure_tiem", PrinterTechnology::Sla), Some("exposure_time"));
    }
}
