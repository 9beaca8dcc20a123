//! Tests of the registry and the loaders together.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use super::*;
use std::path::Path;

/// Marsaglia's xorshift64.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

fn load(name: &str, text: &str) -> Result<(Settings, LoadReport), String> {
    let mut settings = Settings::default();
    let report = load_bytes(Path::new(name), text.as_bytes(), &mut settings).map_err(|e| e.to_string())?;
    Ok((settings, report))
}

fn refusal(key: &str, value: &str) -> String {
    let before = Settings::default();
    let mut settings = before.clone();
    let error = settings.set(key, value).expect_err(value).to_string();
    assert_eq!(settings, before, "{key} = {value} was refused and yet changed something");
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

/// Another value of the same kind, in the form `write` gives.
fn other(key: &Key, technology: PrinterTechnology) -> String {
    let default = key.default_text(technology);
    match (key.name, key.kind) {
        ("printer_technology", _) => default,
        (_, Kind::Flag) => if default == "1" { "0" } else { "1" }.to_owned(),
        (_, Kind::Count(..) | Kind::Integer(..)) => "17".to_owned(),
        (_, Kind::Number(..)) => if default == "0.75" { "0.5" } else { "0.75" }.to_owned(),
        (_, Kind::Percent(..)) => "12.5%".to_owned(),
        (_, Kind::NumberOrPercent(..)) => "35.5%".to_owned(),
        (_, Kind::LengthOrPixels(..)) => "1.5px".to_owned(),
        (_, Kind::Text) if key.per_extruder => "\"a; \\\"b\\\" \\\\ \\n\"".to_owned(),
        (_, Kind::Text) => "G1 \\\\ \"x\"; [y]\\nM2\\n".to_owned(),
        (_, Kind::Points(..)) => "-1.5x0,20x0,20x20.25".to_owned(),
        (_, Kind::Choice(names, _)) => {
            names.iter().find(|n| **n != default).copied().unwrap_or_default().to_owned()
        }
    }
}

const BOTH: [PrinterTechnology; 2] = [PrinterTechnology::Fff, PrinterTechnology::Sla];

#[test]
fn every_key_round_trips() {
    for technology in BOTH {
        let defaults = Settings::of(technology);
        for key in keys::of(technology) {
            let mut s = defaults.clone();
            s.set(key.name, &key.default_text(technology)).unwrap();
            assert_eq!(s, defaults, "{}", key.name);
            let value = other(key, technology);
            s.set(key.name, &value).unwrap();
            assert_eq!(key.get(&s), value, "{}", key.name);
            assert_eq!(s == defaults, key.name == "printer_technology", "{} changes nothing", key.name);
            // No other key moved.
            for (name, value) in s.entries().filter(|(n, _)| *n != key.name) {
                assert_eq!(defaults.get(name), Some(value), "{} moved {name}", key.name);
            }
        }
    }
}

#[test]
fn names_are_unique_and_rows_complete() {
    for technology in BOTH {
        let mut names: Vec<_> = Settings::of(technology).entries().map(|(n, _)| n).collect();
        assert!(names.is_sorted());
        names.dedup();
        assert_eq!(names.len(), keys::of(technology).count());
    }
    let all: Vec<&Key> = KEYS.iter().chain(RESIN_KEYS).collect();
    let unique: std::collections::BTreeSet<_> = all.iter().map(|k| k.name).collect();
    assert_eq!(unique.len(), all.len(), "a name means one thing, whatever the technology");
    assert!(all.iter().all(|k| !k.help.is_empty() && !k.help.contains('\n') && !k.help.contains('|')));
    // Every choice listed is understood, and none of those to come.
    for technology in BOTH {
        for key in keys::of(technology).filter(|k| k.name != "printer_technology") {
            if let Kind::Choice(names, later) = key.kind {
                let set = |n: &str| Settings::of(technology).set(key.name, n);
                assert!(names.iter().all(|n| set(n).is_ok()), "{}", key.name);
                assert!(
                    later.iter().all(|n| matches!(set(n), Err(ValueError::NotYet { .. }))),
                    "{}",
                    key.name
                );
            }
        }
    }
}

#[test]
fn the_config_block_reads_back() {
    for technology in BOTH {
        let mut s = Settings::of(technology);
        for key in keys::of(technology) {
            s.set(key.name, &other(key, technology)).unwrap();
        }
        let ini: String = s.entries().map(|(k, v)| format!("{k} = {v}\n")).collect();
        let block: String = s.entries().map(|(k, v)| format!("; {k} = {v}\n")).collect();
        let gcode =
            format!("G1 X1\n;TYPE:x\n; prusaslicer_config = begin\n{block}; prusaslicer_config = end\nM2\n");
        for (name, text) in [("a.ini", &ini), ("a.gcode", &gcode), ("a", &gcode), ("a", &ini)] {
            let mut read = Settings::of(technology);
            let report = load_bytes(Path::new(name), text.as_bytes(), &mut read).unwrap();
            assert_eq!(read, s, "{name}");
            let applied = keys::of(technology).count();
            assert_eq!(report, LoadReport { applied, ..LoadReport::default() }, "{name}");
        }
    }
}

#[test]
fn each_technology_takes_its_own_files_and_keys() {
    let read = |technology, text: &str| {
        let mut s = Settings::of(technology);
        let report = load_bytes(Path::new("b.ini"), text.as_bytes(), &mut s).map_err(|e| e.to_string());
        report.map(|r| (s, r))
    };
    let [fff, sla] = BOTH;
    let (s, report) = read(
        sla,
        "printer_technology = SLA\nlayer_height = 0.025\nfill_density = 20%\n\
        elefant_foot_compensation = 0.2\nsupport_material = 1\nhollowing_enable = 1\nbed_shape = 0x0\n",
    )
    .unwrap();
    assert_eq!(
        (s.slicing.layer_height, s.slicing.elefant_foot_compensation),
        (0.025, LengthOrPixels::Length(0.2))
    );
    assert_eq!((report.applied, report.ignored.len(), report.unknown.len()), (3, 4, 0));
    assert_eq!(report.warnings.len(), 1);
    assert_eq!(report.warnings[0].key, "hollowing_enable");
    assert_eq!(
        read(sla, "\nprinter_technology = FFF").unwrap_err(),
        "b.ini:2: printer_technology = \"FFF\" means a filament printer, whose settings do not fit a resin job; allowed: SLA"
    );
    // The other way round.
    let (s, report) =
        read(fff, "exposure_time = 3\nhollowing_enable = 1\nelefant_foot_compensation = 0.2").unwrap();
    assert_eq!(s.slicing.elefant_foot_compensation, LengthOrPixels::Length(0.2));
    assert_eq!((report.applied, report.ignored.len(), report.unknown.len()), (1, 2, 0));
    assert!(report.warnings.is_empty());
    assert_eq!((s.get("exposure_time"), s.template_value("light")), (None, None));
    assert!(refusal("printer_technology", "SLA").ends_with("allowed: FFF"));
    let mut s = Settings::resin();
    assert!(s.set("printer_technology", "resin").unwrap_err().to_string().contains("is not a choice here"));
}

#[test]
fn values_are_prusaslicers() {
    let mut s = Settings::default();
    for (key, value, written) in [
        ("fill_density", "20", "20%"),
        ("fill_density", "7.5%", "7.5%"),
        ("cooling", "true", "1"),
        ("cooling", "0", "0"),
        ("layer_height", " .2 ", "0.2"),
        ("layer_height", "2e-1", "0.2"),
        ("xy_size_compensation", "-0", "0"),
        ("external_perimeter_speed", "45", "45"),
        ("first_layer_speed", "80%", "80%"),
        ("bed_shape", "0x0,400x0,400x400", "0x0,400x0,400x400"),
        ("gcode_flavor", "marlin2", "marlin2"),
        ("nozzle_diameter", "0.6,0.6", "0.6"),
        ("temperature", "215,230", "215"),
        ("filament_type", "PETG;PLA", "PETG"),
        ("filament_type", "\"my; PLA\"; ABS", "\"my; PLA\""),
        ("filament_type", "", "\"\""),
        ("end_gcode", "M84\\nM2 ; a=b", "M84\\nM2 ; a=b"),
        ("perimeters", "4", "4"),
    ] {
        s.set(key, value).unwrap();
        assert_eq!(s.get(key).as_deref(), Some(written), "{key} = {value}");
    }
    assert_eq!(s.output.end_gcode, "M84\nM2 ; a=b");
    let warned = |key: &str, value: &str| matches!(Settings::default().assign(key, value), Ok(Assigned::Applied(Some(w))) if w.message.contains("first"));
    assert!(warned("temperature", "215,230") && warned("filament_type", "PLA;ABS"));
    assert!(!warned("temperature", "215,215") && !warned("nozzle_diameter", "0.4"));
}

#[test]
fn bad_values_say_what_is_allowed() {
    assert_eq!(
        refusal("layer_height", "abc"),
        "layer_height = \"abc\" is not a number; allowed: a number (mm) from 0.01 to 10"
    );
    assert_eq!(
        refusal("perimeters", "2.5"),
        "perimeters = \"2.5\" is not a whole number; allowed: a whole number from 0 to 1000"
    );
    assert!(refusal("fill_density", "120%").contains("is too large; allowed: a percentage from 0% to 100%"));
    assert!(refusal("seam_position", "hidden").contains("allowed: random, nearest, aligned, rear"));
    assert!(refusal("printer_technology", "SLA").contains("resin"));
    assert!(refusal("temperature", "nil").contains("nil"));
    for (key, value) in [
        ("layer_height", ""),
        ("layer_height", "nan"),
        ("layer_height", "inf"),
        ("layer_height", "0.2mm"),
        ("layer_height", "0"),
        ("layer_height", "50%"),
        ("first_layer_height", "0"),
        ("first_layer_height", "0%"),
        ("first_layer_height", "%"),
        ("infill_overlap", "150%"),
        ("infill_overlap", "-1"),
        ("perimeters", "-1"),
        ("perimeters", "99999999999999999999"),
        ("cooling", "yes"),
        ("cooling", ""),
        ("gcode_comments", "2"),
        ("fill_density", "20%%"),
        ("bed_shape", ""),
        ("bed_shape", "0x0,1"),
        ("bed_shape", "0x0,1x2x3"),
        ("bed_shape", "0x0,1xinf"),
        ("nozzle_diameter", ",0.4"),
        ("filament_type", "\"PLA"),
        ("filament_type", "\"PLA\"x"),
        ("start_gcode", "G28\\"),
        ("gcode_flavor", "Marlin"),
        ("gcode_flavor", "mach3"),
        ("fill_pattern", "gyroid"),
    ] {
        assert!(refusal(key, value).contains("allowed: "), "{key} = {value}");
    }
    assert_eq!(
        refusal("layer_hieght", "1"),
        "there is no setting \"layer_hieght\"; did you mean layer_height?"
    );
    assert_eq!(refusal("nothing_like_it", "1"), "there is no setting \"nothing_like_it\"");
}

#[test]
fn an_ini_is_counted_in_three_classes() {
    let text = "\u{feff}# written by hand\r\n; another comment\r\nprinter_technology = FFF\r\n\
                nozzle_diameter = 0.4,0.6\r\nlayer_height=0.15\r\nfill_pattern = gyroid\r\nfuzzy_skin = all\r\n\
                wipe = 0\r\nfuzzy_skin_thickness = 0.3\r\nmade_up_key = 7\r\nlayer_hight = 3\r\n\
                \r\nstart_gcode = G28 ; a = b\\nG1 Z5\\n\r\n";
    let (s, report) = load("dir/b.ini", text).unwrap();
    assert_eq!(report.applied, 5);
    let keys = |list: &[(usize, String)]| list.iter().map(|(l, k)| format!("{l} {k}")).collect::<Vec<_>>();
    assert_eq!(keys(&report.ignored), ["7 fuzzy_skin", "8 wipe", "9 fuzzy_skin_thickness"]);
    assert_eq!(keys(&report.unknown), ["10 made_up_key", "11 layer_hight"]);
    let warnings: Vec<_> = report.warnings.iter().map(ToString::to_string).collect();
    assert_eq!(
        warnings,
        [
            "dir/b.ini:4: nozzle_diameter = 0.4,0.6: only the first extruder's value, 0.4, is used",
            "dir/b.ini:6: fill_pattern = gyroid: not supported yet; rectilinear is used",
            "dir/b.ini:7: fuzzy_skin = all: not supported yet, so it has no effect",
            "dir/b.ini:11: layer_hight = 3: no such setting; did you mean layer_height?",
        ]
    );
    assert_eq!((s.slicing.layer_height, s.output.start_gcode.as_str()), (0.15, "G28 ; a = b\nG1 Z5\n"));
}

#[test]
fn toml_says_the_same_in_its_own_words() {
    let toml = "layer_height = 0.2\nfill_density = 15 # percent\nperimeters = 2\n\n[infill]\n\
                top_solid_layers = 0x4\nfill_pattern = 'monotonic'\n[cooling]\ncooling = [false, false]\n\
                [filament]\nfilament_type = 'PLA; \"x\"'\ntemperature = [210, 220]\n[printer]\n\
                bed_shape = [[0, 0], [1_00.5, 0], [100.5, 100]]\n[speed]\nexternal_perimeter_speed = '50%'\n\
                [output]\nstart_gcode = '''\nG28 ; \\n stays\nG1 Z5\n'''\n";
    let (s, report) = load("a.toml", toml).unwrap();
    assert_eq!(report.applied, 11);
    assert_eq!(report.warnings.len(), 1);
    assert_eq!(report.warnings[0].place, "a.toml:12");
    assert_eq!((s.infill.fill_density, s.perimeters.perimeters, s.infill.top_solid_layers), (15.0, 2, 4));
    assert_eq!((s.cooling.cooling, s.filament.temperature), (false, 210));
    assert_eq!(s.filament.filament_type, "PLA; \"x\"");
    assert_eq!(s.printer.bed_shape, [[0.0, 0.0], [100.5, 0.0], [100.5, 100.0]]);
    assert_eq!(s.output.start_gcode, "G28 ; \\n stays\nG1 Z5\n");
    // A nameless file is told by its content.
    assert_eq!(load("settings", toml).unwrap().0, s);
}

#[test]
fn a_wrong_file_is_refused_with_its_line() {
    for (name, text, message) in [
        (
            "b.ini",
            "a = 1\n\nlayer_height = abc\n",
            "b.ini:3: layer_height = \"abc\" is not a number; allowed: a number (mm) from 0.01 to 10",
        ),
        ("b.ini", "printer_technology = SLA", "b.ini:1: printer_technology = \"SLA\" means a resin"),
        ("b.ini", "layer_height = 0.2\n[print:x]\n", "b.ini:2: starts a section; bundles"),
        ("b.ini", "<html>\n", "b.ini:1: \"<html>\" is not of the form key = value"),
        ("b.ini", "= 3\n", "b.ini:1: \"= 3\" is not of the form"),
        ("b.gcode", "G28\n", "b.gcode:1: no settings in this G-code"),
        (
            "b.gcode",
            "G28\n; prusaslicer_config = begin\n; hello\n",
            "b.gcode:3: \"hello\" is not of the form",
        ),
        (
            "b.gcode",
            "; prusaslicer_config = begin\n; perimeters = -2\n",
            "b.gcode:2: perimeters = \"-2\" is too small",
        ),
        ("b.toml", "layer_height = 0.2\nperimeters = \n", "b.toml:2: is not TOML"),
        ("b.toml", "\n[slices]\nlayer_height = 0.2\n", "b.toml:2: there is no table [slices]"),
        ("b.toml", "layer_height = 1979-05-27\n", "b.toml:1: layer_height has a datetime"),
        ("b.toml", "[slicing.x]\nlayer_height = 1\n", "b.toml:1: x has a table"),
        ("b.toml", "[slicing]\nlayer_height = 'x'\n", "b.toml:2: layer_height = \"x\" is not a number"),
        ("b.toml", "bed_shape = [[[0]]]\n", "b.toml:1: bed_shape has a"),
        ("b.toml", "layer_height = nan\n", "b.toml:1: layer_height = \"nan\" is not a finite number"),
        ("b", "GCDE\u{1}", "b:1: is binary G-code"),
    ] {
        let error = load(name, text).map(|_| ()).expect_err(text);
        assert!(error.starts_with(message), "{error}");
        assert_eq!(error.lines().count(), 1, "{error}");
    }
    let mut s = Settings::default();
    let binary =
        |bytes: &[u8], s: &mut Settings| load_bytes(Path::new("b"), bytes, s).unwrap_err().to_string();
    assert!(binary(b"a = 1\nb = \xff\n", &mut s).starts_with("b:2: is not UTF-8"));
    assert!(binary(b"\xff\xfea\0", &mut s).contains("UTF-16"));
    // Half of a refused file must not be in force.
    assert!(load_bytes(Path::new("b.ini"), b"perimeters = 9\nskirts = x", &mut s).is_err());
    assert_eq!(s, Settings::default());
}

#[test]
fn random_bytes_never_panic() {
    let words: Vec<&[u8]> = vec![
        b"layer_height",
        b" = ",
        b"=",
        b"\n",
        b"\r\n",
        b"0.2",
        b"20%",
        b"\"",
        b"[",
        b"]",
        b"'",
        b"#",
        b";",
        b",",
        b"x",
        b"\\",
        b"filament_type",
        b"bed_shape",
        b"start_gcode",
        b"temperature",
        b"slicing",
        b"true",
        b"nil",
        b"\xff",
        b"\xc3\xa9",
        b"; prusaslicer_config = begin\n",
        b"; prusaslicer_config = end",
        b"support_material",
        b"-",
        b"1e999",
    ];
    for seed in 1..4000_u64 {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let mut bytes = Vec::new();
        for _ in 0..random.below(40) {
            match random.below(8) {
                0 => bytes.push(random.below(256) as u8),
                _ => bytes.extend_from_slice(words[random.below(words.len())]),
            }
        }
        for name in ["a.ini", "a.toml", "a.gcode", "a"] {
            let mut s = Settings::default();
            if let Err(error) = load_bytes(Path::new(name), &bytes, &mut s) {
                assert_eq!(error.to_string().lines().count(), 1, "seed {seed}, {name}: {error}");
                assert_eq!(s, Settings::default(), "seed {seed}, {name}");
            }
            let _ = s.validate();
        }
    }
}

#[test]
fn any_text_survives_a_round_trip() {
    let alphabet: Vec<char> = "ab \\\"';,=#[]{}\n\r\té%".chars().collect();
    for seed in 1..2000_u64 {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let text: String = (0..random.below(12)).map(|_| alphabet[random.below(alphabet.len())]).collect();
        let mut s = Settings::default();
        (s.output.layer_gcode, s.filament.filament_type) = (text.clone(), text.clone());
        let mut read = Settings::default();
        for key in ["layer_gcode", "filament_type"] {
            let written = s.get(key).unwrap();
            assert_eq!(written.lines().count().max(1), 1, "seed {seed}: {written}");
            read.set(key, &written).unwrap();
        }
        assert_eq!(read, s, "seed {seed}");
    }
}

#[test]
fn templates_see_every_setting() {
    let s = Settings::default();
    assert!(KEYS.iter().all(|k| s.template_value(k.name).is_some()));
    assert!(RESIN_KEYS.iter().all(|k| s.template_value(k.name).is_none()));
    assert_eq!(s.template_value("temperature[0]").as_deref(), Some("200"));
    assert_eq!(s.template_value("filament_type").as_deref(), Some("PLA"));
    assert_eq!(s.template_value("layer_height[0]"), None);
    assert_eq!(s.template_value("temperature[1]"), None);
    assert_eq!(s.template_value("end_gcode").unwrap(), s.output.end_gcode);
}
