//! Names of outputs that collide with no other.

use crate::resin::Format;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Longest name \[bytes\]. File systems take 255; names of pictures and of files in the making are longer
/// than the output's.
const LONGEST: usize = 230;
/// Extensions of G-code.
const GCODE: [&str; 3] = ["gcode", "gco", "g"];

/// What an output is to be called.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Wish {
    /// Exactly so; checked by [`checked`].
    Own(String),
    /// After the model, with a number where that is taken.
    Model {
        /// The model's name without folder and extension.
        stem: String,
        /// Extension without the dot; empty for a folder.
        extension: String,
    },
}

/// Two wishes for one name, or for a file where the other wants a folder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Clash {
    /// Index of the earlier wish.
    pub first: usize,
    /// Index of the later one.
    pub second: usize,
}

/// A name for each wish, none like another even where letters' case does not count. A model's name gets a
/// number from 2 on where it is taken; it never takes one that another model has without a number.
///
/// # Errors
/// [`Clash`] of two wishes for exact names.
pub fn unique(wishes: &[Wish]) -> Result<Vec<String>, Clash> {
    // What is wished exactly, and the folders that it lies in.
    let mut taken: BTreeMap<String, usize> = BTreeMap::new();
    let mut folders: BTreeMap<String, usize> = BTreeMap::new();
    for (i, wish) in wishes.iter().enumerate() {
        let Wish::Own(name) = wish else { continue };
        let name = fold(name);
        for (at, _) in name.match_indices('/') {
            folders.entry(name[..at].to_owned()).or_insert(i);
        }
        if let Some(first) = taken.insert(name, i) {
            return Err(Clash { first, second: i });
        }
    }
    if let Some((a, b)) = taken.iter().find_map(|(name, i)| Some((*folders.get(name)?, *i))) {
        return Err(Clash { first: a.min(b), second: a.max(b) });
    }
    let bare = |wish: &Wish| match wish {
        Wish::Own(_) => None,
        Wish::Model { stem, extension } => Some(fold(&numbered(&cleaned(stem), 1, extension))),
    };
    let bare: Vec<Option<String>> = wishes.iter().map(bare).collect();
    let own: BTreeSet<&str> = bare.iter().flatten().map(String::as_str).collect();
    let mut next: BTreeMap<&str, u64> = BTreeMap::new();
    let mut names = Vec::with_capacity(wishes.len());
    for (i, (wish, bare)) in wishes.iter().zip(&bare).enumerate() {
        let (stem, extension, bare) = match (wish, bare) {
            (Wish::Model { stem, extension }, Some(bare)) => (cleaned(stem), extension, bare),
            (Wish::Own(name) | Wish::Model { stem: name, .. }, _) => {
                names.push(name.clone());
                continue;
            }
        };
        let number = next.entry(bare).or_insert(1);
        let name = loop {
            let name = numbered(&stem, *number, extension);
            let folded = fold(&name);
            let foreign = *number > 1 && own.contains(folded.as_str());
            *number += 1;
            if !foreign && !taken.contains_key(&folded) && !folders.contains_key(&folded) {
                taken.insert(folded, i);
                break name;
            }
        };
        names.push(name);
    }
    Ok(names)
}

/// A name in the output folder as somebody typed it: parts of folders behind `/`, at the end one for a folder
/// of pictures.
///
/// # Errors
/// What is wrong with it, and the remedy.
pub fn checked(name: &str) -> Result<String, String> {
    let wrong = |why: &str| Err(format!("output \"{}\" {why}", name.escape_debug()));
    if name.contains('\\') || name.chars().any(char::is_control) {
        return wrong("has a backslash or a control character in it; separate folders with /");
    }
    if name.starts_with('/') || name.as_bytes().get(1) == Some(&b':') {
        return wrong("is an absolute path; give a name inside the output folder");
    }
    let inner = name.strip_suffix('/').unwrap_or(name);
    for part in inner.split('/') {
        if part.is_empty() {
            return wrong("has an empty part; give a name such as parts/a.gcode");
        }
        if part.starts_with('.') {
            return wrong("has a part that begins with a dot; give a name inside the output folder");
        }
        if part.len() > LONGEST {
            return Err(format!("output has a part of {} bytes; at most {LONGEST} are allowed", part.len()));
        }
    }
    if is_report(&fold(name)) {
        return wrong("is the name of a report of the batch; give another");
    }
    Ok(name.to_owned())
}

/// The extension of a format as typed, `.svg.zip` shortened or not; empty for a folder of pictures.
///
/// # Errors
/// The formats there are.
pub fn extension_of_format(format: &str) -> Result<String, String> {
    let plain = format.trim().trim_start_matches('.').to_ascii_lowercase();
    match plain.as_str() {
        "folder" => return Ok(String::new()),
        "svg" => return Ok("svg.zip".to_owned()),
        _ if is_gcode(&plain) || Format::of_extension(&plain).is_some() => return Ok(plain),
        _ => {}
    }
    let all: Vec<&str> = Format::ALL.iter().flat_map(|f| f.extensions()).collect();
    Err(format!(
        "no format has the extension \"{}\"; there are gcode, {}, and folder",
        format.escape_debug(),
        all.join(", ")
    ))
}

/// Whether an extension is one of G-code.
pub fn is_gcode(extension: &str) -> bool {
    GCODE.contains(&extension)
}

/// The extension of an output's name, lower case; `None` where it has none, empty where it is a folder.
pub fn extension(name: &str) -> Option<String> {
    let lower = name.to_lowercase();
    if lower.ends_with('/') {
        return Some(String::new());
    }
    if lower.ends_with(".svg.zip") {
        return Some("svg.zip".to_owned());
    }
    Path::new(&lower).extension().map(|e| e.to_string_lossy().into_owned())
}

/// Names are compared without case, as some file systems do; a folder's slash does not count.
fn fold(name: &str) -> String {
    name.trim_end_matches('/').to_lowercase()
}

/// Reports that the batch writes itself, shards' included.
fn is_report(folded: &str) -> bool {
    let Some((stem, extension)) = folded.rsplit_once('.') else { return false };
    (stem.starts_with("report") && ["json", "csv", "html"].contains(&extension))
        || (stem.starts_with("quarantine") && extension == "jsonl")
}

/// What file systems and shells take without trouble.
fn cleaned(stem: &str) -> String {
    const ODD: &[char] = &['/', '\\', ':', '*', '?', '"', '<', '>', '|'];
    let plain = |c: char| if c.is_control() || ODD.contains(&c) { '_' } else { c };
    let name: String = stem.trim_start_matches('.').trim().chars().map(plain).collect();
    // A name that begins with a dash looks like an option.
    let name = name.strip_prefix('-').map(|rest| format!("_{rest}")).unwrap_or(name);
    if name.is_empty() { "model".to_owned() } else { name }
}

/// `stem-2.gcode`, `stem/` for a folder; the stem is cut where the whole would be too long.
fn numbered(stem: &str, number: u64, extension: &str) -> String {
    let tail = if number > 1 { format!("-{number}") } else { String::new() };
    let end = if extension.is_empty() { "/".to_owned() } else { format!(".{extension}") };
    let mut cut = stem.len().min(LONGEST.saturating_sub(tail.len() + end.len()));
    while !stem.is_char_boundary(cut) {
        cut -= 1;
    }
    format!("{}{tail}{end}", &stem[..cut])
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn model(stem: &str) -> Wish {
        Wish::Model { stem: stem.to_owned(), extension: "gcode".to_owned() }
    }

    fn own(name: &str) -> Wish {
        Wish::Own(name.to_owned())
    }

    fn names(wishes: &[Wish]) -> Vec<String> {
        unique(wishes).unwrap()
    }

    #[test]
    fn stems_that_collide_get_numbers_in_order() {
        let stems = ["a", "b", "A", "a-2", "a", "a"].map(model);
        assert_eq!(names(&stems), ["a.gcode", "b.gcode", "A-3.gcode", "a-2.gcode", "a-4.gcode", "a-5.gcode"]);
        // Umlauts have a case too.
        assert_eq!(names(&["Ärger", "ärger"].map(model)), ["Ärger.gcode", "ärger-2.gcode"]);
    }

    #[test]
    fn exact_names_come_first() {
        let wishes = [model("a"), own("A.gcode"), model("b.gcode"), own("b.gcode.gcode/c.gcode")];
        assert_eq!(
            names(&wishes),
            ["a-2.gcode", "A.gcode", "b.gcode-2.gcode", "b.gcode.gcode/c.gcode"],
            "a file and a folder of one name collide too"
        );
        assert_eq!(
            unique(&[own("x/a.gcode"), model("a"), own("X/A.gcode")]),
            Err(Clash { first: 0, second: 2 })
        );
        assert_eq!(unique(&[own("x/y/a.gcode"), own("x/y")]), Err(Clash { first: 0, second: 1 }));
        assert_eq!(unique(&[own("x/"), own("x/a.gcode")]), Err(Clash { first: 0, second: 1 }));
    }

    #[test]
    fn odd_stems_are_cleaned() {
        let stems = ["..", "", ".hidden", "-rf", "a\nb", "a:b", " x ", "käse & brot"].map(model);
        assert_eq!(
            names(&stems),
            [
                "model.gcode",
                "model-2.gcode",
                "hidden.gcode",
                "_rf.gcode",
                "a_b.gcode",
                "a_b-2.gcode",
                "x.gcode",
                "käse & brot.gcode"
            ]
        );
        let long = "ü".repeat(300);
        let cut = names(&[model(&long), model(&long), model(&format!("{long}!"))]);
        assert!(cut.iter().all(|n| n.len() <= LONGEST && n.ends_with(".gcode")), "{cut:?}");
        assert!(cut[1].ends_with("ü-2.gcode") && cut[2].ends_with("ü-3.gcode"));
        let folder = Wish::Model { stem: "v1.2".to_owned(), extension: String::new() };
        assert_eq!(names(&[folder.clone(), folder]), ["v1.2/", "v1.2-2/"]);
    }

    #[test]
    fn many_equal_stems_take_no_time() {
        let names = names(&vec![model("part"); 50_000]);
        assert_eq!(names.last().map(String::as_str), Some("part-50000.gcode"));
        let distinct: BTreeSet<&String> = names.iter().collect();
        assert_eq!(distinct.len(), names.len());
    }

    #[test]
    fn names_stay_in_the_folder() {
        for good in ["a.gcode", "x/y/a.gcode", "a", "masks/", "a b.goo", "report.gcode", "x/report.json"] {
            assert_eq!(checked(good).as_deref(), Ok(good));
        }
        for (bad, word) in [
            ("/a.gcode", "absolute"),
            ("c:/a.gcode", "absolute"),
            ("../a.gcode", "dot"),
            ("x/../a.gcode", "dot"),
            (".microtome/a", "dot"),
            ("", "empty"),
            ("/", "absolute"),
            ("a//b", "empty"),
            ("a\\b", "backslash"),
            ("a\nb", "control"),
            ("Report.JSON", "report"),
            ("report-1-of-2.html", "report"),
            ("quarantine.jsonl", "report"),
        ] {
            let error = checked(bad).unwrap_err();
            assert!(error.contains(word) && error.lines().count() == 1, "{bad}: {error}");
        }
        assert!(checked(&"a".repeat(231)).is_err());
    }

    #[test]
    fn formats_have_extensions() {
        let of = |text| extension_of_format(text).unwrap_or_default();
        assert_eq!((of("GOO").as_str(), of(".sl1").as_str(), of("svg").as_str()), ("goo", "sl1", "svg.zip"));
        assert_eq!(extension_of_format("folder"), Ok(String::new()));
        let error = extension_of_format("stl").unwrap_err();
        assert!(error.starts_with("no format has the extension \"stl\"; there are gcode, goo"), "{error}");
        assert_eq!(extension("A.GOO").as_deref(), Some("goo"));
        assert_eq!(extension("x.y/a.svg.zip").as_deref(), Some("svg.zip"));
        assert_eq!((extension("x.y/a"), extension("masks/").as_deref()), (None, Some("")));
    }
}
