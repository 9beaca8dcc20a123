//! Settings on the command line: `--load FILE`, a flag for each key, `--set key=value`.

use crate::settings::{
    Assigned, KEYS, Key, Kind, LoadReport, Settings, SettingsError, Stage, ValueError, Warning, load_file,
};
use clap::builder::ValueParser;
use clap::{Arg, ArgAction, ArgMatches, Command};
use std::path::PathBuf;
use std::sync::LazyLock;

/// Why the settings of a command line were refused.
#[derive(Debug, thiserror::Error)]
pub enum FlagError {
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

/// The settings as typed, for `#[command(flatten)]` in a derived parser.
#[derive(Clone, Debug, Default)]
pub struct SettingFlags {
    load: Vec<PathBuf>,
    flags: Vec<(&'static Key, String)>,
    set: Vec<String>,
}

/// `--load`, `--set` and a long flag for each key of the registry, grouped by stage.
pub fn command_flags() -> Vec<Arg> {
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
    [load, set].into_iter().chain(Stage::ALL.into_iter().flat_map(stage_flags)).collect()
}

fn stage_flags(stage: Stage) -> impl Iterator<Item = Arg> {
    KEYS.iter().filter(move |k| k.stage == stage).map(flag)
}

/// `layer_height` as a flag is `--layer-height`; with underscores it works too.
fn flag(key: &'static Key) -> Arg {
    let dashed = dashed(key);
    let arg = Arg::new(key.name)
        .help(help(key))
        .help_heading(key.stage.heading())
        .value_name(value_name(&key.kind))
        .action(ArgAction::Set)
        .overrides_with(key.name);
    let arg = if dashed == key.name { arg } else { arg.alias(key.name) }.long(dashed);
    match key.kind {
        // The value needs its "=", or `--cooling part.stl` would eat the file.
        Kind::Flag => arg.num_args(0..=1).require_equals(true).default_missing_value("1"),
        Kind::Text | Kind::Choice(..) => arg,
        Kind::Points(..) => arg.allow_hyphen_values(true),
        // Where "-5" makes no sense the range refuses it, and says what is allowed.
        _ => arg.allow_negative_numbers(true),
    }
}

/// The flag's name without its dashes, e.g. `layer-height`. clap wants names that live as long as the program.
fn dashed(key: &Key) -> &'static str {
    static NAMES: LazyLock<Vec<(&str, String)>> =
        LazyLock::new(|| KEYS.iter().map(|k| (k.name, k.name.replace('_', "-"))).collect());
    NAMES.iter().find(|(name, _)| *name == key.name).map_or(key.name, |(_, dashed)| dashed)
}

fn value_name(kind: &Kind) -> &'static str {
    match kind {
        Kind::Flag => "0|1",
        Kind::Count(..) | Kind::Number(..) => "N",
        Kind::Percent(..) => "N%",
        Kind::NumberOrPercent(..) => "N|N%",
        Kind::Text => "TEXT",
        Kind::Points(..) => "XxY,...",
        Kind::Choice(..) => "NAME",
    }
}

fn help(key: &Key) -> String {
    let unit = match key.kind {
        Kind::Choice(names, _) => names.join(", "),
        // The default shows the sign.
        Kind::Percent(..) => String::new(),
        _ => key.unit.to_owned(),
    };
    let default = key.default_text();
    let default = if default.is_empty() { default } else { format!("default {default}") };
    let facts: Vec<String> = [unit, default].into_iter().filter(|f| !f.is_empty()).collect();
    if facts.is_empty() { key.help.to_owned() } else { format!("{} ({})", key.help, facts.join("; ")) }
}

impl clap::Args for SettingFlags {
    fn augment_args(command: Command) -> Command {
        command.args(command_flags())
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl clap::FromArgMatches for SettingFlags {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(typed(matches))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = typed(matches);
        Ok(())
    }
}

fn typed(matches: &ArgMatches) -> SettingFlags {
    let all = |id: &str| matches.get_many::<String>(id).into_iter().flatten().cloned().collect();
    let flags = KEYS.iter().filter_map(|k| Some((k, matches.get_one::<String>(k.name)?.clone())));
    SettingFlags {
        load: matches.get_many::<PathBuf>("load").into_iter().flatten().cloned().collect(),
        flags: flags.collect(),
        set: all("set"),
    }
}

/// Applies files, then flags, then `--set`, as given to a command that has [`command_flags`].
///
/// # Errors
/// [`FlagError`] for the first value that is refused.
pub fn apply(matches: &ArgMatches, settings: &mut Settings) -> Result<FlagReport, FlagError> {
    typed(matches).apply(settings)
}

impl SettingFlags {
    /// Applies files, then flags, then `--set`.
    ///
    /// # Errors
    /// [`FlagError`] for the first value that is refused.
    pub fn apply(&self, settings: &mut Settings) -> Result<FlagReport, FlagError> {
        let mut report = FlagReport::default();
        for path in &self.load {
            let loaded = load_file(path, settings)?;
            report.warnings.extend_from_slice(&loaded.warnings);
            report.files.push((path.clone(), loaded));
        }
        for (key, value) in &self.flags {
            let assigned = settings
                .assign(key.name, value)
                .map_err(|error| FlagError::Flag { flag: dashed(key), error })?;
            report.warnings.extend(warning(assigned));
        }
        for text in &self.set {
            let (key, value) = text
                .split_once('=')
                .ok_or_else(|| FlagError::NoValue { text: text.escape_debug().to_string() })?;
            let assigned = settings
                .assign(key.trim(), value)
                .map_err(|error| FlagError::Set { text: text.escape_debug().to_string(), error })?;
            report.warnings.extend(warning(assigned));
        }
        Ok(report)
    }
}

fn warning(assigned: Assigned) -> Option<Warning> {
    match assigned {
        Assigned::Applied(warning) | Assigned::NotHonoured(warning) => warning,
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

    #[test]
    fn clap_accepts_the_definition() {
        use clap::CommandFactory;
        Line::command().debug_assert();
        let help = Line::command().render_long_help().to_string();
        assert!(KEYS.iter().all(|k| help.contains(&format!("--{}", dashed(k)))));
        assert!(help.contains("Printer settings:"));
    }

    #[test]
    fn each_key_has_a_flag_that_takes_its_default() {
        for key in KEYS {
            let arg = format!("--{}={}", dashed(key), key.default_text());
            let (settings, ..) = apply_line(&[&arg]).unwrap();
            assert_eq!(settings, Settings::default(), "{arg}");
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
        std::fs::write(file.path(), "perimeters = 5\nskirts = 5\ninfill_speed = 55\nbrim_width = 3\n")
            .unwrap();
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
        let (_, report, _) = apply_line(&["--set", "support_material=1"]).unwrap();
        assert_eq!(report.warnings[0].key, "support_material");
    }
}
