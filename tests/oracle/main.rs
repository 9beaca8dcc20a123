//! An oracle for the slicing core: every plane × every triangle in 128-bit integers, end points
//! joined by equality. It shares no code with the library beyond its plain data types.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod bodies;
mod definition;
mod insets;
mod masks;
mod nasty;
mod plans;
mod stupid;
mod support_case;
mod supports;

use bodies::Random;
use microtome::contour::trace::{LayerContours, TraceOptions, trace};
use microtome::contour::walk::contours_of;
use microtome::lattice::{LIMIT, Point2, Point3};
use microtome::mesh::{Adjacency, Mesh, OPEN};
use microtome::slice::{chunk, cpu};

const RAW: TraceOptions =
    TraceOptions { simplify_tolerance: None, match_tolerance: 0, memory_budget: 1 << 20 };
const FLAT: TraceOptions = TraceOptions { simplify_tolerance: Some(0), ..RAW };
const ROUGH: TraceOptions = TraceOptions { simplify_tolerance: Some(5_000), match_tolerance: 98_000, ..RAW };

/// A body and the planes to cut it by.
struct Case {
    name: String,
    mesh: Mesh,
    planes: Vec<i32>,
}

impl Case {
    fn new(name: impl Into<String>, soup: &[[Point3; 3]], planes: Vec<i32>) -> Self {
        Self { name: name.into(), mesh: bodies::weld(soup), planes }
    }

    fn trace(&self, options: &TraceOptions) -> Vec<LayerContours> {
        trace(&self.mesh, &bodies::adjacency(&self.mesh), &self.planes, options).unwrap()
    }
}

fn steps(from: i32, to: i32, step: usize) -> Vec<i32> {
    (from..=to).step_by(step).collect()
}

/// Bodies whose facets meet in pairs, so that their contours do not depend on the order of facets.
fn manifolds() -> Vec<Case> {
    let p = Point3::new;
    let m = LIMIT - 1;
    let boxes = bodies::cuboid(p(0, 0, 0), p(9_000_001, 5_000_003, 3_000_000));
    let two =
        [boxes.clone(), bodies::cuboid(p(20_000_000, 0, 1_000_000), p(21_000_000, 7, 2_000_000))].concat();
    let hollow: Vec<_> = bodies::cuboid(p(1, 1, 1), p(2_000_000, 3_000_000, 2_900_000))
        .into_iter()
        .map(|[a, b, c]| [a, c, b])
        .chain(boxes.clone())
        .collect();
    vec![
        Case::new("box, planes on its faces", &boxes, steps(-1_000_000, 4_000_000, 500_000)),
        Case::new("box, planes beside its faces", &boxes, steps(-1_000_001, 4_000_000, 333_333)),
        Case::new("two boxes, one of them thin", &two, steps(0, 3_000_000, 250_000)),
        Case::new("hollow box", &hollow, steps(1, 3_000_000, 99_999)),
        Case::new("sphere", &bodies::sphere(7e6, 24), steps(-7_100_000, 7_100_000, 200_000)),
        Case::new("tiny sphere", &bodies::sphere(40.0, 16), steps(-45, 45, 1)),
        Case::new("speck", &bodies::sphere(4.0, 12), steps(-5, 5, 1)),
        Case::new("torus", &bodies::torus(9e6, 3e6, 20), steps(-12_000_000, 12_000_000, 150_000)),
        Case::new(
            "largest box",
            &bodies::cuboid(p(-m, -m, -m), p(m, m, m)),
            vec![-LIMIT, -m, 1 - m, 0, m, LIMIT],
        ),
        Case::new("repeated planes", &bodies::sphere(1e6, 9), vec![0, 0, 10, 500_000, 500_000, 500_000]),
        Case::new("no planes", &boxes, vec![]),
        Case::new("no triangles", &[], vec![0, 1]),
    ]
}

/// Closed bodies that share edges, lie on planes and turn inside out.
fn clusters() -> Vec<Case> {
    (0..60)
        .map(|seed| {
            let mut random = Random::new(seed);
            let step = [1, 7, 1_000, 40_000_000][seed as usize % 4];
            let grid = 2 + random.below(12) as i32;
            let count = 1 + random.below(12) as usize;
            let soup = bodies::tetrahedra(&mut random, count, grid, step);
            let planes = steps(-grid * step - step, grid * step + step, (step as usize / 2).max(1));
            Case::new(format!("tetrahedra, seed {seed}"), &soup, planes)
        })
        .collect()
}

#[test]
fn contours_consist_of_the_segments_of_the_oracle() {
    let mut segments = 0;
    for case in manifolds().into_iter().chain(clusters()) {
        for (k, layer) in case.trace(&RAW).iter().enumerate() {
            let expected = stupid::segments(&case.mesh, case.planes[k]);
            stupid::same(layer, &expected).unwrap_or_else(|e| panic!("{}, plane {k}: {e}", case.name));
            assert_eq!(layer.open.chains, 0, "{}, plane {k}", case.name);
            segments += expected.len();
        }
    }
    assert!(segments > 20_000, "{segments}");
}

#[test]
fn simple_contours_are_those_of_the_oracle() {
    let mut rings = 0;
    for case in manifolds() {
        for (k, layer) in case.trace(&RAW).iter().enumerate() {
            // Where no point occurs twice, equality of points is enough to join segments.
            if let Some(expected) = stupid::rings(&stupid::segments(&case.mesh, case.planes[k])) {
                assert_eq!(layer.rings, expected, "{}, plane {k}", case.name);
                rings += expected.len();
            }
        }
    }
    assert!(rings > 300, "{rings}");
}

#[test]
fn flattening_keeps_the_area_exactly() {
    for case in manifolds().into_iter().chain(clusters()) {
        for (k, layer) in case.trace(&FLAT).iter().enumerate() {
            let expected = stupid::area2(&stupid::segments(&case.mesh, case.planes[k]));
            let area: i128 = layer.rings.iter().map(|r| microtome::lattice::area2(r)).sum();
            assert_eq!(area, expected, "{}, plane {k}", case.name);
        }
    }
}

#[test]
fn the_oracle_sees_planted_faults() {
    let case = Case::new("torus", &bodies::torus(9e6, 3e6, 20), vec![1_234_567]);
    let expected = stupid::segments(&case.mesh, case.planes[0]);
    let good = case.trace(&RAW).remove(0);
    assert_eq!(stupid::same(&good, &expected), Ok(()));
    let mut moved = good.clone();
    moved.rings[0][3].x += 1;
    assert!(stupid::same(&moved, &expected).is_err());
    let mut lost = good.clone();
    lost.rings[0].remove(5);
    assert!(stupid::same(&lost, &expected).is_err());
    let mut reversed = good.clone();
    reversed.rings[1].reverse();
    assert!(stupid::same(&reversed, &expected).is_err());
    let mut missing = good;
    missing.rings.pop();
    assert!(stupid::same(&missing, &expected).is_err());
}

/// The contours by way of the twin's segments, in runs of at most `limit` segments.
fn by_segments(case: &Case, adjacency: &Adjacency, options: &TraceOptions, limit: u64) -> Vec<LayerContours> {
    chunk::runs(&chunk::segments_per_plane(&case.mesh, &case.planes), limit)
        .into_iter()
        .flat_map(|run| {
            let planes = &case.planes[run];
            let segments = cpu::slice(&case.mesh, adjacency, planes);
            contours_of(&case.mesh, planes, &segments, options)
        })
        .collect()
}

#[test]
fn segments_and_trace_give_the_same_bytes_in_any_chunks() {
    for (i, case) in manifolds().into_iter().chain(clusters()).enumerate() {
        for open in [false, true] {
            let mut adjacency = bodies::adjacency(&case.mesh);
            if open {
                // Holes in the mesh: some half-edges have no partner.
                let mut random = Random::new(i as u64);
                for _ in 0..adjacency.twin.len() / 20 {
                    let edge = random.below(adjacency.twin.len() as u64) as usize;
                    let twin = std::mem::replace(&mut adjacency.twin[edge], OPEN);
                    if twin != OPEN {
                        adjacency.twin[twin as usize] = OPEN;
                    }
                }
            }
            for options in [&RAW, &FLAT, &ROUGH] {
                let traced = trace(&case.mesh, &adjacency, &case.planes, options).unwrap();
                assert_eq!(traced.len(), case.planes.len());
                for limit in [1, 7, 100, u64::MAX] {
                    let chunked = by_segments(&case, &adjacency, options, limit);
                    assert!(traced == chunked, "{}, open {open}, {options:?}, limit {limit}", case.name);
                }
            }
        }
    }
}

#[test]
fn a_changed_link_or_start_changes_the_contours() {
    let case = Case::new("torus", &bodies::torus(9e6, 3e6, 20), steps(-11_000_000, 11_000_000, 1_000_001));
    let adjacency = bodies::adjacency(&case.mesh);
    let good = case.trace(&RAW);
    let segments = cpu::slice(&case.mesh, &adjacency, &case.planes);
    let slots = segments.start.len();
    assert_eq!(contours_of(&case.mesh, &case.planes, &segments, &RAW), good);
    for at in (0..slots).step_by(97) {
        let mut moved = segments.clone();
        moved.start[at].y ^= 1;
        assert_ne!(contours_of(&case.mesh, &case.planes, &moved, &RAW), good, "start {at}");
        for link in [OPEN, segments.next[(at + 1) % slots], slots as u32, at as u32] {
            let mut broken = segments.clone();
            broken.next[at] = link;
            assert_ne!(contours_of(&case.mesh, &case.planes, &broken, &RAW), good, "link {at} to {link}");
        }
    }
    for edge in (0..adjacency.twin.len()).step_by(31) {
        for twin in [OPEN, 0, adjacency.twin[(edge + 5) % adjacency.twin.len()]] {
            let mut broken = adjacency.clone();
            broken.twin[edge] = twin;
            // A lie may touch an edge that no plane crosses; it must only never hang or panic.
            let _ = trace(&case.mesh, &broken, &case.planes, &RAW).unwrap();
        }
    }
}

#[test]
fn the_order_of_facets_does_not_matter() {
    for case in manifolds() {
        for options in [&RAW, &FLAT, &ROUGH] {
            let expected = case.trace(options);
            for seed in 0..3 {
                let mesh = bodies::shuffled(&case.mesh, &mut Random::new(seed));
                let other = Case { name: String::new(), mesh, planes: case.planes.clone() };
                assert!(other.trace(options) == expected, "{}, seed {seed}", case.name);
            }
        }
    }
}

#[test]
fn the_number_of_threads_and_the_budget_do_not_matter() {
    for case in manifolds().into_iter().chain(clusters().into_iter().take(8)) {
        let expected = case.trace(&ROUGH);
        for threads in [1, 2, 8] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for memory_budget in [0, 1_000, u64::MAX] {
                let options = TraceOptions { memory_budget, ..ROUGH };
                assert!(
                    pool.install(|| case.trace(&options)) == expected,
                    "{}, {threads} threads",
                    case.name
                );
            }
            let adjacency = bodies::adjacency(&case.mesh);
            assert!(pool.install(|| by_segments(&case, &adjacency, &ROUGH, u64::MAX)) == expected);
        }
    }
}

#[test]
fn a_sphere_with_missing_facets_keeps_its_layers() {
    let soup = bodies::sphere(7e6, 40);
    let whole = Case::new("sphere", &soup, steps(-6_900_000, 6_900_000, 200_000)).trace(&ROUGH);
    let mut random = Random::new(3);
    let holed: Vec<_> = soup.into_iter().filter(|_| random.below(10) > 0).collect();
    let holed = Case::new("holed sphere", &holed, steps(-6_900_000, 6_900_000, 200_000)).trace(&ROUGH);
    let area =
        |layer: &LayerContours| layer.rings.iter().map(|r| microtome::lattice::area2(r)).sum::<i128>() as f64;
    for (k, (whole, holed)) in whole.iter().zip(&holed).enumerate() {
        let share = area(holed) / area(whole);
        let report = holed.open;
        assert!((0.9..1.01).contains(&share), "layer {k}: {share}, {report:?}");
        assert_eq!(report.chains, report.matched + report.forced + report.dropped);
    }
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let case = Case::new("box", &bodies::cuboid(Point3::default(), Point3::new(9, 9, 9)), vec![5]);
    let adjacency = bodies::adjacency(&case.mesh);
    assert!(trace(&case.mesh, &Adjacency::default(), &[5], &RAW).is_err());
    assert!(trace(&case.mesh, &adjacency, &[5, 4], &RAW).is_err());
    let mut torn = case.mesh.clone();
    torn.triangles[7][1] = 8;
    let error = trace(&torn, &adjacency, &[5], &RAW).unwrap_err().to_string();
    assert_eq!(error, "triangle 7 has vertex 8, but there are only 8");
    assert_eq!(
        case.trace(&FLAT)[0].rings,
        [[(0, 0), (9, 0), (9, 9), (0, 9)].map(|(x, y)| Point2::new(x, y))]
    );
}
