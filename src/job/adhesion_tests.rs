#![allow(clippy::unwrap_used)]

use super::*;
use crate::lattice::nm;
use crate::support::{StrandKind, SupportLayer};

fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Ring {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(nm(x) as i32, nm(y) as i32)).to_vec()
}

/// Five layers of a block of 20 mm x 10 mm, 0.2 mm each, on top of `part_z`.
fn block(part_z: i32) -> (Vec<Vec<Island>>, Vec<LayerZ>) {
    let outline = ExPolygon { contour: rectangle(0.0, 0.0, 20.0, 10.0), holes: Vec::new() };
    let islands = vec![vec![Island { outline, ..Island::default() }]; 5];
    let z = (1..=5).map(|i| LayerZ { slice_z: 1, print_z: part_z + i * 200_000, height: 200_000 });
    (islands, z.collect())
}

fn strand(points: Ring) -> Strand {
    Strand { points, closed: true, kind: StrandKind::Base }
}

/// A column that reaches to x = 40 mm at a height.
fn column(print_z: i32) -> Supports {
    Supports {
        layers: vec![SupportLayer { print_z, height: 100_000, ..SupportLayer::default() }],
        strands: vec![vec![strand(rectangle(30.0, 0.0, 40.0, 10.0))]],
        ..Supports::default()
    }
}

fn right_end(rings: &[Ring]) -> f64 {
    rings.iter().flatten().map(|p| lattice::mm(p.x)).fold(f64::MIN, f64::max)
}

fn settings(values: &[(&str, &str)]) -> Settings {
    let mut s = Settings::default();
    for (key, value) in values {
        s.set(key, value).unwrap();
    }
    s
}

fn skirt_of(beside: &Supports, values: &[(&str, &str)]) -> (Vec<Ring>, Vec<Strand>) {
    let (islands, z) = block(0);
    skirt_and_brim(&islands, &z, beside, &settings(values))
}

#[test]
fn the_skirt_goes_around_what_stands_on_its_layers() {
    let spacing = flow(&Settings::default()).spacing();
    let alone = right_end(&skirt_of(&Supports::default(), &[]).0);
    assert!((alone - (20.0 + 6.0 + 0.5 * spacing)).abs() < 1e-3);
    // Supports count with their beads.
    let beside = right_end(&skirt_of(&column(200_000), &[]).0);
    assert!((beside - (40.0 + 0.5 * spacing + 6.0 + 0.5 * spacing)).abs() < 0.02);
    // Not those above it, unless it is as high.
    assert_eq!(right_end(&skirt_of(&column(500_000), &[]).0), alone);
    assert_eq!(right_end(&skirt_of(&column(500_000), &[("skirt_height", "2")]).0), alone);
    assert_eq!(right_end(&skirt_of(&column(500_000), &[("skirt_height", "3")]).0), beside);
    assert_eq!(right_end(&skirt_of(&column(500_000), &[("draft_shield", "limited")]).0), alone);
    assert_eq!(right_end(&skirt_of(&column(500_000), &[("draft_shield", "enabled")]).0), beside);
}

#[test]
fn the_skirt_goes_around_the_brim_but_a_shield_through_it() {
    let own = flow(&Settings::default());
    let count = (8.0 / own.spacing()).floor();
    let (skirt, brim) = skirt_of(&Supports::default(), &[("brim_width", "8")]);
    let end = 20.0 + count * own.spacing() + 6.0 + 0.5 * own.spacing();
    assert!((right_end(&skirt) - end).abs() < 0.02, "{} for {end}", right_end(&skirt));
    assert_eq!(brim.len(), count as usize);
    let (skirt, brim) = skirt_of(&Supports::default(), &[("brim_width", "8"), ("draft_shield", "limited")]);
    let shield = 20.0 + 6.0 + 0.5 * own.spacing();
    assert!((right_end(&skirt) - shield).abs() < 1e-3);
    // Some of the brim's lines have made room.
    assert!((count as usize - 3..count as usize).contains(&brim.len()), "{}", brim.len());
    // On the part's right side.
    let beside = |p: &&Point2| p.x > 20_000_000 && (0..=10_000_000).contains(&p.y);
    let clear = |p: &Point2| (lattice::mm(p.x) - shield).abs() > 0.9 * own.spacing();
    assert!(brim.iter().flat_map(|s| &s.points).filter(beside).all(clear));
}

#[test]
fn a_raft_has_no_brim_and_no_brim_is_none() {
    let wants = |values: &[(&str, &str)]| has_brim(&settings(values));
    assert!(wants(&[("brim_width", "5")]));
    assert!(!wants(&[("brim_width", "5"), ("raft_layers", "1")]));
    assert!(!wants(&[("brim_width", "5"), ("brim_type", "no_brim")]));
    assert!(!wants(&[]));
}

/// Raft layers of 0.2 and 0.3 mm, a column's layer between those of the part, and the part 0.1 mm above.
fn print() -> Vec<PrintLayer> {
    let alone = |print_z, height| PrintLayer {
        z: LayerZ { slice_z: 0, print_z, height },
        supports: vec![strand(rectangle(0.0, 0.0, 9.0, 9.0))],
        support_height: height,
        ..PrintLayer::default()
    };
    let part = |print_z| PrintLayer {
        z: LayerZ { slice_z: 100_000, print_z, height: 200_000 },
        ..PrintLayer::default()
    };
    let z = [800_000, 1_000_000, 1_200_000];
    vec![
        alone(200_000, 200_000),
        alone(500_000, 300_000),
        part(z[0]),
        alone(900_000, 250_000),
        part(z[1]),
        part(z[2]),
    ]
}

#[test]
fn beads_of_the_skirt_lie_upon_each_other() {
    let skirt = [rectangle(-5.0, -5.0, 20.0, 20.0)];
    let heights = |values: &[(&str, &str)]| {
        let mut layers = print();
        lay_skirt(&mut layers, &skirt, 500_000, &settings(values));
        layers.iter().map(|l| if l.skirt.is_empty() { 0 } else { l.skirt_height }).collect::<Vec<_>>()
    };
    assert_eq!(heights(&[]), [200_000, 0, 0, 0, 0, 0]);
    let whole = [200_000, 300_000, 300_000, 0, 200_000, 200_000];
    assert_eq!(heights(&[("draft_shield", "enabled")]), whole);
    // Layers of columns do not count.
    let four = [200_000, 300_000, 300_000, 0, 200_000, 0];
    assert_eq!(heights(&[("draft_shield", "limited"), ("skirt_height", "4")]), four);
    assert_eq!(heights(&[("skirt_height", "4")]), four);
    let mut none = print();
    lay_skirt(&mut none, &[], 500_000, &settings(&[("skirt_height", "9")]));
    assert_eq!(none, print());
}

#[test]
fn what_leaves_the_bed_is_named_once() {
    let origin = [100_000_000, 100_000_000, 0];
    let (islands, z) = block(0);
    let say = |beside: Supports, bed: &str, values: &[(&str, &str)]| {
        let s = settings(&[values, &[("bed_shape", bed)]].concat());
        let (skirt, brim) = skirt_and_brim(&islands, &z, &beside, &s);
        beyond_bed(&skirt, &Supports { brim, ..beside }, origin, &s)
    };
    // The part lies from 100 to 120 mm, its skirt to nearly 127 mm.
    let own = flow(&Settings::default());
    let skirt = format!("the skirt reaches {:.2} mm", 1.0 + 0.5 * (own.spacing() + own.width));
    assert_eq!(say(Supports::default(), "0x0,200x0,200x200,0x200", &[]), None);
    assert_eq!(say(Supports::default(), "0x0,127x0,127x200,0x200", &[]), None);
    let text = say(Supports::default(), "0x0,125x0,125x200,0x200", &[]).unwrap();
    assert!(text.starts_with(&skirt), "{text}");
    // The same bed the other way round.
    let text = say(Supports::default(), "0x0,0x200,125x200,125x0", &[]).unwrap();
    assert!(text.starts_with(&skirt), "{text}");
    let brim = say(Supports::default(), "0x0,125x0,125x200,0x200", &[("brim_width", "8"), ("skirts", "0")]);
    assert!(brim.as_ref().unwrap().starts_with("the brim reaches 2."), "{brim:?}");
    let supports = say(column(200_000), "0x0,130x0,130x200,0x200", &[("skirts", "0")]).unwrap();
    assert!(supports.starts_with("supports reach 10."), "{supports}");
    let raft =
        say(column(200_000), "0x0,130x0,130x200,0x200", &[("skirts", "0"), ("raft_layers", "1")]).unwrap();
    assert!(raft.starts_with("the raft reaches 10."), "{raft}");
    // A box may have corners beyond a bed that all its points lie on.
    assert_eq!(say(Supports::default(), "60x105,110x55,160x105,110x155", &[]), None);
    assert!(say(Supports::default(), "100x105,110x85,120x105,110x125", &[]).is_some());
}
