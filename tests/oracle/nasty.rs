//! Random areas that are hard to move inwards, and distances at which they are hardest.

use crate::bodies::Random;
use microtome::contour::{ExPolygon, Ring};
use microtome::lattice::Point2;
use microtome::region::boolean::{Winding, difference, union};

const MM: i32 = 1_000_000;

/// An area and how far it is to be moved \[nm\].
pub struct Case {
    pub kind: &'static str,
    pub areas: Vec<ExPolygon>,
    pub distance: i64,
}

/// The case of a seed.
pub fn case(seed: u64) -> Case {
    let random = &mut Random::new(seed);
    let any = |random: &mut Random| 20_000 + random.below(780_000) as i64;
    let (kind, areas, distance) = match random.below(10) {
        0 => ("crossing rings", united(&mess(random, 1)), any(random)),
        1 => {
            // Corners on a grid, moved by parts of it: fronts meet exactly, everywhere at once.
            let grid = MM / 4 * (1 + random.below(3) as i32);
            (
                "crossing rings on a grid",
                united(&mess(random, grid)),
                i64::from(grid) / (1 + random.below(4) as i64),
            )
        }
        2 => ("blob", united(&[blob(random)]), any(random)),
        3 => {
            let grid = 200_000 * (1 + random.below(4) as i32);
            let off = [0, 0, 1, -1, 777][random.below(5) as usize];
            (
                "rectangles on a grid",
                rectangles(random, grid),
                i64::from(grid) * (1 + random.below(3) as i64) / 2 + off,
            )
        }
        4 => ("comb", united(&[comb(random)]), any(random) / 2),
        5 => ("star", united(&[star(random)]), any(random)),
        6 => {
            let (areas, wall) = walls(random);
            let off = random.within(3_000);
            ("thin walls", areas, i64::from(wall / 2 + off).max(1))
        }
        7 => ("plate with holes", plate(random), any(random)),
        8 => ("noise", united(&[noise(random)]), any(random)),
        _ => {
            // What an inset leaves, once more: slivers, corners that just met.
            let first = united(&mess(random, 1));
            let d = any(random) / 2;
            ("inset of an inset", microtome::region::offset::inset(&first, d), d)
        }
    };
    Case { kind, areas, distance }
}

fn united(rings: &[Ring]) -> Vec<ExPolygon> {
    union(rings, Winding::NonZero)
}

fn polar(radius: f64, turn: f64) -> Point2 {
    let (s, c) = (turn * std::f64::consts::TAU).sin_cos();
    Point2::new((1e6 * radius * c) as i32, (1e6 * radius * s) as i32)
}

fn unit(random: &mut Random) -> f64 {
    random.below(1 << 20) as f64 / f64::from(1 << 20)
}

/// A few rings that cross themselves and each other.
fn mess(random: &mut Random, grid: i32) -> Vec<Ring> {
    (0..1 + random.below(3))
        .map(|_| {
            let corners = 3 + random.below(14);
            let mut c = || random.within(6 * MM) / grid * grid;
            (0..corners).map(|_| Point2::new(c(), c())).collect()
        })
        .collect()
}

/// A round shape with ripples of many short edges.
fn blob(random: &mut Random) -> Ring {
    let (n, a, k) = (20 + random.below(400), 0.5 + 5.0 * unit(random), 2 + random.below(12));
    let depth = 0.9 * unit(random);
    (0..n)
        .map(|i| {
            let turn = i as f64 / n as f64;
            polar(a * (1.0 + depth * (turn * k as f64 * std::f64::consts::TAU).sin()), turn)
        })
        .collect()
}

fn rectangle(x: i32, y: i32, w: i32, h: i32) -> Ring {
    [(x, y), (x + w, y), (x + w, y + h), (x, y + h)].map(|(x, y)| Point2::new(x, y)).to_vec()
}

fn rectangles(random: &mut Random, grid: i32) -> Vec<ExPolygon> {
    let some = |n: u64, random: &mut Random| -> Vec<Ring> {
        (0..n)
            .map(|_| {
                let mut c = |bound: u64| random.below(bound) as i32 * grid;
                let (x, y, w, h) = (c(20), c(20), c(8) + grid, c(8) + grid);
                rectangle(x, y, w, h)
            })
            .collect()
    };
    let n = 2 + random.below(12);
    let solid = united(&some(n, random));
    let m = random.below(8);
    difference(&solid, &united(&some(m, random)))
}

fn comb(random: &mut Random) -> Ring {
    let teeth = 2 + random.below(15) as i32;
    let (long, wide) = (MM + random.below(8) as i32 * MM, 200_000 + random.below(1_500_000) as i32);
    let gap = 50_000 + random.below(1_000_000) as i32;
    let tip = random.below(wide as u64 + 1) as i32;
    let pitch = wide + gap;
    let mut ring = vec![(0, -2 * MM), (teeth * pitch, -2 * MM)];
    for k in (0..teeth).rev() {
        let (x, lean) = (k * pitch, random.within(300_000));
        ring.extend([(x + wide, 0), (x + (wide + tip) / 2 + lean, long)]);
        if tip > 0 {
            ring.push((x + (wide - tip) / 2 + lean, long));
        }
        ring.push((x, 0));
    }
    ring.into_iter().map(|(x, y)| Point2::new(x, y)).collect()
}

fn star(random: &mut Random) -> Ring {
    let points = 3 + random.below(30);
    let (inner, outer) = (0.05 + 2.0 * unit(random), 2.0 + 5.0 * unit(random));
    (0..2 * points)
        .map(|i| {
            let wobble = 0.8 + 0.4 * unit(random);
            polar(wobble * if i % 2 == 0 { outer } else { inner }, i as f64 / (2 * points) as f64)
        })
        .collect()
}

/// Walls of even thickness, straight, bent or round, and that thickness \[nm\].
fn walls(random: &mut Random) -> (Vec<ExPolygon>, i32) {
    let wall = 300_000 + random.below(900_000) as i32;
    if random.below(2) == 0 {
        let n = [4, 6, 12, 60, 300][random.below(5) as usize];
        let radius = 2.0 + 6.0 * unit(random);
        let phase = unit(random);
        let ring = |r: f64| (0..n).map(|i| polar(r, phase + f64::from(i) / f64::from(n))).collect::<Ring>();
        let thick = f64::from(wall) / 1e6;
        return (difference(&united(&[ring(radius)]), &united(&[ring(radius - thick)])), wall);
    }
    let rooms = 1 + random.below(4) as i32;
    let side = 2 * MM + random.below(4_000_000) as i32;
    let outer = rectangle(0, 0, rooms * side + wall, side + wall);
    let holes: Vec<Ring> =
        (0..rooms).map(|k| rectangle(k * side + wall, wall, side - wall, side - wall)).collect();
    (difference(&united(&[outer]), &united(&holes)), wall)
}

fn plate(random: &mut Random) -> Vec<ExPolygon> {
    let side = 4 * MM + random.below(12_000_000) as i32;
    let holes: Vec<Ring> = (0..random.below(40))
        .map(|_| {
            let (x, y) = (random.below(side as u64) as i32, random.below(side as u64) as i32);
            let (n, r) = (3 + random.below(30), 0.05 + unit(random));
            (0..n).map(|i| polar(r, i as f64 / n as f64)).map(|p| Point2::new(p.x + x, p.y + y)).collect()
        })
        .collect();
    difference(&united(&[rectangle(0, 0, side, side)]), &united(&holes))
}

/// An outline whose every corner is off by a little, and some by much: a scan.
fn noise(random: &mut Random) -> Ring {
    let (n, radius) = (100 + random.below(500), 1.0 + 5.0 * unit(random));
    let rough = 0.3 * unit(random) * unit(random);
    (0..n)
        .map(|i| {
            let spike = if random.below(50) == 0 { 0.5 } else { 0.0 };
            polar(radius + rough * (unit(random) - 0.5) + spike * unit(random), i as f64 / n as f64)
        })
        .collect()
}
