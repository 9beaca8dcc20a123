//! Areas carried over to rows of other directions.

use super::shapes::*;
use super::stays_inside::random_island;
use crate::infill::onto::onto;
use crate::span::algebra::{and, sub};
use crate::span::tests::Random;
use crate::span::{RowFrame, Rows, RowsBuilder, scan};

/// A part of an area with borders at random places.
fn random_part(random: &mut Random, own: &Rows) -> Rows {
    let mut out = RowsBuilder::new(own.first());
    let mut at = 0;
    for (k, _) in own.iter() {
        if k % 7 == 0 {
            at = random.within(-40_000_000, 40_000_000) as i32;
        }
        if k % 23 > 4 {
            out.push(at, at.saturating_add(20_000_000));
        }
        out.end_row();
    }
    and(own, &out.finish())
}

#[test]
fn parts_share_the_lines_out_without_a_rest() {
    let mut checked = 0;
    for seed in 1..40 {
        let mut random = Random(seed * 131);
        let island = random_island(&mut random);
        let rings = || island.infill.iter().flat_map(|e| e.rings()).map(|r| &r[..]);
        let frame = RowFrame::new([45.0, 0.0, 30.0][seed as usize % 3], 0.0, 400_000.0);
        let own = scan(rings(), &frame);
        let part = random_part(&mut random, &own);
        for (degrees, pitch) in
            [(135.0, 400_000.0), (45.0, 2_000_000.0), (10.0, 450_000.0), (90.0, 410_000.0)]
        {
            let lines = RowFrame::new(degrees, 1000.0, pitch);
            let whole = scan(rings(), &lines);
            let a = onto(&part, &own, &frame, &whole, &lines);
            let b = onto(&sub(&own, &part), &own, &frame, &whole, &lines);
            let case = format!("seed {seed}, {degrees} degrees");
            assert_eq!(a.length() + b.length(), whole.length(), "{case}");
            assert!(and(&a, &b).is_empty(), "{case}");
            assert_eq!(onto(&own, &own, &frame, &whole, &lines), whole, "{case}");
            assert!(onto(&Rows::default(), &own, &frame, &whole, &lines).is_empty());
            // Point by point: where the nearest row meets the region, it says what the point is.
            for (k, row) in a.iter() {
                for s in row {
                    let p = lines.xy(((i64::from(s.start) + i64::from(s.end)) / 2) as i32, lines.t(k));
                    let (s, t) = frame.st(p);
                    let near = frame.nearest_row(t.into());
                    let holds = |rows: &Rows| rows.row(near).iter().any(|x| (x.start..x.end).contains(&s));
                    // Rows are half-way apart where rounding decides.
                    let clear = (i64::from(t) - frame.t(near)).abs() < frame.pitch() / 2 - 4;
                    if clear && holds(&own) {
                        assert!(holds(&part), "{case}, row {k}");
                        checked += 1;
                    }
                }
            }
        }
    }
    assert!(checked > 1000, "{checked}");
}

#[test]
fn a_tip_belongs_to_the_kind_of_its_row() {
    // The triangle's tip lies between two rows; lines across it must reach it.
    let triangle = [vec![at(-5.0, 0.05), at(5.0, 0.05), at(0.0, 10.3)]];
    let rings = || triangle.iter().map(|r| &r[..]);
    let (frame, lines) = (RowFrame::new(0.0, 0.0, 1e6), RowFrame::new(90.0, 0.0, 1e6));
    let (own, whole) = (scan(rings(), &frame), scan(rings(), &lines));
    let mut upper = RowsBuilder::new(6);
    for _ in 6..11 {
        upper.push(-9_000_000, 9_000_000);
        upper.end_row();
    }
    let upper = and(&own, &upper.finish());
    let a = onto(&upper, &own, &frame, &whole, &lines);
    let b = onto(&sub(&own, &upper), &own, &frame, &whole, &lines);
    // The middle line runs from 0.05 to 10.3 mm and changes half-way between the rows 5 and 6.
    let middle = whole.row(0)[0];
    assert_eq!((a.row(0)[0].start, a.row(0)[0].end), (5_500_000, middle.end));
    assert_eq!((b.row(0)[0].start, b.row(0)[0].end), (middle.start, 5_500_000));
}
