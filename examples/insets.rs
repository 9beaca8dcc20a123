//! Holds insets against a second polygon library, on random nasty areas and on every layer of models.
//!
//! cargo run --release --example insets -- [--cases N] [--seed S] [MODEL.stl ...]
//!
//! Every case whose area is off by more than 0.1 mm² is printed with its seed and judged by the definition
//! of the inset: what of the area neither a strip along an edge nor a joint at a corner covers, on 20,000
//! rows. `--seed S --cases 1` repeats one. Models are cut in layers of 0.2 mm and moved inwards four times,
//! as three walls and the border of infill are.
#![allow(clippy::unwrap_used, clippy::print_stdout, dead_code, missing_docs)]

#[path = "../tests/oracle/bodies.rs"]
mod bodies;
#[path = "../tests/oracle/definition.rs"]
mod definition;
#[path = "../tests/oracle/insets.rs"]
mod insets;
#[path = "../tests/oracle/nasty.rs"]
mod nasty;

use insets::{Verdict, area, area_of, judge, library_area, library_inset};
use microtome::contour::{ExPolygon, TraceOptions, trace};
use microtome::mesh::{self, Adjacency};
use microtome::region::areas::areas;
use microtome::region::offset::{fast_inset, inset, raw_inset};
use microtome::region::perimeters::WallPlan;
use microtome::settings::Settings;
use microtome::slice::planes;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::time::Instant;

/// Beyond this a difference is looked into \[mm²\].
const NOTABLE: f64 = 0.1;

#[derive(Clone, Default)]
struct Tally {
    insets: u64,
    fast: u64,
    notable: u64,
    large: u64,
    verdicts: BTreeMap<Verdict, u64>,
    /// Seconds by the fast route with its fallback, by the union alone, by the other library.
    seconds: [f64; 3],
    /// Largest and summed difference to the library \[mm²\].
    worst: f64,
    sum: f64,
    /// Total area \[mm²\]: ours, the library's.
    areas: [f64; 2],
}

impl Tally {
    fn add(mut self, other: &Self) -> Self {
        self.insets += other.insets;
        self.fast += other.fast;
        self.notable += other.notable;
        self.large += other.large;
        for (verdict, n) in &other.verdicts {
            *self.verdicts.entry(*verdict).or_default() += n;
        }
        for i in 0..3 {
            self.seconds[i] += other.seconds[i];
        }
        self.worst = self.worst.max(other.worst);
        self.sum += other.sum;
        self.areas = [self.areas[0] + other.areas[0], self.areas[1] + other.areas[1]];
        self
    }

    /// One inset by all routes; returns ours.
    fn step(&mut self, name: impl Fn() -> String, shapes: &[ExPolygon], distance: i64) -> Vec<ExPolygon> {
        let start = Instant::now();
        let ours = inset(shapes, distance);
        let then = Instant::now();
        for shape in shapes {
            std::hint::black_box(raw_inset(shape, distance as f64));
        }
        let later = Instant::now();
        let library = library_area(shapes, distance);
        self.seconds[0] += (then - start).as_secs_f64();
        self.seconds[1] += (later - then).as_secs_f64();
        self.seconds[2] += later.elapsed().as_secs_f64();
        self.insets += shapes.len() as u64;
        self.fast += shapes.iter().filter(|s| fast_inset(s, distance).is_some()).count() as u64;
        let off = area(&ours) - library;
        self.worst = self.worst.max(off.abs());
        self.sum += off.abs();
        self.areas = [self.areas[0] + area(&ours), self.areas[1] + library];
        if off.abs() > NOTABLE {
            self.notable += 1;
            self.large += u64::from(off.abs() > 1.0);
            let (verdict, exact) = judge(shapes, distance, &ours, library);
            *self.verdicts.entry(verdict).or_default() += 1;
            println!(
                "{}, {distance} nm: ours {:.4}, library {library:.4}, definition {exact:.4} mm2: {verdict:?}",
                name(),
                area(&ours)
            );
        }
        ours
    }

    fn print(&self, what: &str) {
        println!(
            "{what}: {} insets, {:.2} % by the fast route; off by more than 0.1 mm2: {}, 1.0: {}; {:?}",
            self.insets,
            100.0 * self.fast as f64 / self.insets.max(1) as f64,
            self.notable,
            self.large,
            self.verdicts
        );
        let [ours, union, library] = self.seconds.map(|s| 1e3 * s);
        println!(
            "  area {:.3} for {:.3} mm2, worst {:.4}, summed {:.4}; ms: ours {ours:.1}, union alone {union:.1}, \
             library {library:.1}",
            self.areas[0], self.areas[1], self.worst, self.sum
        );
    }
}

fn cases(first: u64, count: u64) {
    let by_kind = (first..first + count)
        .into_par_iter()
        .fold(BTreeMap::<&str, Tally>::new, |mut tallies, seed| {
            let case = nasty::case(seed);
            let tally = tallies.entry(case.kind).or_default();
            tally.step(|| format!("seed {seed}, {}", case.kind), &case.areas, case.distance);
            tallies
        })
        .reduce(BTreeMap::new, |mut a, b| {
            for (kind, tally) in b {
                let sum = a.remove(kind).unwrap_or_default().add(&tally);
                a.insert(kind, sum);
            }
            a
        });
    for (kind, tally) in &by_kind {
        tally.print(kind);
    }
    by_kind
        .values()
        .fold(Tally::default(), Tally::add)
        .print(&format!("{count} random cases from seed {first}"));
}

fn model(path: &str) {
    let mut settings = Settings::default();
    settings.slicing.layer_height = 0.2;
    let mut mesh = mesh::load(path.as_ref()).unwrap().mesh;
    // It stands on the bed.
    mesh.origin[2] -= mesh.world_bounds().unwrap()[0][2];
    let adjacency = Adjacency::build(&mesh);
    let layers = planes::of_mesh(&mesh, &settings).unwrap();
    let heights = planes::plane_zs(&layers, mesh.origin[2]);
    let options = TraceOptions { simplify_tolerance: Some(5_000), ..TraceOptions::new(&settings.slicing) };
    let contours = trace(&mesh, &adjacency, &heights, &options).unwrap();
    let plan = WallPlan::new(&settings, 0.2, false);
    let steps = [
        plan.external_width / 2,
        (plan.external_spacing + plan.perimeter_spacing) / 2,
        plan.perimeter_spacing,
        plan.infill_inset(),
    ];
    // Per step: on the same input; and the difference of both chains.
    let layer = |(i, rings): (usize, &microtome::contour::LayerContours)| {
        let (mut tallies, mut chain) = (vec![Tally::default(); steps.len()], 0f64);
        let mut ours = areas(&rings.rings);
        let mut theirs = clipper2_rust::Paths64::new();
        for (k, (&d, tally)) in steps.iter().zip(&mut tallies).enumerate() {
            theirs = if k == 0 { library_inset(&ours, d) } else { again(&theirs, d) };
            ours = tally.step(|| format!("{path}, layer {i}, step {}", k + 1), &ours, d);
            chain = chain.max((area(&ours) - area_of(&theirs)).abs());
        }
        (tallies, chain)
    };
    let found: Vec<_> = contours.par_iter().enumerate().map(layer).collect();
    for k in 0..steps.len() {
        let step = found.iter().fold(Tally::default(), |sum, (tallies, _)| sum.add(&tallies[k]));
        step.print(&format!("{path}, step {}", k + 1));
    }
    let all = found.iter().flat_map(|(tallies, _)| tallies).fold(Tally::default(), Tally::add);
    all.print(&format!("{path}, {} layers", layers.len()));
    let (worst, at) =
        found.iter().zip(0..).map(|(f, i)| (f.1, i)).fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a });
    let over = found.iter().filter(|f| f.1 > NOTABLE).count();
    println!(
        "  four insets in a chain against the library's chain: worst {worst:.4} mm2 (layer {at}), {over} layers over 0.1"
    );
}

/// The library's next inset of its own result, simplified as ours is.
fn again(paths: &clipper2_rust::Paths64, d: i64) -> clipper2_rust::Paths64 {
    use clipper2_rust::{EndType, JoinType};
    let simple = clipper2_rust::simplify_paths(paths, 2_000.0, true);
    clipper2_rust::inflate_paths_64(&simple, -(d as f64), JoinType::Miter, EndType::Polygon, 2.0, 5_000.0)
}

fn main() {
    let (mut count, mut first, mut models) = (0, 0, Vec::new());
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match arg.as_str() {
            "--cases" => count = args.next().unwrap().parse().unwrap(),
            "--seed" => first = args.next().unwrap().parse().unwrap(),
            _ => models.push(arg),
        }
    }
    if count > 0 {
        cases(first, count);
    }
    models.iter().for_each(|path| model(path));
}
