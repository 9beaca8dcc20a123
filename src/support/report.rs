//! What is supported, and by what.

use super::check::{Print, Rule, area, is_raft, supports_under};
use crate::span::algebra::{and, or};
use crate::span::components::label;
use crate::span::{RowFrame, Rows};
use rayon::prelude::*;

/// What supports do, in numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Facts {
    /// What hangs and needs support, summed over the layers \[mm²\].
    pub hanging_mm2: f64,
    /// What hangs and holds itself as a bridge \[mm²\].
    pub bridged_mm2: f64,
    /// What hangs and has support below \[mm²\].
    pub contact_mm2: f64,
    /// Where supports stand on the part \[mm²\].
    pub foot_mm2: f64,
    /// Connected areas of support that begin on the bed, or on a raft.
    pub columns_on_bed: u64,
    /// Those that begin on the part.
    pub columns_on_part: u64,
    /// Space that supports take, raft left out \[mm³\].
    pub volume_mm3: f64,
    /// Space that the raft takes \[mm³\].
    pub raft_mm3: f64,
    /// Layers of supports, raft left out.
    pub layers: u64,
}

/// Measures supports; lengths and areas are those of the rows.
pub fn facts(print: &Print, rule: &Rule) -> Facts {
    let frame = print.part.frame;
    let mm2 = |rows: &Rows| rows.length() as f64 * frame.mm2_per_unit();
    let hanging: Vec<[f64; 3]> = print
        .overhangs
        .par_iter()
        .enumerate()
        .map(|(i, o)| {
            if o.area.is_empty() {
                return [0.0, mm2(&o.bridged), 0.0];
            }
            [mm2(&o.area), mm2(&o.bridged), mm2(&and(&o.area, &supports_under(print, i, rule)))]
        })
        .collect();
    let standing: Vec<[f64; 4]> =
        (0..print.supports.len()).into_par_iter().map(|j| standing(print, j, frame)).collect();
    // Summed in order, so that the threads do not show.
    let mut all = Facts::default();
    for [own, bridged, contact] in hanging {
        all.hanging_mm2 += own;
        all.bridged_mm2 += bridged;
        all.contact_mm2 += contact;
    }
    for (layer, [on_bed, on_part, foot, mm2]) in print.supports.iter().zip(standing) {
        let mm3 = mm2 * crate::lattice::mm(layer.height);
        if is_raft(layer.kind) {
            all.raft_mm3 += mm3;
            continue;
        }
        all.volume_mm3 += mm3;
        all.columns_on_bed += on_bed as u64;
        all.columns_on_part += on_part as u64;
        all.foot_mm2 += foot;
        all.layers += 1;
    }
    all
}

/// Areas of a layer that begin on the bed and on the part, the area of the latter \[mm²\], that of all.
fn standing(print: &Print, j: usize, frame: &RowFrame) -> [f64; 4] {
    let Some(layer) = print.supports.get(j) else { return [0.0; 4] };
    let own_area = area(layer);
    let mm2 = |length: i64| length as f64 * frame.mm2_per_unit();
    let all = mm2(own_area.length());
    if is_raft(layer.kind) || own_area.is_empty() {
        return [0.0, 0.0, 0.0, all];
    }
    let earlier = print.supports.get(..j).unwrap_or_default();
    let first = earlier.partition_point(|l| l.print_z < layer.bottom_z());
    let below = earlier.get(first..).unwrap_or_default();
    let on_raft = below.iter().any(|l| is_raft(l.kind));
    let below = below.iter().fold(Rows::default(), |all, l| or(&all, &area(l)));
    let part = label(&own_area);
    let parts = part.iter().max().map_or(0, |p| *p as usize + 1);
    let (mut stands, mut length) = (vec![true; parts], vec![0i64; parts]);
    for k in own_area.first()..own_area.end() {
        let under = below.row(k);
        for i in own_area.range(k) {
            let (Some(span), Some(&p)) = (own_area.spans().get(i), part.get(i)) else { continue };
            let near = under.partition_point(|s| s.end <= span.start);
            let is_over = under.get(near).is_some_and(|s| s.start < span.end);
            if let (Some(stands), Some(length)) = (stands.get_mut(p as usize), length.get_mut(p as usize)) {
                *stands &= !is_over;
                *length += span.length();
            }
        }
    }
    let own = stands.iter().zip(&length).filter(|(stands, _)| **stands);
    let (count, length) = own.fold((0.0, 0), |(n, sum), (_, l)| (n + 1.0, sum + l));
    if layer.bottom_z() <= 0 || on_raft { [count, 0.0, 0.0, all] } else { [0.0, count, mm2(length), all] }
}
