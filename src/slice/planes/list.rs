//! Planes at given heights, one a line.

use super::{LayerZ, MAX_LAYERS};
use crate::lattice::{NM_PER_MM, mm};
use std::path::PathBuf;
use thiserror::Error;

/// A list of heights that cannot be used. Names the file, the line and the value.
#[derive(Clone, Debug, PartialEq, Error)]
#[error("{}:{line}: {problem}", path.display())]
pub struct ListError {
    /// The file.
    pub path: PathBuf,
    /// Line, counted from 1.
    pub line: usize,
    /// What is wrong with it, and what to do.
    pub problem: ListProblem,
}

/// What can be wrong with a line of a list of heights.
#[derive(Clone, Debug, PartialEq, Error)]
#[expect(missing_docs, reason = "fields say what their message shows")]
pub enum ListProblem {
    /// No number.
    #[error("{text:?} is no height; write one number in millimetres a line, such as 0.2")]
    NotANumber { text: String },
    /// NaN or infinite.
    #[error("{text} is not finite; give a height in millimetres")]
    NotFinite { text: String },
    /// Further from the bed than 32-bit nanometres reach.
    #[error("{value} mm is beyond the lattice's +-2147 mm; check the unit, heights are in millimetres")]
    TooFar { value: f64 },
    /// Below the height before it.
    #[error("{value} mm lies below {before} mm before it; sort the heights")]
    Order { value: f64, before: f64 },
    /// The height before it once more.
    #[error("{value} mm is there twice (heights are compared in whole nanometres); remove one")]
    Twice { value: f64 },
    /// No height in the whole file.
    #[error("the file ends without a height; write one number in millimetres a line")]
    Empty,
    /// More than [`MAX_LAYERS`].
    #[error("more than {MAX_LAYERS} heights; cut the model in several runs")]
    TooMany,
}

/// Reads cutting heights above the bed \[mm\], strictly ascending, one a line; `#` begins a comment, and
/// blank lines are skipped. Heights are rounded to the lattice. `path` stands for the text in messages.
///
/// A layer of such a list reaches from the plane before it (the first from the bed) up to its own plane:
/// the list says where to cut and nothing else about thickness.
///
/// # Errors
/// [`ListError`] for the first line that is wrong.
pub fn parse(text: &str, path: &std::path::Path) -> Result<Vec<LayerZ>, ListError> {
    let mut layers: Vec<LayerZ> = Vec::new();
    let error = |line, problem| ListError { path: path.to_owned(), line, problem };
    let mut lines = 0;
    for (i, line) in text.lines().enumerate() {
        lines = i + 1;
        let value = line.split('#').next().unwrap_or_default().trim();
        if value.is_empty() {
            continue;
        }
        let before = layers.last().map(|l| l.slice_z);
        let z = height(value, before).map_err(|problem| error(i + 1, problem))?;
        if layers.len() as u64 >= MAX_LAYERS {
            return Err(error(i + 1, ListProblem::TooMany));
        }
        layers.push(LayerZ { slice_z: z, print_z: z, height: z.saturating_sub(before.unwrap_or(0)) });
    }
    if layers.is_empty() {
        return Err(error(lines.max(1), ListProblem::Empty));
    }
    Ok(layers)
}

/// A height \[nm\] that must lie above the one before it.
fn height(text: &str, before: Option<i32>) -> Result<i32, ListProblem> {
    let value: f64 = text.parse().map_err(|_| ListProblem::NotANumber { text: shortened(text) })?;
    if !value.is_finite() {
        return Err(ListProblem::NotFinite { text: shortened(text) });
    }
    let nm = (value * NM_PER_MM).round();
    if nm.abs() >= f64::from(i32::MAX) {
        return Err(ListProblem::TooFar { value });
    }
    let z = nm as i32;
    match before {
        Some(below) if z == below => Err(ListProblem::Twice { value }),
        Some(below) if z < below => Err(ListProblem::Order { value, before: mm(below) }),
        _ => Ok(z),
    }
}

/// The beginning of a text, so that a message stays one line.
fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::path::Path;

    fn read(text: &str) -> Result<Vec<i32>, String> {
        parse(text, Path::new("z.txt"))
            .map(|l| l.iter().map(|l| l.slice_z).collect())
            .map_err(|e| e.to_string())
    }

    #[test]
    fn heights_comments_and_blank_lines() {
        assert_eq!(read("# heights\n0.1\n\n 0.25 # mm\r\n1e1\n"), Ok(vec![100_000, 250_000, 10_000_000]));
        assert_eq!(read("-1\n0\n2147"), Ok(vec![-1_000_000, 0, 2_147_000_000]));
        let layers = parse("0.1\n0.4\n", Path::new("z")).unwrap();
        assert_eq!(layers[1], LayerZ { slice_z: 400_000, print_z: 400_000, height: 300_000 });
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        for (text, line, word) in [
            ("0.1\nabc\n", 2, "\"abc\" is no height"),
            ("0.1 0.2\n", 1, "one number"),
            ("0,1\n", 1, "is no height"),
            ("\nNaN\n", 2, "not finite"),
            ("1\ninf", 2, "not finite"),
            ("0.2\n0.1\n", 2, "0.1 mm lies below 0.2 mm"),
            ("0.2\n# x\n0.2\n", 3, "there twice"),
            ("0.2\n0.2000000001\n", 2, "there twice"),
            ("3000\n", 1, "beyond the lattice"),
            ("", 1, "without a height"),
            ("# nothing\n\n", 2, "without a height"),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.starts_with(&format!("z.txt:{line}: ")) && error.contains(word), "{error}");
            assert!(!error.contains('\n'));
        }
    }
}
