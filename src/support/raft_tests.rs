use super::*;
use crate::span::RowFrame;

/// Rows 0.1 mm apart.
fn frame() -> RowFrame {
    RowFrame::new(0.0, 0.0, 1e5)
}

/// A rectangle, in mm.
fn rectangle(x0: f64, y0: f64, x1: f64, y1: f64) -> Rows {
    let row = |mm: f64| frame().row_below(nm(mm));
    let mut rows = RowsBuilder::new(row(y0) + 1);
    for _ in row(y0) + 1..=row(y1) {
        rows.push(nm(x0) as i32, nm(x1) as i32);
        rows.end_row();
    }
    rows.finish()
}

fn mm2(area: &Rows) -> f64 {
    area.length() as f64 * frame().mm2_per_unit()
}

fn settings(layers: u32) -> Settings {
    let mut s = Settings::default();
    s.slicing.layer_height = 0.2;
    s.slicing.first_layer_height = FloatOrPercent::Float(0.2);
    s.adhesion.raft_layers = layers;
    s
}

fn plan(settings: &Settings) -> SupportPlan {
    SupportPlan { frame: frame(), ..SupportPlan::new(settings) }
}

fn layers(settings: &Settings, first: &Rows, columns: &Rows) -> Vec<SupportLayer> {
    raft(first, columns, &Heights::new(settings), &plan(settings))
}

#[test]
fn heights_are_those_of_prusaslicer() {
    // Measured: tops of the layers, number of dense ones, height of the part's first layer less its thickness.
    let cases: [(u32, &[i32], usize, i32); 4] = [
        (1, &[200_000], 1, 300_000),
        (2, &[200_000, 500_000], 1, 600_000),
        (3, &[200_000, 500_000, 800_000], 2, 900_000),
        (5, &[200_000, 500_000, 800_000, 1_100_000, 1_400_000], 3, 1_500_000),
    ];
    for (layers, tops, dense, part_z) in cases {
        let heights = Heights::new(&settings(layers));
        assert_eq!(heights.layers.iter().map(|l| l.0).collect::<Vec<_>>(), tops);
        assert_eq!((heights.dense, heights.part_z, heights.top()), (dense, part_z, tops[tops.len() - 1]));
        let mut below = 0;
        for (top, height) in heights.layers {
            assert_eq!(top - height, below);
            below = top;
        }
    }
    assert_eq!(Heights::new(&settings(0)), Heights::default());
}

#[test]
fn thick_layers_thin_limits_and_soluble_supports_count() {
    let mut s = settings(3);
    s.slicing.layer_height = 0.35;
    assert_eq!(Heights::new(&s).layers, [(200_000, 200_000), (550_000, 350_000), (900_000, 350_000)]);
    s.support.support_material_layer_height = 0.25;
    assert_eq!(Heights::new(&s).top(), 700_000);
    s.adhesion.raft_contact_distance = 0.2;
    s.support.support_material_contact_distance = 0.0;
    assert_eq!(Heights::new(&s).part_z, 900_000);
    s.support.support_material = true;
    assert_eq!(Heights::new(&s).part_z, 700_000);
}

#[test]
fn layers_reach_as_far_as_the_settings_say() {
    let part = rectangle(0.0, 0.0, 10.0, 20.0);
    let raft = layers(&settings(4), &part, &Rows::default());
    let kinds: Vec<LayerKind> = raft.iter().map(|l| l.kind).collect();
    let [first, base, dense] = [LayerKind::RaftFirst, LayerKind::RaftBase, LayerKind::RaftInterface];
    assert_eq!(kinds, [first, base, dense, dense]);
    // 1.5 mm, 0.5 mm more below, 3 mm more on the bed; corners are round.
    let grown = |by: f64| 200.0 + 60.0 * by + std::f64::consts::PI * by * by;
    let wanted = [(4.5, true), (2.0, true), (2.0, false), (1.5, false)];
    for (layer, (by, loose)) in raft.iter().zip(wanted) {
        let (own, other) =
            if loose { (&layer.base, &layer.interface) } else { (&layer.interface, &layer.base) };
        assert!(other.is_empty());
        assert!((mm2(own) - grown(by)).abs() < 0.02 * grown(by), "{} for {}", mm2(own), grown(by));
    }
    let contacts: Vec<bool> = raft.iter().map(|l| !l.contact.is_empty()).collect();
    assert_eq!(contacts, [false, false, false, true]);
    assert!(sub(&part, &raft[3].contact).is_empty() && sub(&raft[3].contact, &part).is_empty());
}

#[test]
fn a_single_layer_is_dense_under_the_part_and_loose_around_it() {
    let part = rectangle(0.0, 0.0, 10.0, 20.0);
    let raft = layers(&settings(1), &part, &Rows::default());
    assert_eq!((raft.len(), raft[0].kind), (1, LayerKind::RaftFirst));
    assert!(and(&raft[0].base, &raft[0].interface).is_empty());
    assert!(mm2(&raft[0].interface) > 290.0 && mm2(&raft[0].base) > 200.0);
    assert!(sub(&part, &raft[0].contact).is_empty() && sub(&raft[0].contact, &part).is_empty());
}

#[test]
fn holes_are_filled_and_narrow_gaps_closed() {
    let ring = sub(&rectangle(0.0, 0.0, 40.0, 40.0), &rectangle(10.0, 10.0, 30.0, 30.0));
    let filled = layers(&settings(2), &ring, &Rows::default());
    assert!(sub(&rectangle(0.0, 0.0, 40.0, 40.0), &filled[1].interface).is_empty());
    assert!(sub(&filled[1].contact, &ring).is_empty());
    // Grown by 1.5 mm each, and gaps up to 4 mm closed: 7 mm.
    for (gap, closed) in [(6.5, true), (7.5, false)] {
        let (a, b) = (rectangle(0.0, 0.0, 10.0, 40.0), rectangle(10.0 + gap, 0.0, 20.0 + gap, 40.0));
        let raft = layers(&settings(2), &or(&a, &b), &Rows::default());
        let middle = rectangle(10.0 + 0.5 * gap - 0.1, 19.0, 10.0 + 0.5 * gap + 0.1, 21.0);
        assert_eq!(sub(&middle, &raft[1].interface).is_empty(), closed, "gap {gap}");
        assert_eq!(and(&middle, &raft[1].interface).is_empty(), !closed, "gap {gap}");
    }
}

#[test]
fn columns_stand_on_loose_layers_all_the_way_down() {
    let (part, column) = (rectangle(0.0, 0.0, 10.0, 20.0), rectangle(30.0, 0.0, 34.0, 20.0));
    for count in 1..6 {
        let raft = layers(&settings(count), &part, &column);
        for layer in &raft {
            assert!(sub(&column, &layer.base).is_empty() && and(&column, &layer.interface).is_empty());
            assert!(and(&layer.base, &layer.interface).is_empty());
        }
        for pair in raft.windows(2) {
            let [below, above] = [&pair[0], &pair[1]].map(|l| or(&l.base, &l.interface));
            assert!(sub(&above, &below).is_empty(), "every layer lies on the one below");
        }
    }
    // Nothing stands on the bed without a part.
    let alone = layers(&settings(2), &Rows::default(), &column);
    assert!(sub(&column, &alone[1].base).is_empty() && alone[1].interface.is_empty());
    assert!(layers(&settings(0), &part, &column).is_empty());
}

#[test]
fn only_what_is_enclosed_is_a_hole() {
    let all = rectangle(0.0, 0.0, 20.0, 20.0);
    let bay = sub(&all, &rectangle(5.0, 5.0, 25.0, 15.0));
    let same = |a: &Rows, b: &Rows| sub(a, b).is_empty() && sub(b, a).is_empty();
    assert!(same(&without_holes(&bay), &bay) && !same(&bay, &all));
    let ring = sub(&all, &rectangle(5.0, 5.0, 15.0, 15.0));
    assert!(same(&without_holes(&ring), &all));
    // An island in the hole.
    let inner = or(&ring, &rectangle(8.0, 8.0, 12.0, 12.0));
    assert!(same(&without_holes(&inner), &all));
    assert!(without_holes(&Rows::default()).is_empty());
}

#[test]
fn a_part_on_a_raft_has_no_first_layer_of_its_own() {
    let mut s = settings(2);
    s.slicing.first_layer_height = FloatOrPercent::Float(0.3);
    s.slicing.elefant_foot_compensation = LengthOrPixels::Length(0.2);
    s.widths.first_layer_extrusion_width = FloatOrPercent::Float(0.8);
    let own = part_settings(&s);
    assert_eq!(own.slicing.first_layer_height.of(own.slicing.layer_height), 0.2);
    assert_eq!(own.slicing.elefant_foot_compensation, LengthOrPixels::Length(0.0));
    let walls = |first| crate::region::perimeters::WallPlan::new(&own, 0.2, first);
    assert_eq!(walls(true), walls(false));
}
