//! Walls that depend on the layers above and below, on shapes worked out by hand and on random ones.

use super::extra::extra_walls;
use super::foot::compensate;
use super::gaps::BeadPlan;
use super::inside::{Cover, Edges};
use super::layers::all_walls;
use super::perimeters::{Neighbours, WallPlan, walls};
use super::tests::Random;
use super::{Island, Wall, boolean, offset};
use crate::contour::{ExPolygon, Ring};
use crate::lattice::Point2;
use crate::settings::OnePerimeter;

const PLAN: WallPlan = WallPlan {
    count: 2,
    external_width: 450_000,
    external_spacing: 400_000,
    perimeter_spacing: 420_000,
    solid_spacing: 400_000,
    solid_width: 440_000,
    infill_overlap: 100_000,
    extra: true,
    reach: 200_000,
    one_wall: OnePerimeter::None,
    beads: BeadPlan { thin_walls: false, gap_fill: false, rounding: 0 },
};

/// A rectangle from corners in micrometres.
fn rectangle(x0: i32, y0: i32, x1: i32, y1: i32) -> Ring {
    [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(1000 * x, 1000 * y)).to_vec()
}

fn area(contour: Ring) -> Vec<ExPolygon> {
    vec![ExPolygon { contour, holes: vec![] }]
}

fn with_hole(contour: Ring, mut hole: Ring) -> Vec<ExPolygon> {
    hole.reverse();
    vec![ExPolygon { contour, holes: vec![hole] }]
}

fn on(below: &[ExPolygon]) -> Neighbours<'_> {
    Neighbours { below: Some(below), above: None }
}

fn under(above: &[ExPolygon]) -> Neighbours<'_> {
    Neighbours { below: None, above: Some(above) }
}

fn hanging(wall: &Wall) -> f64 {
    let n = wall.ring.len();
    assert!(wall.overhang.is_empty() || wall.overhang.len() == n && wall.overhang.contains(&true));
    let edges = (0..n).filter(|&i| wall.overhang.get(i) == Some(&true));
    edges.map(|i| wall.ring[i].distance(wall.ring[(i + 1) % n])).sum()
}

fn all_hanging(islands: &[Island]) -> f64 {
    islands.iter().flat_map(|i| &i.walls).map(hanging).sum()
}

#[test]
fn walls_are_added_where_a_pyramid_asks_for_them() {
    // Walls reach 0.425 + 0.42 deep; outlines above count up to 1.5 * 0.42 further in.
    let own = area(rectangle(0, 0, 40_000, 40_000));
    for (step, extra) in [(800, 0), (850, 1), (1_000, 1), (1_300, 2), (1_470, 2), (1_480, 0), (5_000, 0)] {
        let above = area(rectangle(step, step, 40_000 - step, 40_000 - step));
        let found = extra_walls(&own, &above, &PLAN).first().copied().unwrap_or(0);
        assert_eq!(found, extra, "step {step}");
        let depth = walls(own.clone(), &under(&above), &PLAN)[0].walls.iter().map(|w| w.depth).max();
        assert_eq!(depth, Some(1 + extra));
    }
    assert!(extra_walls(&own, &own, &PLAN).is_empty());
}

#[test]
fn a_slope_on_one_side_of_four_is_no_reason() {
    let own = area(rectangle(0, 0, 40_000, 40_000));
    let one = area(rectangle(1_000, 0, 40_000, 40_000));
    assert_eq!(extra_walls(&own, &one, &PLAN).iter().sum::<u32>(), 0);
    let two = area(rectangle(1_000, 0, 39_000, 40_000));
    assert_eq!(extra_walls(&own, &two, &PLAN), [1]);
    // Each island counts by itself, as if the other were not on the bed.
    let far = |mut ring: Ring| {
        ring.iter_mut().for_each(|p| p.x += 100_000_000);
        ring
    };
    let both = |a: &[ExPolygon], b: Ring| [a.to_vec(), area(far(b))].concat();
    let (own, above) = (both(&own, own[0].contour.clone()), both(&two, own[0].contour.clone()));
    assert_eq!(extra_walls(&own, &above, &PLAN), [1, 0]);
}

#[test]
fn a_table_top_hangs_outside_its_leg() {
    let leg = area(rectangle(10_000, 10_000, 20_000, 20_000));
    let top = walls(area(rectangle(0, 0, 30_000, 30_000)), &on(&leg), &PLAN);
    assert_eq!(top[0].walls.len(), 2);
    assert!(top[0].walls.iter().all(|w| w.overhang == vec![true; 4]));
    // The first layer lies on the bed.
    let first = walls(area(rectangle(0, 0, 30_000, 30_000)), &Neighbours::default(), &PLAN);
    assert_eq!(all_hanging(&first), 0.0);
}

#[test]
fn a_wall_hangs_from_half_the_bore_outside_the_layer_below() {
    let below = area(rectangle(0, 0, 10_000, 10_000));
    let on_it = |x: i32| walls(area(rectangle(x, 0, x + 10_000, 10_000)), &on(&below), &PLAN);
    // The external wall runs 0.225 inside: at 10.175, and at 10.225.
    assert_eq!(all_hanging(&on_it(400)), 0.0);
    assert_eq!(all_hanging(&on_it(450)), 9.55e6 + 2.0 * 0.025e6);
    let islands = on_it(5_000);
    let wall = &islands[0].walls[0];
    let mut ring = rectangle(5_225, 225, 14_775, 9_775);
    ring.insert(1, Point2::new(10_200_000, 225_000));
    ring.insert(4, Point2::new(10_200_000, 9_775_000));
    assert_eq!(wall.ring, ring);
    assert_eq!(wall.overhang, [false, true, true, true, false, false]);
}

#[test]
fn walls_over_a_pocket_hang_and_short_parts_do_not_count() {
    let own = || area(rectangle(0, 0, 10_000, 10_000));
    let over = |hole: Ring| {
        let below = with_hole(rectangle(0, 0, 10_000, 10_000), hole);
        all_hanging(&walls(own(), &on(&below), &WallPlan { count: 12, ..PLAN }))
    };
    // Of the walls at 0.225, 0.635, 1.055 .. those over a pocket that is open from 3.2 to 6.8 hang.
    let rings = (0..).map(|i| 635_000.0 + 420_000.0 * f64::from(i)).take(11);
    let expected: f64 = rings.filter(|d| *d > 3.2e6).map(|d| 4.0 * (10e6 - 2.0 * d)).sum();
    assert_eq!(over(rectangle(3_000, 3_000, 7_000, 7_000)), expected);
    // A slit of 0.5 leaves 0.1 in air, one of 0.7 leaves 0.3 of each of the two walls that cross it.
    let slit = |w: i32| over(rectangle(5_000, 20, 5_000 + w, 1_000));
    assert_eq!(slit(500), 0.0);
    assert_eq!(slit(700), 2.0 * 0.3e6);
}

#[test]
fn a_step_has_one_wall_around_its_tread() {
    let own = area(rectangle(0, 0, 20_000, 10_000));
    let riser = area(rectangle(0, 0, 10_000, 10_000));
    let plan = WallPlan { count: 3, extra: false, one_wall: OnePerimeter::Top, ..PLAN };
    let islands = walls(own.clone(), &under(&riser), &plan);
    let island = &islands[0];
    let of = |depth: u32| island.walls.iter().filter(move |w| w.depth == depth).map(|w| w.ring.clone());
    assert_eq!(of(0).collect::<Vec<_>>(), [rectangle(225, 225, 19_775, 9_775)]);
    // The second wall's edge, half a spacing outside, lies under the riser.
    assert_eq!(of(1).collect::<Vec<_>>(), [rectangle(635, 635, 9_790, 9_365)]);
    assert_eq!(of(2).count(), 1);
    // Inside the walls, and on the tread: 0.3 from the external centre line, 0.31 from the second wall.
    assert_eq!(island.infill.len(), 2);
    let tread: f64 = ExPolygon::area_mm2(&island.infill[1]);
    let wide = 0.225 + 0.2 - 0.1 + 0.2;
    let (left, right, height) = (9.790 + 0.31, 20.0 - wide, 10.0 - 2.0 * wide);
    // The strips above and below the second wall, up to where its corners end, are too narrow.
    assert!((tread - (right - left) * height).abs() < 0.02, "{tread}");

    // Not where the tread is narrow, not with the topmost layer only, nowhere without being asked.
    let narrow = area(rectangle(0, 0, 19_000, 10_000));
    let count = |above: &[ExPolygon], one_wall| {
        walls(own.clone(), &under(above), &WallPlan { one_wall, ..plan })[0].infill.len()
    };
    assert_eq!(count(&narrow, OnePerimeter::Top), 1);
    assert_eq!(count(&riser, OnePerimeter::Topmost), 1);
    assert_eq!(count(&riser, OnePerimeter::None), 1);
    for (one_wall, walls_left) in
        [(OnePerimeter::Topmost, 1), (OnePerimeter::Top, 1), (OnePerimeter::None, 3)]
    {
        let plan = WallPlan { one_wall, ..plan };
        assert_eq!(walls(own.clone(), &Neighbours::default(), &plan)[0].walls.len(), walls_left);
    }
}

#[test]
fn thin_parts_survive_the_compensation() {
    let thin = |w: i32| compensate(&area(rectangle(0, 0, 10_000, w)), 200_000, 450_000);
    assert_eq!(thin(5_000), area(rectangle(200, 200, 9_800, 4_800)));
    assert_eq!(thin(300), area(rectangle(0, 0, 10_000, 300)));
    for w in [460, 600, 700, 840] {
        let left = thin(w);
        assert_eq!(left.len(), 1, "{w}");
        let ys = left[0].contour.iter().map(|p| p.y);
        let (low, high) = ys.fold((i32::MAX, i32::MIN), |(low, high), y| (low.min(y), high.max(y)));
        let width = high - low;
        assert!((450_000..=500_000).contains(&width), "{w}: {width}");
    }
    // Two pads and a bridge of 0.3 between them stay one part.
    let mut parts = area(rectangle(0, 0, 5_000, 5_000));
    parts.extend(area(rectangle(10_000, 0, 15_000, 5_000)));
    parts.extend(area(rectangle(4_000, 2_350, 11_000, 2_650)));
    let dumbbell = boolean::union(parts.iter().map(|p| &p.contour), boolean::Winding::NonZero);
    let left = compensate(&dumbbell, 200_000, 450_000);
    assert_eq!(left.len(), 1);
    let sum = left[0].area_mm2();
    assert!((2.0 * 4.6 * 4.6 + 5.0 * 0.3..2.0 * 4.6 * 4.6 + 5.4 * 0.3 + 0.5).contains(&sum), "{sum}");
    assert_eq!(offset::inset(&dumbbell, 200_000).len(), 2);
}

impl Random {
    /// Rectangles and blobs, on a grid half of the time so that borders touch.
    fn boxes_and_blobs(&mut self) -> Vec<ExPolygon> {
        let grid = [1, 500][self.below(2) as usize];
        let mut rings = Vec::new();
        for _ in 0..1 + self.below(4) {
            let (x, y) = (self.range(0, 8_000), self.range(0, 8_000));
            let (w, h) = (self.range(500, 8_000), self.range(500, 8_000));
            let snap = |v: i32| (v / grid + 1) * grid;
            let mut ring = rectangle(snap(x), snap(y), snap(x) + snap(w), snap(y) + snap(h));
            if self.below(2) == 0 {
                ring = (0..24)
                    .map(|i| {
                        let t = f64::from(i) / 24.0 * std::f64::consts::TAU;
                        let r = f64::from(w) * 0.5e3 * (1.0 + 0.2 * libm::sin(3.0 * t));
                        let at = |c: i32, by: f64| 1000 * c + by as i32;
                        Point2::new(at(x, r * libm::cos(t)), at(y, r * libm::sin(t)))
                    })
                    .collect();
            }
            if rings.len() > 1 && self.below(3) == 0 {
                ring.reverse();
            }
            rings.push(ring);
        }
        boolean::union(&rings, boolean::Winding::Positive)
    }
}

fn mapped(polygons: &[ExPolygon], f: impl Fn(&Ring) -> Ring) -> Vec<ExPolygon> {
    let one = |p: &ExPolygon| ExPolygon { contour: f(&p.contour), holes: p.holes.iter().map(&f).collect() };
    polygons.iter().map(one).collect()
}

#[test]
fn points_and_lengths_inside_agree_with_the_polygon_library() {
    let seed = 0x5EED_0011;
    let mut random = Random(seed);
    let mut lengths = 0.0;
    for case in 0..300 {
        let (a, b) = (random.boxes_and_blobs(), random.boxes_and_blobs());
        let edges = Edges::new(&a);
        for _ in 0..20 {
            let p = Point2::new(random.range(-1, 15) * 1_000_003, random.range(-1, 15) * 1_000_003);
            let around: i32 = a.iter().flat_map(ExPolygon::rings).map(|r| winding(r, p)).sum();
            assert_eq!(edges.contains(p), around > 0, "seed {seed:#x}, case {case}");
        }
        // The border of the common part is a's inside b and b's inside a; where both run along each
        // other it is on no side, so those are moved apart.
        let b = mapped(&b, |r| r.iter().map(|p| Point2::new(p.x + 123_457, p.y + 98_765)).collect());
        let common = boolean::intersection(&a, &b);
        let rings = |p: &[ExPolygon]| p.iter().flat_map(ExPolygon::rings).cloned().collect::<Vec<_>>();
        let within = Edges::new(&a).length_inside(&rings(&b)) + Edges::new(&b).length_inside(&rings(&a));
        let whole: f64 = rings(&common)
            .iter()
            .map(|r| (0..r.len()).map(|i| r[i].distance(r[(i + 1) % r.len()])).sum::<f64>())
            .sum();
        assert!((within - whole).abs() < 30_000.0, "seed {seed:#x}, case {case}: {within}, {whole}");
        lengths += within;
    }
    assert!(lengths > 1e9);
}

fn winding(ring: &Ring, p: Point2) -> i32 {
    let turn = |i: usize| {
        let (a, b) = (ring[i], ring[(i + 1) % ring.len()]);
        let left = crate::lattice::cross(a, b, p) > 0;
        i32::from(a.y <= p.y && b.y > p.y && left) - i32::from(b.y <= p.y && a.y > p.y && !left)
    };
    (0..ring.len()).map(turn).sum()
}

#[test]
fn a_cover_holds_what_the_difference_leaves_nothing_of() {
    let seed = 0x5EED_0012;
    let mut random = Random(seed);
    let mut held = 0;
    for case in 0..300 {
        let (a, b) = (random.boxes_and_blobs(), offset::inset(&random.boxes_and_blobs(), 300_000));
        for island in &b {
            let cover = Cover::new(&a);
            let holds = cover.holds(&island.rings().collect::<Vec<_>>());
            let left = boolean::difference(std::slice::from_ref(island), &a);
            // A border that is touched is not held, though nothing is left.
            assert!(!holds || left.is_empty(), "seed {seed:#x}, case {case}");
            held += u32::from(holds);
        }
    }
    assert!(held > 20, "{held}");
}

#[test]
fn walls_on_slopes_move_and_mirror_with_their_layers() {
    let seed = 0x5EED_0013;
    let mut random = Random(seed);
    let mut sums = (0.0, 0);
    for case in 0..120 {
        let one_wall = [OnePerimeter::None, OnePerimeter::Top, OnePerimeter::Topmost][case % 3];
        let plan = WallPlan { one_wall, ..PLAN };
        let (below, own) = (random.boxes_and_blobs(), random.boxes_and_blobs());
        let above = offset::inset(&own, i64::from(random.range(0, 1_500)) * 1000);
        let of = |f: &dyn Fn(&Ring) -> Ring| {
            let (below, above) = (mapped(&below, f), mapped(&above, f));
            walls(mapped(&own, f), &Neighbours { below: Some(&below), above: Some(&above) }, &plan)
        };
        let (dx, dy) = (random.range(-9, 9) * 100_000_007, random.range(-9, 9) * 99_999_989);
        let shift = |r: &Ring| r.iter().map(|p| Point2::new(p.x + dx, p.y + dy)).collect::<Ring>();
        let here = of(&Ring::clone);
        let mut there = of(&shift);
        assert_eq!(here.len(), there.len());
        for (a, b) in here.iter().zip(&mut there) {
            assert_eq!(mapped(&a.infill, shift), b.infill, "seed {seed:#x}, case {case}");
            let moved: Vec<Wall> =
                a.walls.iter().map(|w| Wall { ring: shift(&w.ring), ..w.clone() }).collect();
            assert_eq!(moved, b.walls, "seed {seed:#x}, case {case}");
        }
        let mirrored = of(&|r| r.iter().rev().map(|p| Point2::new(-p.x, p.y)).collect());
        let infill = |i: &[Island]| i.iter().flat_map(|i| &i.infill).map(ExPolygon::area_mm2).sum::<f64>();
        assert!((infill(&here) - infill(&mirrored)).abs() < 0.05, "seed {seed:#x}, case {case}");
        let error = all_hanging(&here) - all_hanging(&mirrored);
        assert!(error.abs() < 0.5e6, "seed {seed:#x}, case {case}: {error}");
        sums.0 += all_hanging(&here);
        sums.1 += here.iter().flat_map(|i| &i.walls).filter(|w| w.depth >= PLAN.count).count();
    }
    // The cases do show what is tested.
    assert!(sums.0 > 1e8 && sums.1 > 10, "{sums:?}");
}

#[test]
fn equal_layers_have_the_walls_that_each_would_have_alone() {
    let seed = 0x5EED_0014;
    let mut random = Random(seed);
    for case in 0..12 {
        let kinds: Vec<Vec<ExPolygon>> = (0..3).map(|_| random.boxes_and_blobs()).collect();
        let mut areas = Vec::new();
        let mut plans = Vec::new();
        while areas.len() < 40 {
            let kind = &kinds[random.below(3) as usize];
            let plan = WallPlan { count: 1 + random.below(2) as u32, ..PLAN };
            for _ in 0..1 + random.below(8) {
                areas.push(kind.clone());
                plans.push(plan);
            }
        }
        let alone: Vec<Vec<Island>> = (0..areas.len())
            .map(|i| {
                let neighbours = Neighbours {
                    below: i.checked_sub(1).map(|j| areas[j].as_slice()),
                    above: areas.get(i + 1).map(Vec::as_slice),
                };
                walls(areas[i].clone(), &neighbours, &plans[i])
            })
            .collect();
        assert_eq!(all_walls(areas, &plans), alone, "seed {seed:#x}, case {case}");
    }
}
