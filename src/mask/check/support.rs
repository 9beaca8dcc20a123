//! Which pixels of a layer have nothing beneath them.

use super::parts::LayerParts;
use crate::mask::Panel;
use crate::span::Span;

/// How far a pixel may lie beside what supports it.
///
/// Distances are those between centres of pixels; as a table: per number of rows between them the most
/// columns between them.
#[derive(Clone, Debug)]
pub struct Reach {
    columns: Vec<i32>,
}

impl Reach {
    /// `reach` \[nm\] on a panel; below 0 counts as 0: straight beneath.
    pub fn new(reach: i64, panel: &Panel) -> Self {
        let [px, py] = [panel.pitch_x.max(1), panel.pitch_y.max(1)];
        // A square of it fits an i64, and no panel is as wide.
        let reach = reach.clamp(0, 1 << 30);
        let rows = (reach / py).min(i64::from(panel.height));
        let columns = |d: i64| ((reach * reach - d * py * d * py).max(0).isqrt() / px).min(1 << 28) as i32;
        Self { columns: (0..=rows).map(columns).collect() }
    }
}

/// The pixels of a layer beyond reach of the layer below.
#[derive(Clone, Debug, Default)]
pub struct Unsupported {
    /// Their number, by part of the layer.
    pub of_part: Vec<u32>,
    /// As (row, columns), if asked for.
    pub spans: Vec<(i32, Span)>,
}

impl Unsupported {
    /// Compares a layer with the one below. Depends on its arguments alone. Costs by spans, and by the
    /// rows in reach only where a span sticks out of what lies straight beneath.
    pub fn of(layer: &LayerParts, below: &LayerParts, reach: &Reach, keep_spans: bool) -> Self {
        let mut out = Self { of_part: vec![0; layer.pixels.len()], spans: Vec::new() };
        let Some(&most) = reach.columns.first() else { return out };
        let (mut left, mut next) = (Vec::new(), Vec::new());
        for k in layer.rows.first()..layer.rows.end() {
            let beneath = below.rows.row(k);
            let mut j = 0;
            for i in layer.rows.range(k) {
                let span = layer.rows.spans()[i];
                while j < beneath.len() && beneath[j].end + most <= span.start {
                    j += 1;
                }
                if let Some(b) = beneath.get(j)
                    && b.start - most <= span.start
                    && span.end <= b.end + most
                {
                    continue;
                }
                left.clear();
                left.push(span);
                cut(&mut left, &mut next, &beneath[j..], most);
                for (d, &columns) in (1i32..).zip(&reach.columns[1..]) {
                    if left.is_empty() {
                        break;
                    }
                    cut(&mut left, &mut next, below.rows.row(k - d), columns);
                    cut(&mut left, &mut next, below.rows.row(k + d), columns);
                }
                for s in &left {
                    out.of_part[layer.part[i] as usize] += (s.end - s.start) as u32;
                }
                if keep_spans {
                    out.spans.extend(left.iter().map(|&s| (k, s)));
                }
            }
        }
        out
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u64 {
        self.of_part.iter().map(|&n| u64::from(n)).sum()
    }

    /// The parts of the layer that have no support at all: its islands.
    pub fn islands<'a>(&'a self, layer: &'a LayerParts) -> impl Iterator<Item = u32> + 'a {
        let parts = (0u32..).zip(self.of_part.iter().zip(&layer.pixels));
        parts.filter(|(_, (without, all))| without == all).map(|(part, _)| part)
    }
}

/// Takes the spans of a row, made longer by `by` at both ends, away from `left`.
fn cut(left: &mut Vec<Span>, next: &mut Vec<Span>, row: &[Span], by: i32) {
    let Some(first) = left.first() else { return };
    let mut j = row.partition_point(|s| s.end + by <= first.start);
    if left.last().is_none_or(|last| row.get(j).is_none_or(|s| s.start - by >= last.end)) {
        return;
    }
    next.clear();
    for span in left.iter() {
        let mut start = span.start;
        while j < row.len() && row[j].end + by <= start {
            j += 1;
        }
        let mut i = j;
        while i < row.len() && row[i].start - by < span.end {
            if start < row[i].start - by {
                next.push(Span { start, end: row[i].start - by });
            }
            start = start.max(row[i].end + by);
            i += 1;
        }
        if start < span.end {
            next.push(Span { start, end: span.end });
        }
    }
    std::mem::swap(left, next);
}
