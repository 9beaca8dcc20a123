//! Areas as whole cells of the grid.

use crate::span::algebra::{dilate, or, sub};
use crate::span::{Rows, RowsBuilder};
use crate::support::SupportPlan;

/// The cells that an area meets, on the rows of the area.
///
/// Cells begin at multiples of their size from the zero of the frame, in both directions, so that they are the
/// same on all layers. What lies in a cell by a sliver only does not count, as long as a neighbour is near.
pub fn covering(area: &Rows, plan: &SupportPlan) -> Rows {
    if area.is_empty() {
        return Rows::default();
    }
    let size = Size::new(plan);
    // As much as a row through the cell.
    let most = expand(&met(area, &size, size.side), &size);
    let rest = sub(area, &dilate(&most, 1, size.pitch as i32));
    if rest.is_empty() { most } else { or(&most, &expand(&met(&rest, &size, 1), &size)) }
}

/// Of cells \[units\].
struct Size {
    rows: i32,
    side: i64,
    pitch: i64,
}

impl Size {
    fn new(plan: &SupportPlan) -> Self {
        let rows = plan.cell_rows.max(1) as i32;
        let pitch = plan.frame.pitch();
        Self { rows, side: pitch * i64::from(rows), pitch }
    }
}

/// The cells of which at least `least` \[units of span\] lies in the area: rows of cells, numbers of cells.
fn met(area: &Rows, size: &Size, least: i64) -> Rows {
    let low = area.spans().iter().map(|s| s.start).min().map_or(0, i64::from).div_euclid(size.side);
    let high = area.spans().iter().map(|s| s.end).max().map_or(0, i64::from).div_euclid(size.side);
    let mut filled = vec![0i64; (high - low + 1) as usize];
    let (first, end) = (area.first().div_euclid(size.rows), (area.end() - 1).div_euclid(size.rows) + 1);
    let mut out = RowsBuilder::with_capacity(first, (end - first) as usize, 2 * (end - first) as usize);
    for row in first..end {
        filled.fill(0);
        for k in row * size.rows..(row + 1) * size.rows {
            for span in area.row(k) {
                let (mut from, end) = (i64::from(span.start), i64::from(span.end));
                while from < end {
                    let cell = from.div_euclid(size.side);
                    let to = end.min((cell + 1) * size.side);
                    filled[(cell - low) as usize] += to - from;
                    from = to;
                }
            }
        }
        for (cell, _) in (low..).zip(&filled).filter(|(_, f)| **f >= least) {
            out.push(cell as i32, cell as i32 + 1);
        }
        out.end_row();
    }
    out.finish()
}

/// Cells as areas.
fn expand(cells: &Rows, size: &Size) -> Rows {
    let rows = (cells.end() - cells.first()).max(0) * size.rows;
    let spans = cells.spans().len() * size.rows as usize;
    let mut out = RowsBuilder::with_capacity(cells.first() * size.rows, rows as usize, spans);
    let at = |cell: i32| (i64::from(cell) * size.side).clamp(i32::MIN.into(), i32::MAX.into()) as i32;
    for (_, row) in cells.iter() {
        for _ in 0..size.rows {
            row.iter().for_each(|s| out.push(at(s.start), at(s.end)));
            out.end_row();
        }
    }
    out.finish()
}
