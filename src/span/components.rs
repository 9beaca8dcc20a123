//! Connected parts of an area.

use super::{Rows, RowsBuilder};

/// Per span of `area` the number of its connected part, parts numbered by their first span.
///
/// Spans of neighbouring rows are connected when they overlap.
pub fn label(area: &Rows) -> Vec<u32> {
    let mut parent: Vec<u32> = (0..area.spans().len() as u32).collect();
    for k in area.first()..area.end() {
        let (below, above) = (area.range(k), area.range(k + 1));
        let (mut i, mut j) = (below.start, above.start);
        while i < below.end && j < above.end {
            let (a, b) = (area.spans()[i], area.spans()[j]);
            if a.start < b.end && b.start < a.end {
                let (x, y) = (root(&mut parent, i as u32), root(&mut parent, j as u32));
                parent[x.max(y) as usize] = x.min(y);
            }
            if a.end <= b.end { i += 1 } else { j += 1 }
        }
    }
    // A root is the smallest span of its part, so its number is known before it is asked for.
    let mut parts = 0;
    let mut number = vec![0; parent.len()];
    for i in 0..parent.len() as u32 {
        let r = root(&mut parent, i);
        number[i as usize] = if r == i {
            parts += 1;
            parts - 1
        } else {
            number[r as usize]
        };
    }
    number
}

/// The connected parts whose total span length is below `least` \[units\].
pub fn smaller_than(area: &Rows, least: i64) -> Rows {
    let part = label(area);
    let mut length = vec![0i64; part.len()];
    for (s, &p) in area.spans().iter().zip(&part) {
        length[p as usize] += s.length();
    }
    let mut out = RowsBuilder::new(area.first());
    for k in area.first()..area.end() {
        for i in area.range(k) {
            if length[part[i] as usize] < least {
                out.push(area.spans()[i].start, area.spans()[i].end);
            }
        }
        out.end_row();
    }
    out.finish()
}

fn root(parent: &mut [u32], mut i: u32) -> u32 {
    while parent[i as usize] != i {
        let up = parent[parent[i as usize] as usize];
        parent[i as usize] = up;
        i = up;
    }
    i
}
