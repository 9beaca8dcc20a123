//! Rings as segments: what a device is given of outlines that are at the host.

use super::{RowFrame, RowWindow, WindowError};
use crate::lattice::Point2;
use crate::slice::Segments;

/// The edges of each plane's closed rings \[nm\], plane after plane, as segments for the rows of a frame.
///
/// A device computes (s, t) along the axes and the diagonals only. For other directions the segments begin
/// at the frame's own coordinates, rounded as [`RowFrame::st`] rounds them, and [`window`] has rows along
/// +x to go with them.
pub fn segments(planes: &[Vec<&[Point2]>], frame: &RowFrame) -> Segments {
    let total: usize = planes.iter().flatten().map(|r| r.len()).sum();
    let mut out = Segments {
        first: Vec::with_capacity(total),
        offset: (0..=total as u32).collect(),
        start: Vec::with_capacity(total),
        next: Vec::with_capacity(total),
    };
    for (plane, rings) in (0..).zip(planes) {
        for ring in rings {
            let begin = out.start.len() as u32;
            match frame.direction() {
                Some(_) => out.start.extend_from_slice(ring),
                None => out.start.extend(ring.iter().map(|&p| {
                    let (s, t) = frame.st(p);
                    Point2::new(s, t)
                })),
            }
            let end = out.start.len() as u32;
            out.next.extend((begin..end).map(|i| if i + 1 == end { begin } else { i + 1 }));
            // Each segment is a triangle's only one.
            out.first.resize(end as usize, plane);
        }
    }
    out
}

/// The window of all rows of a frame that may cross the rings.
///
/// # Errors
/// [`WindowError`] for rows that a device does not take.
pub fn window(planes: &[Vec<&[Point2]>], frame: &RowFrame) -> Result<RowWindow, WindowError> {
    let t = || planes.iter().flatten().flat_map(|r| r.iter()).map(|&p| i64::from(frame.st(p).1));
    let n = frame.sub_rows().max(1) as i32;
    let line = |t: i64| frame.row_below(t).div_euclid(n);
    let (low, high) = (t().min().map_or(0, line), t().max().map_or(0, line));
    let [a, b] = frame.direction().unwrap_or([1, 0]).map(|c| c as i32);
    let undivided = [0];
    let (base, offsets) = match n {
        1 => (frame.t(low), &undivided[..]),
        _ => (frame.base() + i64::from(low) * frame.pitch(), frame.offsets()),
    };
    RowWindow::new([a, b], low * n, base, frame.pitch(), offsets, (high - low) as u32 + 1)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::span::tests::Random;
    use crate::span::{Axis, scan, twin};

    fn rings(random: &mut Random) -> Vec<Vec<Point2>> {
        (0..random.below(4))
            .map(|_| {
                let corners = 1 + random.below(12);
                let mut c = || random.within(-9_000_000, 9_000_000) as i32;
                (0..corners).map(|_| Point2::new(c(), c())).collect()
            })
            .collect()
    }

    #[test]
    fn the_twins_scan_rings_in_any_direction() {
        let any = [0.0, 30.0, 45.0, 60.0, 77.7, 90.0, 135.0, 165.0].map(|a| RowFrame::new(a, 0.0, 407_080.0));
        let strips = [Axis::X, Axis::Diagonal].map(|axis| RowFrame::strips(axis, -777, 600_001, 4));
        let mut spans = 0;
        for frame in any.iter().chain(&strips) {
            for seed in 1..20 {
                let mut random = Random(seed);
                let planes: Vec<Vec<Vec<Point2>>> = (0..3).map(|_| rings(&mut random)).collect();
                let planes: Vec<Vec<&[Point2]>> =
                    planes.iter().map(|p| p.iter().map(|r| &r[..]).collect()).collect();
                let window = window(&planes, frame).unwrap();
                let rows = twin::scan(&window, 3, &segments(&planes, frame)).unwrap();
                for (rows, rings) in rows.iter().zip(&planes) {
                    let (rows, expected) = (rows.as_ref().unwrap(), scan(rings.iter().copied(), frame));
                    for k in rows.first().min(expected.first())..rows.end().max(expected.end()) {
                        assert_eq!(rows.row(k), expected.row(k), "seed {seed}, row {k}, {frame:?}");
                    }
                    spans += expected.spans().len();
                }
            }
        }
        assert!(spans > 1_000, "{spans}");
    }
}
