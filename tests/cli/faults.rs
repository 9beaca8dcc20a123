//! Faulty meshes: what can be mended is, and no layer is lost in silence.

use super::{Bench, stderr, stdout};
use microtome::job::open::OpenContours;
use microtome::job::part::{MeshOptions, Part, PartOptions, prepare};
use microtome::job::progress::Progress;
use microtome::job::summary::Stopwatch;
use microtome::lattice::{Point3, mm};
use microtome::mesh::orient::Orient;
use microtome::mesh::{Mesh, Placement, load, shapes};
use microtome::region::areas::areas;
use microtome::settings::{FloatOrPercent, PrinterSettings, SlicingSettings};
use microtome::slice::planes::{layers, plane_zs};
use std::path::Path;

struct Silent;
impl Progress for Silent {
    fn stage(&self, _: &'static str) {}
}

/// SplitMix64.
struct Random(u64);
impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let x = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let x = (x ^ x >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        (x ^ x >> 31) % n
    }
}

/// A facet with the normal that its file stores.
type Facet = ([f32; 3], [[f32; 3]; 3]);

/// The facets of a mesh with their right normals.
fn facets(mesh: &Mesh) -> Vec<Facet> {
    let corner = |p: Point3| {
        let [x, y, z] = mesh.origin;
        [x + i64::from(p.x), y + i64::from(p.y), z + i64::from(p.z)].map(|c| mm(c) as f32)
    };
    let facet = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| corner(mesh.vertices[v as usize]));
        let (u, v) = ([0, 1, 2].map(|k| b[k] - a[k]), [0, 1, 2].map(|k| c[k] - a[k]));
        let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
        let length = (n[0] * n[0] + n[1] * n[1] + n[2] * n[2]).sqrt();
        (n.map(|c| c / length), [a, b, c])
    };
    mesh.triangles.iter().map(facet).collect()
}

fn stl(facets: &[Facet]) -> Vec<u8> {
    let mut bytes = vec![b' '; 80];
    bytes.extend((facets.len() as u32).to_le_bytes());
    for (normal, corners) in facets {
        bytes.extend(normal.iter().chain(corners.as_flattened()).flat_map(|c| c.to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

/// Area of each layer \[mm²\], and what was done to the mesh.
struct Sliced {
    areas: Vec<f64>,
    part: Part,
    open: OpenContours,
}

fn slice(path: &Path, options: &MeshOptions) -> Sliced {
    let printer = PrinterSettings::default();
    let options_of_part = PartOptions {
        printer: &printer,
        placement: Placement::Keep,
        must_fit: false,
        mesh: options,
        file: Some(path),
    };
    let part =
        prepare(load(path).unwrap(), "part", &options_of_part, &Silent, &mut Stopwatch::default()).unwrap();
    let settings = SlicingSettings {
        layer_height: 0.2,
        first_layer_height: FloatOrPercent::Float(0.2),
        ..SlicingSettings::default()
    };
    let [lo, hi] = part.mesh.world_bounds().unwrap();
    let list = layers(lo[2], hi[2], &settings).unwrap();
    let planes = plane_zs(&list, part.mesh.origin[2]);
    let traced =
        microtome::contour::trace(&part.mesh, &part.adjacency, &planes, &options.trace_options(&settings))
            .unwrap();
    let open = OpenContours::new(&traced, &list, part.mesh.origin);
    let area = |rings: &Vec<_>| areas(rings).iter().map(|e| e.area_mm2()).sum::<f64>();
    Sliced { areas: traced.iter().map(|l| area(&l.rings)).collect(), part, open }
}

fn sliced(facets: &[Facet], options: &MeshOptions) -> Sliced {
    let bench = Bench::new();
    slice(&bench.write("part.stl", stl(facets)), options)
}

/// Holds the areas of all layers against those of the intact body: within a share of the area plus a
/// few tenths of a square millimetre.
fn compare(what: &str, found: &Sliced, intact: &Sliced, share: f64, extra: f64) {
    assert_eq!(found.areas.len(), intact.areas.len(), "{what}");
    for (k, (a, b)) in found.areas.iter().zip(&intact.areas).enumerate() {
        assert!((a - b).abs() <= share * b + extra, "{what}: layer {k} has {a} mm2 instead of {b}");
        assert!(*a > 0.0 || *b == 0.0, "{what}: layer {k} is lost");
    }
}

fn ball() -> Vec<Facet> {
    facets(&shapes::sphere(12.0, 120, 60))
}

fn flip(facets: &mut [Facet], random: &mut Random, one_in: u64) {
    for (_, corners) in facets {
        if random.below(one_in) == 0 {
            corners.swap(1, 2);
        }
    }
}

fn without_normals(facets: &mut [Facet]) {
    facets.iter_mut().enumerate().for_each(|(i, f)| f.0 = if i % 2 == 0 { [0.0; 3] } else { [f32::NAN; 3] });
}

#[test]
fn missing_facets_cost_no_layer() {
    let intact = sliced(&ball(), &MeshOptions::default());
    assert_eq!((intact.areas.len(), intact.open.chains), (120, 0));
    assert!(intact.part.warnings.is_empty());
    for seed in 0..3 {
        for (one_in, share, extra) in [(100, 0.01, 0.1), (10, 0.05, 0.5)] {
            let mut random = Random(seed);
            let mut holed = ball();
            holed.retain(|_| random.below(one_in) > 0);
            let found = sliced(&holed, &MeshOptions::default());
            compare(&format!("1 in {one_in} missing, seed {seed}"), &found, &intact, share, extra);
            let open = &found.open;
            assert_eq!(open.chains, open.matched + open.forced + open.dropped);
            let worst = open.worst.unwrap();
            assert!(worst.gap_mm > 0.1 && worst.z_mm > 0.0 && worst.z_mm < 24.0, "{worst:?}");
            // Wound at random besides, and without normals.
            let mut mixed = holed.clone();
            flip(&mut mixed, &mut random, 2);
            without_normals(&mut mixed);
            let found = sliced(&mixed, &MeshOptions::default());
            assert!(found.part.summary.orientation.turned_by_neighbours > 0);
            compare(&format!("and flipped, seed {seed}"), &found, &intact, share, extra);
        }
    }
    // A planted fault: half of the facets are more than can be mended.
    let mut holed = ball();
    let mut random = Random(1);
    holed.retain(|_| random.below(2) > 0);
    let found = sliced(&holed, &MeshOptions::default());
    assert!(std::panic::catch_unwind(|| compare("half missing", &found, &intact, 0.01, 0.1)).is_err());
}

#[test]
fn an_open_bottom_and_a_missing_lid_change_nothing() {
    let body = facets(&shapes::cylinder(8.0, 6.0, 90));
    let intact = sliced(&body, &MeshOptions::default());
    for height in [0.0, 6.0] {
        let mut open = body.clone();
        open.retain(|(_, corners)| corners.iter().any(|c| c[2] != height));
        let found = sliced(&open, &MeshOptions::default());
        assert!(found.part.summary.open_edges > 0 && found.open.chains == 0);
        compare("open", &found, &intact, 0.0, 0.0);
    }
}

#[test]
fn any_winding_is_mended() {
    let body = shapes::merge(&[
        shapes::sphere(12.0, 60, 30),
        shapes::moved(shapes::torus(9.0, 3.0, 60, 30), [40.0, 0.0, 0.0]),
    ]);
    let good = facets(&body);
    let intact = sliced(&good, &MeshOptions::default());
    let count = |found: &Sliced| {
        let o = &found.part.summary.orientation;
        (o.inside_out, o.turned_by_normals > 0, o.turned_by_neighbours > 0, o.shells_turned)
    };
    let exact = |what: &str, facets: &[Facet], options: &MeshOptions| {
        let found = sliced(facets, options);
        compare(what, &found, &intact, 0.0, 0.0);
        assert_eq!((found.open.chains, found.part.summary.flipped_edges), (0, 0), "{what}");
        count(&found)
    };
    let auto = MeshOptions::default();
    let wish = |orient| MeshOptions { orient, ..MeshOptions::default() };

    let mut all = good.clone();
    flip(&mut all, &mut Random(0), 1);
    assert_eq!(exact("all flipped", &all, &auto), (true, false, false, 0));
    assert_eq!(exact("all flipped", &all, &wish(Orient::Normals)), (false, true, false, 0));
    assert_eq!(exact("all flipped", &all, &wish(Orient::Repair)), (false, false, true, 0));
    let kept = sliced(&all, &wish(Orient::Winding));
    assert!(kept.part.warnings.iter().any(|w| w.contains("inside out")), "{:?}", kept.part.warnings);

    let mut one = good.clone();
    flip(&mut one[..2000], &mut Random(0), 1);
    let turned = exact("one shell flipped", &shell(&good), &auto);
    assert_eq!(turned, (false, false, false, 1));
    assert!(exact("some flipped", &one, &auto).1);

    for seed in 0..3 {
        let mut half = good.clone();
        flip(&mut half, &mut Random(seed), 2);
        assert_eq!(exact("half flipped", &half, &auto), (false, true, false, 0));
        without_normals(&mut half);
        assert_eq!(exact("half flipped, no normals", &half, &auto), (false, false, true, 0));
        let asked = sliced(&half, &wish(Orient::Normals));
        assert!(asked.part.warnings.iter().any(|w| w.contains("no usable normals")));
    }
}

/// The second shell inside out: the facets whose x is beyond 20 mm.
fn shell(good: &[Facet]) -> Vec<Facet> {
    let mut facets = good.to_vec();
    for (_, corners) in facets.iter_mut().filter(|(_, c)| c[0][0] > 20.0) {
        corners.swap(1, 2);
    }
    facets
}

#[test]
fn duplicates_and_double_walls_change_nothing() {
    let good = facets(&shapes::torus(9.0, 3.0, 90, 45));
    let intact = sliced(&good, &MeshOptions::default());
    for seed in 0..3 {
        let mut random = Random(seed);
        let mut some = good.clone();
        for facet in &good {
            if random.below(10) == 0 {
                some.push((facet.0, [facet.1[1], facet.1[2], facet.1[0]]));
            }
        }
        let found = sliced(&some, &MeshOptions::default());
        compare("some twice", &found, &intact, 0.0, 1e-9);
        assert!(found.part.summary.orientation.duplicates_dropped > 100);
        assert_eq!(found.open.chains, 0);
    }
    let found = sliced(&[good.clone(), good.clone()].concat(), &MeshOptions::default());
    compare("all twice", &found, &intact, 0.0, 1e-9);
    let mut thick = good.clone();
    thick.extend(facets(&shapes::moved(shapes::torus(9.0, 2.98, 90, 45), [0.0, 0.0, 0.02])));
    let found = sliced(&thick, &MeshOptions::default());
    compare("two walls", &found, &intact, 0.0, 1e-6);
}

#[test]
fn cracks_close_by_matching_and_on_the_grid() {
    // A sheet of facets on whole tenths of a millimetre.
    let body = shapes::prism(
        &(0..80)
            .map(|i| match i / 20 {
                0 => [f64::from(i % 20), 0.0],
                1 => [20.0, f64::from(i % 20)],
                2 => [20.0 - f64::from(i % 20), 20.0],
                _ => [0.0, 20.0 - f64::from(i % 20)],
            })
            .collect::<Vec<_>>(),
        0.0,
        5.0,
    );
    let good = facets(&body);
    let intact = sliced(&good, &MeshOptions::default());
    let mut cracked = good.clone();
    for (_, corners) in cracked.iter_mut().filter(|(_, c)| c.iter().map(|c| c[0]).sum::<f32>() > 30.0) {
        corners.iter_mut().for_each(|c| c[0] += 0.003);
    }
    let found = sliced(&cracked, &MeshOptions::default());
    assert!(found.part.summary.open_edges > 0);
    assert!(found.open.matched > 0 && found.open.forced + found.open.dropped == 0, "{:?}", found.open);
    assert!(found.open.worst.unwrap().gap_mm < 0.004);
    compare("cracked", &found, &intact, 1e-3, 0.0);
    let exact = MeshOptions { match_tolerance: Some(1000), ..MeshOptions::default() };
    assert!(sliced(&cracked, &exact).open.forced > 0, "a tolerance below the gap does not reach over it");
    let snapped = MeshOptions { snap_grid: Some(10_000), ..MeshOptions::default() };
    let found = sliced(&cracked, &snapped);
    assert_eq!((found.part.summary.open_edges, found.open.chains), (0, 0));
    assert!(found.part.summary.snapped > 0);
    compare("snapped", &found, &intact, 0.0, 0.0);

    // T-junctions: every other wall facet is split where its neighbour is not.
    let mut split = Vec::new();
    for (i, (normal, [a, b, c])) in good.iter().enumerate() {
        if i % 2 == 0 && normal[2] == 0.0 {
            let m = [0, 1, 2].map(|k| 0.5 * (a[k] + b[k]));
            split.extend([(*normal, [*a, m, *c]), (*normal, [m, *b, *c])]);
        } else {
            split.push((*normal, [*a, *b, *c]));
        }
    }
    let found = sliced(&split, &MeshOptions::default());
    assert!(found.part.summary.open_edges > 0);
    assert_eq!(found.open.forced + found.open.dropped, 0, "{:?}", found.open);
    compare("T-junctions", &found, &intact, 1e-6, 0.0);
}

#[test]
fn flags_reach_the_mesh_and_the_summary_tells_where_gaps_are() {
    let bench = Bench::new();
    let mut holed = ball();
    let mut random = Random(5);
    holed.retain(|_| random.below(10) > 0);
    bench.write("ball.stl", stl(&holed));
    let run = |more: &[&str]| {
        let args = ["slice", "ball.stl", "-o", "a.gcode", "--json"];
        let done = bench.run(args.iter().chain(more));
        (done.status.code(), stderr(&done), serde_json::from_str::<serde_json::Value>(&stdout(&done)).ok())
    };
    let (code, text, summary) = run(&[]);
    let open = &summary.unwrap()["open_contours"];
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("open contours on"), "{text}");
    let of = |key: &str| open[key].as_u64().unwrap();
    assert_eq!(of("chains"), of("matched") + of("forced") + of("dropped"));
    assert!(of("layers") > 10 && open["worst"]["z_mm"].as_f64().unwrap() > 0.0, "{open}");
    assert!(open["worst"]["x_mm"].as_f64().unwrap() > 80.0, "on the bed: {open}");
    let (_, _, wide) = run(&["--match-tolerance", "2.5", "--snap-grid", "0.01"]);
    let wide = wide.unwrap();
    assert!(wide["open_contours"]["forced"].as_u64().unwrap() < of("forced"));

    let mut all = ball();
    flip(&mut all, &mut Random(0), 1);
    bench.write("ball.stl", stl(&all));
    let (code, text, summary) = run(&[]);
    assert_eq!(code, Some(0), "{text}");
    assert!(text.contains("inside out; all its facets were turned"), "{text}");
    assert_eq!(summary.unwrap()["mesh"]["orientation"]["inside_out"], true);
    assert_eq!(run(&["--orient", "normals"]).0, Some(0));
    assert_eq!(run(&["--orient", "inside"]).0, Some(2));
    assert_eq!(run(&["--snap-grid", "-1"]).0, Some(2));
    assert_eq!(run(&["--match-tolerance", "nan"]).0, Some(2));
}
