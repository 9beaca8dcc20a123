//! Settings from a file: TOML, PrusaSlicer's flat `.ini`, or the config block of a G-code file.

use super::assign::{Assigned, ValueError, Warning, brief};
use super::keys;
use super::types::Settings;
use super::validate::Invalid;
use super::{ini, toml};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Larger files are no settings, and no reasonable G-code either.
const MAX_BYTES: u64 = 512 << 20;

/// Why settings could not be had.
#[derive(Debug, thiserror::Error)]
pub enum SettingsError {
    /// The file cannot be read.
    #[error("{}: cannot read the settings: {source}", .path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// The file is not what it should be.
    #[error("{}:{line}: {message}", .path.display())]
    Syntax {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What is wrong and what to do.
        message: String,
    },
    /// A value in the file is wrong.
    #[error("{}:{line}: {error}", .path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// The value and what is allowed.
        error: ValueError,
    },
    /// Values contradict each other.
    #[error(transparent)]
    Invalid(#[from] Invalid),
}

/// What a file brought.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadReport {
    /// How many values came into force.
    pub applied: usize,
    /// Line and key of settings PrusaSlicer has and this crate does not honour yet.
    pub ignored: Vec<(usize, String)>,
    /// Line and key of settings nobody knows.
    pub unknown: Vec<(usize, String)>,
    /// What will be missed in the print.
    pub warnings: Vec<Warning>,
}

/// A key and its value in PrusaSlicer's syntax, with the line it stands on, from 1.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Entry {
    pub line: usize,
    pub key: String,
    pub value: String,
}

/// What is wrong with a file as a whole, and where.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct Malformed {
    pub line: usize,
    pub message: String,
}

/// Reads a settings file into `settings`: keys it does not name keep their values.
///
/// The format is told by the extension (`.toml`, `.ini`, `.gcode`), or else by the content. A choice PrusaSlicer
/// has and this crate does not yet (`fill_pattern = gyroid`) becomes the default, with a warning.
///
/// # Errors
/// [`SettingsError`]; the settings are then unchanged.
pub fn load_file(path: &Path, settings: &mut Settings) -> Result<LoadReport, SettingsError> {
    let io = |source| SettingsError::Io { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    let file = File::open(path).map_err(io)?;
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(io(std::io::Error::new(std::io::ErrorKind::FileTooLarge, "larger than 512 MiB")));
    }
    load_bytes(path, &bytes, settings)
}

/// As [`load_file`], from memory; `path` tells the format and names the place of errors.
///
/// # Errors
/// [`SettingsError`]; the settings are then unchanged.
pub fn load_bytes(path: &Path, bytes: &[u8], settings: &mut Settings) -> Result<LoadReport, SettingsError> {
    let entries = parse(path, bytes).map_err(|Malformed { line, message }| SettingsError::Syntax {
        path: path.to_owned(),
        line,
        message,
    })?;
    let mut changed = settings.clone();
    let mut report = LoadReport::default();
    for entry in entries {
        let place = format!("{}:{}", path.display(), entry.line);
        let assigned = changed.assign(&entry.key, &entry.value);
        let warning = match assigned {
            Ok(Assigned::Applied(warning)) => {
                report.applied += 1;
                warning
            }
            Ok(Assigned::NotHonoured(warning)) => {
                report.ignored.push((entry.line, entry.key));
                warning
            }
            Err(ValueError::Unknown { key, suggestion }) => {
                // Files of other versions hold many unknown keys; one that looks like a slip is worth a word.
                let slip = suggestion.filter(|s| changed.get(s).is_some());
                let warning = slip
                    .map(|s| Warning::new(&key, &entry.value, format!("no such setting; did you mean {s}?")));
                report.unknown.push((entry.line, key));
                warning
            }
            Err(ValueError::NotYet { key, .. }) => {
                report.applied += 1;
                Some(stand_in(&mut changed, key, &entry.value))
            }
            Err(error) => {
                return Err(SettingsError::Value { path: path.to_owned(), line: entry.line, error });
            }
        };
        report.warnings.extend(warning.map(|w| Warning { place, ..w }));
    }
    *settings = changed;
    Ok(report)
}

/// Puts the default in the place of a choice that is not supported yet.
fn stand_in(settings: &mut Settings, key: &str, value: &str) -> Warning {
    let default = keys::find(key).map(|k| k.default_text(settings.technology())).unwrap_or_default();
    // A default is always a valid value.
    let _ = settings.set(key, &default);
    Warning::new(key, value, format!("not supported yet; {default} is used"))
}

fn parse(path: &Path, bytes: &[u8]) -> Result<Vec<Entry>, Malformed> {
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") {
        return Err(Malformed { line: 1, message: "is UTF-16 text; save it as UTF-8".to_owned() });
    }
    if bytes.starts_with(b"GCDE") {
        let message = "is binary G-code, whose settings cannot be read yet; export plain G-code or an .ini";
        return Err(Malformed { line: 1, message: message.to_owned() });
    }
    let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
    match extension.as_str() {
        "toml" => toml::entries(text(bytes)?),
        "gcode" | "gco" | "g" => ini::config_block(bytes)?.ok_or_else(no_config_block),
        "ini" | "cfg" => ini::entries(text(bytes)?),
        _ => {
            if let Some(entries) = ini::config_block(bytes)? {
                return Ok(entries);
            }
            let text = text(bytes)?;
            // A file that is both, such as `layer_height = 0.2`, means the same in both.
            toml::entries(text).or_else(|_| ini::entries(text))
        }
    }
}

fn no_config_block() -> Malformed {
    let message = "no settings in this G-code: it lacks the line \"; prusaslicer_config = begin\"";
    Malformed { line: 1, message: message.to_owned() }
}

fn text(bytes: &[u8]) -> Result<&str, Malformed> {
    std::str::from_utf8(bytes).map_err(|e| {
        let before = bytes.get(..e.valid_up_to()).unwrap_or_default();
        let line = 1 + before.iter().filter(|b| **b == b'\n').count();
        Malformed { line, message: "is not UTF-8 text; is this a settings file?".to_owned() }
    })
}

/// The message for a line that is not `key = value`.
pub(super) fn no_assignment(line: usize, text: &str) -> Malformed {
    Malformed { line, message: format!("\"{}\" is not of the form key = value", brief(text)) }
}
