//! The settings of a request: a printer's preset, files, single values. What files gave is kept.

use super::files::stat;
use super::{Failure, Request, Technology};
use crate::job::FailureKind;
use crate::settings::printers::{self, PrinterError};
use crate::settings::{
    Assigned, LoadReport, PrinterTechnology, Settings, SettingsError, ValueError, Warning, keys, load_file,
};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

/// Profiles that are kept; the one unused for longest goes first.
const KEPT: usize = 64;

/// Settings of files that were read before. A file is read again when its size or its time of modification
/// changes.
#[derive(Debug, Default)]
pub struct Profiles {
    /// Most recently used last.
    known: Mutex<Vec<(Recipe, Arc<Resolved>)>>,
}

/// All settings of a request.
#[derive(Clone, Debug, PartialEq)]
pub struct Resolved {
    /// The settings; not yet checked against each other.
    pub settings: Settings,
    /// What deserves a look.
    pub warnings: Vec<String>,
}

/// What settings are made of before single values.
#[derive(Clone, Debug, PartialEq)]
struct Recipe {
    technology: Technology,
    printer: Option<String>,
    /// Each file read, the printer's among them, with its size and time of modification.
    files: Vec<(PathBuf, [i64; 2])>,
}

impl Profiles {
    /// The defaults of the technology; over them the printer's preset, then the files, then the values by
    /// key: the order of the command line.
    ///
    /// # Errors
    /// [`FailureKind::Settings`] for the first file or value that is refused.
    pub fn resolve(&self, request: &Request) -> Result<Resolved, Failure> {
        let mut resolved = self.of_files(request)?;
        for (key, value) in &request.settings {
            let warnings = assign(&mut resolved.settings, key, value, "settings")
                .map_err(|e| Failure::new(FailureKind::Settings, format!("settings: {e}")))?;
            resolved.warnings.extend(warnings.iter().map(ToString::to_string));
        }
        Ok(resolved)
    }

    /// Preset and files.
    fn of_files(&self, request: &Request) -> Result<Resolved, Failure> {
        let before = Recipe::of(request);
        if let Some(found) = before.as_ref().and_then(|recipe| self.find(recipe)) {
            return Ok((*found).clone());
        }
        let resolved = read(request)?;
        // A file that changed while it was read is not kept under either state.
        if let Some(recipe) = before.filter(|recipe| Recipe::of(request).as_ref() == Some(recipe)) {
            let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            if known.len() >= KEPT {
                known.remove(0);
            }
            known.push((recipe, Arc::new(resolved.clone())));
        }
        Ok(resolved)
    }

    fn find(&self, recipe: &Recipe) -> Option<Arc<Resolved>> {
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let at = known.iter().rposition(|(known, _)| known == recipe)?;
        let last = known.len() - 1;
        known[at..=last].rotate_left(1);
        known.last().map(|(_, resolved)| Arc::clone(resolved))
    }
}

impl Recipe {
    /// `None` where a file cannot be looked at, or is none.
    fn of(request: &Request) -> Option<Self> {
        let printer = request.printer.as_deref().filter(|name| printers::is_file(name)).map(Path::new);
        let paths = printer.into_iter().chain(request.load.iter().map(PathBuf::as_path));
        let files = paths.map(|path| Some((path.to_owned(), stat(path).ok()?))).collect::<Option<_>>()?;
        Some(Self { technology: request.technology, printer: request.printer.clone(), files })
    }
}

/// Reads what [`Recipe`] names.
fn read(request: &Request) -> Result<Resolved, Failure> {
    let mut settings = Settings::of(match request.technology {
        Technology::Filament => PrinterTechnology::Fff,
        Technology::Resin => PrinterTechnology::Sla,
    });
    let mut warnings = Vec::new();
    let mut note = |loaded: LoadReport| warnings.extend(loaded.warnings.iter().map(ToString::to_string));
    if let Some(name) = &request.printer {
        let loaded = printers::apply(name, &mut settings).map_err(|e| match &e {
            PrinterError::File(file) => refused(file, format!("printer: {e}")),
            PrinterError::Unknown { .. } => Failure::new(FailureKind::Settings, format!("printer: {e}")),
        })?;
        note(loaded);
    }
    for path in &request.load {
        note(load_file(path, &mut settings).map_err(|e| refused(&e, e.to_string()))?);
    }
    Ok(Resolved { settings, warnings })
}

fn refused(error: &SettingsError, message: String) -> Failure {
    let transient = super::outcome::settings_may_pass(error);
    Failure { transient, ..Failure::new(FailureKind::Settings, message) }
}

/// Assigns a value that was typed by hand; `place` says where, for warnings. In a file a setting of the other
/// technology is nothing to speak of; typed by hand it is.
///
/// # Errors
/// [`ValueError`]: no such key, or a value that is not allowed.
pub fn assign(
    settings: &mut Settings,
    key: &str,
    value: &str,
    place: &str,
) -> Result<Vec<Warning>, ValueError> {
    let key = key.trim();
    let assigned = settings.assign(key, value)?;
    let stray = keys::find(key).filter(|_| assigned == Assigned::NotHonoured(None)).map(|key| {
        let printers = if key.technology.fits(PrinterTechnology::Sla) { "resin" } else { "filament" };
        Warning {
            place: place.to_owned(),
            key: key.name.to_owned(),
            value: value.escape_debug().to_string(),
            message: format!("a setting of {printers} printers, so it has no effect here"),
        }
    });
    let (Assigned::Applied(warning) | Assigned::NotHonoured(warning)) = assigned;
    Ok(warning.into_iter().chain(stray).collect())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::time::{Duration, SystemTime};

    fn height(profiles: &Profiles, request: &Request) -> f64 {
        profiles.resolve(request).unwrap().settings.slicing.layer_height
    }

    #[test]
    fn files_then_values_and_files_are_read_once() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.ini");
        let write = |text: &str, age: u64| {
            std::fs::write(&path, text).unwrap();
            let file = std::fs::File::options().write(true).open(&path).unwrap();
            file.set_modified(SystemTime::UNIX_EPOCH + Duration::from_secs(age)).unwrap();
        };
        write("layer_height = 0.21\nfill_pattern = hilbertcurve\n", 1000);
        let profiles = Profiles::default();
        let request = Request::new("m.stl").load(&path);
        let first = profiles.resolve(&request).unwrap();
        assert_eq!((first.settings.slicing.layer_height, first.warnings.len()), (0.21, 1));
        // Same size, same time: not read again, so that what is kept is what comes.
        write("layer_height = 0.25\nfill_pattern = hilbertcurve\n", 1000);
        assert_eq!(profiles.resolve(&request).unwrap(), first);
        write("layer_height = 0.25\nfill_pattern = hilbertcurve\n", 2000);
        assert_eq!(height(&profiles, &request), 0.25);
        assert_eq!(height(&profiles, &request.clone().set("layer_height", "0.1")), 0.1);
        assert_eq!(height(&profiles, &request), 0.25, "values leave what is kept alone");
        std::fs::remove_file(&path).unwrap();
        let gone = profiles.resolve(&request).unwrap_err();
        assert!(gone.kind == FailureKind::Settings && !gone.transient, "{gone:?}");
        assert!(gone.message.contains("a.ini: cannot read the settings"), "{gone:?}");
    }

    #[test]
    fn few_profiles_are_kept_and_the_last_used_among_them() {
        let dir = tempfile::tempdir().unwrap();
        let profiles = Profiles::default();
        let request = |i: usize| Request::new("m.stl").load(dir.path().join(format!("{i}.toml")));
        for i in 0..2 * KEPT {
            std::fs::write(dir.path().join(format!("{i}.toml")), format!("perimeters = {}\n", i % 9 + 1))
                .unwrap();
            assert_eq!(
                profiles.resolve(&request(i)).unwrap().settings.perimeters.perimeters as usize,
                i % 9 + 1
            );
            profiles.resolve(&request(0)).unwrap();
        }
        let known = profiles.known.lock().unwrap();
        assert_eq!(known.len(), KEPT);
        assert!(known.last().unwrap().0.files[0].0.ends_with("0.toml"));
    }

    #[test]
    fn refusals_name_the_key_or_the_printer() {
        let profiles = Profiles::default();
        let error = |request: Request| profiles.resolve(&request).unwrap_err().message;
        let base = || Request::new("m.stl");
        assert_eq!(
            error(base().set("layer_hight", "0.2")),
            "settings: there is no setting \"layer_hight\"; did you mean layer_height?"
        );
        assert!(error(base().set("layer_height", "-1")).starts_with("settings: layer_height = \"-1\" "));
        assert!(error(base().resin("prusa-sl2")).starts_with("printer: there is no printer \"prusa-sl2\""));
        assert!(error(base().resin("none.toml")).starts_with("printer: none.toml: cannot read"));
        let stray = profiles.resolve(&base().set("exposure_time", "3")).unwrap();
        assert_eq!(
            stray.warnings,
            ["settings: exposure_time = 3: a setting of resin printers, so it has no effect here"]
        );
        let resin = profiles.resolve(&base().resin("prusa-sl1s")).unwrap();
        assert_eq!(resin.settings.display.display_pixels_x, 2560);
    }
}
