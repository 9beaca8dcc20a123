//! Overhangs of simple bodies, whose answer is known.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::lattice::Point2;
use crate::settings::Settings;
use crate::span::RowsBuilder;
use crate::span::algebra::dilate;
use crate::span::scan;
use crate::span::tests::Random;
use crate::support::Level;

const LAYER: i64 = 200_000;

type Ring = Vec<[f64; 2]>;

/// Layers as polygons \[mm\], 0.2 mm thick.
struct Body {
    outlines: Vec<Arc<Rows>>,
    levels: Vec<Level>,
    plan: SupportPlan,
}

fn plan(threshold: f64) -> SupportPlan {
    let mut settings = Settings::default();
    settings.support.support_material = true;
    settings.support.support_material_threshold = threshold;
    SupportPlan::new(&settings)
}

fn on_rows(rings: &[Ring], degrees: f64, frame: &RowFrame) -> Rows {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let nm = |mm: f64| (mm * 1e6).round() as i32;
    let point = |p: &[f64; 2]| Point2::new(nm(p[0] * cos - p[1] * sin), nm(p[0] * sin + p[1] * cos));
    let rings: Vec<Vec<Point2>> = rings.iter().map(|r| r.iter().map(point).collect()).collect();
    scan(rings.iter().map(|r| &r[..]), frame)
}

fn rect(x: [f64; 2], y: [f64; 2]) -> Ring {
    vec![[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]]
}

impl Body {
    /// Layers turned by some degrees.
    fn new(layers: &[Vec<Ring>], degrees: f64, plan: SupportPlan) -> Self {
        let rows = |rings: &Vec<Ring>| Arc::new(on_rows(rings, degrees, &plan.frame));
        let levels = (0..layers.len() as i64).map(|i| Level { bottom: i * LAYER, top: (i + 1) * LAYER });
        Self { outlines: layers.iter().map(rows).collect(), levels: levels.collect(), plan }
    }

    fn part(&self) -> Part<'_> {
        Part { outlines: &self.outlines, levels: &self.levels, frame: &self.plan.frame }
    }

    fn plain(&self) -> Vec<Overhang> {
        self.with(Modifiers::default(), &[])
    }

    fn with(&self, modifiers: Modifiers, bridges: &[Vec<Bridge>]) -> Vec<Overhang> {
        let bridges = Bridges { of_layer: bridges, frame: &area_frame() };
        overhangs(self.part(), modifiers, bridges, &self.plan)
    }

    fn mm2(&self, rows: &Rows) -> f64 {
        rows.length() as f64 * self.plan.frame.mm2_per_unit()
    }
}

/// The infill's rows.
fn area_frame() -> RowFrame {
    RowFrame::new(45.0, 0.0, 407_080.0)
}

/// A bridge laid in a polygon that is turned by some degrees, in a direction from there.
fn bridge(ring: Ring, degrees: f64, along: f64) -> Bridge {
    let rows = on_rows(&[ring], degrees, &area_frame());
    Bridge { rows, degrees: (degrees + along).rem_euclid(180.0) }
}

/// A wall that leans over by `degrees` from horizontal.
fn wedge(degrees: f64, layers: usize) -> Vec<Vec<Ring>> {
    let step = 0.2 / libm::tan(degrees.to_radians());
    (0..layers).map(|i| vec![rect([0.0, 6.0 + step * i as f64], [0.0, 20.0])]).collect()
}

#[test]
fn slopes_are_found_in_every_direction() {
    for threshold in [30.0, 45.0, 60.0] {
        for turn in [0.0, 30.0, 90.0, 137.0, 180.0, 270.0] {
            // What a sixth of a row is over the reach, in degrees, and a bit.
            for (off, least, most) in [(5.0, 0.0, 0.0), (-5.0, 1.0, 1.0), (0.0, 0.0, 1.0)] {
                let slope = threshold + off;
                let body = Body::new(&wedge(slope, 60), turn, plan(threshold));
                let found = body.plain();
                let strip = 20.0 * 0.2 / libm::tan(slope.to_radians());
                let area: f64 = found.iter().skip(9).map(|o| body.mm2(&o.area)).sum::<f64>();
                let share = area / (51.0 * strip);
                let what = format!("threshold {threshold}, slope {slope}, turned {turn}: {share}");
                assert!(share >= least - 0.04 && share <= most + 0.04, "{what}");
                assert!(found.iter().all(|o| o.islands.is_empty() && o.bridged.is_empty()), "{what}");
                if off < 0.0 {
                    assert!(found.iter().skip(9).all(|o| !o.area.is_empty()), "{what}");
                }
            }
        }
    }
}

#[test]
fn without_a_threshold_half_a_wall_is_allowed() {
    let own = plan(0.0);
    assert_eq!(own.threshold, None);
    let reach = own.half_wall * 1e-6;
    for turn in [0.0, 90.0, 30.0] {
        for (factor, is_found) in [(0.85, false), (1.15, true)] {
            let step = reach * factor;
            let layers: Vec<Vec<Ring>> =
                (0..40).map(|i| vec![rect([0.0, 6.0 + step * f64::from(i)], [0.0, 9.0])]).collect();
            let found = Body::new(&layers, turn, plan(0.0)).plain();
            let count = found.iter().skip(9).filter(|o| !o.area.is_empty()).count();
            assert_eq!(count, if is_found { 31 } else { 0 }, "turned {turn}, {factor}");
        }
    }
}

/// A T of the given arms \[mm\].
fn tee() -> Vec<Vec<Ring>> {
    let stem = vec![rect([-3.0, 3.0], [0.0, 8.0])];
    [vec![stem; 10], vec![vec![rect([-15.0, 15.0], [0.0, 8.0])]; 4]].concat()
}

#[test]
fn both_arms_of_a_tee_hang_as_a_whole() {
    for turn in [0.0, 45.0, 71.0] {
        let body = Body::new(&tee(), turn, plan(45.0));
        let found = body.plain();
        assert!(found.iter().enumerate().all(|(i, o)| (i == 10) != o.area.is_empty()));
        let area = body.mm2(&found[10].area);
        assert!((area - 2.0 * 12.0 * 8.0).abs() < 0.02 * area, "{area}");
        assert!(found[10].islands.is_empty());
        // The infill lays bridges in the arms, held at one end only.
        let laid = [[-14.0, -2.0], [2.0, 14.0]].map(|x| bridge(rect(x, [1.0, 7.0]), turn, 0.0));
        let mut bridges = vec![Vec::new(); 14];
        bridges[10] = laid.to_vec();
        let again = body.with(Modifiers::default(), &bridges);
        assert_eq!(again, found, "turned {turn}");
    }
}

/// A table's two legs and its top.
fn table(length: f64) -> Vec<Vec<Ring>> {
    let legs = vec![rect([-4.0, 0.0], [0.0, 10.0]), rect([length, length + 4.0], [0.0, 10.0])];
    [vec![legs; 5], vec![vec![rect([-4.0, length + 4.0], [0.0, 10.0])]; 3]].concat()
}

#[test]
fn a_bridge_between_two_legs_holds_itself() {
    for (turn, length) in [(0.0, 20.0), (90.0, 20.0), (23.0, 20.0), (45.0, 50.0), (0.0, 64.0)] {
        let mut body = Body::new(&table(length), turn, plan(45.0));
        let mut bridges = vec![Vec::new(); 8];
        bridges[5] = vec![bridge(rect([-2.0, length + 2.0], [1.0, 9.0]), turn, 0.0)];
        let found = body.with(Modifiers::default(), &bridges);
        let (area, bridged) = (body.mm2(&found[5].area), body.mm2(&found[5].bridged));
        let whole = 10.0 * length;
        if length <= 60.0 {
            assert!(found.iter().all(|o| o.area.is_empty()), "turned {turn}: {area}");
            assert!((bridged - whole).abs() < 0.015 * whole, "turned {turn}: {bridged} of {whole}");
        } else {
            assert!((area - whole).abs() < 0.015 * whole && bridged == 0.0, "{area} and {bridged}");
        }
        // Laid the other way, its lines rest on nothing.
        bridges[5][0].degrees = (bridges[5][0].degrees + 90.0).rem_euclid(180.0);
        let across = body.with(Modifiers::default(), &bridges);
        assert!(across[5].bridged.is_empty() && (body.mm2(&across[5].area) - whole).abs() < 0.015 * whole);
        bridges[5][0].degrees = turn;
        body.plan.spare_bridges = false;
        let all = body.with(Modifiers::default(), &bridges);
        assert!((body.mm2(&all[5].area) - whole).abs() < 0.015 * whole && all[5].bridged.is_empty());
    }
}

#[test]
fn beside_a_bridge_a_curved_wall_is_supported() {
    // Between the legs the top is wider on one side, in a bow of 3 mm.
    let bow = |x: f64| 10.0 + 3.0 * (1.0 - (x / 10.0 - 1.0) * (x / 10.0 - 1.0));
    let mut top = vec![[-4.0, 0.0], [24.0, 0.0], [24.0, 10.0]];
    top.extend((0..=40).rev().map(|i| f64::from(i) * 0.5).map(|x| [x, bow(x)]));
    top.push([-4.0, 10.0]);
    let legs = table(20.0)[0].clone();
    let layers = [vec![legs; 5], vec![vec![top]; 2]].concat();
    for turn in [0.0, 90.0, 33.0] {
        let body = Body::new(&layers, turn, plan(45.0));
        let mut bridges = vec![Vec::new(); 7];
        bridges[5] = vec![bridge(rect([-2.0, 22.0], [1.0, 11.0]), turn, 0.0)];
        let found = body.with(Modifiers::default(), &bridges);
        let (area, bridged) = (body.mm2(&found[5].area), body.mm2(&found[5].bridged));
        // The bow's own area is two thirds of its bounds.
        assert!((area - 40.0).abs() < 3.5, "turned {turn}: {area}");
        assert!((bridged - 200.0).abs() < 5.0, "turned {turn}: {bridged}");
    }
}

#[test]
fn a_hole_in_a_bridge_cuts_its_lines() {
    let hole: Ring = vec![[9.0, 4.0], [9.0, 6.0], [11.0, 6.0], [11.0, 4.0]];
    let mut layers = table(20.0);
    layers.iter_mut().skip(5).for_each(|l| l.push(hole.clone()));
    let body = Body::new(&layers, 0.0, plan(45.0));
    let mut bridges = vec![Vec::new(); 8];
    let around = [
        rect([-2.0, 22.0], [1.0, 3.0]),
        rect([-2.0, 22.0], [7.0, 9.0]),
        rect([-2.0, 8.0], [3.0, 7.0]),
        rect([12.0, 22.0], [3.0, 7.0]),
    ];
    // Those of one direction are one.
    let laid = around.map(|r| bridge(r, 0.0, 0.0).rows).iter().fold(Rows::default(), |a, b| or(&a, b));
    bridges[5] = vec![Bridge { rows: laid, degrees: 0.0 }];
    let found = body.with(Modifiers::default(), &bridges);
    let area = body.mm2(&found[5].area);
    // Lines that end at the hole, 36 mm², and the walls along it, 8 mm², but for a row of the infill's where
    // these meet what is bridged.
    assert!(area > 36.5 && area < 44.0, "{area}");
}

#[test]
fn islands_are_found_however_small() {
    let mut layers = tee();
    for layer in layers.iter_mut().skip(6) {
        layer.push(rect([30.0, 30.4], [0.0, 0.4]));
        layer.push(rect([40.0, 40.1], [0.0, 0.1]));
        // Side by side with what stands.
        layer.push(rect([3.2, 4.0], [0.0, 8.0]));
    }
    let body = Body::new(&layers, 0.0, plan(45.0));
    let found = body.plain();
    let small = body.mm2(&found[6].islands);
    assert!((small - 0.16 - 0.8 * 8.0).abs() < 0.3, "{small}");
    assert_eq!(found[6].islands, found[6].area);
    assert!(found.iter().enumerate().all(|(i, o)| (i == 6) != o.islands.is_empty()));
    let mut body = body;
    body.plan.auto = false;
    assert!(body.plain().iter().all(|o| o.area.is_empty()));
}

#[test]
fn enforcers_and_blockers_have_their_way() {
    let mut body = Body::new(&wedge(60.0, 30), 0.0, plan(45.0));
    assert!(body.plain().iter().all(|o| o.area.is_empty()));
    let some = Arc::new(on_rows(&[rect([0.0, 90.0], [5.0, 10.0])], 0.0, &body.plan.frame));
    let enforced = vec![Arc::clone(&some); 30];
    let strip = 5.0 * 0.2 / libm::tan(60f64.to_radians());
    for auto in [true, false] {
        body.plan.auto = auto;
        let found = body.with(Modifiers { enforced: &enforced, blocked: &[] }, &[]);
        for o in &found[1..] {
            assert!((body.mm2(&o.area) - strip).abs() < 0.03 * strip, "{}", body.mm2(&o.area));
        }
        let none = body.with(Modifiers { enforced: &enforced, blocked: &enforced }, &[]);
        assert!(none.iter().all(|o| o.area.is_empty()));
    }
    // In an enforcer a bridge is supported as well.
    let body = Body::new(&table(20.0), 0.0, plan(45.0));
    let mut bridges = vec![Vec::new(); 8];
    bridges[5] = vec![bridge(rect([-2.0, 22.0], [1.0, 9.0]), 0.0, 0.0)];
    let found = body.with(Modifiers { enforced: &enforced[..8], blocked: &[] }, &bridges);
    let [area, bridged] = [&found[5].area, &found[5].bridged].map(|r| body.mm2(r));
    assert!((area - 100.0).abs() < 2.0 && (bridged - 100.0).abs() < 2.0, "{area} and {bridged}");
    let found = body.with(Modifiers { enforced: &[], blocked: &enforced[..8] }, &[]);
    assert!((body.mm2(&found[5].area) - 100.0).abs() < 2.0);
}

#[test]
fn a_shrunk_first_layer_makes_nothing_hang() {
    let shrunk = vec![rect([0.2, 9.8], [0.2, 9.8])];
    let layers = [vec![shrunk], vec![vec![rect([0.0, 10.0], [0.0, 10.0])]; 3]].concat();
    for (turn, enforce) in [(0.0, 0), (30.0, 0), (45.0, 2)] {
        let mut body = Body::new(&layers, turn, plan(60.0));
        body.plan.enforce_layers = enforce;
        assert!(body.plain().iter().any(|o| !o.area.is_empty()));
        body.plan.first_shrink = 0.2e6;
        assert!(body.plain().iter().all(|o| o.area.is_empty()), "turned {turn}");
    }
}

#[test]
fn the_first_layers_can_be_supported_as_they_are() {
    let mut body = Body::new(&wedge(70.0, 12), 0.0, plan(45.0));
    (body.plan.enforce_layers, body.plan.auto) = (5, false);
    let found = body.plain();
    assert!(found.iter().enumerate().all(|(i, o)| (1..5).contains(&i) != o.area.is_empty()));
}

#[test]
fn above_the_part_nothing_is_left_where_supports_stand_on_the_bed() {
    // A plate at the bottom under one arm of a T.
    let mut layers = tee();
    layers[..2].iter_mut().for_each(|l| l.push(rect([3.0, 9.0], [0.0, 8.0])));
    let mut body = Body::new(&layers, 0.0, plan(45.0));
    let whole = body.plain();
    body.plan.on_bed_only = true;
    let found = body.plain();
    let [all, rest] = [&whole, &found].map(|f| body.mm2(&f[10].area));
    assert!((all - rest - 48.0).abs() < 1.0, "{all} and {rest}");
    assert!(and(&found[10].area, &body.outlines[0]).is_empty());
    assert!(!and(&whole[10].area, &body.outlines[0]).is_empty());
}

/// Blobs that wander from layer to layer, on rows.
fn wander(random: &mut Random, plan: SupportPlan) -> Body {
    let mut blobs: Vec<[f64; 4]> = Vec::new();
    let mut unit = |a: f64, b: f64| a + (b - a) * random.below(1 << 20) as f64 / f64::from(1 << 20);
    let mut layers = Vec::new();
    for i in 0..14 {
        if i % 5 == 0 {
            blobs.push([unit(-6.0, 6.0), unit(-6.0, 6.0), unit(0.5, 4.0), unit(0.5, 4.0)]);
        }
        for b in &mut blobs {
            for c in b.iter_mut() {
                *c += unit(-0.4, 0.4);
            }
        }
        layers.push(
            blobs
                .iter()
                .map(|b| {
                    let (x, y) = (b[2].abs() + 0.3, b[3].abs() + 0.3);
                    vec![[b[0] - x, b[1]], [b[0], b[1] - y], [b[0] + x, b[1]], [b[0], b[1] + y]]
                })
                .collect(),
        );
    }
    Body::new(&layers, 0.0, plan)
}

/// The same area seen in a mirror.
fn mirrored(area: &Rows, up: bool) -> Rows {
    if up {
        let mut out = RowsBuilder::new(1 - area.end());
        for k in (area.first()..area.end()).rev() {
            area.row(k).iter().for_each(|s| out.push(s.start, s.end));
            out.end_row();
        }
        return out.finish();
    }
    let mut out = RowsBuilder::new(area.first());
    for (_, row) in area.iter() {
        row.iter().rev().for_each(|s| out.push(-s.end, -s.start));
        out.end_row();
    }
    out.finish()
}

/// Equal but for empty rows at the ends.
fn same(a: &Rows, b: &Rows) -> bool {
    sub(a, b).is_empty() && sub(b, a).is_empty()
}

#[test]
fn what_hangs_hangs_in_the_mirror_too() {
    let (mut hanging, mut islands) = (0.0, 0);
    for seed in 1..30 {
        let mut random = Random(seed * 3_571);
        let body = wander(&mut random, plan(45.0));
        let found = body.plain();
        for up in [false, true] {
            let outlines = body.outlines.iter().map(|o| Arc::new(mirrored(o, up))).collect();
            let other = Body { outlines, levels: body.levels.clone(), plan: body.plan.clone() };
            for (a, b) in found.iter().zip(other.plain()) {
                assert!(same(&mirrored(&a.area, up), &b.area), "seed {seed}");
                assert!(same(&mirrored(&a.islands, up), &b.islands), "seed {seed}");
            }
        }
        hanging += found.iter().map(|o| body.mm2(&o.area)).sum::<f64>();
        islands += found.iter().filter(|o| !o.islands.is_empty()).count();
        // Displaced by a hair the comparison fails.
        if let Some(area) = found.iter().map(|o| &o.area).find(|a| !a.is_empty()) {
            assert!(!same(area, &dilate(area, 0, 1)));
        }
    }
    assert!(hanging > 100.0 && islands > 5, "{hanging}, {islands}");
}

#[test]
fn overhangs_keep_their_promises() {
    for seed in 1..40 {
        let mut random = Random(seed * 6_133);
        let mut body = wander(&mut random, plan(if seed % 2 == 0 { 45.0 } else { 0.0 }));
        body.plan.on_bed_only = seed % 3 == 0;
        let found = body.plain();
        let crumb = body.plan.half_wall * body.plan.half_wall * 1e-12;
        for (i, o) in found.iter().enumerate().skip(1) {
            let (own, below) = (&body.outlines[i], &body.outlines[i - 1]);
            assert!(same(&and(&o.area, &sub(own, below)), &o.area), "seed {seed}, layer {i}");
            assert!(same(&and(&o.islands, &o.area), &o.islands), "seed {seed}, layer {i}");
            if body.plan.on_bed_only {
                assert!(body.outlines[..i].iter().all(|under| and(&o.area, under).is_empty()));
                continue;
            }
            // What is a row further out than allowed is supported, but for crumbs.
            let reach = slope::Reach { part: body.part(), plan: &body.plan, layer: i }.units(1);
            let (pitch, t) = (body.plan.frame.pitch(), |k| body.plan.frame.t(k));
            let held = dilate(&dilate_disc(below, reach, t), 1, 0);
            let missed = sub(&sub(own, &held), &o.area);
            assert!(body.mm2(&missed) < 3.0 * crumb, "seed {seed}, layer {i}: {}", body.mm2(&missed));
            // Nothing is supported that hangs near nothing but what is allowed.
            let near = dilate_disc(&sub(own, &dilate_disc(below, reach - pitch, t)), reach + pitch, t);
            assert!(sub(&sub(&o.area, &near), &o.islands).is_empty(), "seed {seed}, layer {i}");
        }
    }
}

#[test]
fn threads_do_not_matter() {
    let pool = |n| rayon::ThreadPoolBuilder::new().num_threads(n).build().unwrap();
    for seed in 1..6 {
        let mut body = wander(&mut Random(seed), plan(45.0));
        body.plan.on_bed_only = seed % 2 == 0;
        let [one, three] = [1, 3].map(|n| pool(n).install(|| body.plain()));
        assert_eq!(one, three);
    }
}

#[test]
fn a_moved_part_hangs_alike() {
    let body = wander(&mut Random(99), plan(45.0));
    let by = (7, 12_345);
    let moved = |rows: &Rows| {
        let mut out = RowsBuilder::new(rows.first() + by.0);
        for (_, row) in rows.iter() {
            row.iter().for_each(|s| out.push(s.start + by.1, s.end + by.1));
            out.end_row();
        }
        out.finish()
    };
    let outlines = body.outlines.iter().map(|o| Arc::new(moved(o))).collect();
    let other = Body { outlines, levels: body.levels.clone(), plan: body.plan.clone() };
    for (a, b) in body.plain().iter().zip(other.plain()) {
        assert!(same(&moved(&a.area), &b.area) && same(&moved(&a.islands), &b.islands));
    }
}
