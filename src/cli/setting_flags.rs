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
        // "-5" is then refused by the range, which says what is allowed.
        Kind::Text | Kind::Choice(..) => arg,
        _ => arg.allow_hyphen_values(true),
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
    let choices = match key.kind {
        Kind::Choice(names, _) => format!(" ({})", names.join(", ")),
        _ if key.unit.is_empty() => String::new(),
        _ => format!(" [{}]", key.unit),
    };
    match key.default_text() {
        default if default.is_empty() => format!("{}{choices}", key.help),
        default => format!("{}{choices} (default {default})", key.help),
    }
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
