//! The built-in demo part: one small print that shows what a slicer must cope with.

use super::Mesh;
use super::shapes::{cuboid, holed_plate, merge, moved, prism, revolve, upright};
use std::f64::consts::TAU;

/// A part of 60 x 40 x 30 mm on z = 0: a plate with a vertical hole that carries a dome, an arch with a
/// bridge and a horizontal hole, a leaning arm with a 45 degree overhang and a stair under it, four thin
/// fins, and the letter m raised on the plate.
///
/// Its shells overlap; the part is their union by the non-zero rule. Each shell is closed and faces
/// outwards. Heights are chosen off the usual layer planes.
pub fn demo_part() -> Mesh {
    let top = 3.07;
    // Everything that stands on the plate is sunk into it a little, so that the union is one body.
    let foot = top - 0.83;
    let mut parts = vec![
        holed_plate([0.0, 0.0], [60.0, 40.0], [10.0, 10.0], 4.0, 96, [0.0, top]),
        moved(dome(9.0, 144, 40), [28.0, 11.0, foot]),
    ];
    // The arch: its back pillar carries a horizontal hole, its beam bridges 14 mm of air.
    let pillar = holed_plate([2.0, foot], [14.0, 22.13], [8.0, 13.0], 3.0, 96, [-38.0, -30.0]);
    parts.push(upright(&pillar));
    parts.push(cuboid([28.0, 30.0, foot], [33.0, 38.0, 22.13]));
    parts.push(cuboid([2.0, 30.0, 19.03], [33.0, 38.0, 22.13]));
    // The arm: leans out at 45 degrees, then 8 mm of stair whose steps overhang 2 mm each.
    let arm = [
        [44.0, foot],
        [50.0, foot],
        [50.0, 17.91],
        [55.0, 22.91],
        [55.0, 25.07],
        [57.0, 25.07],
        [57.0, 27.47],
        [59.0, 27.47],
        [59.0, 30.0],
        [44.0, 30.0],
    ];
    parts.push(upright(&prism(&arm, -38.0, -28.0)));
    for (k, thickness) in [0.8, 1.0, 1.2, 1.6].into_iter().enumerate() {
        let x = 42.0 + 4.0 * k as f64;
        parts.push(cuboid([x, 3.0, foot], [x + thickness, 17.0, 12.07 + 1.1 * k as f64]));
    }
    parts.push(moved(letter_m(0.9), [41.5, 19.5, foot]));
    merge(&parts)
}

/// Half a sphere on its flat side.
fn dome(radius: f64, around: usize, rings: usize) -> Mesh {
    let mut profile = vec![[0.0, 0.0]];
    for k in 0..=rings {
        let angle = TAU / 4.0 * k as f64 / rings as f64;
        let r = if k == rings { 0.0 } else { radius * libm::cos(angle) };
        profile.push([r, radius * libm::sin(angle)]);
    }
    revolve(&profile, around)
}

/// The letter m in strokes of 1.6 mm, raised by 0.6 mm above a plate it is sunk 0.83 mm into.
fn letter_m(scale: f64) -> Mesh {
    let outline = [
        [0.0, 0.0],
        [1.8, 0.0],
        [1.8, 5.2],
        [2.6, 6.2],
        [3.8, 6.2],
        [4.4, 5.4],
        [4.4, 0.0],
        [6.2, 0.0],
        [6.2, 5.2],
        [7.0, 6.2],
        [8.2, 6.2],
        [8.8, 5.4],
        [8.8, 0.0],
        [10.6, 0.0],
        [10.6, 6.0],
        [9.2, 8.0],
        [6.9, 8.0],
        [5.6, 6.9],
        [4.6, 8.0],
        [2.9, 8.0],
        [1.8, 7.0],
        [1.8, 8.0],
        [0.0, 8.0],
    ];
    let outline: Vec<[f64; 2]> = outline.iter().map(|p| p.map(|c| c * scale)).collect();
    prism(&outline, 0.0, 1.43)
}
