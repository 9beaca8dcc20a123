//! Setting and reading a value by its key.

use super::foreign;
use super::keys::{self, Key};
use super::kind::Kind;
use super::suggest;
use super::types::{PrinterTechnology, Settings};
use super::value::{Problem, escape, unescape};
use std::fmt;

/// What became of an assignment.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Assigned {
    /// The value is in force.
    Applied(Option<Warning>),
    /// PrusaSlicer has this key, this crate does not honour it yet; a warning if that will be seen in the print.
    NotHonoured(Option<Warning>),
}

/// Something the user should know that does not stop the job.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Warning {
    /// File and line the value came from, `b.ini:12`; empty where there is none.
    pub place: String,
    /// The setting.
    pub key: String,
    /// Its value.
    pub value: String,
    /// What will happen, and what to do.
    pub message: String,
}

impl Warning {
    pub(super) fn new(key: &str, value: &str, message: impl Into<String>) -> Self {
        Self { place: String::new(), key: key.to_owned(), value: brief(value), message: message.into() }
    }
}

/// One line: `b.ini:12: support_material = 1: not supported yet, ...`.
impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.place.is_empty() {
            write!(f, "{}: ", self.place)?;
        }
        write!(f, "{} = {}: {}", self.key, self.value, self.message)
    }
}

/// Why a value was not taken. One line each, with what is allowed instead.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ValueError {
    /// Wrong syntax or out of range.
    #[error("{key} = \"{value}\" {problem}; allowed: {allowed}")]
    Bad {
        /// The setting.
        key: &'static str,
        /// The text given.
        value: String,
        /// The rest of the sentence: "is not a number".
        problem: String,
        /// What may be written.
        allowed: String,
    },
    /// A choice PrusaSlicer has and this crate does not yet.
    #[error("{key} = \"{value}\" is not supported yet; allowed: {allowed}")]
    NotYet {
        /// The setting.
        key: &'static str,
        /// The text given.
        value: String,
        /// What may be written.
        allowed: String,
    },
    /// No such key.
    #[error("there is no setting \"{key}\"{}", .suggestion.map(|s| format!("; did you mean {s}?")).unwrap_or_default())]
    Unknown {
        /// The name given.
        key: String,
        /// The most similar name.
        suggestion: Option<&'static str>,
    },
}

/// A value short enough for one line of a message.
pub(super) fn brief(value: &str) -> String {
    let line: String = value.chars().take(60).flat_map(char::escape_debug).collect();
    // `escape_debug` also escapes quotes, which are harmless here.
    let line = line.replace("\\\"", "\"").replace("\\'", "'");
    if value.chars().nth(60).is_some() { line + "..." } else { line }
}

/// The key that names the technology. A command decides it and no value changes it.
const TECHNOLOGY: &str = "printer_technology";

/// Why a file for the other technology is refused, as the rest of a sentence.
fn other_technology(own: PrinterTechnology) -> &'static str {
    match own {
        PrinterTechnology::Fff => "means a resin printer, whose settings do not fit a filament job",
        PrinterTechnology::Sla => "means a filament printer, whose settings do not fit a resin job",
    }
}

/// Whether a technology has a setting of that name, honoured or not.
fn is_known(key: &str, technology: PrinterTechnology) -> bool {
    keys::of(technology).any(|k| k.name == key) || foreign::find(key, technology).is_some()
}

impl Settings {
    /// Sets `key` from a text in PrusaSlicer's syntax and says what came of it.
    ///
    /// Of a list with an entry per extruder (`0.4,0.4`) the first is used.
    ///
    /// # Errors
    /// [`ValueError`]; the settings are then unchanged.
    pub fn assign(&mut self, key: &str, value: &str) -> Result<Assigned, ValueError> {
        let technology = self.technology();
        let Some(row) = keys::find(key).filter(|k| k.technology.fits(technology)) else {
            return match foreign::find(key, technology) {
                Some(f) => Ok(Assigned::NotHonoured(f.warning(value.trim()))),
                None if is_known(key, technology.other()) => Ok(Assigned::NotHonoured(None)),
                None => {
                    let suggestion = suggest::nearest(key, technology);
                    Err(ValueError::Unknown { key: brief(key), suggestion })
                }
            };
        };
        // Blanks around a template are part of it.
        let value = if row.kind == Kind::Text && !row.per_extruder { value } else { value.trim() };
        let allowed = || row.kind.allowed(row.unit);
        let bad =
            |problem| ValueError::Bad { key: row.name, value: brief(value), problem, allowed: allowed() };
        if row.name == TECHNOLOGY && value == technology.other().name() {
            return Err(ValueError::Bad {
                key: row.name,
                value: brief(value),
                problem: other_technology(technology).to_owned(),
                allowed: technology.name().to_owned(),
            });
        }
        let (first, warning) =
            if row.per_extruder { row.first_entry(value) } else { Ok((value.to_owned(), None)) }.map_err(
                |p| match p {
                    Problem::Wrong(what) => bad(what),
                    Problem::NotYet => bad("is not supported yet".to_owned()),
                },
            )?;
        match (row.read)(self, &first) {
            Ok(()) => Ok(Assigned::Applied(warning)),
            Err(Problem::Wrong(what)) => Err(bad(what)),
            Err(Problem::NotYet) => {
                Err(ValueError::NotYet { key: row.name, value: brief(value), allowed: allowed() })
            }
        }
    }

    /// Sets `key` from a text in PrusaSlicer's syntax; a key that is known but not honoured has no effect.
    ///
    /// # Errors
    /// [`ValueError`]; the settings are then unchanged.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), ValueError> {
        self.assign(key, value).map(|_| ())
    }

    /// The value of `key` in PrusaSlicer's syntax; `None` for a key that is not honoured, or is of
    /// another technology.
    pub fn get(&self, key: &str) -> Option<String> {
        keys::find(key).filter(|k| k.technology.fits(self.technology())).map(|k| k.get(self))
    }

    /// Every key of the technology and its value, sorted by key: the config block of a G-code file.
    pub fn entries(&self) -> impl Iterator<Item = (&'static str, String)> {
        let mut rows: Vec<&'static Key> = keys::of(self.technology()).collect();
        rows.sort_unstable_by_key(|k| k.name);
        rows.into_iter().map(|k| (k.name, k.get(self)))
    }

    /// The value a template's `[name]` stands for: texts as they are, lists per extruder also as `name[0]`.
    pub fn template_value(&self, name: &str) -> Option<String> {
        let (base, indexed) = match name.strip_suffix("[0]") {
            Some(base) => (base, true),
            None => (name, false),
        };
        let row = keys::find(base).filter(|k| k.technology.fits(self.technology()))?;
        if indexed && !row.per_extruder {
            return None;
        }
        // The raw text of a template or a name; reading back what was written cannot fail.
        match row.kind {
            Kind::Text => unescape(&(row.write)(self)).ok(),
            _ => Some(row.get(self)),
        }
    }
}

impl Key {
    /// The first extruder's entry, and a warning if the others differ.
    fn first_entry(&self, value: &str) -> Result<(String, Option<Warning>), Problem> {
        let entries: Vec<String> = match self.kind {
            Kind::Text => split_texts(value)?.iter().map(|t| escape(t)).collect(),
            _ => value.split(',').map(|e| e.trim().to_owned()).collect(),
        };
        let first = entries.first().cloned().unwrap_or_default();
        if first == "nil" && self.kind != Kind::Text {
            return Err("is not a value (nil leaves a filament's override unset)".into());
        }
        let same = entries.iter().all(|e| *e == first);
        let warning = (!same).then(|| {
            Warning::new(self.name, value, format!("only the first extruder's value, {first}, is used"))
        });
        Ok((first, warning))
    }
}

/// PrusaSlicer's list of texts: separated by ';', each bare or in quotes with escapes.
fn split_texts(value: &str) -> Result<Vec<String>, Problem> {
    let mut texts = Vec::new();
    let mut rest = value;
    loop {
        rest = rest.trim_start();
        let text = if let Some(quoted) = rest.strip_prefix('"') {
            let mut escaped = false;
            let end = quoted.find(|c| {
                let closes = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                closes
            });
            let Some(end) = end else { return Err("lacks its closing quote".into()) };
            rest = quoted.get(end + 1..).unwrap_or_default().trim_start();
            if !(rest.is_empty() || rest.starts_with(';')) {
                return Err("goes on after its closing quote".into());
            }
            unescape(quoted.get(..end).unwrap_or_default())?
        } else {
            let end = rest.find(';').unwrap_or(rest.len());
            let (bare, after) = rest.split_at(end);
            rest = after;
            bare.trim_end().to_owned()
        };
        texts.push(text);
        match rest.strip_prefix(';') {
            Some(after) => rest = after,
            None => return Ok(texts),
        }
    }
}

/// One text as an entry of such a list: in quotes where it would not survive bare.
pub(super) fn quote(text: &str) -> String {
    let bare =
        !text.is_empty() && !text.contains(['"', ';', '\\', '\n', '\r', '\t', ' ']) && text.trim() == text;
    if bare { text.to_owned() } else { format!("\"{}\"", escape(text).replace('"', "\\\"")) }
}
