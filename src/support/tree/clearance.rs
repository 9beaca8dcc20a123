//! Where no support may be, and how far away that is.

use super::{Layer, Part, SupportPlan, per_layer};
use crate::span::algebra::or;
use crate::span::morph::dilate_disc;
use crate::span::{RowFrame, Rows};
use std::ops::Range;
use std::sync::Arc;

/// Per layer of supports what it must keep out of: the part beside it and the gap around that, the part above
/// and below it as far as the gaps there reach. Neighbours that are equal share theirs.
pub fn clearance(part: Part, layers: &[Layer], plan: &SupportPlan) -> Vec<Arc<Rows>> {
    // The part's layers that reach into the heights between two.
    let within = |low: i64, high: i64| -> Range<usize> {
        let first = part.levels.partition_point(|l| l.top <= low);
        let end = part.levels.partition_point(|l| l.bottom < high);
        first..end.min(part.outlines.len()).max(first)
    };
    let ranges: Vec<[Range<usize>; 2]> = layers
        .iter()
        .map(|l| {
            let (low, high) = (i64::from(l.top - l.height), i64::from(l.top));
            [within(low, high), within(low - i64::from(plan.bottom_gap), high + i64::from(plan.top_gap))]
        })
        .collect();
    let used = ranges.iter().map(|r| r[0].end).max().unwrap_or(0);
    let gap = part.frame.units(plan.xy_gap);
    let is_new = |i: usize| i == 0 || !Arc::ptr_eq(&part.outlines[i], &part.outlines[i - 1]);
    let own = per_layer(used, |i| {
        is_new(i).then(|| Arc::new(dilate_disc(&part.outlines[i], gap, |k| part.frame.t(k))))
    });
    let wide = filled(own);
    let own = per_layer(layers.len(), |j| {
        let of = |j: usize| ranges[j].clone().map(|r| r.map(|i| Arc::as_ptr(&part.outlines[i])));
        let [beside, near] = ranges[j].clone();
        let same = j > 0 && {
            let ([a, b], [c, d]) = (of(j - 1), of(j));
            distinct(a).eq(distinct(c)) && distinct(b).eq(distinct(d))
        };
        (!same).then(|| {
            let mut all = Rows::default();
            for i in beside.clone().filter(|&i| i == beside.start || is_new(i)) {
                all = or(&all, &wide[i]);
            }
            for i in near.clone().filter(|&i| (i == near.start || is_new(i)) && !beside.contains(&i)) {
                all = or(&all, &part.outlines[i]);
            }
            Arc::new(all)
        })
    });
    filled(own)
}

/// Equal neighbours once.
fn distinct<T: PartialEq + Copy>(all: impl Iterator<Item = T>) -> impl Iterator<Item = T> {
    let mut last = None;
    all.filter(move |x| last.replace(*x) != Some(*x))
}

/// What is missing is what comes before it.
fn filled(all: Vec<Option<Arc<Rows>>>) -> Vec<Arc<Rows>> {
    let mut last = Arc::default();
    all.into_iter()
        .map(|own| {
            last = own.unwrap_or_else(|| Arc::clone(&last));
            Arc::clone(&last)
        })
        .collect()
}

/// The distance from a point to an area \[units\], at most `limit`; 0 inside.
pub fn distance(area: &Rows, frame: &RowFrame, at: [f64; 2], limit: f64) -> f64 {
    let (s, t) = (at[0].round() as i64, at[1].round() as i64);
    let limit_units = limit.ceil() as i64;
    let first = frame.row_below(t - limit_units).max(area.first());
    let last = (frame.row_below(t + limit_units) + 1).min(area.end() - 1);
    let mut best = limit * limit;
    for k in first..=last {
        let dt = (frame.t(k) - t) as f64;
        if dt * dt >= best {
            continue;
        }
        let row = area.row(k);
        let i = row.partition_point(|x| i64::from(x.end) <= s);
        let right = row.get(i).map(|x| (i64::from(x.start) - s).max(0));
        let left = i.checked_sub(1).map(|i| s - i64::from(row[i].end));
        for ds in [left, right].into_iter().flatten() {
            best = best.min((ds * ds) as f64 + dt * dt);
        }
    }
    best.sqrt()
}

/// Whether a disc touches an area; calls `each` with the index of every span of it that it touches.
pub fn touched(area: &Rows, frame: &RowFrame, at: [f64; 2], radius: f64, mut each: impl FnMut(usize)) {
    let (s, t, r) = (at[0].round() as i64, at[1].round() as i64, radius as i64);
    let first = (frame.row_below(t - r) + 1).max(area.first());
    let last = frame.row_below(t + r).min(area.end() - 1);
    for k in first..=last {
        let dt = frame.t(k) - t;
        let half = (r * r - dt * dt).max(0).isqrt();
        let range = area.range(k);
        let row = area.row(k);
        let from = row.partition_point(|x| i64::from(x.end) <= s - half);
        for (i, x) in range.zip(row).skip(from) {
            if i64::from(x.start) >= s + half {
                break;
            }
            each(i);
        }
    }
}
