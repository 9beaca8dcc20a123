//! Settings on the command line: `--printer NAME`, `--load FILE`, a flag for each key, `--set key=value`.

use crate::settings::printers::PrinterError;
use crate::settings::{
    Key, Kind, LoadReport, PrinterTechnology, Settings, SettingsError, Stage, ValueError, Warning, keys,
    load_file, printers,
};
use crate::slicer::profiles::assign;
use clap::builder::ValueParser;
use clap::{Arg, ArgAction, ArgMatches, Command};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Why the settings of a command line were refused.
#[derive(Debug, thiserror::Error)]
pub enum FlagError {
    /// A printer given to `--printer`.
    #[error("--printer: {0}")]
    Printer(#[from] PrinterError),
    /// A file given to `--load`.
    #[error(transparent)]
    Load(#[from] SettingsError),
    /// A value given to a key's own flag.
    #[error("--{}: {error}", .flag)]
    Flag {
        /// The flag, without its dashes.
        flag: &'static str,
        /// The value and what is allowed.
        error: ValueError,
    },
    /// A value given to `--set`.
    #[error("--set {text}: {error}")]
    Set {
        /// What was given.
        text: String,
        /// The value and what is allowed.
        error: ValueError,
    },
    /// `--set` without a value.
    #[error("--set {text}: not of the form key=value, such as --set layer_height=0.2")]
    NoValue {
        /// What was given.
        text: String,
    },
}

/// What the settings of a command line brought.
#[derive(Clone, Debug, Default)]
pub struct FlagReport {
    /// Each file loaded, in order.
    pub files: Vec<(PathBuf, LoadReport)>,
    /// All warnings, those of the files included.
    pub warnings: Vec<Warning>,
}

/// The settings of a technology, or of all, as typed, for `#[command(flatten)]` in a derived parser.
#[derive(Clone, Debug, Default)]
pub struct FlagsOf<const KIND: u8> {
    /// The printer's name or file; of resin printers only.
    pub printer: Option<String>,
    /// Files of settings.
    pub load: Vec<PathBuf>,
    flags: Vec<(&'static Key, String)>,
    set: Vec<String>,
}

const FILAMENT: u8 = 0;
const RESIN: u8 = 1;
const ALL: u8 = 2;

/// The settings of a filament printer as typed.
pub type SettingFlags = FlagsOf<FILAMENT>;

/// The settings of a resin printer as typed, `--printer` included.
pub type ResinFlags = FlagsOf<RESIN>;

/// The settings of either kind of printer as typed, `--printer` included.
pub type AllFlags = FlagsOf<ALL>;

/// `--load`, `--set` and a long flag for each key of some technologies, grouped by stage; where resin is among
/// them also `--printer`.
fn command_flags(technologies: &'static [PrinterTechnology]) -> Vec<Arg> {
    let printer = Arg::new("printer")
        .long("printer")
        .value_name("NAME|FILE.toml")
        .action(ArgAction::Set)
        .help("The printer, as listed by `microtome printers`, or a settings file that describes one")
        .help_heading("Settings");
    let load = Arg::new("load")
        .long("load")
        .value_name("FILE")
        .value_parser(ValueParser::path_buf())
        .action(ArgAction::Append)
        .help("Read settings from TOML, a PrusaSlicer .ini or G-code; may be repeated, later files win")
        .help_heading("Settings");
    let set = Arg::new("set")
        .long("set")
        .value_name("KEY=VALUE")
        .action(ArgAction::Append)
        .help("Set any setting, after --load and the flags below; may be repeated")
        .help_heading("Settings");
    let printer = technologies.contains(&PrinterTechnology::Sla).then_some(printer);
    let keys =
        Stage::ALL.into_iter().flat_map(|stage| keys_of(technologies).filter(move |k| k.stage == stage));
    printer.into_iter().chain([load, set]).chain(keys.map(|key| flag(key, technologies))).collect()
}

/// The keys of some technologies, each once.
fn keys_of(technologies: &[PrinterTechnology]) -> impl Iterator<Item = &'static Key> {
    let all = [PrinterTechnology::Fff, PrinterTechnology::Sla].into_iter();
    let own = all.enumerate().filter(|(_, t)| technologies.contains(t));
    own.flat_map(move |(i, technology)| {
        let before = i > 0 && technologies.contains(&PrinterTechnology::Fff);
        keys::of(technology).filter(move |k| !(before && k.technology.fits(PrinterTechnology::Fff)))
    })
}

/// `layer_height` as a flag is `--layer-height`; with underscores it works too.
fn flag(key: &'static Key, technologies: &[PrinterTechnology]) -> Arg {
    let dashed = dashed(key);
    let arg = Arg::new(key.name)
        .help(help(key, technologies))
        .help_heading(key.stage.heading())
        .value_name(value_name(&key.kind))
        .action(ArgAction::Set)
        .overrides_with(key.name);
    let arg = if dashed == key.name { arg } else { arg.alias(key.name) }.long(dashed);
    let arg = if key.name == "anti_aliasing" { arg.visible_alias("antialias") } else { arg };
    match key.kind {
        // The value needs its "=", or `--cooling part.stl` would eat the file.
        Kind::Flag => arg.num_args(0..=1).require_equals(true).default_missing_value("1"),
        Kind::Text | Kind::Choice(..) => arg,
        Kind::Points(..) | Kind::LengthOrPixels(..) => arg.allow_hyphen_values(true),
        // Where "-5" makes no sense the range refuses it, and says what is allowed.
        _ => arg.allow_negative_numbers(true),
    }
}

/// The flag's name without its dashes, e.g. `layer-height`. clap wants names that live as long as the program.
fn dashed(key: &Key) -> &'static str {
    static NAMES: LazyLock<Vec<(&str, String)>> = LazyLock::new(|| {
        let all = [PrinterTechnology::Fff, PrinterTechnology::Sla].into_iter().flat_map(keys::of);
        all.map(|k| (k.name, k.name.replace('_', "-"))).collect()
    });
    NAMES.iter().find(|(name, _)| *name == key.name).map_or(key.name, |(_, dashed)| dashed)
}

fn value_name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Flag => "0|1",
        Kind::Count(..) | Kind::Integer(..) | Kind::Number(..) => "N",
        Kind::Percent(..) => "N%",
        Kind::NumberOrPercent(..) => "N|N%",
        Kind::LengthOrPixels(..) => "N|Npx",
        Kind::Text => "TEXT",
        Kind::Points(..) => "XxY,...",
        Kind::Choice(..) => "NAME",
    }
}

fn help(key: &Key, technologies: &[PrinterTechnology]) -> String {
    let unit = match key.kind {
        Kind::Choice(names, _) => names.join(", "),
        // The default shows the sign.
        Kind::Percent(..) => String::new(),
        _ => key.unit.to_owned(),
    };
    let own = technologies.iter().filter(|t| key.technology.fits(**t));
    let mut defaults: Vec<String> = own.map(|t| key.default_text(*t)).collect();
    defaults.dedup();
    let default = match defaults.as_slice() {
        [of_filament, of_resin] => format!("default {of_filament}, for resin {of_resin}"),
        [default] if !default.is_empty() => format!("default {default}"),
        _ => String::new(),
    };
    let facts: Vec<String> = [unit, default].into_iter().filter(|f| !f.is_empty()).collect();
    if facts.is_empty() { key.help.to_owned() } else { format!("{} ({})", key.help, facts.join("; ")) }
}

impl<const KIND: u8> clap::Args for FlagsOf<KIND> {
    fn augment_args(command: Command) -> Command {
        command.args(command_flags(Self::TECHNOLOGIES))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<const KIND: u8> clap::FromArgMatches for FlagsOf<KIND> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self::typed(matches))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::typed(matches);
        Ok(())
    }
}

impl<const KIND: u8> FlagsOf<KIND> {
    const TECHNOLOGIES: &[PrinterTechnology] = match KIND {
        FILAMENT => &[PrinterTechnology::Fff],
        RESIN => &[PrinterTechnology::Sla],
        _ => &[PrinterTechnology::Fff, PrinterTechnology::Sla],
    };

    fn typed(matches: &ArgMatches) -> Self {
        let flags =
            keys_of(Self::TECHNOLOGIES).filter_map(|k| Some((k, matches.get_one::<String>(k.name)?.clone())));
        let has_printer = Self::TECHNOLOGIES.contains(&PrinterTechnology::Sla);
        Self {
            printer: if has_printer { matches.get_one::<String>("printer").cloned() } else { None },
            load: matches.get_many::<PathBuf>("load").into_iter().flatten().cloned().collect(),
            flags: flags.collect(),
            set: matches.get_many::<String>("set").into_iter().flatten().cloned().collect(),
        }
    }

    /// The values of flags and `--set` by key, as in the settings of a request.
    pub fn values(&self) -> BTreeMap<String, String> {
        let flags = self.flags.iter().map(|(key, value)| (key.name.to_owned(), value.clone()));
        let set = self.set.iter().filter_map(|text| text.split_once('='));
        flags.chain(set.map(|(key, value)| (key.trim().to_owned(), value.to_owned()))).collect()
    }

    /// Looks at the values of keys that a technology does not have, by the rules of the other.
    ///
    /// # Errors
    /// [`FlagError`] for the first value that is refused.
    pub fn check_others(&self, technology: PrinterTechnology) -> Result<(), FlagError> {
        let is_other = |key: &Key| !key.technology.fits(technology);
        let others = Self {
            printer: None,
            load: Vec::new(),
            flags: self.flags.iter().filter(|(key, _)| is_other(key)).cloned().collect(),
            set: self
                .set
                .iter()
                .filter(|text| {
                    text.split_once('=').is_some_and(|(k, _)| keys::find(k.trim()).is_some_and(is_other))
                })
                .cloned()
                .collect(),
        };
        others.apply(&mut Settings::of(technology.other())).map(drop)
    }

    /// Applies the printer's preset, then files, then flags, then `--set`; `settings` are those of the
    /// technology.
    ///
    /// # Errors
    /// [`FlagError`] for the first value that is refused.
    pub fn apply(&self, settings: &mut Settings) -> Result<FlagReport, FlagError> {
        let mut report = FlagReport::default();
        if let Some(name) = &self.printer {
            let loaded = printers::apply(name, settings)?;
            report.warnings.extend_from_slice(&loaded.warnings);
            if printers::is_file(name) {
                report.files.push((name.into(), loaded));
            }
        }
        for path in &self.load {
            let loaded = load_file(path, settings)?;
            report.warnings.extend_from_slice(&loaded.warnings);
            report.files.push((path.clone(), loaded));
        }
        for (key, value) in &self.flags {
            let flag = dashed(key);
            let warnings = assign(settings, key.name, value, &format!("--{flag}"))
                .map_err(|error| FlagError::Flag { flag, error })?;
            report.warnings.extend(warnings);
        }
        for text in &self.set {
            let (key, value) = text
                .split_once('=')
                .ok_or_else(|| FlagError::NoValue { text: text.escape_debug().to_string() })?;
            let warnings = assign(settings, key, value, "--set")
                .map_err(|error| FlagError::Set { text: text.escape_debug().to_string(), error })?;
            report.warnings.extend(warnings);
        }
        Ok(report)
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        settings: SettingFlags,
        model: Option<String>,
    }

    fn apply_line(line: &[&str]) -> Result<(Settings, FlagReport, Option<String>), String> {
        let parsed = Line::try_parse_from([&["slice"], line].concat()).map_err(|e| e.to_string())?;
        let mut settings = Settings::default();
        let report = parsed.settings.apply(&mut settings).map_err(|e| e.to_string())?;
        Ok((settings, report, parsed.model))
    }

    #[derive(Parser)]
    struct ResinLine {
        #[command(flatten)]
        settings: ResinFlags,
    }

    fn resin_line(line: &[&str]) -> Result<(Settings, FlagReport), String> {
        let parsed = ResinLine::try_parse_from([&["mask"], line].concat()).map_err(|e| e.to_string())?;
        let mut settings = Settings::resin();
        let report = parsed.settings.apply(&mut settings).map_err(|e| e.to_string())?;
        Ok((settings, report))
    }

    #[test]
    fn preset_then_files_then_flags_then_set() {
        let file = tempfile::Builder::new().suffix(".ini").tempfile().unwrap();
        let text = "printer_technology = SLA\nexposure_time = 3\ninitial_exposure_time = 31\nfaded_layers = 8\n\
                    perimeters = 3\nsupports_enable = 1\nprinter_model = X\n";
        std::fs::write(file.path(), text).unwrap();
        let path = file.path().to_str().unwrap();
        let line = [
            "--set",
            "exposure_time=5",
            "--exposure-time=4",
            "--initial-exposure-time",
            "32",
            "--load",
            path,
        ];
        let (s, report) = resin_line(&[&line[..], &["--printer", "prusa-sl1s"]].concat()).unwrap();
        let e = &s.exposure;
        assert_eq!((e.exposure_time, e.initial_exposure_time, e.faded_layers), (5.0, 32.0, 8));
        assert_eq!((s.display.display_pixels_x, s.machine.printer_model.as_str()), (2560, "X"));
        let loaded = &report.files[0].1;
        assert_eq!((report.files.len(), loaded.applied, loaded.ignored.len()), (1, 5, 2));
        assert_eq!(report.warnings.len(), 1, "{:?}", report.warnings);
        assert_eq!(report.warnings[0].key, "supports_enable");
    }

    #[test]
    fn resin_refusals_name_the_flag() {
        let error = |line: &[&str]| resin_line(line).err().unwrap_or_default();
        assert!(
            error(&["--printer", "elegoo-satrun"])
                .starts_with("--printer: there is no printer \"elegoo-satrun\"; did you mean elegoo-saturn?")
        );
        assert!(error(&["--printer", "none.toml"]).starts_with("--printer: none.toml: cannot read"));
        assert!(error(&["--anti-aliasing", "3"]).ends_with("is not a choice here; allowed: 1, 2, 4, 8, 16"));
        assert!(
            error(&["--absolute-correction", "9cm"])
                .ends_with("allowed: a number (mm) from -10 to 10, or up to 500 pixels such as 2px")
        );
        assert!(error(&["--set", "printer_technology=FFF"]).contains("means a filament printer"));
        assert_eq!(
            resin_line(&["--absolute-correction", "-2px"]).unwrap().0.image.absolute_correction,
            crate::settings::LengthOrPixels::Pixels(-2.0)
        );
        // A setting of the other technology, typed by hand, is worth a word.
        let (_, report) = resin_line(&["--set", "perimeters=3"]).unwrap();
        assert_eq!(
            report.warnings[0].to_string(),
            "--set: perimeters = 3: a setting of filament printers, so it has no effect here"
        );
        let (_, report, _) = apply_line(&["--set", "exposure_time=3"]).unwrap();
        assert_eq!(
            report.warnings[0].to_string(),
            "--set: exposure_time = 3: a setting of resin printers, so it has no effect here"
        );
    }

    #[derive(Parser)]
    struct AllLine {
        #[command(flatten)]
        settings: AllFlags,
    }

    #[test]
    fn all_flags_are_those_of_both() {
        use clap::CommandFactory;
        AllLine::command().debug_assert();
        let help = AllLine::command().render_long_help().to_string();
        for key in keys::KEYS.iter().chain(crate::settings::RESIN_KEYS) {
            let count = help.matches(&format!("--{} ", dashed(key))).count()
                + help.matches(&format!("--{}[", dashed(key))).count();
            assert_eq!(count, 1, "{}", key.name);
        }
        assert!(help.contains("(mm; default 0.3, for resin 0.05)") && help.contains("--printer "));
        let line = ["batch", "--layer-height", "0.1", "--set", " layer_height =0.2", "--exposure-time=3"];
        let flags = AllLine::try_parse_from(line).unwrap().settings;
        let values: Vec<_> = flags.values().into_iter().collect();
        let own = |k: &str, v: &str| (k.to_owned(), v.to_owned());
        assert_eq!(values, [own("exposure_time", "3"), own("layer_height", "0.2")]);
        let mut settings = Settings::default();
        let report = flags.apply(&mut settings).unwrap();
        assert_eq!(settings.slicing.layer_height, 0.2);
        assert_eq!(
            report.warnings[0].to_string(),
            "--exposure-time: exposure_time = 3: a setting of resin printers, so it has no effect here"
        );
        assert!(flags.check_others(PrinterTechnology::Fff).is_ok());
        let wrong = AllLine::try_parse_from(["batch", "--exposure-time=long"]).unwrap().settings;
        assert!(wrong.apply(&mut Settings::default()).is_ok());
        let error = wrong.check_others(PrinterTechnology::Fff).unwrap_err().to_string();
        assert!(error.starts_with("--exposure-time: exposure_time = \"long\" is not a number"), "{error}");
    }

    #[test]
    fn clap_accepts_the_definition() {
        use clap::CommandFactory;
        Line::command().debug_assert();
        let help = Line::command().render_long_help().to_string();
        let named = |help: &str, key: &Key| {
            help.contains(&format!("--{} ", dashed(key))) || help.contains(&format!("--{}[", dashed(key)))
        };
        assert!(keys::of(PrinterTechnology::Fff).all(|k| named(&help, k)));
        assert!(help.contains("Printer settings:") && !help.contains("Exposure settings:"));
        assert!(crate::settings::RESIN_KEYS.iter().all(|k| !named(&help, k)) && !help.contains("--printer "));
        ResinLine::command().debug_assert();
        let help = ResinLine::command().render_long_help().to_string();
        assert!(keys::of(PrinterTechnology::Sla).all(|k| named(&help, k)));
        assert!(help.contains("Exposure settings:") && help.contains("--printer <NAME|FILE.toml>"));
        let filament =
            keys::of(PrinterTechnology::Fff).filter(|k| !k.technology.fits(PrinterTechnology::Sla));
        assert!(filament.into_iter().all(|k| !named(&help, k)));
    }

    #[test]
    fn each_key_has_a_flag_that_takes_its_default() {
        for key in keys::of(PrinterTechnology::Fff) {
            let arg = format!("--{}={}", dashed(key), key.default_text(PrinterTechnology::Fff));
            let (settings, ..) = apply_line(&[&arg]).unwrap();
            assert_eq!(settings, Settings::default(), "{arg}");
        }
        for key in keys::of(PrinterTechnology::Sla) {
            let arg = format!("--{}={}", dashed(key), key.default_text(PrinterTechnology::Sla));
            assert_eq!(resin_line(&[&arg]).unwrap().0, Settings::resin(), "{arg}");
        }
    }

    #[test]
    fn values_come_separately_or_after_an_equals_sign() {
        let (s, _, model) = apply_line(&[
            "--layer-height",
            "0.2",
            "--fill_density=15%",
            "--z-offset",
            "-0.1",
            "--bed-shape",
            "-50x-50,50x-50,50x50",
            "--external-perimeters-first",
            "part.stl",
        ])
        .unwrap();
        assert_eq!((s.slicing.layer_height, s.infill.fill_density, s.printer.z_offset), (0.2, 15.0, -0.1));
        assert_eq!(s.printer.bed_shape[0], [-50.0, -50.0]);
        assert!(s.perimeters.external_perimeters_first);
        assert_eq!(model.as_deref(), Some("part.stl"));
        assert!(!apply_line(&["--cooling=0"]).unwrap().0.cooling.cooling);
        let last = apply_line(&["--perimeters", "2", "--perimeters", "4"]).unwrap().0;
        assert_eq!(last.perimeters.perimeters, 4);
    }

    #[test]
    fn files_then_flags_then_set() {
        let file = tempfile::Builder::new().suffix(".ini").tempfile().unwrap();
        std::fs::write(file.path(), "perimeters = 5\nskirts = 5\ninfill_speed = 55\nwipe = 1\n").unwrap();
        let path = file.path().to_str().unwrap();
        let (s, report, _) =
            apply_line(&["--set", "perimeters=7", "--perimeters=6", "--skirts=6", "--load", path]).unwrap();
        assert_eq!((s.perimeters.perimeters, s.adhesion.skirts, s.speed.infill_speed), (7, 6, 55.0));
        assert_eq!(report.files[0].1.applied, 3);
        assert_eq!(report.warnings.len(), 1);
        assert_eq!(report.warnings[0].place, format!("{path}:4"));
    }

    #[test]
    fn refusals_name_the_flag() {
        let error = |line: &[&str]| apply_line(line).err().unwrap_or_default();
        assert_eq!(
            error(&["--layer-height", "abc"]),
            "--layer-height: layer_height = \"abc\" is not a number; allowed: a number (mm) from 0.01 to 10"
        );
        assert!(
            error(&["--perimeters", "-1"]).contains("is too small; allowed: a whole number from 0 to 1000")
        );
        assert!(error(&["--fill-pattern", "gyroid"]).contains("not supported yet; allowed: rectilinear"));
        assert!(error(&["--set", "layer_hight=0.2"]).contains("did you mean layer_height?"));
        assert!(error(&["--set", "layer_height"]).contains("key=value"));
        assert!(error(&["--load", "/nonexistent/x.ini"]).starts_with("/nonexistent/x.ini: cannot read"));
        // Known, but without effect: a warning and no error.
        let (_, report, _) = apply_line(&["--set", "fuzzy_skin=all"]).unwrap();
        assert_eq!(report.warnings[0].key, "fuzzy_skin");
    }
}
