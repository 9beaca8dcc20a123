#![allow(clippy::unwrap_used)]

use super::*;
use crate::infill::Level;
use crate::span::algebra::sub;
use crate::span::scan;
use std::sync::Arc;

const LAYER: i64 = 200_000;

fn frame() -> RowFrame {
    RowFrame::new(0.0, 0.0, 100_000.0)
}

/// A rectangle by its corners \[mm\].
fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Rows {
    let p = |x: f64, y: f64| Point2::new(nm(x) as i32, nm(y) as i32);
    let ring = [p(x0, y0), p(x1, y0), p(x1, y1), p(x0, y1)];
    scan([&ring[..]], &frame())
}

fn rule() -> Rule {
    Rule {
        threshold: Some(45.0),
        half_wall: 225_000.0,
        xy_gap: 300_000.0,
        top_gap: LAYER,
        bottom_gap: LAYER,
        raft_gap: 100_000,
        contact: LAYER,
        foot: 2 * LAYER,
        room: 3 * LAYER,
        thickest: 0,
        room_on_bed: 0,
        support_reach: 200_000.0,
        support_slope: 0.0,
        straight: 400_000.0,
    }
}

/// A print of layers of 0.2 mm.
struct Case {
    outlines: Vec<Arc<Rows>>,
    levels: Vec<Level>,
    frame: RowFrame,
    overhangs: Vec<Overhang>,
    supports: Vec<SupportLayer>,
}

impl Case {
    fn new(outlines: Vec<Rows>) -> Self {
        let levels =
            (0..outlines.len() as i64).map(|i| Level { top: (i + 1) * LAYER, bottom: i * LAYER }).collect();
        let outlines = outlines.into_iter().map(Arc::new).collect();
        Self { outlines, levels, frame: frame(), overhangs: Vec::new(), supports: Vec::new() }
    }

    /// A stem of 4 mm with a bar of 20 mm on it, from its sixth layer.
    fn tee() -> Self {
        let mut case = Self::new(
            (0..8)
                .map(|i| {
                    rectangle(if i < 5 { -2.0 } else { -10.0 }, 0.0, if i < 5 { 2.0 } else { 10.0 }, 8.0)
                })
                .collect(),
        );
        case.overhangs = vec![Overhang::default(); 8];
        case
    }

    /// Supports under both arms that leave the gaps: layers 0 to 3.
    fn propped() -> Self {
        let mut case = Self::tee();
        let both = or(&rectangle(-10.0, 0.0, -2.3, 8.0), &rectangle(2.3, 0.0, 10.0, 8.0));
        case.supports = (1..=4)
            .map(|i| SupportLayer {
                print_z: i * LAYER as i32,
                height: LAYER as i32,
                base: both.clone(),
                ..SupportLayer::default()
            })
            .collect();
        case
    }

    fn print(&self) -> Print<'_> {
        let part = Part { outlines: &self.outlines, levels: &self.levels, frame: &self.frame };
        Print { part, overhangs: &self.overhangs, supports: &self.supports }
    }

    fn in_air(&self) -> Vec<InAir> {
        in_air(&self.print(), &rule())
    }
}

#[test]
fn arms_hang_unless_something_is_below() {
    let found = Case::tee().in_air();
    assert_eq!(found.iter().map(|f| f.what).collect::<Vec<_>>(), [What::Part(5)]);
    // Each arm is 8 mm long, of which 0.2 mm and a pitch are in reach.
    assert!((found[0].mm2 - 2.0 * 7.7 * 8.0).abs() < 2.0, "{}", found[0].mm2);
    assert!((found[0].largest_mm2 - found[0].mm2 / 2.0).abs() < 0.01);
    assert_eq!(found[0].z, 5 * LAYER);
    assert!(found[0].place.x.abs() > 2_300_000 && (0..8_000_000).contains(&found[0].place.y));
    assert!(Case::propped().in_air().is_empty());
    let mut case = Case::tee();
    case.overhangs[5].bridged = rectangle(-10.0, 0.0, 10.0, 8.0);
    assert!(case.in_air().is_empty());
    // On the plate anything may lie.
    assert!(Case::new(vec![rectangle(0.0, 0.0, 90.0, 90.0)]).in_air().is_empty());
}

#[test]
fn supports_that_end_too_low_or_miss_a_place_are_seen() {
    let mut case = Case::propped();
    case.supports.pop();
    assert_eq!(case.in_air().len(), 1);
    let mut case = Case::propped();
    case.supports.remove(1);
    assert_eq!(case.in_air()[0].what, What::Support(1), "a column without a layer");
    let mut case = Case::propped();
    case.supports.iter_mut().for_each(|l| l.base = rectangle(-10.0, 0.0, -2.3, 8.0));
    let found = case.in_air();
    assert_eq!(found.len(), 1);
    assert!(found[0].place.x > 2_000_000 && (found[0].mm2 - 7.7 * 8.0).abs() < 2.0);
    // A hole of 2 mm between supports, bridged by nothing.
    let mut case = Case::propped();
    let top = case.supports.last_mut().unwrap();
    top.base = sub(&top.base, &rectangle(5.0, 3.0, 7.0, 5.0));
    let found = case.in_air();
    assert!((found[0].mm2 - 1.4 * 1.4).abs() < 0.4, "{}", found[0].mm2);
}

#[test]
fn slopes_hold_themselves_up_to_the_threshold() {
    for (step, hangs) in [(0.15, false), (0.2, false), (0.29, false), (0.42, true)] {
        for turned in [false, true] {
            let layer = |i: i32| {
                let r = 3.0 + f64::from(i) * step;
                if turned { rectangle(0.0, -r, 9.0, r) } else { rectangle(-r, 0.0, r, 9.0) }
            };
            let case = Case::new((0..9).map(layer).collect());
            assert_eq!(!case.in_air().is_empty(), hangs, "{step} mm, turned {turned}");
        }
    }
}

#[test]
fn the_gap_between_part_and_support_is_held_by_both() {
    let mut case = Case::propped();
    let wide = Rule { xy_gap: 1_000_000.0, ..rule() };
    case.supports.iter_mut().for_each(|l| {
        l.base = sub(&l.base, &rectangle(-3.0, 0.0, 3.0, 8.0));
    });
    assert!(in_air(&case.print(), &wide).is_empty());
    assert_eq!(in_air(&case.print(), &rule()).len(), 1);
}

#[test]
fn supports_keep_their_distances() {
    let print = Case::propped();
    assert!(clashes(&print.print(), &rule()).is_empty());
    let sides =
        |case: &Case| clashes(&case.print(), &rule()).iter().map(|c| (c.layer, c.side)).collect::<Vec<_>>();
    let mut case = Case::propped();
    case.supports[2].base = or(&case.supports[2].base, &rectangle(2.1, 1.0, 3.0, 2.0));
    assert_eq!(sides(&case), [(2, Side::Beside)]);
    // One layer more touches the bar.
    let mut case = Case::propped();
    let top = SupportLayer { print_z: 5 * LAYER as i32, ..case.supports[3].clone() };
    case.supports.push(top);
    assert_eq!(sides(&case), [(4, Side::Above)]);
    case.supports[4].print_z += LAYER as i32;
    assert_eq!(sides(&case), [(4, Side::Beside), (4, Side::Above)], "inside the bar");
    // A column on the part, without a gap and with one.
    let mut case = Case::new((0..4).map(|_| rectangle(0.0, 0.0, 9.0, 9.0)).collect());
    for (above, expected) in [(0, vec![(0, Side::Below)]), (1, Vec::new())] {
        let print_z = (5 + above) * LAYER as i32;
        let base = rectangle(2.0, 2.0, 4.0, 4.0);
        case.supports = vec![SupportLayer { print_z, height: LAYER as i32, base, ..SupportLayer::default() }];
        assert_eq!(sides(&case), expected);
        assert!(case.in_air().is_empty(), "it stands on the part");
    }
    case.supports[0].print_z += 3 * LAYER as i32;
    assert_eq!(case.in_air()[0].what, What::Support(0));
}

#[test]
fn lines_over_air_are_bridges_only_from_end_to_end() {
    let case = Case::new(
        (0..3)
            .map(|i| match i {
                0 | 1 => or(&rectangle(0.0, 0.0, 4.0, 9.0), &rectangle(12.0, 0.0, 16.0, 9.0)),
                _ => rectangle(0.0, 0.0, 16.0, 9.0),
            })
            .collect(),
    );
    let ground = Ground::of_part(&case.print(), 2, &rule());
    let p = |x: f64, y: f64| Point2::new(nm(x) as i32, nm(y) as i32);
    let hangs = |points: &[Point2]| hanging(points, &ground, 400_000.0);
    assert!(hangs(&[p(3.0, 5.0), p(13.0, 5.0)]).is_empty());
    assert!(hangs(&[p(3.0, 5.0), p(8.0, 5.2), p(13.0, 5.0)]).is_empty());
    let open = hangs(&[p(3.0, 5.0), p(10.0, 5.0)]);
    assert_eq!(open.len(), 1);
    assert_eq!(open[0].anchored, [true, false]);
    assert!((open[0].length - 5.7e6).abs() < 1e5, "{}", open[0].length);
    assert_eq!(hangs(&[p(8.0, 5.0), p(13.0, 5.0)])[0].anchored, [false, true]);
    assert_eq!(hangs(&[p(8.0, 5.0), p(8.0, 7.0)])[0].anchored, [false, false]);
    // Held at both ends, but it would be pulled straight.
    let bent = hangs(&[p(3.0, 5.0), p(8.0, 5.0), p(8.0, 6.0), p(13.0, 6.0)]);
    assert!(bent[0].anchored == [true, true] && bent[0].bend > 400_000.0);
    // Back to where it came from.
    assert_eq!(hangs(&[p(3.0, 5.0), p(8.0, 5.0), p(8.0, 5.4), p(3.0, 5.4)]).len(), 1);
    assert!(Ground::of_part(&case.print(), 0, &rule()).holds(p(99.0, 99.0)));
}

#[test]
fn discs_around_what_is_left_are_discs_around_all() {
    let mut random = crate::span::tests::Random(7);
    for seed in 0..40 {
        let mut some = |n: i64| {
            (0..n).fold(Rows::default(), |all, _| {
                let mut c = || random.within(0, 200) as f64 / 10.0;
                let (x, y, w, h) = (c(), c(), c() / 4.0, c() / 4.0);
                or(&all, &rectangle(x, y, x + w, y + h))
            })
        };
        let (area, ground, frame) = (some(9), some(6), frame());
        let all = crate::span::morph::dilate_disc(&ground, 700_000, |k| frame.t(k));
        let expected = sub(&area, &all);
        let found = ground::far(&area, &ground, 700_000, &frame);
        assert_eq!(found.spans(), expected.spans(), "seed {seed}");
    }
}

#[test]
fn what_supports_cannot_reach_is_told_apart() {
    // A slot of 1 mm between two walls is closed: supports keep 0.3 mm off either.
    let walls = or(&rectangle(0.0, 0.0, 5.0, 9.0), &rectangle(6.0, 0.0, 11.0, 9.0));
    let slot = |closed: Rows| {
        Case::new((0..6).map(|i| if i < 4 { walls.clone() } else { closed.clone() }).collect())
    };
    let found = slot(rectangle(0.0, 0.0, 11.0, 9.0)).in_air();
    assert!((found[0].mm2 - 0.4 * 9.0).abs() < 0.4 && found[0].cramped_mm2 == found[0].mm2, "{found:?}");
    // Beyond the walls there is room.
    let found = slot(rectangle(0.0, 0.0, 19.0, 9.0)).in_air();
    assert!(found[0].mm2 > found[0].cramped_mm2 + 50.0 && found[0].cramped_mm2 > 3.0, "{found:?}");
    // An arm two layers above a plate, and one five layers above it.
    for (layers, room) in [(2, false), (5, true)] {
        let own = |i: usize| match i {
            0 => rectangle(0.0, 0.0, 20.0, 9.0),
            i if i <= layers => rectangle(0.0, 0.0, 5.0, 9.0),
            _ => rectangle(0.0, 0.0, 20.0, 9.0),
        };
        let found = Case::new((0..layers + 2).map(own).collect()).in_air();
        assert_eq!(found[0].cramped_mm2 < 0.5 * found[0].mm2, room, "{layers} layers: {found:?}");
    }
}
