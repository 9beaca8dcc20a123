//! Supports, brim and raft between the layers of the part.

use super::testing::{Random, circle, rectangle};
use super::{Extrusion, LayerPlan, PrintIsland, PrintLayer, Role, plan};
use crate::lattice::Point2;
use crate::region::Wall;
use crate::settings::{FloatOrPercent, SeamPosition, Settings};
use crate::slice::planes::LayerZ;
use crate::support::{Strand, StrandKind};

const HEIGHT: i32 = 200_000;

fn strand(kind: StrandKind, points: &[(i32, i32)], closed: bool) -> Strand {
    Strand { points: points.iter().map(|&(x, y)| Point2::new(x * 1000, y * 1000)).collect(), closed, kind }
}

/// Layer `k` of a part with one wall.
fn part(k: i32, ring: Vec<Point2>) -> PrintLayer {
    let wall = Wall { ring, depth: 0, hole: false, overhang: Vec::new() };
    PrintLayer {
        z: LayerZ { slice_z: k * HEIGHT + 100_000, print_z: (k + 1) * HEIGHT, height: HEIGHT },
        islands: vec![PrintIsland { walls: vec![wall], ..PrintIsland::default() }],
        ..PrintLayer::default()
    }
}

/// A layer of supports alone.
fn beside(print_z: i32, height: i32) -> PrintLayer {
    PrintLayer {
        z: LayerZ { slice_z: 0, print_z, height },
        supports: vec![strand(StrandKind::Base, &[(0, 0), (9_000, 0)], false)],
        support_height: height,
        ..PrintLayer::default()
    }
}

fn uncooled() -> Settings {
    let mut settings = Settings::default();
    settings.cooling.cooling = false;
    settings
}

fn roles(layer: &LayerPlan) -> Vec<Role> {
    layer.extrusions.iter().map(|e| e.role).collect()
}

#[test]
fn supports_come_before_the_part_and_after_the_brim() {
    let square = rectangle(20_000_000, 0, 40_000_000, 20_000_000);
    let layer = PrintLayer {
        skirt: vec![rectangle(-9_000_000, -9_000_000, 50_000_000, 30_000_000)],
        brim: vec![strand(StrandKind::Brim, &[(19_000, -1_000), (41_000, -1_000), (41_000, 21_000)], true)],
        supports: vec![
            strand(StrandKind::Interface, &[(0, 0), (0, 9_000)], false),
            strand(StrandKind::Base, &[(12_000, 0), (12_000, 9_000)], false),
            strand(StrandKind::Base, &[(1_000, 0), (9_000, 0), (9_000, 9_000), (1_000, 9_000)], true),
        ],
        support_height: 300_000,
        ..part(1, square.clone())
    };
    let layers = plan(&[part(0, square), layer], Point2::default(), &uncooled());
    use Role::{ExternalPerimeter, Skirt, SupportInterface, SupportMaterial};
    let second = &layers[1];
    assert_eq!(
        roles(second),
        [Skirt, Skirt, SupportMaterial, SupportMaterial, SupportInterface, ExternalPerimeter]
    );
    let heights: Vec<f64> = second.extrusions.iter().map(|e| e.height).collect();
    assert_eq!(heights, [0.2, 0.2, 0.3, 0.3, 0.3, 0.2]);
    // Loops are closed but for the seam's gap; lines of both kinds have their own speeds.
    let closed = |e: &Extrusion| second.path(e)[0].distance(second.path(e)[second.path(e).len() - 1]) < 70e3;
    assert!(closed(&second.extrusions[1]) && second.extrusions.iter().filter(|e| closed(e)).count() == 4);
    let s = uncooled().speed;
    assert_eq!(second.extrusions[2].speed, s.support_material_speed);
    assert_eq!(second.extrusions[4].speed, s.support_material_interface_speed.of(s.support_material_speed));
    assert!(second.extrusions[5].retract);
}

#[test]
fn supports_are_printed_without_detours() {
    for seed in 0..50 {
        let mut random = Random::new(seed);
        let supports: Vec<Strand> = (0..30)
            .map(|i| {
                let (x, y) = (random.below(60) as i32 * 1000, random.below(60) as i32 * 1000);
                let kind = [StrandKind::Base, StrandKind::Interface][i % 2];
                if random.below(2) == 0 {
                    return strand(kind, &[(x, y), (x + 3_000, y), (x + 3_000, y + 500)], false);
                }
                let points = circle(x * 1000, y * 1000, 2_000_000, 30, 0.0);
                Strand { points, closed: true, kind }
            })
            .collect();
        let layer =
            PrintLayer { supports, support_height: HEIGHT, ..part(0, circle(0, 0, 9_000_000, 9, 0.0)) };
        let planned = plan([&layer], Point2::default(), &uncooled()).remove(0);
        assert_eq!(planned.extrusions.len(), 31, "seed {seed}");
        let kinds: Vec<Role> = roles(&planned);
        assert!(kinds[..15].iter().all(|r| *r == Role::SupportMaterial), "seed {seed}");
        assert!(kinds[15..30].iter().all(|r| *r == Role::SupportInterface), "seed {seed}");
        // In the given order the ways would be about 31 mm each.
        let ways = planned.extrusions.windows(2).map(|w| {
            let from = planned.path(&w[0]);
            from[from.len() - 1].distance(planned.path(&w[1])[0])
        });
        let mean = ways.sum::<f64>() / 30e6;
        assert!(mean < 20.0, "seed {seed}: {mean}");
    }
}

/// The places where the walls of the part's layers begin.
fn seams(layers: &[LayerPlan]) -> Vec<Point2> {
    let walls = |l: &LayerPlan| {
        let wall = l.extrusions.iter().find(|e| e.role == Role::ExternalPerimeter)?;
        l.path(wall).first().copied()
    };
    layers.iter().filter_map(walls).collect()
}

#[test]
fn layers_of_supports_leave_the_part_as_it_is() {
    for position in [SeamPosition::Aligned, SeamPosition::Random, SeamPosition::Rear] {
        let mut settings = uncooled();
        settings.perimeters.seam_position = position;
        // Round, so that nothing but the seam below holds a seam in its place; it wanders.
        let ring = |k: i32| circle(k * 50_000, 0, 9_000_000, 64, f64::from(k) * 0.02);
        let alone: Vec<_> = (0..6).map(|k| part(k, ring(k))).collect();
        let mut mixed = Vec::new();
        for layer in &alone {
            let z = layer.z.print_z;
            mixed.push(beside(z - 90_000, 110_000));
            mixed.push(layer.clone());
        }
        let (a, b) = (plan(&alone, Point2::default(), &settings), plan(&mixed, Point2::default(), &settings));
        assert_eq!(seams(&a), seams(&b), "{position:?}");
        assert_eq!(seams(&a).len(), 6);
    }
}

#[test]
fn combined_infill_counts_the_parts_layers() {
    use crate::infill::{FillKind, FillPath};
    let fill = FillPath {
        points: vec![Point2::new(0, 0), Point2::new(9_000_000, 0)],
        kind: FillKind::Sparse,
        layers: 2,
    };
    let mut upper = part(1, Vec::new());
    upper.islands[0].fills = vec![fill];
    let layers = [part(0, Vec::new()), beside(290_000, 110_000), upper];
    let planned = plan(&layers, Point2::default(), &uncooled());
    assert!((planned[2].extrusions[0].height - 0.4).abs() < 1e-12);
}

#[test]
fn only_the_lowest_layer_is_the_first() {
    let mut settings = uncooled();
    settings.speed.first_layer_speed = FloatOrPercent::Float(11.0);
    settings.speed.first_layer_speed_over_raft = FloatOrPercent::Float(22.0);
    settings.widths.first_layer_extrusion_width = FloatOrPercent::Float(0.6);
    let ring = rectangle(0, 0, 20_000_000, 20_000_000);
    let on_raft = PrintLayer { on_raft: true, ..part(5, ring.clone()) };
    let layers = [beside(200_000, 200_000), beside(500_000, 300_000), on_raft, part(6, ring)];
    let planned = plan(&layers, Point2::default(), &settings);
    let speeds: Vec<f64> = planned.iter().map(|l| l.extrusions[0].speed).collect();
    assert_eq!(speeds[..3], [11.0, settings.speed.support_material_speed, 22.0]);
    assert!(speeds[3] > 22.0);
    let widths: Vec<f64> = planned.iter().map(|l| l.extrusions[0].width).collect();
    assert_eq!(widths[0], 0.6);
    assert!(widths[1..].iter().all(|w| *w < 0.5));
    // Of the layers between, too, the height is their own.
    assert_eq!(planned.iter().map(|l| l.height).collect::<Vec<_>>(), [200_000, 300_000, 200_000, 200_000]);
    // The fan counts all layers.
    let mut cooled = settings.clone();
    cooled.cooling.cooling = true;
    cooled.cooling.disable_fan_first_layers = 2;
    let fans: Vec<bool> = plan(&layers, Point2::default(), &cooled).iter().map(|l| l.fan > 0.0).collect();
    assert_eq!(fans, [false, false, true, true]);
}

#[test]
fn the_skirt_beside_a_raft_closes_the_gap_above_it() {
    let square = rectangle(0, 0, 20_000_000, 20_000_000);
    let skirt = vec![rectangle(-9_000_000, -9_000_000, 50_000_000, 30_000_000)];
    let section = |skirt_height: i32| {
        let layer = PrintLayer { skirt: skirt.clone(), skirt_height, ..part(1, square.clone()) };
        let layers = plan(&[part(0, square.clone()), layer], Point2::default(), &uncooled());
        let line = &layers[1].extrusions[0];
        assert_eq!(line.role, Role::Skirt);
        assert_eq!(layers[1].extrusions[1].height, 0.2);
        (line.height, line.mm3_per_mm)
    };
    let (own, thick) = (section(200_000), section(300_000));
    assert_eq!((own.0, thick.0), (0.2, 0.3));
    assert!(thick.1 > 1.35 * own.1);
    assert_eq!(section(0), own);
}
