//! Reads written files back, with a reader that shares nothing with the writer.

#![allow(clippy::panic)]

use super::{LayerText, Summary, Texts, write};
use crate::infill::{FillKind, FillPath};
use crate::lattice::Point2;
use crate::path::testing::{Random, circle, rectangle};
use crate::path::{LayerPlan, PrintIsland, PrintLayer, Role, plan};
use crate::region::{Bead, BeadKind, Wall};
use crate::settings::{FloatOrPercent, GcodeFlavor, Settings};
use crate::slice::planes::LayerZ;
use crate::support::{Strand, StrandKind};
use std::collections::BTreeMap;
use std::f64::consts::PI;

const ORIGIN: [i64; 3] = [100_000_400, 50_000_600, 77];

/// One move as a printer sees it.
#[derive(Clone, Debug, Default)]
struct Move {
    kind: String,
    width: String,
    height: String,
    fan: String,
    from: [f64; 3],
    to: [f64; 3],
    e: f64,
    feed: f64,
}

/// Everything between the first layer change and the user's end G-code.
fn read(text: &str) -> Result<Vec<Move>, String> {
    let (mut now, mut moves) = (Move::default(), Vec::new());
    let (mut absolute_e, mut e, mut printing) = (true, 0.0, false);
    for line in text.lines() {
        match line {
            ";LAYER_CHANGE" => printing = true,
            ";TYPE:Custom" if printing => break,
            "M83 ; use relative distances for extrusion" => absolute_e = false,
            "G92 E0" => e = 0.0,
            _ => {}
        }
        if let Some(kind) = line.strip_prefix(";TYPE:") {
            now.kind = kind.to_owned();
        }
        if let Some(width) = line.strip_prefix(";WIDTH:") {
            now.width = width.to_owned();
        }
        if let Some(height) = line.strip_prefix(";HEIGHT:") {
            now.height = height.to_owned();
        }
        if line == "M107" || line.starts_with("M106 ") {
            now.fan = line.to_owned();
        }
        let code = line.split(';').next().unwrap_or_default();
        let mut words = code.split_whitespace();
        if words.next() != Some("G1") || !printing {
            continue;
        }
        (now.from, now.e) = (now.to, 0.0);
        for word in words {
            let (letter, number) = word.split_at(1);
            let value: f64 = number.parse().map_err(|_| format!("{line}: {word}"))?;
            match letter {
                "X" => now.to[0] = value,
                "Y" => now.to[1] = value,
                "Z" => now.to[2] = value,
                "F" => now.feed = value,
                "E" => {
                    now.e = if absolute_e { value - e } else { value };
                    e += now.e;
                }
                _ => return Err(format!("{line}: {letter}")),
            }
        }
        if now.feed <= 0.0 {
            return Err(format!("{line}: no feed rate yet"));
        }
        moves.push(now.clone());
    }
    Ok(moves)
}

/// Holds a file against its plan; returns the filament of each role \[mm\].
fn verify(
    text: &str,
    layers: &[LayerPlan],
    settings: &Settings,
) -> Result<BTreeMap<&'static str, f64>, String> {
    let moves = read(text)?;
    let mut printed = moves.iter().filter(|m| m.from[..2] != m.to[..2] && m.e != 0.0);
    let mut read_e: BTreeMap<&str, f64> = BTreeMap::new();
    let mut planned_e: BTreeMap<&str, f64> = BTreeMap::new();
    let area = PI / 4.0 * settings.filament.filament_diameter.powi(2);
    let at = |p: Point2| [0, 1].map(|a| ([p.x, p.y][a] as i64 + ORIGIN[a]) as f64 / 1e6);
    for layer in layers {
        let z = f64::from(layer.print_z) / 1e6 + settings.printer.z_offset;
        for extrusion in &layer.extrusions {
            let name = extrusion.role.name();
            for w in layer.path(extrusion).windows(2) {
                let m = printed.next().ok_or("a line is missing")?;
                let place = format!("{m:?} for {:?} of {extrusion:?}", [at(w[0]), at(w[1])]);
                let off = |p: [f64; 3], q: [f64; 2]| (p[0] - q[0]).abs().max((p[1] - q[1]).abs());
                if off(m.from, at(w[0])).max(off(m.to, at(w[1]))) > 0.000_501 || (m.to[2] - z).abs() > 1e-9 {
                    return Err(format!("wrong place: {place}"));
                }
                let width: f64 = m.width.parse().map_err(|_| place.clone())?;
                let height: f64 = m.height.parse().map_err(|_| place.clone())?;
                let off = (width - extrusion.width).abs().max((height - extrusion.height).abs());
                if m.kind != name || off > 5.1e-6 {
                    return Err(format!("wrong role, width or height: {place}"));
                }
                let step = (extrusion.fan.unwrap_or(layer.fan) * 2.55).round();
                if m.fan != if step > 0.0 { format!("M106 S{step}") } else { "M107".to_owned() } {
                    return Err(format!("wrong fan speed, not {step}: {place}"));
                }
                if (m.feed - extrusion.speed * 60.0).abs() > 0.501 {
                    return Err(format!("wrong feed rate: {place}"));
                }
                let e =
                    w[0].distance(w[1]) / 1e6 * extrusion.mm3_per_mm * settings.filament.extrusion_multiplier
                        / area;
                if m.e <= 0.0 || (m.e - e).abs() > 2e-5 {
                    return Err(format!("wrong E, not {e}: {place}"));
                }
                *read_e.entry(name).or_default() += m.e;
                *planned_e.entry(name).or_default() += e;
            }
        }
    }
    if let Some(m) = printed.next() {
        return Err(format!("one line too many: {m:?}"));
    }
    // No drift: the sum agrees to the last step, and those of the roles but for what is carried over
    // half a step or less wherever the role changes.
    let total = |e: &BTreeMap<&str, f64>| e.values().sum::<f64>();
    if (total(&read_e) - total(&planned_e)).abs() > 1.01e-5 {
        return Err(format!("{} mm of filament, not {}", total(&read_e), total(&planned_e)));
    }
    let changes = text.matches(";TYPE:").count() as f64;
    for (name, planned) in &planned_e {
        let read: f64 = read_e[name];
        if (read - planned).abs() > 5e-6 * changes {
            return Err(format!("{name}: {read} mm of filament, not {planned}"));
        }
    }
    let r = &settings.retraction;
    let mut out = 0.0;
    for m in &moves {
        if m.from == m.to && m.e != 0.0 {
            out += m.e;
            if !((out + r.retract_length).abs() < 1e-6 || (out - r.retract_restart_extra).abs() < 1e-6) {
                return Err(format!("retracted by {out}: {m:?}"));
            }
            out = if m.e > 0.0 { 0.0 } else { out };
        } else if m.e != 0.0 && out != 0.0 {
            return Err(format!("extruding while retracted: {m:?}"));
        } else if m.e == 0.0 && m.from[..2] != m.to[..2] {
            let length = (m.to[0] - m.from[0]).hypot(m.to[1] - m.from[1]);
            let first = !moves.iter().take_while(|n| !std::ptr::eq(*n, m)).any(|n| n.e != 0.0);
            if !first && r.retract_length > 0.0 && length > r.retract_before_travel + 0.01 && out == 0.0 {
                return Err(format!("travel of {length} mm without retraction: {m:?}"));
            }
        }
    }
    Ok(read_e)
}

/// Squares with holes, circles and lines.
fn sample(settings: &Settings) -> Vec<LayerPlan> {
    let mut random = Random::new(3);
    let layer = |k: i32| {
        let mut islands: Vec<_> = (0..6)
            .map(|i| {
                let (x, y) = (i % 3 * 30_000_000 - 40_000_000, i / 3 * 30_000_000);
                let ring = |inset: i32| match i % 2 {
                    0 => rectangle(x + inset, y + inset, x + 22_000_123 - inset, y + 19_000_000 - inset),
                    _ => circle(x + 12_000_000, y + 12_000_000, 10_000_000 - inset, 60, 0.1),
                };
                let hole = |grow: i32| {
                    let mut ring = circle(x + 10_000_000, y + 10_000_000, 2_000_000 + grow, 17, 0.2);
                    ring.reverse();
                    ring
                };
                let walls: Vec<_> = (0..3)
                    .flat_map(|depth| {
                        let inset = 225_000 + depth as i32 * 407_000;
                        let outer = ring(inset);
                        let overhang =
                            if k > 0 { (0..outer.len()).map(|i| i % 3 == 1).collect() } else { Vec::new() };
                        [
                            Wall { ring: outer, depth, hole: false, overhang },
                            Wall { ring: hole(inset), depth, hole: true, overhang: Vec::new() },
                        ]
                    })
                    .collect();
                let bead = |y0: i32, kind| Bead {
                    points: (0..9).map(|j| Point2::new(x + j * 800_000, y + y0 + j % 3 * 90_000)).collect(),
                    widths: (0..9).map(|j| 250_000 + j * j % 5 * 90_000).collect(),
                    kind,
                };
                let mut closed = bead(17_000_000, BeadKind::ThinWall);
                closed.points = circle(x + 3_000_000, y + 3_000_000, 700_000, 8, 0.3);
                closed.points.push(closed.points[0]);
                let beads =
                    vec![bead(8_000_000, BeadKind::GapFill), bead(9_000_000, BeadKind::ThinWall), closed];
                let mut line = |kind| {
                    let mut at = |_| {
                        Point2::new(x + random.below(20_000_000) as i32, y + random.below(20_000_000) as i32)
                    };
                    let layers = if kind == FillKind::Sparse { 1 + k as u32 % 2 } else { 1 };
                    FillPath { points: (0..5).map(&mut at).collect(), kind, layers }
                };
                let fills = [
                    FillKind::Solid,
                    FillKind::Sparse,
                    FillKind::TopSolid,
                    FillKind::Bridge,
                    FillKind::Sparse,
                    FillKind::InternalBridge,
                ];
                PrintIsland { walls, fills: fills.into_iter().map(&mut line).collect(), beads }
            })
            .collect();
        islands.push(PrintIsland::default());
        let skirt = if k == 0 { vec![circle(0, 20_000_000, 80_000_000, 90, 0.0)] } else { Vec::new() };
        let z = LayerZ { slice_z: k * 200_000 + 100_000, print_z: (k + 1) * 200_000, height: 200_000 };
        PrintLayer { z, islands, skirt, ..PrintLayer::default() }
    };
    let layers: Vec<_> = (0..5).map(layer).collect();
    plan(&layers, Point2::new(-100_000_000, -50_000_000), settings)
}

fn written(layers: &[LayerPlan], settings: &Settings, texts: &Texts<'_>) -> (String, Summary) {
    let mut out = Vec::new();
    let summary = write(&mut out, layers, ORIGIN, settings, texts).unwrap_or_default();
    assert_eq!(summary.bytes, out.len() as u64);
    (String::from_utf8_lossy(&out).into_owned(), summary)
}

fn variants() -> Vec<Settings> {
    let mut all = vec![Settings::default(); 7];
    all[1].printer.use_relative_e_distances = true;
    all[2].retraction.retract_lift = 0.4;
    all[2].retraction.retract_restart_extra = 0.1;
    all[2].retraction.deretract_speed = 25.0;
    all[2].retraction.retract_layer_change = true;
    all[3].retraction.retract_length = 0.0;
    all[3].printer.z_offset = -0.05;
    (all[4].infill.thick_bridges, all[4].infill.bridge_flow_ratio) = (false, 0.87);
    all[4].output.gcode_comments = true;
    all[4].perimeters.external_perimeters_first = true;
    all[4].filament.extrusion_multiplier = 0.93;
    all[5].infill.infill_first = true;
    all[5].printer.gcode_flavor = GcodeFlavor::Klipper;
    all[5].cooling.slowdown_below_layer_time = 300.0;
    all[6].speed.max_volumetric_speed = 1.5;
    all[6].retraction.retract_before_travel = 0.0;
    all[6].speed.first_layer_speed = FloatOrPercent::Percent(40.0);
    all
}

#[test]
fn what_is_written_is_what_was_planned() {
    for (i, settings) in variants().iter().enumerate() {
        let layers = sample(settings);
        assert!(layers.iter().all(|l| l.extrusions.len() >= 6 * 10));
        let (text, summary) = written(&layers, settings, &Texts::default());
        let by_role = verify(&text, &layers, settings).unwrap_or_else(|e| panic!("variant {i}: {e}"));
        for role in Role::ALL {
            let read = by_role.get(role.name()).copied().unwrap_or_default();
            assert!((summary.role_mm[role.index()] - read).abs() < 1e-4, "variant {i}: {role:?}");
        }
        assert_eq!(by_role.len(), 9);
        let extra = summary.retractions.saturating_sub(1) as f64 * settings.retraction.retract_restart_extra;
        assert!((summary.filament_mm - by_role.values().sum::<f64>() - extra).abs() < 1e-4, "variant {i}");
        assert_eq!(text.matches(";LAYER_CHANGE").count(), 5);
    }
}

#[test]
fn faults_are_noticed() {
    let settings = Settings::default();
    let layers = sample(&settings);
    let (text, _) = written(&layers, &settings, &Texts::default());
    let line = text.lines().filter(|l| l.contains(" X") && l.contains(" E")).nth(200).unwrap_or_default();
    let word = |letter| line.split(' ').find(|w| w.starts_with(letter)).unwrap_or_default();
    let (x, e) = (word('X'), word('E'));
    for (fault, from, to) in [
        ("a lost line", line.to_owned(), String::new()),
        ("a moved point", line.to_owned(), line.replace(x, "X123.456")),
        ("another length", line.to_owned(), line.replace(e, &e.replacen('E', "E9", 1))),
        ("another role", ";TYPE:Solid infill".to_owned(), ";TYPE:Internal infill".to_owned()),
        ("another width", ";WIDTH:0.4\n".to_owned(), ";WIDTH:0.41\n".to_owned()),
        ("another height of a bead", ";HEIGHT:0.4\n".to_owned(), ";HEIGHT:0.41\n".to_owned()),
        ("another fan speed", "M106 S255\n".to_owned(), "M106 S25\n".to_owned()),
        ("a fan left on", "M107\nG1".to_owned(), "G1".to_owned()),
        ("a lost retraction", "G1 E-".to_owned(), "; G1 E-".to_owned()),
        ("another feed rate", " F1800".to_owned(), " F1900".to_owned()),
        ("another height", "G1 Z0.4".to_owned(), "G1 Z0.5".to_owned()),
    ] {
        assert!(text.contains(&from), "{fault}: {from}");
        let bad = text.replacen(&from, &to, 1);
        assert!(verify(&bad, &layers, &settings).is_err(), "{fault} went unnoticed");
    }
}

#[test]
fn absolute_and_relative_e_are_the_same_filament() {
    let mut settings = Settings::default();
    let layers = sample(&settings);
    let (_, absolute) = written(&layers, &settings, &Texts::default());
    settings.printer.use_relative_e_distances = true;
    let (_, relative) = written(&layers, &settings, &Texts::default());
    assert_eq!(absolute.filament_mm, relative.filament_mm);
    assert_eq!(absolute.role_mm, relative.role_mm);
}

#[test]
fn firmware_retraction_is_balanced() {
    let mut settings = Settings::default();
    settings.printer.use_firmware_retraction = true;
    let (text, summary) = written(&sample(&settings), &settings, &Texts::default());
    let commands: Vec<_> = text.lines().filter(|l| ["G10", "G11"].contains(l)).collect();
    assert!(commands.chunks(2).all(|c| c[0] == "G10" && c.get(1).is_none_or(|c| *c == "G11")));
    assert_eq!(commands.len() as u64, 2 * summary.retractions - 1);
    assert!(!text.contains("E-"));
}

#[test]
fn the_file_has_the_structure_that_hosts_expect() {
    let mut settings = Settings::default();
    settings.filament.first_layer_temperature = 215;
    settings.filament.first_layer_bed_temperature = 60;
    settings.filament.bed_temperature = 55;
    settings.filament.filament_density = 1.24;
    settings.filament.filament_cost = 25.0;
    settings.printer.gcode_flavor = GcodeFlavor::Klipper;
    let layers = sample(&settings);
    let config =
        [("layer_height", "0.2"), ("start_gcode", "G28\nG29")].map(|(k, v)| (k.to_owned(), v.to_owned()));
    let before = |l: LayerText| format!(";BEFORE_LAYER_CHANGE\n;{}", l.z);
    let after = |l: LayerText| format!(";AFTER {} {}\n", l.index, l.height);
    let texts = Texts {
        generator: "microtome 9.9.9",
        start: "G28\n",
        end: "M84\n",
        before_layer: &before,
        layer: &after,
        config: &config,
        ..Texts::default()
    };
    let (text, summary) = written(&layers, &settings, &texts);
    assert!(text.starts_with("; generated by microtome 9.9.9 on 1970-01-01 at 00:00:00 UTC\n"));
    let mut rest = text.as_str();
    for part in [
        "; first layer extrusion width = ",
        "\nM190 S60 ; ",
        "\nM104 S215 ; ",
        "\n;TYPE:Custom\nG28\nM109 S215 ; ",
        "\nG21 ; ",
        "\nG90 ; ",
        "\nM82 ; ",
        "\nG92 E0\n",
        "SET_PRINT_STATS_INFO TOTAL_LAYER=5\n",
        ";LAYER_CHANGE\n;Z:0.2\n;HEIGHT:0.2\nSET_PRINT_STATS_INFO CURRENT_LAYER=1\n",
        ";BEFORE_LAYER_CHANGE\n;0.2\nG1 Z0.2 F7800\n;AFTER 0 0.2\n",
        ";TYPE:Skirt/Brim\n;WIDTH:0.4\n",
        ";TYPE:Perimeter\n",
        ";TYPE:External perimeter\n",
        ";LAYER_CHANGE\n;Z:0.4\n;HEIGHT:0.2\n",
        "G1 Z0.4 F7800\n;AFTER 1 0.2\nM104 S200 ; set temperature\nM140 S55 ; set bed temperature\n",
        ";TYPE:Top solid infill\n;WIDTH:0.4\n",
        "G1 Z1 F7800\n",
        "\nM107\n;TYPE:Custom\nM84\n\n; filament used [mm] = ",
        "\n; filament used [cm3] = ",
        "\n; filament used [g] = ",
        "\n; filament cost = ",
        "\n; total filament used [g] = ",
        "\n; total layers count = 5\n",
        "\n; prusaslicer_config = begin\n; layer_height = 0.2\n; start_gcode = G28\\nG29\n; prusaslicer_config = end\n",
    ] {
        let Some(place) = rest.find(part) else { panic!("{part:?} is missing or out of place") };
        rest = &rest[place + part.len()..];
    }
    assert_eq!(rest, "");
    assert!(!text.contains("estimated printing time"));
    assert!(!text.contains("G1 E-") || text.find("G1 E-") > text.find(";TYPE:Skirt/Brim"));
    assert!((summary.filament_g - summary.filament_cm3 * 1.24).abs() < 1e-9);
    assert_eq!([summary.low[2], summary.high[2]], [0.2, 1.0]);
    assert!((summary.low[0] - 20.0).abs() < 0.01 && (summary.high[0] - 180.0).abs() < 0.01);
}

#[test]
fn start_gcode_with_temperatures_of_its_own_is_left_alone() {
    let mut settings = Settings::default();
    settings.filament.first_layer_bed_temperature = 60;
    let start = "M140 S70\nM104 S150\n";
    let (text, _) = written(&sample(&settings), &settings, &Texts { start, ..Texts::default() });
    assert!(!["M190", "M109", "M104 S200"].iter().any(|c| text.contains(c)));
}

#[test]
fn nothing_to_print_is_a_file_all_the_same() {
    let (text, summary) = written(&[], &Settings::default(), &Texts::default());
    assert!(text.contains("; total layers count = 0\n"));
    assert_eq!((summary.low, summary.high, summary.filament_mm), ([0.0; 3], [0.0; 3], 0.0));
    let empty = LayerPlan { print_z: 200_000, height: 200_000, ..LayerPlan::default() };
    let (text, _) = written(&[empty], &Settings::default(), &Texts::default());
    assert!(!text.contains("E-"));
}

/// A part with supports beside it: brim, columns and their dense layer, and a layer of these alone.
#[test]
fn supports_and_brim_as_text() {
    let mut settings = Settings::default();
    settings.cooling.cooling = false;
    settings.printer.use_relative_e_distances = true;
    let at = |points: &[(i32, i32)]| {
        points.iter().map(|&(x, y)| Point2::new(x * 1000 - 400, y * 1000 - 600)).collect()
    };
    let strand = |kind, closed, points: &[(i32, i32)]| Strand { points: at(points), closed, kind };
    let part = |k: i32| {
        let wall = Wall { ring: at(&[(0, 0), (4000, 0), (4000, 4000), (0, 4000)]), ..Wall::default() };
        PrintLayer {
            z: LayerZ { slice_z: k * 200_000 + 100_000, print_z: (k + 1) * 200_000, height: 200_000 },
            islands: vec![PrintIsland { walls: vec![wall], ..PrintIsland::default() }],
            ..PrintLayer::default()
        }
    };
    let sheath = strand(StrandKind::Base, true, &[(10_000, 0), (14_000, 0), (14_000, 4000), (10_000, 4000)]);
    let lines =
        strand(StrandKind::Base, false, &[(10_500, 1000), (13_500, 1000), (13_500, 3000), (10_500, 3000)]);
    let dense = strand(StrandKind::Interface, false, &[(10_000, 5000), (14_000, 5000)]);
    let first = PrintLayer {
        brim: vec![strand(
            StrandKind::Brim,
            true,
            &[(-1000, -1000), (5000, -1000), (5000, 5000), (-1000, 5000)],
        )],
        supports: vec![lines.clone(), sheath.clone()],
        support_height: 200_000,
        ..part(0)
    };
    let beside = PrintLayer {
        z: LayerZ { slice_z: 0, print_z: 498_000, height: 298_000 },
        supports: vec![dense.clone(), sheath, lines],
        support_height: 298_000,
        ..PrintLayer::default()
    };
    let both = PrintLayer { supports: vec![dense], support_height: 102_000, ..part(2) };
    let layers = plan(&[first, part(1), beside, both], Point2::default(), &settings);
    assert!(verify(&written(&layers, &settings, &Texts::default()).0, &layers, &settings).is_ok());
    let (text, _) = written(&layers, &settings, &Texts::default());
    let from = text.find(";LAYER_CHANGE").unwrap_or_default();
    let to = text.rfind(";TYPE:Custom").unwrap_or(text.len());
    assert_eq!(text[from..to].trim_end(), SUPPORTS_AS_TEXT.trim());
}

const SUPPORTS_AS_TEXT: &str = "
;LAYER_CHANGE
;Z:0.2
;HEIGHT:0.2
G1 Z0.2 F7800
G1 X99 Y50.001
;TYPE:Skirt/Brim
;WIDTH:0.4
G1 Y49 E0.02971 F1800
G1 X105 E0.17815
G1 Y55 E0.17814
G1 X99 E0.17815
G1 Y50.061 E0.14666
G1 E-2 F2400
G1 X110 F7800
;TYPE:Support material
;WIDTH:0.4
G1 E2 F2400
G1 Y50 E0.0018 F1800
G1 X114 E0.11876
G1 Y54 E0.11877
G1 X110 E0.11876
G1 Y50.121 E0.11519
G1 X110.5 Y51 F7800
G1 X113.5 E0.08907 F1800
G1 Y53 E0.05939
G1 X110.5 E0.08907
G1 E-2 F2400
G1 X104 Y54 F7800
;TYPE:External perimeter
;WIDTH:0.4
G1 E2 F2400
G1 X100 E0.11876 F1800
G1 Y50 E0.11877
G1 X104 E0.11876
G1 Y53.94 E0.11699
;LAYER_CHANGE
;Z:0.4
;HEIGHT:0.2
G1 Z0.4 F7800
G1 Y54
;TYPE:External perimeter
;WIDTH:0.42
G1 X100 E0.12542 F900
G1 Y50 E0.12541
G1 X104 E0.12542
G1 Y53.94 E0.12354
;LAYER_CHANGE
;Z:0.498
;HEIGHT:0.298
G1 Z0.498 F7800
G1 E-2 F2400
G1 X110 F7800
;TYPE:Support material
;WIDTH:0.4
G1 E2 F2400
G1 Y50 E0.16404 F3600
G1 X114 E0.16653
G1 Y54 E0.16654
G1 X110 E0.16654
G1 X110.5 Y53 F7800
G1 X113.5 E0.1249 F3600
G1 Y51 E0.08327
G1 X110.5 E0.1249
G1 E-2 F2400
G1 X110 Y55 F7800
;TYPE:Support material interface
;WIDTH:0.4
G1 E2 F2400
G1 X114 E0.16654 F3600
;LAYER_CHANGE
;Z:0.6
;HEIGHT:0.2
G1 Z0.6 F7800
;TYPE:Support material interface
;WIDTH:0.4
;HEIGHT:0.102
G1 X110 E0.06414 F3600
G1 E-2 F2400
G1 X104 Y54 F7800
;TYPE:External perimeter
;WIDTH:0.42
;HEIGHT:0.2
G1 E2 F2400
G1 X100 E0.12542 F900
G1 Y50 E0.12541
G1 X104 E0.12542
G1 Y53.94 E0.12354
G1 E-2 F2400
M107
";
