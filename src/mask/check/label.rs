//! Connected parts of a layer's spans and of the gaps between them.

use super::parts::{Gap, Region};
use crate::span::{Rows, Span};

const NONE: u32 = u32::MAX;

/// Per span the number of its part, and the pixels of each part. Spans of neighbouring rows are
/// connected where they overlap: across edges of pixels.
pub(super) fn parts(rows: &Rows) -> (Vec<u32>, Vec<u32>) {
    let spans = rows.spans();
    let mut label = vec![NONE; spans.len()];
    let mut sets = Sets::default();
    let mut above = 0..0;
    for k in rows.first()..rows.end() {
        let here = rows.range(k);
        let mut i = above.start;
        for j in here.clone() {
            let span = spans[j];
            while i < above.end && spans[i].end <= span.start {
                i += 1;
            }
            let mut own = NONE;
            let mut p = i;
            while p < above.end && spans[p].start < span.end {
                own = if own == NONE { label[p] } else { sets.join(own, label[p]) };
                p += 1;
            }
            // The last one that overlaps may reach into the next span too.
            i = p.max(i + 1) - 1;
            label[j] = if own == NONE { sets.add() } else { own };
        }
        above = here;
    }
    let (number, count) = sets.number(0);
    let mut pixels = vec![0u32; count as usize];
    for (l, s) in label.iter_mut().zip(spans) {
        *l = number[*l as usize];
        pixels[*l as usize] += (s.end - s.start) as u32;
    }
    (label, pixels)
}

/// The holes: gaps between spans that are not connected to the outside across edges or corners, as
/// pieces by row, their extents, and per span the hole behind it (0 = none; no entries without holes).
pub(super) fn holes(rows: &Rows) -> (Vec<Gap>, Vec<Region>, Vec<u32>) {
    let spans = rows.spans();
    // Set 0 is the outside.
    let mut sets = Sets::default();
    sets.add();
    // Sets of the gaps of two rows: before the first span, behind each.
    let (mut above, mut here) = (vec![0], vec![0]);
    let mut above_spans: &[Span] = &[];
    let mut gaps: Vec<Gap> = Vec::new();
    for k in rows.first()..=rows.end() {
        let range = rows.range(k);
        let here_spans = &spans[range.clone()];
        if here_spans.len() > 1 || above_spans.len() > 1 {
            here.clear();
            here.resize(here_spans.len() + 1, NONE);
            here[0] = 0;
            here[here_spans.len()] = 0;
            meet(above_spans, here_spans, |a, b| {
                here[b] = if here[b] == NONE { above[a] } else { sets.join(here[b], above[a]) };
            });
            for (i, pair) in here_spans.windows(2).enumerate() {
                if here[i + 1] == NONE {
                    here[i + 1] = sets.add();
                }
                let (start, end) = (pair[0].end, pair[1].start);
                let span = (range.start + i) as u32;
                gaps.push(Gap { row: k, start, end, hole: here[i + 1], span });
            }
        } else {
            here.clear();
            here.resize(here_spans.len() + 1, 0);
        }
        std::mem::swap(&mut above, &mut here);
        above_spans = here_spans;
    }
    let (number, count) = sets.number(0);
    if count < 2 {
        return Default::default();
    }
    let mut behind = vec![0; spans.len()];
    let mut holes = vec![Region::default(); count as usize - 1];
    gaps.retain_mut(|gap| {
        let n = number[gap.hole as usize];
        behind[gap.span as usize] = n;
        gap.hole = n.wrapping_sub(1);
        if n > 0 {
            holes[gap.hole as usize].add(gap.row, gap.start, gap.end);
        }
        n > 0
    });
    (gaps, holes, behind)
}

/// Pairs of gaps of two neighbouring rows that touch, corners included. Gap 0 comes before the first
/// span, gap i behind span i - 1; the outermost ones have no end.
#[inline]
fn meet(above: &[Span], here: &[Span], mut pair: impl FnMut(usize, usize)) {
    let bounds = |spans: &[Span], i: usize| {
        let start = if i == 0 { i32::MIN } else { spans[i - 1].end };
        (start, spans.get(i).map_or(i32::MAX, |s| s.start))
    };
    let (mut a, mut b) = (0, 0);
    while a <= above.len() && b <= here.len() {
        let (from, to) = (bounds(above, a), bounds(here, b));
        if from.0 <= to.1 && to.0 <= from.1 {
            pair(a, b);
        }
        // Where both end together neither meets the other's successor.
        if from.1 <= to.1 {
            a += 1;
        }
        if to.1 <= from.1 {
            b += 1;
        }
    }
}

/// Disjoint sets; the smallest member stands for its set.
#[derive(Clone, Debug, Default)]
pub(super) struct Sets {
    parent: Vec<u32>,
}

impl Sets {
    /// Members 0..n, each for itself.
    pub(super) fn reset(&mut self, n: u32) {
        self.parent.clear();
        self.parent.extend(0..n);
    }

    /// A new member.
    pub(super) fn add(&mut self) -> u32 {
        let n = self.parent.len() as u32;
        self.parent.push(n);
        n
    }

    #[inline]
    pub(super) fn root(&mut self, mut i: u32) -> u32 {
        while self.parent[i as usize] != i {
            let up = self.parent[self.parent[i as usize] as usize];
            self.parent[i as usize] = up;
            i = up;
        }
        i
    }

    /// Unites two sets and returns the root.
    #[inline]
    pub(super) fn join(&mut self, a: u32, b: u32) -> u32 {
        if a == b {
            return a;
        }
        let (a, b) = (self.root(a), self.root(b));
        let (low, high) = (a.min(b), a.max(b));
        self.parent[high as usize] = low;
        low
    }

    /// Per member the number of its set, sets counted by their roots from `first`; and the number behind
    /// the last.
    fn number(&mut self, first: u32) -> (Vec<u32>, u32) {
        let mut next = first;
        let mut number = vec![0; self.parent.len()];
        for i in 0..self.parent.len() {
            let up = self.parent[i] as usize;
            // A parent is smaller and has its number already.
            number[i] = if up == i {
                next += 1;
                next - 1
            } else {
                number[up]
            };
        }
        (number, next)
    }
}
