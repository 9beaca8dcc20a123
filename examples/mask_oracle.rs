//! Holds every layer's mask of a model against a plain scan of its contours, and its area against the
//! contours' own.
//!
//! cargo run --release --example mask_oracle -- MODEL.stl [PRINTER [SUB_ROWS [LAYER_HEIGHT]]]
//!
//! The oracle shares neither the sections (it takes the traced contours) nor the scan (it computes every
//! crossing by itself in 128-bit integers, row by row, and sorts it into a list) nor the pixel rule (it
//! walks from centre to centre) with the code that it judges.
#![allow(clippy::unwrap_used, clippy::print_stdout, missing_docs)]

use microtome::contour::{self, TraceOptions};
use microtome::lattice::{self, Point2};
use microtome::mask::Panel;
use microtome::mask::antialias::Shading;
use microtome::mask::raster::{Painter, Raster};
use microtome::mesh::{self, Adjacency, Placement};
use microtome::resin::{machine, schedule};
use microtome::settings::{SlicingSettings, printers};
use microtome::slice::planes::plane_zs;
use microtome::slice::section::Sections;
use rayon::prelude::*;
use std::cmp::Ordering;
use std::sync::Arc;

/// A side of a ring from its lower to its upper end, and whether the ring runs upwards there.
#[derive(Clone, Copy)]
struct Side {
    low: Point2,
    high: Point2,
    up: bool,
}

/// The sides that are not level, by their lower ends.
fn sloping(rings: &[Vec<Point2>]) -> Vec<Side> {
    let side = |[a, b]: [Point2; 2]| match a.y.cmp(&b.y) {
        Ordering::Less => Some(Side { low: a, high: b, up: true }),
        Ordering::Greater => Some(Side { low: b, high: a, up: false }),
        Ordering::Equal => None,
    };
    let mut found: Vec<Side> = sides(rings).into_iter().filter_map(side).collect();
    found.sort_unstable_by_key(|s| s.low.y);
    found
}

/// Where sides cross a row of pixel centres, rounded to nanometres as the rule says, and whether they go
/// up there.
fn crossings(sides: &[Side], t: i64) -> Vec<(i64, bool)> {
    let cross = |s: &Side| {
        let (dx, dy) =
            (i128::from(s.high.x) - i128::from(s.low.x), i128::from(s.high.y) - i128::from(s.low.y));
        let rise = i128::from(t) - i128::from(s.low.y);
        // Rounded to the nearest, halves towards +x.
        let x = i128::from(s.low.x) + (2 * dx * rise + dy).div_euclid(2 * dy);
        (x as i64, s.up)
    };
    let meets = |s: &&Side| i64::from(s.low.y) < t && t <= i64::from(s.high.y);
    let mut found: Vec<_> = sides.iter().filter(meets).map(cross).collect();
    found.sort_unstable();
    found
}

/// Lit pixels of a row: those whose centres have a winding number other than 0.
fn lit(mut crossings: &[(i64, bool)], panel: &Panel, left: i64) -> u64 {
    let (mut winding, mut lit) = (0, 0);
    let centre = |i: i64| left + i * panel.pitch_x + (panel.pitch_x + 1) / 2;
    let mut pixel = 0;
    while let Some(&(x, _)) = crossings.first() {
        while pixel < i64::from(panel.width) && centre(pixel) < x {
            lit += u64::from(winding != 0);
            pixel += 1;
        }
        while let Some((&(at, up), rest)) = crossings.split_first() {
            if at != x {
                break;
            }
            winding += if up { 1 } else { -1 };
            crossings = rest;
        }
    }
    lit
}

/// A layer as it was drawn and as it should be.
struct Layer {
    number: usize,
    lit: u64,
    /// By the oracle; as drawn where there are greys.
    expected: u64,
    /// \[mm²\]
    area: f64,
    /// \[mm²\]
    exact: f64,
}

impl Layer {
    /// Relative error of its area.
    fn error(&self) -> f64 {
        (self.area / self.exact - 1.0).abs()
    }
}

fn main() {
    let mut args = std::env::args().skip(1);
    let path = args.next().unwrap();
    let printer = args.next().unwrap_or_else(|| "elegoo-saturn-3-ultra".to_owned());
    let sub_rows: u32 = args.next().map_or(1, |n| n.parse().unwrap());
    let mut settings = printers::find(&printer).unwrap().settings().unwrap();
    settings.slicing.layer_height = args.next().map_or(0.05, |h| h.parse().unwrap());
    settings.exposure.initial_layer_height = settings.slicing.layer_height;
    let panel = machine::panel(&settings);
    assert!(!panel.portrait, "the oracle reads landscape panels");
    let mut mesh = mesh::load(path.as_ref()).unwrap().mesh;
    let [w, h] = panel.plate().map(lattice::mm);
    mesh::place(&mut mesh, &[[0.0, 0.0], [w, 0.0], [w, h], [0.0, h]], Placement::DropAndCentre).unwrap();
    let adjacency = Adjacency::build(&mesh);
    let open = adjacency.twin.contains(&mesh::OPEN);
    let [lo, hi] = mesh.world_bounds().unwrap();
    let layers = schedule::layers(lo[2], hi[2], &settings).unwrap();
    let planes = plane_zs(&layers, mesh.origin[2]);
    let shading = Shading { sub_rows, gamma: 1.0, minimum_grey: 0 };
    let raster = Raster::new(panel, [mesh.origin[0], mesh.origin[1]], &shading).unwrap();
    let sections = Sections::new(&mesh, &planes, planes.len().div_ceil(16)).unwrap();
    let trace = TraceOptions { simplify_tolerance: None, ..TraceOptions::new(&SlicingSettings::default()) };
    let (left, bottom) = (-mesh.origin[0], -mesh.origin[1]);
    let results: Vec<Vec<Layer>> = (0..sections.runs().len())
        .into_par_iter()
        .map(|run| {
            let planes = &planes[sections.runs()[run].clone()];
            let contours = contour::trace(&mesh, &adjacency, planes, &trace).unwrap();
            let mut masks = microtome::mask::layers(&sections, run, &raster);
            let mut painter = Painter::new(&raster);
            let numbered = sections.runs()[run].clone().zip(contours);
            numbered
                .map(|(number, contours)| {
                    let section = masks.next().unwrap();
                    // A mesh with holes is drawn by its closed contours, as the program does.
                    let mask = if open { Arc::new(painter.mask(&sides(&contours.rings))) } else { section };
                    let rings = contours.rings;
                    let exact: f64 = rings.iter().map(|r| area(r)).sum();
                    let mut expected = mask.lit();
                    if sub_rows == 1 {
                        expected = 0;
                        let all = sloping(&rings);
                        let (mut next, mut near) = (0, Vec::new());
                        for row in 0..i64::from(panel.height) {
                            let t = bottom + row * panel.pitch_y + (panel.pitch_y + 1) / 2;
                            while let Some(side) = all.get(next).filter(|s| i64::from(s.low.y) < t) {
                                near.push(*side);
                                next += 1;
                            }
                            near.retain(|s| t <= i64::from(s.high.y));
                            expected += lit(&crossings(&near, t), &panel, left);
                        }
                    }
                    Layer { number, lit: mask.lit(), expected, area: mask.area() * panel.pixel_mm2(), exact }
                })
                .collect()
        })
        .collect();
    let layers: Vec<_> = results.into_iter().flatten().collect();
    let wrong = layers.iter().filter(|l| l.lit != l.expected).count();
    let (area, exact) = layers.iter().fold((0.0, 0.0), |(a, b), l| (a + l.area, b + l.exact));
    // Sections with overlapping shells have a smaller area than the sum of their rings; there are none in
    // the models that this is meant for.
    let large = || layers.iter().filter(|l| l.exact > 10.0);
    let off = large().filter(|l| l.error() > 0.001).count();
    let worst = large().max_by(|a, b| a.error().total_cmp(&b.error()));
    println!(
        "{path}: {} layers, {sub_rows} sub-rows: {} pixels, {wrong} layers differ from the oracle; volume {:+.5} %; \
         worst layer above 10 mm2: {:.4} % (layer {}, {:.2} mm2); {off} of {} such layers are off by more than 0.1 %",
        layers.len(),
        layers.iter().map(|l| l.lit).sum::<u64>(),
        (area / exact - 1.0) * 100.0,
        worst.map_or(0.0, |l| l.error() * 100.0),
        worst.map_or(0, |l| l.number),
        worst.map_or(0.0, |l| l.exact),
        large().count(),
    );
    assert_eq!(wrong, 0);
}

fn sides(rings: &[Vec<Point2>]) -> Vec<[Point2; 2]> {
    rings.iter().flat_map(|r| r.iter().zip(r.iter().cycle().skip(1)).map(|(&a, &b)| [a, b])).collect()
}

fn area(ring: &[Point2]) -> f64 {
    let origin = ring[0];
    let sum: i128 = ring.windows(2).map(|w| i128::from(lattice::cross(origin, w[0], w[1]))).sum();
    sum as f64 / 2.0 * 1e-12
}
