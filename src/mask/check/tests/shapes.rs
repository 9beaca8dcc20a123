//! Shapes made by hand.

use super::*;

fn settings() -> CheckSettings {
    CheckSettings { reach_mm: 0.05, ..CheckSettings::default() }
}

/// Counts of islands, cups, trapped voids.
fn counts(f: &Findings) -> [u64; 3] {
    [f.islands.count, f.cups.count, f.trapped.count]
}

fn square(half: i32) -> impl Fn(i32, i32) -> bool {
    move |x, y| (x - 15).abs().max((y - 15).abs()) <= half
}

#[test]
fn a_hollow_ball_traps_resin_unless_it_drains() {
    let shell = |x: i32, y: i32, z: i32| {
        let d = (x - 15).pow(2) + (y - 15).pow(2) + (z - 14).pow(2);
        (81..=196).contains(&d)
    };
    let closed = Stack::solid(panel(31, 31), 31, shell);
    let found = closed.check(CheckSettings { reach_mm: 1.0, ..settings() }, 7);
    assert_eq!(counts(&found), [0, 0, 1]);
    let void = &found.trapped.listed[0];
    assert_eq!((void.fate, void.first_layer, void.last_layer), (Fate::Closed, 6, 22));
    assert_eq!(void.greatest_layer, 14);
    let inside = (0..31).flat_map(|z| (0..31).flat_map(move |y| (0..31).map(move |x| (x, y, z))));
    let pixels =
        inside.filter(|(x, y, z)| (x - 15i32).pow(2) + (y - 15i32).pow(2) + (z - 15i32).pow(2) < 81).count();
    let expected = pixels as f64 * 0.03 * 0.05 * HEIGHT * 1e-3;
    assert!((void.volume_ml - expected).abs() < 1e-12, "{} for {expected}", void.volume_ml);
    assert!((void.centre_mm[0] - 15.5 * 0.03).abs() < 1e-9 && (void.centre_mm[1] - 15.5 * 0.05).abs() < 1e-9);
    // A bore at the widest layer: a cup up to the layer beneath it, and nothing from there on.
    let bored = Stack::solid(panel(31, 31), 31, |x, y, z| shell(x, y, z) && !(z == 14 && y == 15 && x < 15));
    let found = bored.check(CheckSettings { reach_mm: 1.0, ..settings() }, 100);
    assert_eq!(counts(&found), [0, 1, 0]);
    let cup = &found.cups.listed[0];
    assert_eq!((cup.fate, cup.first_layer, cup.last_layer), (Fate::Opened, 6, 13));
    assert!(found.layers[13].sealed_mm2 > 0.0 && found.layers[14].sealed_mm2 == 0.0);
    // A bore down to the plate does not drain: the plate closes it.
    let down = |x, y, z| shell(x, y, z + 3) && !(z < 5 && x == 15 && y == 15);
    let found = Stack::solid(panel(31, 31), 31, down).check(settings(), 4);
    assert_eq!(found.trapped.listed[0].first_layer, 0);
}

#[test]
fn cups_and_tubes() {
    let wall = |x, y| square(10)(x, y) && !square(7)(x, y);
    // A mug that stands: open at the top, where the film closes it.
    let up = Stack::solid(panel(31, 31), 10, |x, y, z| if z < 3 { square(10)(x, y) } else { wall(x, y) });
    let found = up.check(settings(), 3);
    assert_eq!(counts(&found), [0, 1, 0]);
    let cup = &found.cups.listed[0];
    assert_eq!((cup.fate, cup.first_layer, cup.last_layer, cup.greatest_layer), (Fate::Top, 3, 9, 3));
    assert!((cup.greatest_area_mm2 - 225.0 * 0.0015).abs() < 1e-9);
    assert!((found.layers[9].peel_mm2 - 441.0 * 0.0015).abs() < 1e-9);
    // Upside down the plate is its lid: trapped, the roof hangs.
    let down = Stack::solid(panel(31, 31), 10, |x, y, z| if z > 6 { square(10)(x, y) } else { wall(x, y) });
    let found = down.check(settings(), 3);
    assert_eq!(counts(&found), [0, 0, 1]);
    assert_eq!((found.trapped.listed[0].first_layer, found.trapped.listed[0].last_layer), (0, 6));
    assert!(found.layers[7].overhang_mm2 > 0.2 && found.layers[8].overhang_mm2 == 0.0);
    assert_eq!(found.overhang_marks.layer, 7);
    // A tube on feet is open below.
    let raised = Stack::solid(panel(31, 31), 10, |x, y, z| wall(x, y) && (z > 1 || (x - 15).abs() > 5));
    assert_eq!(raised.check(settings(), 3).cups.count, 0);
    // A tube on the plate is sealed all the way; equal layers take the short way.
    let tube = Stack::solid(panel(31, 31), 10, |x, y, _| wall(x, y));
    let found = tube.check(settings(), 4);
    assert_eq!((counts(&found), found.cups.listed[0].last_layer), ([0, 1, 0], 9));
    let volume = 225.0 * 0.0015 * 10.0 * HEIGHT * 1e-3;
    assert!((found.cups.listed[0].volume_ml - volume).abs() < 1e-12);
}

#[test]
fn islands_and_overhangs() {
    // A post with a flag that starts in the air and is joined later.
    let stack = Stack::solid(panel(31, 31), 10, |x, y, z| {
        let post = (3..6).contains(&x) && (3..6).contains(&y);
        let flag = (20..24).contains(&x) && (10..12).contains(&y) && z >= 5;
        let beam = z == 8 && (3..24).contains(&x) && (3..12).contains(&y);
        post || flag || beam
    });
    let found = stack.check(settings(), 2);
    assert_eq!(counts(&found), [1, 0, 0]);
    let island = &found.islands.listed[0];
    assert_eq!((island.layer, island.pixels), (5, 8));
    assert!((island.z_mm - 6.0 * HEIGHT).abs() < 1e-9);
    assert!((island.centre_mm[0] - 22.0 * 0.03).abs() < 1e-9);
    assert!((island.centre_mm[1] - (31.0 - 11.0) * 0.05).abs() < 1e-9);
    assert!((island.area_mm2 - 8.0 * 0.0015).abs() < 1e-12);
    assert!(found.layers[5].islands == 1 && found.layers[6].islands == 0 && found.layers[5].parts == 2);
    assert!(found.layers[8].islands == 0 && found.layers[8].overhang_mm2 > 0.1);
    // A T: its bar hangs but is no island. Nothing below at all: an island.
    let bar = |x: i32, y: i32, z: i32| {
        if z < 5 { z != 3 && square(1)(x, y) } else { (y - 15).abs() < 2 }
    };
    let found = Stack::solid(panel(31, 31), 7, bar).check(settings(), 3);
    assert_eq!((counts(&found), found.islands.listed[0].layer), ([1, 0, 0], 4));
    // Within reach counts as supported, beyond does not: columns are 0.03 mm apart.
    let step = |d: i32| Stack::solid(panel(31, 31), 2, move |x, y, z| [x, y] == [3 + d * z, 9]);
    assert_eq!([0, 1, 2].map(|d| step(d).check(settings(), 9).islands.count), [0, 0, 1]);
}

#[test]
fn parts_that_merge_make_one_void() {
    // Two chambers, joined in layer 4, closed from layer 6 on.
    let stack = Stack::solid(panel(31, 31), 8, |x, y, z| {
        let room = |at: i32| (x - at).abs() <= 2 && (y - 15).abs() <= 2;
        let hollow = (1..6).contains(&z) && (room(10) || room(20));
        let door = (4..6).contains(&z) && y == 15 && (10..20).contains(&x);
        square(12)(x, y) && !hollow && !door
    });
    let found = stack.check(settings(), 5);
    assert_eq!(counts(&found), [0, 0, 1]);
    let void = &found.trapped.listed[0];
    assert_eq!((void.first_layer, void.last_layer, void.greatest_layer), (1, 5, 4));
    assert!((void.greatest_area_mm2 - 55.0 * 0.0015).abs() < 1e-9);
    assert!(void.marks.sealed.iter().all(|(_, number)| found.fates.is_trapped(*number)));
}

#[test]
fn the_place_on_the_plate_does_not_depend_on_the_panel() {
    // One pixel of plate, 30 x 50 um in landscape, in the middle of plate pixel (20, 4) counted from
    // the lower left; portrait exchanges the plate's axes.
    let base = panel(31, 21);
    for i in 0..8 {
        let (mirror_x, mirror_y, portrait) = (i & 1 > 0, i & 2 > 0, i & 4 > 0);
        let panel = Panel { mirror_x, mirror_y, portrait, ..base };
        let x = if mirror_x { 30 - 20 } else { 20 };
        let y = if mirror_y { 4 } else { 20 - 4 };
        let found = Stack::solid(panel, 2, |px, py, z| z == 1 && [px, py] == [x, y]).check(settings(), 2);
        let [a, b] = found.islands.listed[0].centre_mm;
        let expected = if portrait { [4.5 * 0.05, 20.5 * 0.03] } else { [20.5 * 0.03, 4.5 * 0.05] };
        assert!((a - expected[0]).abs() < 1e-9 && (b - expected[1]).abs() < 1e-9, "{panel:?}: {a} {b}");
        let [x0, y0, x1, y1] = found.islands.listed[0].bounds_mm;
        assert!(x0 < a && a < x1 && y0 < b && b < y1);
    }
}

#[test]
fn lists_are_bounded_and_counts_complete() {
    let dots = |x: i32, y: i32, z: i32| z > 0 && x % 4 == 0 && y % 4 == 0 && x < 4 * z;
    let found = Stack::solid(panel(31, 31), 3, dots).check(CheckSettings { listed: 3, ..settings() }, 2);
    // One column of eight dots in layer 1, a second in layer 2.
    assert_eq!((found.islands.count, found.islands.listed.len()), (16, 3));
    assert!(found.islands.listed.iter().all(|i| i.layer == 1));
    assert!((found.islands.total - 16.0 * 0.0015).abs() < 1e-9);
    // Nothing at all, an empty layer, and faint greys.
    assert!(Checker::new(panel(4, 4), settings()).finish().layers.is_empty());
    let faint = Stack::new(panel(5, 5), 3, |_, _, z| if z == 1 { 90 } else { 0 }).check(settings(), 1);
    assert_eq!(counts(&faint), [0; 3]);
    assert!(faint.layers[1].area_mm2 > 0.0 && faint.layers[1].parts == 0 && faint.volume_ml > 0.0);
}
