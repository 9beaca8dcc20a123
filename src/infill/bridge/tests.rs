//! Bridges over shapes made by hand, and measured directions against a search point by point.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::lines::{Cells, Line};
use super::*;
use crate::lattice::Point2;
use crate::span::scan;
use crate::span::tests::Random;

const PITCH: f64 = 407_000.0;
const PLAN: BridgePlan = BridgePlan { anchor: 3e6, degrees: None, over_air: true };

fn frame(degrees: f64) -> RowFrame {
    RowFrame::new(degrees, 0.0, PITCH)
}

/// Corners \[mm\] turned by `degrees` and moved.
fn ring(corners: &[(f64, f64)], degrees: f64) -> Vec<Point2> {
    let (sin, cos) = libm::sincos(degrees.to_radians());
    let turn = |&(x, y): &(f64, f64)| {
        let round = |v: f64| (v * 1e6).round() as i32;
        Point2::new(round(cos * x - sin * y + 3.7), round(sin * x + cos * y - 1.9))
    };
    corners.iter().map(turn).collect()
}

fn rectangle(x: f64, y: f64, w: f64, h: f64) -> Vec<(f64, f64)> {
    vec![(x, y), (x + w, y), (x + w, y + h), (x, y + h)]
}

fn circle(radius: f64) -> Vec<(f64, f64)> {
    (0..180)
        .map(|i| libm::sincos(f64::from(i).to_radians() * 2.0))
        .map(|(s, c)| (radius * c, radius * s))
        .collect()
}

fn reversed(mut ring: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    ring.reverse();
    ring
}

/// A layer over another.
struct Case {
    own: Rows,
    below: Rows,
    degrees: f64,
}

impl Case {
    /// Rings of both, turned by `turn`, on rows at `degrees`.
    fn new(own: &[Vec<(f64, f64)>], below: &[Vec<(f64, f64)>], turn: f64, degrees: f64) -> Self {
        let frame = frame(degrees);
        let rows = |rings: &[Vec<(f64, f64)>]| {
            let rings: Vec<_> = rings.iter().map(|r| ring(r, turn)).collect();
            scan(rings.iter().map(|r| &r[..]), &frame)
        };
        Self { own: rows(own), below: rows(below), degrees }
    }

    fn air(&self) -> Rows {
        sub(&self.own, &self.below)
    }

    fn bridges(&self) -> Vec<Bridge> {
        let frame = frame(self.degrees);
        let grid = Grid { frame: &frame, degrees: self.degrees };
        let found = over_air(&self.own, &self.air(), &self.below, grid, 77.0, &PLAN);
        let mut all = 0;
        for b in &found {
            assert!(sub(&b.rows, &self.own).is_empty(), "a bridge leaves the region");
            all += b.rows.length();
        }
        assert_eq!(union(&found).length(), all, "bridges overlap");
        found
    }

    /// The only bridge.
    fn bridge(&self) -> Bridge {
        let mut found = self.bridges();
        assert_eq!(found.len(), 1);
        let left = sub(&self.air(), &found[0].rows).length() as f64 * frame(self.degrees).mm2_per_unit();
        assert!(left < 0.5, "{left} mm² of air left");
        found.remove(0)
    }

    /// Share of a bridge's lines, by length, with both ends on the layer below.
    fn anchored(&self, bridge: &Bridge) -> f64 {
        let pitch = frame(self.degrees).pitch();
        let (low, high) = (bridge.rows.spans().iter().map(|s| s.start).min().unwrap(), bridge.rows.first());
        let cells = Cells::new(&bridge.rows, pitch, (low, high));
        let below = Cells::new(&self.below, pitch, (low, high));
        let (sin, cos) = libm::sincos((bridge.degrees - self.degrees).rem_euclid(180.0).to_radians());
        let (mut all, mut held) = (0.0, 0.0);
        for i in -400..400 {
            let q = f64::from(i) * PITCH;
            let line = Line { from: (-q * sin, q * cos), along: (cos, sin) };
            cells.pieces(line, |a, b| {
                all += b - a;
                let inside = |x: f64| below.holds(line.at(x));
                // Half a millimetre inside the ends, so that an anchor is one.
                if inside(a + 0.5e6) && inside(b - 0.5e6) {
                    held += b - a;
                }
            });
        }
        held / all
    }
}

/// The angle between two directions \[degrees\].
fn apart(a: f64, b: f64) -> f64 {
    ((a - b + 90.0).rem_euclid(180.0) - 90.0).abs()
}

/// Area on rows at 45 degrees \[mm²\].
fn area(rows: &Rows) -> f64 {
    rows.length() as f64 * frame(45.0).mm2_per_unit()
}

#[test]
fn lines_run_from_pillar_to_pillar_at_any_rotation() {
    for (w, h) in [(30.0, 12.0), (12.0, 30.0), (40.0, 3.0), (20.0, 20.0)] {
        for turn in (0..180).step_by(7) {
            let own = [rectangle(0.0, 0.0, w + 10.0, h)];
            let below = [rectangle(0.0, 0.0, 5.0, h), rectangle(w + 5.0, 0.0, 5.0, h)];
            let case = Case::new(&own, &below, f64::from(turn), [45.0, 0.0, 30.0][turn as usize % 3]);
            let bridge = case.bridge();
            let off = apart(bridge.degrees, f64::from(turn));
            assert!(off < 1.5, "{w} x {h} at {turn}: {}", bridge.degrees);
            let anchored = case.anchored(&bridge);
            assert!(anchored > if h > 3.0 { 0.93 } else { 0.75 }, "{w} x {h} at {turn}: {anchored}");
            // Three millimetres at either end.
            let found = bridge.rows.length() as f64 * frame(case.degrees).mm2_per_unit();
            let expected = (w + 6.0) * h;
            assert!((found / expected - 1.0).abs() < 0.12, "{w} x {h} at {turn}: {found} for {expected}");
        }
    }
}

#[test]
fn the_other_direction_is_not_anchored() {
    let own = [rectangle(0.0, 0.0, 40.0, 12.0)];
    let below = [rectangle(0.0, 0.0, 5.0, 12.0), rectangle(35.0, 0.0, 5.0, 12.0)];
    let case = Case::new(&own, &below, 20.0, 45.0);
    let bridge = Bridge { degrees: 110.0, ..case.bridge() };
    assert!(case.anchored(&bridge) < 0.3);
}

#[test]
fn a_hole_closes_over_along_its_edges() {
    for turn in [0.0, 10.0, 33.0, 45.0, 80.0] {
        let own = [rectangle(-20.0, -20.0, 40.0, 40.0)];
        let hole = |w: f64, h: f64| {
            [rectangle(-20.0, -20.0, 40.0, 40.0), reversed(rectangle(-w / 2.0, -h / 2.0, w, h))]
        };
        let square = Case::new(&own, &hole(10.0, 10.0), turn, 45.0).bridge();
        let off = apart(square.degrees, turn).min(apart(square.degrees, turn + 90.0));
        assert!(off < 1.0, "{turn}: {}", square.degrees);
        // Across the shorter side.
        let long = Case::new(&own, &hole(24.0, 8.0), turn, 45.0);
        let bridge = long.bridge();
        assert!(apart(bridge.degrees, turn + 90.0) < 1.0, "{turn}: {}", bridge.degrees);
        assert!(long.anchored(&bridge) > 0.97);
        let round = Case::new(&own, &[own[0].clone(), reversed(circle(6.0))], turn, 45.0);
        assert!(round.anchored(&round.bridge()) > 0.97);
    }
}

#[test]
fn a_cantilever_runs_out_from_its_wall() {
    for turn in [0.0, 25.0, 45.0, 90.0, 140.0] {
        for (w, h) in [(10.0, 30.0), (30.0, 10.0)] {
            let case =
                Case::new(&[rectangle(0.0, 0.0, 10.0 + w, h)], &[rectangle(0.0, 0.0, 10.0, h)], turn, 45.0);
            let bridge = case.bridge();
            assert!(apart(bridge.degrees, turn) < 1.0, "{w} x {h} at {turn}: {}", bridge.degrees);
        }
    }
}

#[test]
fn what_nothing_holds_is_laid_as_usual() {
    let bridge =
        Case::new(&[rectangle(0.0, 0.0, 9.0, 5.0)], &[rectangle(50.0, 0.0, 9.0, 5.0)], 0.0, 45.0).bridge();
    assert_eq!(bridge.degrees, 77.0);
    assert!((area(&bridge.rows) - 45.0).abs() < 1.5);
    // Nothing in, nothing out.
    assert!(Case::new(&[], &[], 0.0, 45.0).bridges().is_empty());
    let whole = [rectangle(0.0, 0.0, 9.0, 5.0)];
    assert!(Case::new(&whole, &whole, 0.0, 45.0).bridges().is_empty());
}

#[test]
fn a_table_stands_on_its_legs() {
    for turn in [0.0, 20.0, 45.0] {
        let leg = |x: f64, y: f64| rectangle(x, y, 6.0, 6.0);
        let legs = [leg(0.0, 0.0), leg(44.0, 0.0), leg(0.0, 24.0), leg(44.0, 24.0)];
        let case = Case::new(&[rectangle(0.0, 0.0, 50.0, 30.0)], &legs, turn, 45.0);
        let bridge = case.bridge();
        // From leg to leg, the short way or the long one.
        let off = apart(bridge.degrees, turn).min(apart(bridge.degrees, turn + 90.0));
        assert!(off < 1.0, "{turn}: {}", bridge.degrees);
    }
}

#[test]
fn an_l_and_a_ring_are_whole() {
    let l = vec![(0.0, 0.0), (30.0, 0.0), (30.0, 8.0), (8.0, 8.0), (8.0, 30.0), (0.0, 30.0)];
    let below =
        [rectangle(0.0, 0.0, 12.0, 12.0), rectangle(25.0, 0.0, 5.0, 8.0), rectangle(0.0, 25.0, 8.0, 5.0)];
    let case = Case::new(&[l], &below, 15.0, 45.0);
    let found = case.bridges();
    // Two spans of their own directions.
    assert_eq!(found.len(), 2);
    let mut off: Vec<f64> = found.iter().map(|b| apart(b.degrees, 15.0)).collect();
    off.sort_by(f64::total_cmp);
    assert!(off[0] < 1.0 && off[1] > 89.0, "{off:?}");
    found.iter().for_each(|b| assert!(case.anchored(b) > 0.9));
    // A groove all around, closed over.
    let own = [circle(20.0)];
    let below = [circle(20.0), reversed(circle(14.0)), circle(9.0)];
    let case = Case::new(&own, &below, 0.0, 45.0);
    let bridge = case.bridge();
    assert!(case.anchored(&bridge) > 0.9);
}

#[test]
fn crumbs_are_left_to_the_walls() {
    let own = [rectangle(0.0, 0.0, 30.0, 30.0)];
    let with = |side: f64| {
        let below = [own[0].clone(), reversed(rectangle(10.0, 10.0, side, side))];
        Case::new(&own, &below, 0.0, 45.0).bridges().len()
    };
    assert_eq!((with(0.5), with(2.0)), (0, 1));
}

#[test]
fn neighbours_share_what_is_between_them() {
    let own = [rectangle(0.0, 0.0, 40.0, 20.0)];
    let hole = |x: f64| reversed(rectangle(x, 5.0, 8.0, 10.0));
    let apart = |gap: f64| {
        let below = [own[0].clone(), hole(5.0), hole(13.0 + gap), hole(21.0 + 2.0 * gap)];
        let case = Case::new(&own, &below, 10.0, 45.0);
        let found = case.bridges();
        assert!(sub(&case.air(), &union(&found)).is_empty());
        let merged = by_direction(found.clone());
        assert_eq!(union(&merged), union(&found));
        (found.len(), merged.len())
    };
    assert_eq!(apart(4.0), (3, 1));
    assert_eq!(apart(1.0), (1, 1));
}

#[test]
fn a_part_moved_by_whole_rows_is_bridged_alike() {
    let case = |x: f64| {
        let own = [rectangle(x, x, 40.0, 20.0)];
        let below = [own[0].clone(), reversed(rectangle(x + 10.0, x + 5.0, 9.0, 13.0))];
        Case::new(&own, &below, 0.0, 0.0).bridges()
    };
    let (here, there) = (case(0.0), case(407.0 * 0.25));
    assert_eq!(here.len(), 1);
    assert_eq!(here[0].degrees, there[0].degrees);
    assert_eq!(here[0].rows.length(), there[0].rows.length());
}

#[test]
fn the_angle_of_the_settings_overrides() {
    let mut settings = Settings::default();
    assert_eq!(BridgePlan::new(&settings).degrees, None);
    settings.infill.bridge_angle = 200.0;
    let plan = BridgePlan::new(&settings);
    let case = Case::new(&[rectangle(0.0, 0.0, 9.0, 5.0)], &[rectangle(0.0, 0.0, 2.0, 5.0)], 0.0, 45.0);
    let frame = frame(45.0);
    let grid = Grid { frame: &frame, degrees: 45.0 };
    assert_eq!(over_air(&case.own, &case.air(), &case.below, grid, 0.0, &plan)[0].degrees, 20.0);
}

/// Is a point of the frame, relative to a corner, in the area?
fn holds(rows: &Rows, corner: (i32, i32), (s, t): (f64, f64)) -> bool {
    let k = (t / PITCH + 0.5).floor() as i32 + corner.1;
    let s = s + f64::from(corner.0);
    rows.row(k).iter().any(|x| f64::from(x.start) <= s && s < f64::from(x.end))
}

#[test]
fn scores_equal_a_search_point_by_point() {
    let mut worst = 0.0f64;
    for seed in 1..25 {
        let mut random = Random(seed * 7907);
        let star = |random: &mut Random, radius: f64| -> Vec<(f64, f64)> {
            let n = 5 + random.below(12);
            (0..n)
                .map(|i| {
                    let (s, c) = libm::sincos(i as f64 * std::f64::consts::TAU / n as f64);
                    let r = radius * (0.5 + 0.5 * random.below(1000) as f64 / 1000.0);
                    (r * c, r * s)
                })
                .collect()
        };
        let own = [star(&mut random, 14.0)];
        let below = [star(&mut random, 6.0), rectangle(6.0, -9.0, 8.0, 6.0), rectangle(-12.0, 2.0, 6.0, 4.0)];
        let case = Case::new(&own, &below, 0.0, 0.0);
        let frame = frame(0.0);
        let grid = Grid { frame: &frame, degrees: 0.0 };
        let air = case.air();
        let Some((patch, _)) = parts(&air, &air, 0).into_iter().max_by_key(|p| p.0.length()) else {
            continue;
        };
        let measure = Measure::new(&patch, &case.below, grid);
        let degrees = f64::from((seed as u32 * 37) % 180);
        let score = measure.score(degrees);
        let corner = (patch.spans().iter().map(|s| s.start).min().unwrap(), patch.first());
        let (sin, cos) = libm::sincos(degrees.to_radians());
        // The same lines, cut into steps of ten micrometres.
        let width = f64::from(patch.spans().iter().map(|s| s.end).max().unwrap() - corner.0);
        let height = f64::from(patch.end() - patch.first()) * PITCH;
        let (t0, t1) = (-0.5 * PITCH, height - 0.5 * PITCH);
        let across = [(0.0, t0), (width, t0), (0.0, t1), (width, t1)].map(|(s, t)| t * cos - s * sin);
        let low = across.into_iter().fold(f64::INFINITY, f64::min);
        let extent = across.into_iter().fold(f64::NEG_INFINITY, f64::max) - low;
        let lines = (extent / PITCH).round().clamp(12.0, 64.0);
        let (mut all, mut held) = (0.0, [0.0, 0.0]);
        let step = 10_000.0;
        for i in 0..lines as u32 {
            let q = low + extent * (f64::from(i) + 0.5) / lines;
            let at = |x: f64| (x * cos - q * sin, x * sin + q * cos);
            let mut begun: Option<i32> = None;
            for j in -6000..6000 {
                let x = f64::from(j) * step;
                match (holds(&patch, corner, at(x)), begun) {
                    (true, None) => begun = Some(j),
                    (false, Some(b)) => {
                        begun = None;
                        let (from, to) = (f64::from(b) * step - step / 2.0, x - step / 2.0);
                        let rests = |x: f64, way: f64| {
                            (1..=4)
                                .any(|n| holds(&case.below, corner, at(x + way * PITCH / 2.0 * f64::from(n))))
                        };
                        let ends = [rests(from, -1.0), rests(to, 1.0)];
                        all += to - from;
                        held[0] += if ends[0] && ends[1] { to - from } else { 0.0 };
                        held[1] += if ends[0] || ends[1] { to - from } else { 0.0 };
                    }
                    _ => {}
                }
            }
        }
        for i in [0, 1] {
            let off = (score.held[i] - held[i] / all).abs();
            assert!(off < 0.02, "seed {seed} at {degrees}: {:?} for {}", score.held, held[i] / all);
            worst = worst.max(held[0] / all);
        }
        // The comparison can fail: another direction has another score.
        let other = measure.score(degrees + 60.0);
        worst = worst.max((other.held[1] - score.held[1]).abs());
    }
    assert!(worst > 0.05, "nothing was held anywhere");
}

#[test]
fn solid_infill_over_sparse_is_bridged_where_it_is_wide() {
    let frame = frame(45.0);
    let grid = Grid { frame: &frame, degrees: 45.0 };
    let solid = Case::new(&[rectangle(0.0, 0.0, 30.0, 20.0)], &[], 0.0, 45.0).own;
    let sparse = |w: f64| Case::new(&[rectangle(5.0, 4.0, w, 12.0)], &[], 0.0, 45.0).own;
    let found = over_sparse(&solid, &sparse(15.0), grid, 135.0, &PLAN).unwrap();
    assert_eq!(found.degrees, 135.0);
    assert!(sub(&found.rows, &solid).is_empty());
    assert!(area(&found.rows) > 15.0 * 12.0 && area(&found.rows) < 21.5 * 18.5, "{}", area(&found.rows));
    assert_eq!(over_sparse(&solid, &sparse(1.2), grid, 135.0, &PLAN), None);
    assert_eq!(over_sparse(&solid, &Rows::default(), grid, 135.0, &PLAN), None);
}

#[test]
fn sparse_lines_are_crossed() {
    assert_eq!(across(&[45.0], 45.0), 135.0);
    assert_eq!(across(&[22.5], 112.5), 112.5);
    assert_eq!(across(&[45.0, 135.0], 45.0), 0.0);
    assert_eq!(across(&[0.0, 60.0, 120.0], 90.0), 90.0);
    assert_eq!(across(&[], 17.0), 17.0);
}
