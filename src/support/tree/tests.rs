//! Branches under T, cone and random stacks.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use super::*;
use crate::settings::Settings;
use crate::settings::SupportStyle;
use crate::span::RowsBuilder;
use crate::span::algebra::{and, or, sub};
use crate::span::morph::dilate_disc;
use crate::span::tests::Random;
use crate::support::Level;
use crate::support::overhang::{Bridges, Modifiers, overhangs};

/// Thickness of the part's layers \[nm\].
const LAYER: i32 = 200_000;

fn plan() -> SupportPlan {
    let mut settings = Settings::default();
    settings.support.support_material = true;
    settings.support.support_material_style = SupportStyle::Organic;
    settings.slicing.layer_height = 0.2;
    SupportPlan::new(&settings)
}

/// A part made of layers.
struct Stack {
    outlines: Vec<Arc<Rows>>,
    levels: Vec<Level>,
    overhangs: Vec<Overhang>,
    plan: SupportPlan,
}

impl Stack {
    fn new(outlines: Vec<Arc<Rows>>, plan: SupportPlan) -> Self {
        let level = |i: usize| {
            let bottom = i64::from(plan.base_z) + i as i64 * i64::from(LAYER);
            Level { top: bottom + i64::from(LAYER), bottom }
        };
        let levels: Vec<Level> = (0..outlines.len()).map(level).collect();
        let part = Part { outlines: &outlines, levels: &levels, frame: &plan.frame };
        let bridges = vec![Vec::new(); outlines.len()];
        let bridges = Bridges { of_layer: &bridges, frame: &plan.frame };
        let overhangs = overhangs(part, Modifiers::default(), bridges, &plan);
        Self { outlines, levels, overhangs, plan }
    }

    fn part(&self) -> Part<'_> {
        Part { outlines: &self.outlines, levels: &self.levels, frame: &self.plan.frame }
    }

    fn tree(&self) -> Vec<SupportLayer> {
        tree(self.part(), &self.overhangs, &self.plan)
    }
}

/// A rectangle \[mm\].
fn rectangle(frame: &crate::span::RowFrame, [x, y]: [f64; 2], [u, v]: [f64; 2]) -> Rows {
    let t = |mm: f64| frame.units(mm * 1e6);
    let first = frame.row_below(t(y)) + 1;
    let mut out = RowsBuilder::new(first);
    for _ in first..=frame.row_below(t(v)) {
        out.push(t(x) as i32, t(u) as i32);
        out.end_row();
    }
    out.finish()
}

fn disc(frame: &crate::span::RowFrame, at: [f64; 2], r: f64) -> Rows {
    draw::discs(std::iter::once((at.map(|c| c * 1e6), r * 1e6)), frame)
}

fn tee(plan: SupportPlan) -> Stack {
    let stem = Arc::new(rectangle(&plan.frame, [-3.0, -4.0], [3.0, 4.0]));
    let bar = Arc::new(rectangle(&plan.frame, [-14.0, -4.0], [14.0, 4.0]));
    let layers = (0..70).map(|i| Arc::clone(if i < 60 { &stem } else { &bar })).collect();
    Stack::new(layers, plan)
}

fn cone(plan: SupportPlan) -> Stack {
    let layers = (0..40).map(|i| Arc::new(disc(&plan.frame, [1.0, 2.0], 2.0 + 0.3 * f64::from(i)))).collect();
    Stack::new(layers, plan)
}

/// Rectangles and discs that begin and end at random heights.
fn random_stack(seed: u64, plan: SupportPlan) -> Stack {
    let mut random = Random(seed * 7919 + 3);
    let bodies: Vec<(i64, i64, Rows)> = (0..5)
        .map(|n| {
            let low = if n == 0 { 0 } else { random.within(0, 35) };
            let mut mm = |a: i64, b: i64| random.within(a * 100, b * 100) as f64 / 100.0;
            let at = [mm(-8, 8), mm(-8, 8)];
            let area = match n % 2 {
                0 => rectangle(&plan.frame, at, [at[0] + mm(1, 12), at[1] + mm(1, 12)]),
                _ => disc(&plan.frame, at, mm(1, 6)),
            };
            (low, low + random.within(3, 30), area)
        })
        .collect();
    let layer = |i: i64| {
        let inside = bodies.iter().filter(|b| (b.0..b.1).contains(&i));
        Arc::new(inside.fold(Rows::default(), |all, b| or(&all, &b.2)))
    };
    let high = bodies.iter().map(|b| b.1).max().unwrap_or(0);
    Stack::new((0..high).map(layer).collect(), plan)
}

/// All test bodies, with a name.
fn stacks() -> Vec<(String, Stack)> {
    let mut all = vec![("tee".to_owned(), tee(plan())), ("cone".to_owned(), cone(plan()))];
    let mut bare = plan();
    bare.top_interface = 0;
    all.push(("tee without roof".to_owned(), tee(bare)));
    let mut on_layers = plan();
    on_layers.synchronized = true;
    all.push(("cone on the part's layers".to_owned(), cone(on_layers)));
    all.extend((0..8).map(|seed| (format!("random {seed}"), random_stack(seed, plan()))));
    all
}

/// What of the overhangs hangs further than allowed from the part below and from support right under it, where
/// support is allowed.
fn unsupported(stack: &Stack, layers: &[SupportLayer]) -> Vec<(usize, Rows)> {
    let (part, plan) = (stack.part(), &stack.plan);
    let t = |k| plan.frame.t(k);
    let mut found = Vec::new();
    for (i, overhang) in stack.overhangs.iter().enumerate().filter(|o| !o.1.area.is_empty()) {
        let reach = plan.frame.units(contacts::reach(part, i, plan)) + 1;
        let bottom = stack.levels[i].bottom as i32;
        let under = bottom - plan.top_gap;
        let mut held = Arc::clone(&stack.outlines[i - 1]);
        for l in layers.iter().filter(|l| l.print_z <= bottom && l.print_z > under - heights::THINNEST) {
            held = Arc::new(or(&held, &or(&l.base, &l.interface)));
        }
        // No support may be beside or right above the part, nor below the first layer's top.
        let Some(layer) = layers.iter().find(|l| l.print_z == under) else {
            assert!(under < plan.base_z + plan.first_height, "no layer ends below layer {i}");
            continue;
        };
        let own = [Layer { top: layer.print_z, height: layer.height }];
        let barred = &clearance::clearance(part, &own, plan)[0];
        let open = sub(&overhang.area, &dilate_disc(barred, reach, t));
        let bad = sub(&open, &dilate_disc(&held, reach, t));
        if !bad.is_empty() {
            found.push((i, bad));
        }
    }
    found
}

#[test]
fn all_that_hangs_is_held() {
    for (name, stack) in stacks() {
        let mut layers = stack.tree();
        let bad = unsupported(&stack, &layers);
        assert!(bad.is_empty(), "{name}: {:?}", bad.iter().map(|b| (b.0, b.1.length())).collect::<Vec<_>>());
        // Without its highest layer something hangs.
        if layers.pop().is_some() {
            let had = stack.overhangs.iter().rposition(|o| !o.area.is_empty());
            assert!(had.is_some());
            if name == "tee" {
                layers.iter_mut().for_each(|l| l.interface = Rows::default());
                layers.push(SupportLayer {
                    print_z: 60 * LAYER - stack.plan.top_gap,
                    ..SupportLayer::default()
                });
                assert!(!unsupported(&stack, &layers).is_empty(), "{name}");
            }
        }
    }
}

#[test]
fn nothing_is_in_the_clearance() {
    for (name, stack) in stacks() {
        let plan = &stack.plan;
        let layers = stack.tree();
        let breaks = |wider: f64| {
            layers.iter().any(|l| {
                let (low, high) = (i64::from(l.bottom_z()), i64::from(l.print_z));
                let all = or(&l.base, &l.interface);
                stack.levels.iter().zip(&stack.outlines).any(|(level, outline)| {
                    let is_beside = level.top > low && level.bottom < high;
                    let is_near = level.top > low - i64::from(plan.bottom_gap)
                        && level.bottom < high + i64::from(plan.top_gap);
                    let gap = if is_beside { plan.frame.units(plan.xy_gap + wider) } else { 0 };
                    // Brute force: the ends of all spans against all spans of the part.
                    is_near
                        && all.iter().any(|(k, row)| {
                            row.iter().any(|s| {
                                outline.iter().any(|(j, other)| {
                                    let d = plan.frame.t(j) - plan.frame.t(k);
                                    d.abs() <= gap && {
                                        let w = (gap * gap - d * d).isqrt() as i32;
                                        other.iter().any(|o| s.start < o.end + w && s.end > o.start - w)
                                    }
                                })
                            })
                        })
                })
            })
        };
        assert!(!breaks(0.0), "{name}");
        assert!(name != "tee" || breaks(50_000.0), "the roof reaches the gap around the stem");
    }
}

#[test]
fn all_stands_on_the_bed_or_on_the_part() {
    for (name, stack) in stacks() {
        let layers = stack.tree();
        let keep_out = clearance::clearance(
            stack.part(),
            &layers.iter().map(|l| Layer { top: l.print_z, height: l.height }).collect::<Vec<_>>(),
            &stack.plan,
        );
        let all: Vec<Rows> = layers.iter().map(|l| or(&l.base, &l.interface)).collect();
        for j in 1..layers.len() {
            assert_eq!(layers[j].bottom_z(), layers[j - 1].print_z, "{name}, layer {j}");
            let loose = draw::apart_from(&all[j], &or(&all[j - 1], &keep_out[j - 1]));
            assert!(loose.is_empty(), "{name}, layer {j}: {}", loose.length());
            assert!(and(&layers[j].base, &layers[j].interface).is_empty(), "{name}, layer {j}");
            assert!(sub(&layers[j].thick, &layers[j].base).is_empty(), "{name}, layer {j}");
        }
        if name == "tee" {
            // A layer that is missing is seen.
            let high = all.len() - 1;
            assert!(!draw::apart_from(&all[high], &Rows::default()).is_empty());
        }
    }
}

#[test]
fn branches_lean_no_more_than_they_may() {
    for (name, stack) in stacks() {
        let plan = &stack.plan;
        let (layers, skeleton) = skeleton(&stack);
        let lean = libm::tan(plan.tree.angle.to_radians());
        let slow = libm::tan(plan.tree.angle_slow.to_radians());
        let mut most = 0.0f64;
        for j in 1..skeleton.len() {
            let rise = 0.5 * f64::from(layers[j].height + layers[j - 1].height);
            for node in skeleton[j].iter().filter(|n| n.below != grow::ON_PART) {
                let under = skeleton[j - 1][node.below as usize];
                let (u, v) = (under.at[0] - node.at[0], under.at[1] - node.at[1]);
                let moved = (u * u + v * v).sqrt();
                most = most.max(moved / rise);
                // Where two join, the lighter one may jump, but stays well within the joint.
                let joins = skeleton[j].iter().filter(|n| n.below == node.below).count() > 1;
                let allowed = if joins { 0.75 * under.r.max(node.r) } else { 0.0 };
                assert!(moved <= (lean * rise).max(allowed) * 1.001, "{name}, layer {j}: {moved} nm");
                assert!(moved <= 0.9 * node.r.max(under.r), "{name}, layer {j}: it does not stand");
                assert!(under.r >= node.r, "{name}, layer {j}");
            }
        }
        assert!(name != "tee" || most > slow * 0.5, "{name}: nothing leans");
    }
}

fn skeleton(stack: &Stack) -> (Vec<Layer>, grow::Skeleton) {
    let plan = &stack.plan;
    let mut wanted = contacts::wanted(stack.part(), &stack.overhangs, plan);
    let layers = heights::heights(stack.part(), &mut wanted, plan);
    let keep_out = clearance::clearance(stack.part(), &layers, plan);
    let held = contacts::held(stack.part(), &stack.overhangs, &wanted, &keep_out, plan);
    let stage = Stage { layers: &layers, keep_out: &keep_out, held: &held, plan };
    let mut skeleton = grow::grow(&stage, &field::Field::new(&stage));
    smooth::smooth(&mut skeleton, &stage);
    (layers.clone(), skeleton)
}

#[test]
fn branches_grow_together() {
    let (_, skeleton) = skeleton(&tee(plan()));
    let most = skeleton.iter().map(Vec::len).max().unwrap();
    assert!(most >= 12 && skeleton[0].len() * 3 <= most, "{most} to {}", skeleton[0].len());
}

#[test]
fn the_same_with_any_number_of_threads() {
    for (name, stack) in stacks().into_iter().take(6) {
        let with = |threads| {
            rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(|| stack.tree())
        };
        assert!(with(1) == with(3), "{name}");
    }
}

#[test]
fn on_the_bed_only_nothing_stands_on_the_part() {
    // A plate above a wider one, and one beside it.
    let mut plan = plan();
    plan.on_bed_only = true;
    let low = Arc::new(rectangle(&plan.frame, [-10.0, -10.0], [10.0, 10.0]));
    let post = Arc::new(rectangle(&plan.frame, [-1.0, -1.0], [1.0, 1.0]));
    let high = Arc::new(rectangle(&plan.frame, [-5.0, -5.0], [30.0, 5.0]));
    let layers = (0..60).map(|i| Arc::clone([&low, &post, &high][(i > 9) as usize + (i > 49) as usize]));
    let stack = Stack::new(layers.collect(), plan);
    // A branch beside the plate may lean over its edge, a little right above it.
    let inner = rectangle(&stack.plan.frame, [-7.0, -7.0], [7.0, 7.0]);
    let on_plate = |layers: &[SupportLayer]| {
        let just_above = layers.iter().filter(|l| l.print_z < 16 * LAYER);
        just_above.map(|l| or(&l.base, &l.interface)).any(|all| !and(&all, &inner).is_empty())
    };
    let layers = stack.tree();
    assert!(!layers.is_empty() && !on_plate(&layers));
    let mut anywhere = stack.plan.clone();
    anywhere.on_bed_only = false;
    assert!(on_plate(&Stack::new(stack.outlines, anywhere).tree()));
}
