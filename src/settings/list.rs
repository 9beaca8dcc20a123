//! The registry as text: a reference in Markdown and a list for the terminal.

use super::foreign;
use super::keys;
use super::kind::Stage;
use super::types::PrinterTechnology::{self, Fff, Sla};
use std::fmt::Write as _;

/// All settings of a technology with their defaults, units and ranges, for a terminal.
pub fn terminal_list(technology: PrinterTechnology) -> String {
    let mut out = String::new();
    for stage in stages(technology) {
        // Writing to a String cannot fail.
        let _ = writeln!(out, "{}", stage.heading());
        for key in keys::of_stage(technology, stage) {
            let unit = if key.unit.is_empty() { String::new() } else { format!(" {}", key.unit) };
            let range = key.kind.to_string();
            let range = if range.is_empty() { range } else { format!(" [{range}]") };
            let _ = writeln!(out, "  {} = {}{unit}{range}", key.name, key.default_text(technology));
            let _ = writeln!(out, "      {}", key.help);
        }
    }
    out
}

/// The stages in which a technology has settings.
fn stages(technology: PrinterTechnology) -> impl Iterator<Item = Stage> {
    Stage::ALL.into_iter().filter(move |stage| keys::of_stage(technology, *stage).next().is_some())
}

/// The text of `docs/SETTINGS.md`.
pub fn reference() -> String {
    let mut out = String::from(HEAD);
    tables(&mut out, Fff);
    out.push_str(RESIN_HEAD);
    tables(&mut out, Sla);
    out.push_str(FOREIGN_HEAD);
    not_honoured(&mut out, Fff);
    out.push_str("\n### Of resin printers\n");
    not_honoured(&mut out, Sla);
    out
}

fn tables(out: &mut String, technology: PrinterTechnology) {
    for stage in stages(technology) {
        let _ = writeln!(out, "\n### {} (`[{}]`)\n", stage.heading(), stage.name());
        out.push_str("| key | default | unit | range | meaning |\n|---|---|---|---|---|\n");
        for key in keys::of_stage(technology, stage) {
            let star = if key.per_extruder { "\\*" } else { "" };
            let default = key.default_text(technology);
            let default = if default.is_empty() { default } else { format!("`{}`", cell(&default)) };
            let (range, help) = (cell(&key.kind.to_string()), cell(key.help));
            let _ = writeln!(out, "| `{}`{star} | {default} | {} | {range} | {help} |", key.name, key.unit);
        }
    }
}

fn not_honoured(out: &mut String, technology: PrinterTechnology) {
    let foreign = foreign::of(technology);
    out.push_str("\n| key | warns unless |\n|---|---|\n");
    for f in foreign {
        if let Some(off) = f.off {
            let off: Vec<String> = off
                .iter()
                .map(|o| if o.is_empty() { "empty".to_owned() } else { format!("`{o}`") })
                .collect();
            let _ = writeln!(out, "| `{}` | {} |", f.name, off.join(", "));
        }
    }
    let quiet: Vec<String> =
        foreign.iter().filter(|f| f.off.is_none()).map(|f| format!("`{}`", f.name)).collect();
    let _ = writeln!(out, "\nKnown by name, without a warning:\n\n{}.", quiet.join(", "));
}

fn cell(text: &str) -> String {
    text.replace('|', "\\|")
}

const HEAD: &str = "# Settings

The names, units, value syntax and defaults are PrusaSlicer's, with these exceptions: `fill_pattern` is
`rectilinear` here; `adaptive_layer_height`, `adaptive_cusp_height`, `support_material_layer_height`,
`support_material_flow_ratio`, `support_material_interface_flow_ratio`, `brim_ears` and `brim_ears_max_angle` are not
PrusaSlicer's. This page is generated from the registry in `src/settings/keys.rs` and `keys_resin.rs`; a test keeps it true
(`MICROTOME_BLESS=1 cargo test --lib settings` rewrites it). The settings of resin printers come second.

Settings come, later ones winning, from files (`--load FILE`, may be repeated), from a flag for each key
(`--layer-height 0.2`, `--fill-density 20%`, `--cooling=0`), and from `--set key=value`.

Values are written as in PrusaSlicer: `0` and `1` (also `false` and `true`), `20%`, points `0x0,200x0,...`, and
texts on one line with `\\n` for a new line. A key marked \\* may have an entry for each extruder (`0.4,0.4`, texts
`PLA;PETG`); the first is used. Ranges include both ends.

A file is TOML, a flat PrusaSlicer `.ini`, or a G-code file with PrusaSlicer's config block. In TOML the keys stand
at the top or in the tables named below; numbers, booleans and texts are TOML's own, and points are
`[[0, 0], [200, 0], ...]`. Where the table `[perimeters]` is used, the key `perimeters` stands in it. Of a G-code file
only the lines between `; prusaslicer_config = begin` and `end` are read. A choice of PrusaSlicer's that is not supported
yet, such as `fill_pattern = gyroid`, is an error on the command line; in a file it becomes the default, with a warning.

A file's keys fall in three classes: applied; known to PrusaSlicer but not honoured here; unknown. The last two are
counted, not refused, so that a file of another version loads. On the command line an unknown key is an error.

G-code templates may use `[name]` or `{name}` for each setting on this page, `[name_0]` or `{name[0]}` for a key marked
\\*, and the values of the print such as `layer_num` and `layer_z`. As in PrusaSlicer a `[` or `{` starts a name
everywhere, in comments too, and there is no way to escape it; `]` and `}` alone are plain text. Anything but a name is
an error.

## Filament printers
";

const RESIN_HEAD: &str = "
## Resin printers

The settings of `microtome mask`. Those that PrusaSlicer has carry its names, units and meanings; those of lifts, rests,
bottom and transition layers, light, anti-aliasing and the container are this program's own, as PrusaSlicer lacks them.
The defaults of exposures and lifts are starting points for a monochrome panel and a common resin: the resin's maker
knows better. The panel has no default; it comes from the preset of a printer.

Settings come, later ones winning, from a printer's preset (`--printer NAME`, see `microtome printers`, or
`--printer FILE.toml`), from files (`--load FILE`), from a flag for each key, and from `--set key=value`.

A length marked `px` in its range may be given in pixels, `2px`: as many times the panel's pitch in the direction at hand.

Exposure has two descriptions. `bottom_layers` layers get the full `initial_exposure_time`, and over the
`transition_layers` behind them it falls linearly to `exposure_time`: of T transition layers the i-th, counted from 1,
gets `initial - (initial - normal) i / (T + 1)`. PrusaSlicer's `faded_layers = F` above 0 replaces both and means what
it means there: three bottom layers and F transition layers.
Lift, rests and light change at once, behind the bottom layers.

A file with `printer_technology = FFF` is refused here, as one with `SLA` is by the commands for filament. Settings of the
other technology in a file are counted as not honoured.
";

const FOREIGN_HEAD: &str = "
## Known, not honoured yet

These are settings of PrusaSlicer that have no effect here yet. They are accepted and counted. A value that asks for
something the print would visibly lack gives a warning.
";

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn the_reference_in_docs_is_up_to_date() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/SETTINGS.md");
        let now = reference();
        if std::env::var_os("MICROTOME_BLESS").is_some() {
            std::fs::create_dir_all(concat!(env!("CARGO_MANIFEST_DIR"), "/docs")).unwrap();
            std::fs::write(path, &now).unwrap();
        }
        let stored = std::fs::read_to_string(path).unwrap_or_default();
        assert!(stored == now, "docs/SETTINGS.md is stale; run the tests once with MICROTOME_BLESS=1");
    }

    #[test]
    fn the_terminal_list_names_every_key() {
        for technology in [Fff, Sla] {
            let list = terminal_list(technology);
            assert!(keys::of(technology).all(|k| list.contains(&format!("  {} = ", k.name))));
        }
        assert!(!terminal_list(Fff).contains("exposure_time"));
        assert!(!terminal_list(Sla).contains("perimeters"));
    }
}
