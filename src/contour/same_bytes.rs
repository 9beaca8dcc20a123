//! Every route from a mesh to its contours gives the bytes of the walk over the twin's segments.
#![allow(clippy::unwrap_used)]

use super::spans;
use super::trace::{self, LayerContours, Route, TraceOptions};
use super::walk::{contours_of, count_cycles};
use crate::lattice::Point3;
use crate::mesh::{Adjacency, Mesh, shapes};
use crate::slice::cpu;

/// xorshift64 (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn below(&mut self, n: i32) -> i32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (((self.0 >> 33) as i64 * i64::from(n)) >> 31) as i32
    }

    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }
}

const RAW: TraceOptions =
    TraceOptions { simplify_tolerance: None, match_tolerance: 50, memory_budget: 1 << 20 };
const ROUGH: TraceOptions = TraceOptions { simplify_tolerance: Some(2_000), ..RAW };

/// Checks all routes, with the planes in one run and in several.
fn check(name: &str, mesh: &Mesh, planes: &[i32]) -> usize {
    let adjacency = Adjacency::build(mesh);
    let segments = cpu::slice(mesh, &adjacency, planes);
    for options in [RAW, ROUGH] {
        let expected = contours_of(mesh, planes, &segments, &options);
        for route in Route::ALL {
            for parts in [1, 2, 5] {
                let got = traced(mesh, &adjacency, planes, &options, route, parts);
                assert!(got == expected, "{name}, {route:?} in {parts} parts");
            }
        }
    }
    let (closed, open) = count_cycles(&segments);
    let rings = traced(mesh, &adjacency, planes, &RAW, Route::Front, 1);
    // Chains without length are no chains.
    assert!(open >= rings.iter().map(|l| u64::from(l.open.chains)).sum(), "{name}");
    // Contours that shrink to a point or a line are cycles, but no rings.
    assert!(open > 0 || closed >= rings.iter().map(|l| l.rings.len() as u64).sum::<u64>(), "{name}");
    segments.start.len()
}

fn traced(
    mesh: &Mesh,
    adjacency: &Adjacency,
    planes: &[i32],
    options: &TraceOptions,
    route: Route,
    parts: usize,
) -> Vec<LayerContours> {
    let (spans, _) = spans::spans(mesh, planes, 1).unwrap();
    let step = planes.len().div_ceil(parts).max(1);
    let runs: Vec<_> =
        (0..planes.len()).step_by(step).map(|from| from..planes.len().min(from + step)).collect();
    trace::trace_runs(mesh, adjacency, planes, options, spans, &runs, route)
}

fn steps(mesh: &Mesh, count: i32) -> Vec<i32> {
    let [lo, hi] = mesh.bounds().unwrap();
    let extent = i64::from(hi.z) - i64::from(lo.z) + 2;
    (0..=count).map(|i| (i64::from(lo.z) - 1 + extent * i64::from(i) / i64::from(count)) as i32).collect()
}

/// Closed tetrahedra that share corners and edges on a coarse grid, and planes through its points.
fn tetrahedra(random: &mut Random, count: usize, grid: i32, scale: i32) -> Mesh {
    let side = grid as u32;
    let mut mesh = Mesh::default();
    for i in 0..grid * grid * grid {
        mesh.vertices.push(Point3::new(i % grid * scale, i / grid % grid * scale, i / (grid * grid) * scale));
    }
    while mesh.triangles.len() < 4 * count {
        let c = [0; 4].map(|_: i32| random.below((side * side * side) as i32) as u32);
        let mut sorted = c;
        sorted.sort_unstable();
        if sorted.windows(2).all(|w| w[0] != w[1]) {
            let [a, b, c, d] = c;
            mesh.triangles.extend([[a, c, b], [a, b, d], [b, c, d], [c, a, d]]);
        }
    }
    mesh
}

/// Moves every vertex a little, so that planes meet it in no particular order.
fn roughen(mut mesh: Mesh, by: i32, random: &mut Random) -> Mesh {
    for v in &mut mesh.vertices {
        let mut near = |c: i32| c + random.below(2 * by + 1) - by;
        *v = Point3::new(near(v.x), near(v.y), near(v.z));
    }
    mesh
}

#[test]
fn all_routes_agree_on_bodies() {
    let mut random = Random::new(7);
    let bodies = [
        ("sphere", shapes::sphere(5.0, 40, 30)),
        ("tall cylinder", shapes::cylinder(3.0, 40.0, 60)),
        ("torus", shapes::upright(&shapes::torus(10.0, 3.0, 60, 25))),
        ("knot", shapes::knot(5.0, 1.5, 3_000)),
        ("rough torus", roughen(shapes::torus(10.0, 3.0, 50, 20), 300_000, &mut random)),
        ("rough knot", roughen(shapes::knot(5.0, 1.5, 3_000), 200_000, &mut random)),
        (
            "boxes",
            shapes::merge(&[0.0, 5.0, 2.0].map(|x| shapes::cuboid([x, x, 0.0], [x + 1.0, x + 1.0, 4.0]))),
        ),
        ("speck", shapes::sphere(0.000_02, 12, 8)),
    ];
    for (name, mesh) in &bodies {
        for count in [3, 40, 300] {
            assert!(check(name, mesh, &steps(mesh, count)) > 0);
        }
        let mut repeated = steps(mesh, 20);
        repeated.extend(repeated.clone());
        repeated.sort_unstable();
        check(name, mesh, &repeated);
        check(name, mesh, &[]);
    }
}

#[test]
fn all_routes_agree_where_contours_merge_split_and_touch() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let (grid, count) = (3 + random.below(5), 1 + random.below(30) as usize);
        let scale = [2, 10, 1_000_000][seed as usize % 3];
        let mesh = tetrahedra(&mut random, count, grid, scale);
        check(&format!("seed {seed}"), &mesh, &steps(&mesh, 3 * grid));
        let rough = roughen(mesh, scale / 3, &mut random);
        check(&format!("rough, seed {seed}"), &rough, &steps(&rough, 60));
    }
}

#[test]
fn all_routes_agree_on_open_and_turned_facets() {
    for seed in 0..60 {
        let mut random = Random::new(seed);
        let mut mesh = roughen(shapes::torus(10.0, 3.0, 24, 12), 100_000, &mut random);
        for _ in 0..1 + random.below(40) {
            let at = random.below(mesh.triangles.len() as i32) as usize;
            if random.below(3) == 0 {
                mesh.triangles[at].swap(0, 1);
            } else {
                mesh.triangles.swap_remove(at);
            }
        }
        check(&format!("seed {seed}"), &mesh, &steps(&mesh, 90));
    }
}

#[test]
fn the_comparison_sees_planted_faults() {
    let mesh = shapes::cylinder(3.0, 40.0, 60);
    let (adjacency, planes) = (Adjacency::build(&mesh), steps(&mesh, 30));
    let segments = cpu::slice(&mesh, &adjacency, &planes);
    let expected = contours_of(&mesh, &planes, &segments, &RAW);
    for route in Route::ALL {
        let mut moved = mesh.clone();
        moved.vertices[5].x += 1_000;
        assert!(traced(&moved, &adjacency, &planes, &RAW, route, 2) != expected, "{route:?}");
    }
}
