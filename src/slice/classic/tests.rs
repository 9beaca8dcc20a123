//! Every algorithm against the reference twin.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::lattice::{LIMIT, area2};
use crate::mesh::shapes;

/// SplitMix64 (Steele et al. 2014).
struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (x ^ x >> 31) % n
    }

    fn coordinate(&mut self, reach: i32) -> i32 {
        self.below(2 * reach as u64 + 1) as i32 - reach
    }

    /// Triangles that join random vertices of a small lattice, so that much coincides.
    fn soup(&mut self, triangles: usize, reach: i32) -> Mesh {
        let n = 3 + triangles as u64 / 2;
        let mut point =
            || Point3::new(self.coordinate(reach), self.coordinate(reach), self.coordinate(reach));
        let vertices = (0..n).map(|_| point()).collect();
        let mut corners = || {
            let a = self.below(n);
            let b = (a + 1 + self.below(n - 1)) % n;
            let c = (0..n).map(|i| (b + 1 + i) % n).find(|c| *c != a && *c != b).unwrap();
            [a, b, c].map(|v| v as u32)
        };
        let triangles = (0..triangles).map(|_| corners()).collect();
        Mesh { vertices, triangles, origin: [0; 3] }
    }

    /// Ascending planes with repeats, some through vertices.
    fn planes(&mut self, mesh: &Mesh, count: usize, reach: i32) -> Vec<i32> {
        let vertices = mesh.vertices.len() as u64;
        let mut planes: Vec<i32> = (0..count)
            .map(|i| match i % 3 {
                0 if vertices > 0 => mesh.vertices[self.below(vertices) as usize].z,
                _ => self.coordinate(reach),
            })
            .collect();
        planes.extend_from_within(..count / 4);
        planes.sort_unstable();
        planes
    }
}

/// What differs between an algorithm and the twin.
fn difference(algorithm: Algorithm, mesh: &Mesh, planes: &[i32]) -> Option<String> {
    let adjacency = Adjacency::build(mesh);
    let twin = cpu::slice(mesh, &adjacency, planes);
    if slice(algorithm, mesh, &adjacency, planes) != twin {
        return Some(format!("{algorithm}: other buffers"));
    }
    let layers = segments(algorithm, mesh, planes);
    if layers.len() != planes.len() {
        return Some(format!("{algorithm}: {} layers for {} planes", layers.len(), planes.len()));
    }
    // The twin's segments, in order of triangles on each plane.
    let mut expected = vec![Vec::new(); planes.len()];
    for t in 0..mesh.triangles.len() {
        for slot in twin.offset[t]..twin.offset[t + 1] {
            let k = (twin.first[t] + slot - twin.offset[t]) as usize;
            expected[k].push((t as u32, twin.start[slot as usize]));
        }
    }
    for (k, (layer, expected)) in layers.iter().zip(&expected).enumerate() {
        if !layer.iter().map(|s| (s.triangle, s.start)).eq(expected.iter().copied()) {
            return Some(format!("{algorithm}: other segments on plane {k}"));
        }
    }
    // Where a segment has a successor, it ends where that begins.
    for t in 0..mesh.triangles.len() {
        for slot in twin.offset[t]..twin.offset[t + 1] {
            let next = twin.next[slot as usize];
            let k = (twin.first[t] + slot - twin.offset[t]) as usize;
            let layer = &layers[k];
            let own = layer[layer.binary_search_by_key(&(t as u32), |s| s.triangle).unwrap()];
            if next != crate::mesh::OPEN && own.end != twin.start[next as usize] {
                return Some(format!("{algorithm}: triangle {t} ends elsewhere on plane {k}"));
            }
        }
    }
    None
}

fn check(what: &str, mesh: &Mesh, planes: &[i32]) {
    for algorithm in Algorithm::ALL {
        assert_eq!(difference(algorithm, mesh, planes), None, "{what}");
    }
    assert_eq!(
        interval_tree::run(mesh, planes).iter().map(Vec::len).sum::<usize>(),
        trivial::run(mesh, planes).iter().map(Vec::len).sum::<usize>(),
        "{what}: the interval tree on planes of any spacing"
    );
}

fn even(from: i32, step: i32, count: i32) -> Vec<i32> {
    (0..count).map(|k| from + k * step).collect()
}

#[test]
fn all_equal_the_twin_on_bodies() {
    for (what, mesh) in [
        ("box", shapes::cuboid([0.0; 3], [10.0, 8.0, 3.0])),
        ("sphere", shapes::sphere(4.0, 40, 30)),
        ("torus", shapes::torus(6.0, 2.0, 50, 24)),
        ("cylinder", shapes::cylinder(3.0, 8.0, 90)),
        ("demo part", crate::mesh::demo_part()),
    ] {
        let (low, high) = bounds(&mesh);
        let step = (high - low) / 57;
        check(what, &mesh, &even(low + step / 2, step, 57));
        // Through the bottom, the top and many vertices.
        check(what, &mesh, &even(low, step, 58));
        let mut vertices: Vec<i32> = mesh.vertices.iter().map(|v| v.z).take(40).collect();
        vertices.extend([low - 5, low, low + 1, high - 1, high, high, high + 1]);
        vertices.sort_unstable();
        check(what, &mesh, &vertices);
        check(what, &mesh, &[]);
        check(what, &mesh, &[0]);
        check(what, &mesh, &[0, 0, 0]);
        // Rounded like the middles of layers of a third of a millimetre.
        let thirds: Vec<i32> =
            (0..60).map(|k| low + (1e6 / 3.0 * (f64::from(k) + 0.5)).round() as i32).collect();
        check(what, &mesh, &thirds);
    }
}

fn bounds(mesh: &Mesh) -> (i32, i32) {
    let zs = || mesh.vertices.iter().map(|v| v.z);
    (zs().min().unwrap_or(0), zs().max().unwrap_or(0))
}

#[test]
fn all_equal_the_twin_on_soups() {
    for seed in 0..120 {
        let mut random = Random(seed);
        let reach = [3, 10, 1000, LIMIT - 1][seed as usize % 4];
        let mesh = random.soup(1 + seed as usize * 3, reach);
        let count = random.below(40) as usize;
        let planes = random.planes(&mesh, count, reach);
        check(&format!("seed {seed}"), &mesh, &planes);
        let step = (reach / 20).max(1);
        check(&format!("seed {seed}, even"), &mesh, &even(-(reach / 2), step, 25));
    }
}

#[test]
fn nothing_gives_nothing() {
    let planes = [-1, 0, 7];
    check("no triangles", &Mesh::default(), &planes);
    check("nothing at all", &Mesh::default(), &[]);
    let mut flat = shapes::cuboid([0.0; 3], [4.0, 4.0, 1.0]);
    flat.vertices.iter_mut().for_each(|v| v.z = 0);
    check("horizontal facets only", &flat, &planes);
    assert!(segments(Algorithm::Sweep, &flat, &planes).iter().all(Vec::is_empty));
}

#[test]
fn a_planted_fault_is_seen() {
    let mesh = shapes::sphere(4.0, 20, 10);
    let adjacency = Adjacency::build(&mesh);
    let planes = even(-3_000_000, 500_000, 13);
    let twin = cpu::slice(&mesh, &adjacency, &planes);
    let good = run(Algorithm::Grouping, &mesh, &planes);
    assert_eq!(link(&mesh, &adjacency, &planes, &good), twin);
    let mut moved = good.clone();
    moved[4][3].start.x += 1;
    assert_ne!(link(&mesh, &adjacency, &planes, &moved), twin);
    let mut lost = good;
    lost[0].pop();
    assert_ne!(link(&mesh, &adjacency, &planes, &lost), twin);
}

#[test]
fn assembled_rings_enclose_what_linked_ones_do() {
    for mesh in [shapes::torus(6.0, 2.0, 50, 24), shapes::sphere(4.0, 40, 30), crate::mesh::demo_part()] {
        let (low, high) = bounds(&mesh);
        let planes = even(low + (high - low) / 62, (high - low) / 31, 31);
        let layers = run(Algorithm::Incremental, &mesh, &planes);
        let adjacency = Adjacency::build(&mesh);
        let linked = cpu::slice(&mesh, &adjacency, &planes);
        let assembled = assemble(&layers);
        for (k, (plane, segments)) in assembled.iter().zip(&layers).enumerate() {
            assert!(plane.chains.is_empty(), "plane {k}");
            let points: usize = plane.rings.iter().map(Vec::len).sum();
            assert_eq!(points, segments.iter().filter(|s| s.start != s.end).count(), "plane {k}");
            let origin = Point2::default();
            let area: i128 =
                segments.iter().map(|s| i128::from(crate::lattice::cross(origin, s.start, s.end))).sum();
            assert_eq!(plane.rings.iter().map(|r| area2(r)).sum::<i128>(), area, "plane {k}");
        }
        // A hole leaves chains, and every segment is still in one of them or in a ring.
        let mut holed = mesh.clone();
        holed.triangles.swap_remove(layers[15][0].triangle as usize);
        let layers = run(Algorithm::Incremental, &holed, &planes);
        assert!(layers.iter().map(Vec::len).sum::<usize>() < linked.start.len());
        let mut chains = 0;
        for (plane, segments) in assemble(&layers).iter().zip(&layers) {
            let used: usize = plane.rings.iter().map(Vec::len).sum::<usize>()
                + plane.chains.iter().map(|c| c.len() - 1).sum::<usize>();
            assert_eq!(used, segments.iter().filter(|s| s.start != s.end).count());
            chains += plane.chains.len();
        }
        assert!(chains > 0);
    }
}

#[test]
fn the_table_of_edges_is_the_rule() {
    for bits in 1..ALL_BELOW {
        let corner = [0, 1, 2].map(|i| Point3::new(0, 0, if bits >> i & 1 == 1 { 4 } else { 5 }));
        assert_eq!(below(corner, 5), bits);
        let [down, up] = edges(bits);
        assert_eq!((down, up), crossing::down_up(corner.map(|c| c.z), 5), "{bits:03b}");
    }
}

#[test]
fn names_are_read_back() {
    for algorithm in Algorithm::ALL {
        assert_eq!(algorithm.name().parse(), Ok(algorithm));
    }
    let error = "tree".parse::<Algorithm>().unwrap_err().to_string();
    assert!(error.contains("\"tree\"") && error.contains("incremental"), "{error}");
}
