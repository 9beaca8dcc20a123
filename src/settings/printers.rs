//! Presets of resin printers: panel, build volume, container, and starting points for the rest.
//!
//! Each is a settings file in `data/printers/`, in the form that a user's own has: panels, pitches and
//! volumes as in the profiles that UVtools and PrusaSlicer ship for these machines.

use super::load::{LoadReport, SettingsError, load_bytes, load_file};
use super::suggest;
use super::types::Settings;
use std::path::Path;

/// One preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preset {
    /// The name it is called by, such as `elegoo-saturn-3-ultra`.
    pub slug: &'static str,
    /// Its settings as TOML.
    pub toml: &'static str,
}

/// Why a printer's settings could not be had.
#[derive(Debug, thiserror::Error)]
pub enum PrinterError {
    /// No preset has that name.
    #[error(
        "there is no printer \"{name}\"{}; `microtome printers` lists them, and a file of one's own is named as FILE.toml",
        .suggestion.map(|s| format!("; did you mean {s}?")).unwrap_or_default()
    )]
    Unknown {
        /// The name given.
        name: String,
        /// The most similar one.
        suggestion: Option<&'static str>,
    },
    /// The file given in its place is wrong.
    #[error(transparent)]
    File(Box<SettingsError>),
}

impl From<SettingsError> for PrinterError {
    fn from(error: SettingsError) -> Self {
        Self::File(Box::new(error))
    }
}

/// All presets: Prusa first, then by maker and generation.
pub fn all() -> &'static [Preset] {
    PRESETS
}

/// The preset of that name; case and the kind of dash do not matter.
///
/// # Errors
/// [`PrinterError::Unknown`], with the nearest name.
pub fn find(name: &str) -> Result<&'static Preset, PrinterError> {
    let plain: String = name
        .trim()
        .chars()
        .map(|c| if c == '_' || c == ' ' { '-' } else { c.to_ascii_lowercase() })
        .collect();
    PRESETS.iter().find(|p| p.slug == plain).ok_or_else(|| PrinterError::Unknown {
        name: super::assign::brief(name),
        suggestion: nearest(&plain),
    })
}

/// Applies the preset of that name, or the settings file where a path is given: one with a separator in
/// it, or that ends in `.toml` or `.ini`. Keys that it does not name keep their values.
///
/// # Errors
/// [`PrinterError`]; the settings are then unchanged.
pub fn apply(name: &str, settings: &mut Settings) -> Result<LoadReport, PrinterError> {
    if is_file(name) {
        return Ok(load_file(Path::new(name), settings)?);
    }
    Ok(find(name)?.apply(settings)?)
}

/// Whether a printer's name is the path of a file.
pub fn is_file(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    name.contains(['/', '\\']) || [".toml", ".ini"].iter().any(|e| lower.ends_with(e))
}

impl Preset {
    /// Applies the preset to settings of resin printers.
    ///
    /// # Errors
    /// [`SettingsError`] where `settings` are those of filament printers; they are then unchanged.
    pub fn apply(&self, settings: &mut Settings) -> Result<LoadReport, SettingsError> {
        load_bytes(Path::new(&format!("{}.toml", self.slug)), self.toml.as_bytes(), settings)
    }

    /// The settings of resin printers with this preset.
    ///
    /// # Errors
    /// None for the presets of this crate.
    pub fn settings(&self) -> Result<Settings, SettingsError> {
        let mut settings = Settings::resin();
        self.apply(&mut settings)?;
        Ok(settings)
    }
}

/// The name meant: one that differs by a slip, or else the first that has all the words given.
fn nearest(name: &str) -> Option<&'static str> {
    let words: Vec<&str> = name.split('-').filter(|w| !w.is_empty()).collect();
    let has_all = |slug: &str| words.iter().all(|w| slug.split('-').any(|s| s == *w));
    suggest::nearest_of(name, PRESETS.iter().map(|p| p.slug), '-')
        .or_else(|| PRESETS.iter().map(|p| p.slug).find(|slug| !words.is_empty() && has_all(slug)))
}

/// One row per file of `data/printers/`, by its name.
macro_rules! presets {
    ($($slug:literal,)*) => {
        &[$(Preset {
            slug: $slug,
            toml: include_str!(concat!("../../data/printers/", $slug, ".toml")),
        },)*]
    };
}

static PRESETS: &[Preset] = presets![
    "prusa-sl1",
    "prusa-sl1s",
    "elegoo-mars",
    "elegoo-mars-c",
    "elegoo-mars-2",
    "elegoo-mars-2-pro",
    "elegoo-mars-3",
    "elegoo-mars-4",
    "elegoo-mars-4-ultra",
    "elegoo-mars-4-max",
    "elegoo-mars-5",
    "elegoo-mars-5-ultra",
    "elegoo-saturn",
    "elegoo-saturn-s",
    "elegoo-saturn-2",
    "elegoo-saturn-8k",
    "elegoo-saturn-3",
    "elegoo-saturn-3-ultra",
    "elegoo-saturn-4",
    "elegoo-saturn-4-ultra-12k",
    "elegoo-saturn-4-ultra-16k",
    "elegoo-jupiter",
    "elegoo-jupiter-2",
    "anycubic-photon-mono",
    "anycubic-photon-mono-se",
    "anycubic-photon-mono-4k",
    "anycubic-photon-mono-x",
    "anycubic-photon-mono-x-6k",
    "anycubic-photon-m3",
    "anycubic-photon-m3-max",
    "anycubic-photon-mono-m5",
    "anycubic-photon-mono-m5s",
    "anycubic-photon-mono-m5s-pro",
    "phrozen-sonic-mini-4k",
    "phrozen-sonic-mighty-4k",
    "phrozen-sonic-mini-8k",
    "phrozen-sonic-mini-8k-s",
    "phrozen-sonic-mighty-8k",
    "concepts3d-athena-8k",
    "concepts3d-athena-12k",
];

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_preset_is_sound() {
        for preset in all() {
            let mut s = Settings::resin();
            let report = preset.apply(&mut s).unwrap();
            assert!(
                report.unknown.is_empty() && report.ignored.is_empty() && report.warnings.is_empty(),
                "{}",
                preset.slug
            );
            assert_eq!(s.validate_resin().unwrap(), [], "{}", preset.slug);
            assert!(
                !s.machine.machine_name.is_empty() && s.printer.max_print_height > 100.0,
                "{}",
                preset.slug
            );
            let d = &s.display;
            for (pixels, length) in
                [(d.display_pixels_x, d.display_width), (d.display_pixels_y, d.display_height)]
            {
                // Panels come in pitches of whole 50 nm: a slip in a size or a number of pixels shows here.
                let pitch = length * 1e6 / f64::from(pixels);
                let whole = (pitch / 50.0).round() * 50.0;
                assert!((pitch - whole).abs() < 0.01, "{}: {pitch} nm", preset.slug);
                assert!((10_000.0..60_000.0).contains(&pitch), "{}: {pitch} nm", preset.slug);
            }
            let prusa = matches!(s.machine.container.name(), "sl1" | "sl1s");
            assert_eq!((s.lift.tilt, s.exposure.faded_layers > 0), (prusa, prusa), "{}", preset.slug);
        }
    }

    #[test]
    fn the_list_is_the_folder() {
        let listed: BTreeSet<String> = all().iter().map(|p| p.slug.to_owned()).collect();
        assert_eq!(listed.len(), all().len(), "a slug comes twice");
        let folder = std::fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/data/printers")).unwrap();
        let files: BTreeSet<String> =
            folder.map(|f| f.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned()).collect();
        assert_eq!(files, listed);
        let names: BTreeSet<String> =
            all().iter().map(|p| p.settings().unwrap().machine.machine_name).collect();
        assert_eq!(names.len(), all().len(), "a machine's name comes twice");
    }

    #[test]
    fn the_panels_are_those_of_the_profiles() {
        for (slug, pixels, size, container) in [
            ("prusa-sl1", [2560, 1440], [120.96, 68.04], "sl1"),
            ("prusa-sl1s", [2560, 1620], [128.0, 81.0], "sl1s"),
            ("elegoo-mars-2-pro", [1620, 2560], [82.62, 130.56], "ctb"),
            ("elegoo-saturn-3-ultra", [11_520, 5120], [218.88, 122.88], "goo"),
            ("elegoo-saturn-4-ultra-16k", [15_120, 6230], [211.68, 118.37], "encrypted-ctb"),
            ("anycubic-photon-mono-x-6k", [5760, 3600], [198.144, 123.84], "pwmb"),
        ] {
            let s = find(slug).unwrap().settings().unwrap();
            let d = &s.display;
            assert_eq!(
                ([d.display_pixels_x, d.display_pixels_y], [d.display_width, d.display_height]),
                (pixels, size)
            );
            assert_eq!(
                (s.machine.container.name(), d.display_mirror_x, d.display_mirror_y),
                (container, true, false)
            );
        }
    }

    #[test]
    fn names_are_found_and_slips_corrected() {
        assert_eq!(find("Elegoo_Saturn 3-ULTRA").unwrap().slug, "elegoo-saturn-3-ultra");
        let error = |name: &str| find(name).unwrap_err().to_string();
        assert!(
            error("elegoo-satrun-3")
                .contains("\"elegoo-satrun-3\"; did you mean elegoo-saturn-3?; `microtome printers`")
        );
        assert!(error("saturn 4 ultra").contains("did you mean elegoo-saturn-4-ultra-12k?"));
        assert!(error("sl1s").contains("did you mean prusa-sl1s?"));
        assert!(
            error("").starts_with("there is no printer \"\"; `microtome")
                && error("toaster").lines().count() == 1
        );
    }

    #[test]
    fn a_file_of_ones_own_is_applied() {
        let file = tempfile::Builder::new().suffix(".toml").tempfile().unwrap();
        std::fs::write(file.path(), "[display]\ndisplay_pixels_x = 640\n").unwrap();
        let mut s = Settings::resin();
        let report = apply(file.path().to_str().unwrap(), &mut s).unwrap();
        assert_eq!((report.applied, s.display.display_pixels_x), (1, 640));
        let error = apply("no/such.toml", &mut s).unwrap_err().to_string();
        assert!(error.starts_with("no/such.toml: cannot read the settings"), "{error}");
        assert!(is_file("mine.TOML") && is_file("./mine") && !is_file("prusa-sl1s"));
    }

    #[test]
    fn filament_settings_take_no_preset() {
        let mut s = Settings::default();
        let error = find("prusa-sl1").unwrap().apply(&mut s).unwrap_err().to_string();
        assert!(error.contains("printer_technology = \"SLA\" means a resin printer"), "{error}");
        assert_eq!(s, Settings::default());
    }
}
