//! What must be true of whatever is printed: beads stay inside the outline, walls never cross, and neither
//! place nor mirror nor threads change more than they should.

use super::bodies::Random;
use microtome::contour::{ExPolygon, TraceOptions, trace};
use microtome::job::backend::{Backend, BackendOptions};
use microtome::job::filament::{self, FilamentJob, Planned};
use microtome::job::part::MeshOptions;
use microtome::job::progress::Silent;
use microtome::job::summary::Stopwatch;
use microtome::lattice::{Point2, Point3, area2, cross};
use microtome::mesh::{Adjacency, Loaded, Mesh, Placement, demo_part, shapes};
use microtome::path::{LayerPlan, Planner, PrintLayer, Role};
use microtome::region::areas::areas;
use microtome::region::{BeadKind, Wall};
use microtome::settings::flow::{Flow, FlowRole};
use microtome::settings::{FloatOrPercent, Settings};
use microtome::slice::planes;

/// How far the edge of a bead may lie outside the outline \[nm\].
const OUTSIDE: f64 = 10_000.0;

/// Beads of varying width: least and most, in widths of an external wall.
const THIN_WALL: [f64; 2] = [0.499, 1.56];
const GAP_FILL: [f64; 2] = [0.18, 1.56];

fn settings() -> Settings {
    let mut s = Settings::default();
    s.slicing.layer_height = 0.2;
    s.slicing.first_layer_height = FloatOrPercent::Float(0.2);
    s.slicing.resolution = 0.005;
    s.output.gcode_resolution = 0.0;
    s.widths.extrusion_width = FloatOrPercent::Float(0.45);
    s.widths.first_layer_extrusion_width = FloatOrPercent::Float(0.45);
    s
}

fn job(settings: &Settings) -> FilamentJob<'_> {
    FilamentJob {
        settings,
        placement: Placement::DropAndCentre,
        mesh: MeshOptions::default(),
        backend: BackendOptions::new(Backend::Cpu, None, None),
        stem: "part".to_owned(),
        date: 0,
        modifiers: Default::default(),
        copies: 1,
    }
}

fn planned(mesh: &Mesh, job: &FilamentJob<'_>) -> Planned {
    let facets = mesh.triangles.len() as u64;
    let loaded = Loaded { mesh: mesh.clone(), facets, collapsed: 0, warnings: Vec::new() };
    filament::plan_mesh(loaded, "the part", job, &Silent, Stopwatch::default()).unwrap()
}

fn layers(mesh: &Mesh) -> Vec<PrintLayer> {
    planned(mesh, &job(&settings())).layers
}

/// A simple polygon about the origin \[mm\].
fn star(random: &mut Random) -> Vec<[f64; 2]> {
    let corners = 5 + random.below(60);
    let size = 3.0 + random.below(9) as f64;
    (0..corners)
        .map(|i| {
            let turn = i as f64 / corners as f64 * std::f64::consts::TAU;
            let r = size * (0.4 + 0.6 * random.below(1000) as f64 / 1000.0);
            [r * turn.cos(), r * turn.sin()]
        })
        .collect()
}

/// Teeth that become thinner, and gaps between them that become narrower \[mm\].
fn comb() -> Vec<[f64; 2]> {
    let mut points = vec![[0.0, -3.0], [30.0, -3.0], [30.0, 0.0]];
    let mut x = 29.0;
    for k in 0..14 {
        let (wide, gap) = (2.0 - 0.13 * f64::from(k), 0.9 - 0.05 * f64::from(k));
        points.extend([[x, 0.0], [x, 7.0], [x - wide, 7.0], [x - wide, 0.0]]);
        x -= wide + gap;
    }
    points.push([0.0, 0.0]);
    points
}

fn bodies() -> Vec<(String, Mesh)> {
    let mut bodies = vec![
        ("the demo part".to_owned(), demo_part()),
        ("a cone".to_owned(), shapes::cone(6.0, 5.0, 90)),
        ("a comb".to_owned(), shapes::prism(&comb(), 0.0, 1.0)),
        ("a ball".to_owned(), shapes::sphere(5.0, 80, 60)),
        ("a knot".to_owned(), shapes::upright(&shapes::knot(12.0, 2.5, 6_000))),
    ];
    for seed in 0..12 {
        let mut random = Random::new(seed);
        bodies.push((format!("prism, seed {seed}"), shapes::prism(&star(&mut random), 0.0, 1.0)));
    }
    bodies
}

/// The exact sections that layers are cut from, every point of them.
fn sections(mesh: &Mesh) -> Vec<Vec<ExPolygon>> {
    let heights = planes::of_mesh(mesh, &settings()).unwrap();
    let zs = planes::plane_zs(&heights, mesh.origin[2]);
    let options = TraceOptions { simplify_tolerance: None, match_tolerance: 0, memory_budget: 1 << 28 };
    let traced = trace(mesh, &Adjacency::build(mesh), &zs, &options).unwrap();
    traced.iter().map(|l| areas(&l.rings)).collect()
}

/// A mesh on the bed, as the job puts it.
fn placed(mesh: &Mesh) -> Mesh {
    let mut mesh = mesh.clone();
    microtome::mesh::place(&mut mesh, &settings().printer.bed_shape, Placement::DropAndCentre).unwrap();
    mesh
}

fn edges<'a>(rings: impl Iterator<Item = &'a Vec<Point2>>) -> Vec<[Point2; 2]> {
    rings.flat_map(|r| (0..r.len()).map(|i| [r[i], r[(i + 1) % r.len()]])).collect()
}

/// Distance of a point from a segment \[nm\].
fn off(p: Point2, [a, b]: [Point2; 2]) -> f64 {
    let f = |(x, y): (i64, i64)| (x as f64, y as f64);
    let ((ux, uy), (vx, vy)) = (f(b.minus(a)), f(p.minus(a)));
    let along = ((ux * vx + uy * vy) / (ux * ux + uy * uy).max(1.0)).clamp(0.0, 1.0);
    (vx - along * ux).hypot(vy - along * uy)
}

/// Whether two segments have a point in common.
fn meet([a, b]: [Point2; 2], [c, d]: [Point2; 2]) -> bool {
    let side = |p, q, r| cross(p, q, r).signum();
    let within = |p: Point2, q: Point2, r: Point2| {
        side(p, q, r) == 0
            && (p.x.min(q.x)..=p.x.max(q.x)).contains(&r.x)
            && (p.y.min(q.y)..=p.y.max(q.y)).contains(&r.y)
    };
    side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0
        || within(a, b, c)
        || within(a, b, d)
        || within(c, d, a)
        || within(c, d, b)
}

/// Whether two segments' boxes come nearer than `reach`.
fn near([a, b]: [Point2; 2], [c, d]: [Point2; 2], reach: i64) -> bool {
    let apart = |a: i32, b: i32, c: i32, d: i32| {
        let (a, b, c, d) = (i64::from(a), i64::from(b), i64::from(c), i64::from(d));
        a.min(b) - c.max(d) > reach || c.min(d) - a.max(b) > reach
    };
    !apart(a.x, b.x, c.x, d.x) && !apart(a.y, b.y, c.y, d.y)
}

/// Whether the point is inside the outline, or on it.
fn inside(p: Point2, outline: &[[Point2; 2]]) -> bool {
    outline
        .iter()
        .filter(|[a, b]| (a.y <= p.y) != (b.y <= p.y) && (cross(*a, *b, p) > 0) == (b.y > a.y))
        .count()
        % 2
        == 1
}

/// Whether a bead along a line, `half` \[nm\] wide to either side, stays inside the outline.
fn stays_inside(line: &[Point2], half: f64, outline: &[[Point2; 2]]) -> Result<(), String> {
    let least = half - OUTSIDE;
    if least > 0.0 && !inside(line[0], outline) {
        return Err(format!("{:?} lies outside", line[0]));
    }
    for pair in line.windows(2) {
        let segment = [pair[0], pair[1]];
        for &edge in outline.iter().filter(|e| near(segment, **e, half as i64)) {
            let ends = [off(pair[0], edge), off(pair[1], edge), off(edge[0], segment), off(edge[1], segment)];
            let distance =
                if meet(segment, edge) { 0.0 } else { ends.into_iter().fold(f64::INFINITY, f64::min) };
            if distance < least {
                return Err(format!("{segment:?} is {distance:.0} nm from {edge:?}, not {half:.0}"));
            }
        }
    }
    Ok(())
}

/// Every bead of a layer, in the order of printing.
fn beads_stay_inside(plan: &LayerPlan, outline: &[ExPolygon]) -> Result<usize, String> {
    let outline = edges(outline.iter().flat_map(ExPolygon::rings));
    let mut beads = 0;
    for extrusion in &plan.extrusions {
        if matches!(extrusion.role, Role::Skirt | Role::SupportMaterial | Role::SupportInterface) {
            continue;
        }
        stays_inside(plan.path(extrusion), 0.5e6 * extrusion.width, &outline)
            .map_err(|e| format!("{:?}: {e}", extrusion.role))?;
        beads += 1;
    }
    Ok(beads)
}

fn plans(layers: &[PrintLayer]) -> Vec<LayerPlan> {
    let settings = settings();
    let mut planner = Planner::new(Point2::new(0, 0), &settings);
    let plan = |layer| {
        let mut plan = LayerPlan::default();
        planner.layer(layer, &mut plan);
        plan
    };
    layers.iter().map(plan).collect()
}

#[test]
fn no_bead_lies_outside_the_outline() {
    for (name, mesh) in bodies() {
        let sections = sections(&placed(&mesh));
        let plans = plans(&layers(&mesh));
        let mut beads = 0;
        for (i, (plan, section)) in plans.iter().zip(&sections).enumerate() {
            beads += beads_stay_inside(plan, section).unwrap_or_else(|e| panic!("{name}, layer {i}: {e}"));
        }
        assert!(beads > 5, "{name}: {beads} beads");
    }
}

#[test]
fn a_bead_outside_is_seen() {
    let mesh = shapes::prism(&[[0.0, 0.0], [9.0, 0.0], [9.0, 5.0], [0.0, 5.0]], 0.0, 1.0);
    let section = &sections(&placed(&mesh))[2];
    let mut layers = layers(&mesh);
    assert!(beads_stay_inside(&plans(&layers)[2], section).is_ok());
    for p in &mut layers[2].islands[0].walls[0].ring {
        p.x += 11_000;
    }
    assert!(beads_stay_inside(&plans(&layers)[2], section).is_err());
    let outline = edges(section.iter().flat_map(ExPolygon::rings));
    let far = [Point2::new(90_000_000, 0), Point2::new(91_000_000, 0)];
    assert!(stays_inside(&far, 2e5, &outline).is_err());
}

/// Walls of a layer, none of which may meet another or itself.
fn never_cross(walls: &[&Wall]) -> Result<(), String> {
    let mut all: Vec<(usize, usize, [Point2; 2])> = Vec::new();
    for (w, wall) in walls.iter().enumerate() {
        let edges = edges(std::iter::once(&wall.ring));
        all.extend(edges.into_iter().enumerate().map(|(i, e)| (w, i, e)));
    }
    let left = |e: &[Point2; 2]| e[0].x.min(e[1].x);
    all.sort_by_key(|(_, _, e)| left(e));
    for (k, &(w, i, e)) in all.iter().enumerate() {
        let right = e[0].x.max(e[1].x);
        for &(v, j, f) in all[k + 1..].iter().take_while(|(_, _, f)| left(f) <= right) {
            let n = walls[w].ring.len();
            let neighbours = w == v && ((i + 1) % n == j || (j + 1) % n == i);
            if !neighbours && near(e, f, 0) && meet(e, f) {
                return Err(format!("edge {i} of wall {w} meets edge {j} of wall {v}: {e:?}, {f:?}"));
            }
        }
    }
    Ok(())
}

fn walls(layer: &PrintLayer) -> Vec<&Wall> {
    layer.islands.iter().flat_map(|i| &i.walls).collect()
}

#[test]
fn walls_never_cross() {
    let mut seen = 0;
    for (name, mesh) in bodies() {
        for (i, layer) in layers(&mesh).iter().enumerate() {
            never_cross(&walls(layer)).unwrap_or_else(|e| panic!("{name}, layer {i}: {e}"));
            seen += walls(layer).len();
        }
    }
    assert!(seen > 500, "{seen}");
}

#[test]
fn a_crossing_is_seen() {
    let layers = layers(&shapes::cone(6.0, 3.0, 60));
    let mut good: Vec<Wall> = walls(&layers[3]).into_iter().cloned().collect();
    assert!(never_cross(&good.iter().collect::<Vec<_>>()).is_ok());
    let mut touching = good.clone();
    touching[1].ring[4] = touching[0].ring[4];
    assert!(never_cross(&touching.iter().collect::<Vec<_>>()).is_err());
    good[0].ring.swap(3, 9);
    assert!(never_cross(&good.iter().collect::<Vec<_>>()).is_err());
}

#[test]
fn beads_are_as_wide_as_they_may_be() {
    let settings = settings();
    let wide = Flow::new(FlowRole::ExternalPerimeter, 0.2, false, &settings).width_nm() as f64;
    for (name, mesh) in bodies() {
        let layers = layers(&mesh);
        for bead in layers.iter().flat_map(|l| &l.islands).flat_map(|i| &i.beads) {
            let [least, most] = if bead.kind == BeadKind::ThinWall { THIN_WALL } else { GAP_FILL };
            assert_eq!(bead.points.len(), bead.widths.len(), "{name}");
            for &w in &bead.widths {
                let w = f64::from(w) / wide;
                assert!((least..=most).contains(&w), "{name}: {:?} of {w} widths", bead.kind);
            }
        }
        for (i, plan) in plans(&layers).iter().enumerate() {
            for e in &plan.extrusions {
                let w = 1e6 * e.width / wide;
                assert!((GAP_FILL[0]..=GAP_FILL[1]).contains(&w), "{name}, layer {i}: {:?} of {w}", e.role);
            }
        }
    }
}

/// Area inside the walls of every depth, and length of all other lines times their width \[mm²\].
fn sums(layers: &[PrintLayer]) -> (Vec<f64>, f64) {
    let mut inside = vec![0.0; 9];
    for wall in layers.iter().flat_map(walls) {
        inside[wall.depth.min(8) as usize] += area2(&wall.ring) as f64 * 0.5e-12;
    }
    let other = |e: &&microtome::path::Extrusion| {
        !matches!(e.role, Role::Perimeter | Role::ExternalPerimeter | Role::Skirt)
    };
    let plans = plans(layers);
    let filled = plans.iter().flat_map(|p| &p.extrusions).filter(other).map(|e| e.length * e.width);
    (inside, filled.sum())
}

/// Whether two prints have the same area sums.
fn same_sums(a: &[PrintLayer], b: &[PrintLayer]) -> Result<(), String> {
    let ((a, filled), (b, other)) = (sums(a), sums(b));
    for (depth, (a, b)) in a.iter().zip(&b).enumerate() {
        if (a - b).abs() > 0.02 + 2e-4 * a.abs() {
            return Err(format!("walls at depth {depth}: {a} and {b} mm2"));
        }
    }
    // Rows lie elsewhere in the mirrored part, so that lines begin and end elsewhere.
    if (filled - other).abs() > 2.0 + 0.03 * filled {
        return Err(format!("infill: {filled} and {other} mm2"));
    }
    Ok(())
}

#[test]
fn a_mirrored_part_has_mirrored_areas() {
    for (name, mesh) in bodies() {
        let mut mirrored = mesh.clone();
        mirrored.vertices.iter_mut().for_each(|v| v.x = -v.x);
        mirrored.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        mirrored.origin[0] = -mirrored.origin[0];
        let own = layers(&mesh);
        same_sums(&own, &layers(&mirrored)).unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut larger = mesh;
        larger.vertices.iter_mut().for_each(|v| v.x += v.x / 200);
        assert!(same_sums(&own, &layers(&larger)).is_err(), "{name}: the comparison is blind");
    }
}

#[test]
fn a_moved_part_has_the_same_paths() {
    let settings = settings();
    let mut job = job(&settings);
    job.placement = Placement::Keep;
    for (name, mesh) in bodies() {
        let lifted = |by: [i64; 2]| {
            let mut mesh = mesh.clone();
            let low = mesh.world_bounds().unwrap()[0];
            mesh.origin =
                [mesh.origin[0] - low[0] + by[0], mesh.origin[1] - low[1] + by[1], mesh.origin[2] - low[2]];
            planned(&mesh, &job)
        };
        let (here, there) = (lifted([10_000_000, 20_000_000]), lifted([71_234_567, 44_444_444]));
        assert!(here.layers == there.layers, "{name}");
        assert_eq!(there.origin[0] - here.origin[0], 61_234_567, "{name}");
        assert_eq!(there.origin[1] - here.origin[1], 24_444_444, "{name}");
    }
}

/// The walls of a part whose corners lie elsewhere on the lattice are the same, moved.
#[test]
fn walls_move_with_the_corners_of_the_part() {
    for (name, mesh) in bodies() {
        let (dx, dy) = (12_345_679, -7_654_321);
        let mut moved = mesh.clone();
        moved.vertices.iter_mut().for_each(|v| *v = Point3::new(v.x + dx, v.y + dy, v.z));
        let (own, moved) = (layers(&mesh), layers(&moved));
        for (i, (a, b)) in own.iter().zip(&moved).enumerate() {
            let shift = |w: &&Wall| -> Vec<Point2> {
                w.ring.iter().map(|p| Point2::new(p.x + dx, p.y + dy)).collect()
            };
            let there: Vec<_> = walls(b).iter().map(|w| w.ring.clone()).collect();
            assert!(walls(a).iter().map(shift).collect::<Vec<_>>() == there, "{name}, layer {i}");
        }
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let settings = settings();
    let job = job(&settings);
    let text = |mesh: &Mesh, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut out = Vec::new();
            filament::write(planned(mesh, &job), &job, &mut out, &Silent).unwrap();
            out
        })
    };
    for (name, mesh) in bodies() {
        let one = text(&mesh, 1);
        assert!(one.len() > 1_000, "{name}");
        for threads in [2, 3] {
            assert!(text(&mesh, threads) == one, "{name}, {threads} threads");
        }
    }
    assert!(text(&demo_part(), 1) != text(&shapes::cone(6.0, 5.0, 90), 1));
}
