#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::{columns, contacts, shape};
use crate::infill::Level;
use crate::settings::{Settings, SupportStyle};
use crate::span::algebra::{and, or, sub};
use crate::span::tests::Random;
use crate::span::{RowFrame, Rows, RowsBuilder};
use crate::support::overhang::Overhang;
use crate::support::{Part, SupportLayer, SupportPlan};
use std::sync::Arc;

const MM: f64 = 1e6;

/// A part of boxes, each from one corner to the other \[mm\], in layers of 0.2 mm.
struct Boxes {
    outlines: Vec<Arc<Rows>>,
    levels: Vec<Level>,
    overhangs: Vec<Overhang>,
}

fn rectangle([x0, y0]: [f64; 2], [x1, y1]: [f64; 2], plan: &SupportPlan) -> Rows {
    let (first, end) =
        (plan.frame.row_below((y0 * MM) as i64) + 1, plan.frame.row_below((y1 * MM) as i64) + 1);
    let mut out = RowsBuilder::new(first);
    for _ in first..end {
        out.push((x0 * MM) as i32, (x1 * MM) as i32);
        out.end_row();
    }
    out.finish()
}

impl Boxes {
    fn new(boxes: &[[[f64; 3]; 2]], plan: &SupportPlan) -> Self {
        let height = boxes.iter().map(|b| b[1][2]).fold(0.0, f64::max);
        let layers = (height / 0.2).round() as usize;
        let mut part = Self { outlines: Vec::new(), levels: Vec::new(), overhangs: Vec::new() };
        for i in 0..layers {
            let middle = 0.2 * (i as f64 + 0.5);
            let own = boxes.iter().filter(|b| b[0][2] < middle && middle < b[1][2]);
            let outline = own
                .fold(Rows::default(), |all, [a, b]| or(&all, &rectangle([a[0], a[1]], [b[0], b[1]], plan)));
            let below = part.outlines.last();
            part.overhangs.push(Overhang {
                area: below.map_or(Rows::default(), |below| sub(&outline, below)),
                ..Overhang::default()
            });
            let same = below.filter(|b| ***b == outline).cloned();
            part.outlines.push(same.unwrap_or_else(|| Arc::new(outline)));
            let bottom = i64::from(plan.base_z) + 200_000 * i as i64;
            part.levels.push(Level { top: bottom + 200_000, bottom });
        }
        part
    }

    fn columns(&self, plan: &SupportPlan) -> Vec<SupportLayer> {
        let part = Part { outlines: &self.outlines, levels: &self.levels, frame: &plan.frame };
        columns(part, &self.overhangs, plan)
    }
}

fn plan(style: SupportStyle) -> SupportPlan {
    let mut settings = Settings::default();
    settings.support.support_material_style = style;
    settings.slicing.layer_height = 0.2;
    SupportPlan::new(&settings)
}

/// A bar of 50 x 20 mm, 20 mm above the bed, upon a stem.
const TEE: [[[f64; 3]; 2]; 2] =
    [[[-4.7, -10.0, 0.0], [4.7, 10.0, 20.0]], [[-25.0, -10.0, 20.0], [25.0, 10.0, 22.0]]];

#[test]
fn columns_of_a_tee_end_a_thread_and_a_gap_below_its_bar() {
    for style in [SupportStyle::Grid, SupportStyle::Snug] {
        let plan = plan(style);
        let layers = Boxes::new(&TEE, &plan).columns(&plan);
        let top = layers.last().unwrap();
        assert_eq!(top.print_z, 20_000_000 - plan.top_gap - plan.thread_drop, "{style:?}");
        assert!(top.base.is_empty() && !top.contact.is_empty());
        assert_eq!(layers[0].bottom_z(), 0);
        assert!(layers.windows(2).all(|w| w[0].print_z == w[1].bottom_z()));
        assert_eq!(layers.iter().filter(|l| !l.interface.is_empty()).count(), 3);
    }
}

#[test]
fn columns_are_the_same_from_layer_to_layer() {
    for style in [SupportStyle::Grid, SupportStyle::Snug] {
        let plan = plan(style);
        let layers = Boxes::new(&TEE, &plan).columns(&plan);
        assert!(layers[1..layers.len() - 4].windows(2).all(|w| w[0].base == w[1].base), "{style:?}");
        // The first is wider, yet no nearer to the stem.
        let (first, second) = (&layers[0].base, &layers[1].base);
        let ends = |rows: &Rows| [rows.row(0)[0].start, rows.row(0)[0].end];
        let [from, to] = [ends(first)[0] - ends(second)[0], ends(first)[1] - ends(second)[1]];
        assert!((f64::from(from) + plan.first_expansion).abs() < 2e5 && to == 0, "{from} {to}");
    }
}

/// A table upon a table.
const TABLES: [[[f64; 3]; 2]; 3] = [
    [[-10.0, -10.0, 0.0], [10.0, 10.0, 4.0]],
    [[-2.0, -2.0, 4.0], [2.0, 2.0, 12.0]],
    [[-10.0, -10.0, 12.0], [10.0, 10.0, 14.0]],
];

#[test]
fn columns_stand_on_the_part_a_gap_above_it() {
    let plan = plan(SupportStyle::Snug);
    let layers = Boxes::new(&TABLES, &plan).columns(&plan);
    assert_eq!(layers[0].bottom_z(), 4_000_000 + plan.bottom_gap);
    let bottom = layers.iter().take_while(|l| !l.bottom_interface.is_empty()).count();
    assert_eq!(bottom, plan.bottom_interface as usize);
    assert!(layers[0].base.is_empty() && !layers[bottom].base.is_empty());
    let bed_only = SupportPlan { on_bed_only: true, ..plan };
    assert!(Boxes::new(&TABLES, &bed_only).columns(&bed_only).is_empty());
}

#[test]
fn columns_stand_on_a_raft_without_a_foot() {
    let plan = SupportPlan { base_z: 1_000_000, ..plan(SupportStyle::Grid) };
    let layers = Boxes::new(&TEE, &plan).columns(&plan);
    assert_eq!(layers[0].bottom_z(), plan.base_z);
    assert_eq!(layers[0].base, layers[1].base);
    assert!(layers[0].height > 200_000 && layers[0].height <= plan.heights[1]);
}

#[test]
fn synchronized_layers_are_those_of_the_part() {
    let plan = SupportPlan { synchronized: true, top_gap: 250_000, ..plan(SupportStyle::Snug) };
    let part = Boxes::new(&TEE, &plan);
    let layers = part.columns(&plan);
    for layer in &layers {
        let own = part.levels.iter().find(|l| l.top == i64::from(layer.print_z)).unwrap();
        assert_eq!(own.bottom, i64::from(layer.bottom_z()));
    }
    let highest = 20_000_000 - plan.top_gap - plan.thread_drop;
    assert_eq!(layers.last().unwrap().print_z, highest / 200_000 * 200_000);
}

#[test]
fn soluble_columns_touch_the_part() {
    let plan = SupportPlan { top_gap: 0, bottom_gap: 0, thread_drop: 0, ..plan(SupportStyle::Snug) };
    let layers = Boxes::new(&TABLES, &plan).columns(&plan);
    assert_eq!(layers[0].bottom_z(), 4_000_000);
    assert_eq!(layers.last().unwrap().print_z, 12_000_000);
}

#[test]
fn gaps_are_closed_and_slivers_left_out() {
    let plan = plan(SupportStyle::Snug);
    let two = |gap: f64| {
        let left = rectangle([-5.0, -5.0], [0.0, 5.0], &plan);
        or(&left, &rectangle([gap, -5.0], [gap + 5.0, 5.0], &plan))
    };
    for (gap, closes) in [(0.5, true), (3.9, true), (4.1, false)] {
        let closed = shape::closed(&two(gap), 2.0 * MM, &plan.frame);
        assert_eq!(closed.row(0).len() == 1, closes, "{gap}");
    }
    let kept = |w: f64, h: f64| {
        !shape::without_slivers(&rectangle([0.0, 0.0], [w, h], &plan), 0.45 * MM, &plan.frame).is_empty()
    };
    assert!(kept(0.3, 5.0) && kept(5.0, 0.35));
    assert!(!kept(0.2, 5.0) && !kept(5.0, 0.1));
    // What hangs far out grows to what can be printed.
    let slim = rectangle([0.0, 0.0], [0.1, 5.0], &plan);
    let wide = shape::widened(&slim, &slim, 0.45 * MM, &plan.frame);
    assert!(wide.row(20)[0].length() >= 450_000, "{:?}", wide.row(20));
    assert_eq!(shape::widened(&slim, &Rows::default(), 0.45 * MM, &plan.frame), slim);
}

#[test]
fn a_layer_list_fits_between_its_fixed_heights() {
    for seed in 1..300 {
        let mut random = Random(seed);
        let least = random.within(40_000, 200_000) as i32;
        let plan = SupportPlan {
            heights: [least, least + random.within(0, 200_000) as i32],
            base_z: if random.below(2) == 0 { 0 } else { 700_000 },
            ..plan(SupportStyle::Snug)
        };
        let count = 1 + random.below(6) as usize;
        let mut tops: Vec<i32> = (0..count).map(|_| random.within(0, 4_000_000) as i32).collect();
        tops.sort_unstable();
        let hanging = |top: &i32| contacts::Hanging {
            top: *top,
            area: rectangle([0.0, 0.0], [3.0, 3.0], &plan),
            far: Rows::default(),
            deep: Rows::default(),
        };
        let hanging: Vec<_> = tops.iter().map(hanging).collect();
        let part = Part { outlines: &[], levels: &[], frame: &plan.frame };
        let layers = super::heights::layers(part, &hanging, &plan);
        let begin = if plan.base_z == 0 { 0 } else { plan.base_z };
        assert!(layers.first().is_none_or(|l| l.bottom == begin), "seed {seed}");
        assert!(layers.windows(2).all(|w| w[0].top == w[1].bottom), "seed {seed}");
        for (i, layer) in layers.iter().enumerate().skip(usize::from(begin == 0)) {
            let height = layer.top - layer.bottom;
            assert!(plan.heights[0] <= height && height <= plan.heights[1], "seed {seed}, {i}: {height}");
        }
        // Every top is reached from below, by less than the least height.
        let floor = if begin == 0 { plan.first_height } else { begin };
        for top in tops.iter().filter(|t| **t >= floor + plan.heights[0]) {
            let reached = layers.iter().map(|l| l.top).filter(|t| t <= top).max().unwrap();
            assert!(top - reached < plan.heights[0], "seed {seed}: {top} {reached}");
        }
    }
}

/// Whether a cell of an area lies at most `distance` \[units\] from cell `s` of row `k`.
fn near(area: &Rows, frame: &RowFrame, k: i32, s: i32, distance: i64) -> bool {
    let rows = (distance / frame.pitch()) as i32 + 1;
    (k - rows..=k + rows).any(|j| {
        let across = frame.t(j) - frame.t(k);
        area.row(j).iter().any(|x| {
            let along = i64::from((x.start - s).max(s - (x.end - 1)).max(0));
            across * across + along * along <= distance * distance
        })
    })
}

/// Cells at the ends and in the middle of all spans of some rows.
fn samples(area: &Rows) -> impl Iterator<Item = (i32, i32)> {
    let ends = |s: &crate::span::Span| [s.start, s.start.midpoint(s.end), s.end - 1];
    area.iter().step_by(5).flat_map(move |(k, row)| row.iter().flat_map(ends).map(move |s| (k, s)))
}

/// Supports that come too near to the part, and overlap.
fn misplaced(part: &Boxes, layers: &[SupportLayer], plan: &SupportPlan) -> usize {
    let gap = plan.frame.units(plan.xy_gap);
    let mut wrong = 0;
    for layer in layers {
        let areas = [&layer.base, &layer.interface, &layer.bottom_interface];
        for (i, a) in areas.iter().enumerate() {
            wrong += areas[i + 1..].iter().filter(|b| !and(a, b).is_empty()).count();
        }
        wrong += usize::from(!sub(&layer.contact, &layer.interface).is_empty());
        let (bottom, top) = (i64::from(layer.bottom_z()), i64::from(layer.print_z));
        for (outline, level) in part.outlines.iter().zip(&part.levels) {
            let beside = level.top > bottom - i64::from(plan.bottom_gap) && level.bottom < top;
            let above = level.top > top && level.bottom < top + i64::from(plan.top_gap);
            if beside || above {
                let distance = if beside { gap } else { 0 };
                let cells = areas.iter().flat_map(|a| samples(a));
                wrong += cells.filter(|(k, s)| near(outline, &plan.frame, *k, *s, distance)).count();
            }
        }
    }
    wrong
}

/// Cells that hang without support although there is room for it, and how many were looked at.
fn unsupported(part: &Boxes, layers: &[SupportLayer], plan: &SupportPlan) -> [usize; 2] {
    let half = plan.frame.units(plan.half_wall);
    let mut counts = [0; 2];
    for i in 1..part.levels.len() {
        let bottom = part.levels[i].bottom;
        let highest = bottom - i64::from(plan.top_gap);
        let lowest = highest - i64::from(plan.thread_drop) - i64::from(plan.heights[0]);
        let ends = |l: &&SupportLayer| (lowest..=highest).contains(&l.print_z.into());
        let under: Vec<Rows> =
            layers.iter().filter(ends).map(|l| or(&l.base, &or(&l.interface, &l.bottom_interface))).collect();
        for (k, s) in samples(&part.overhangs[i].area) {
            let below = bottom - 2_000_000;
            let blocked = (0..i).any(|j| {
                part.levels[j].top > below && near(&part.outlines[j], &plan.frame, k, s, 2 * half + 200_000)
            });
            if blocked || below < 0 {
                continue;
            }
            counts[1] += 1;
            counts[0] += usize::from(!under.iter().any(|u| near(u, &plan.frame, k, s, half)));
        }
    }
    counts
}

#[test]
fn random_stacks_are_supported_and_nothing_comes_near_them() {
    let mut looked_at = 0;
    for seed in 1..25 {
        for style in [SupportStyle::Grid, SupportStyle::Snug] {
            let mut random = Random(seed);
            let plan = plan(style);
            let boxes: Vec<[[f64; 3]; 2]> = (0..2 + random.below(4))
                .map(|i| {
                    let mut mm = |low, high| random.within(low, high) as f64;
                    let from = [mm(-8, 6), mm(-8, 6), if i == 0 { 0.0 } else { 0.2 * mm(0, 25) }];
                    [from, [from[0] + mm(1, 9), from[1] + mm(1, 9), from[2] + 0.2 * mm(2, 12)]]
                })
                .collect();
            let part = Boxes::new(&boxes, &plan);
            let layers = part.columns(&plan);
            assert_eq!(misplaced(&part, &layers, &plan), 0, "seed {seed}, {style:?}");
            let [bare, cells] = unsupported(&part, &layers, &plan);
            assert_eq!(bare, 0, "seed {seed}, {style:?}, of {cells}");
            looked_at += cells;
            // Both can fail.
            let wide = SupportPlan { xy_gap: 3.0 * plan.xy_gap, ..plan.clone() };
            assert!(layers.is_empty() || cells == 0 || misplaced(&part, &layers, &wide) > 0 || seed % 3 > 0);
            assert_eq!(unsupported(&part, &[], &plan)[0], cells);
        }
    }
    assert!(looked_at > 1000, "{looked_at}");
}
