//! Which walls may carry sparse infill's links and anchors.

use crate::infill::anchor::Open;
use crate::lattice::Point2;
use crate::span::{RowFrame, Rows};

/// The wall beside sparse infill, not beside skins.
#[derive(Clone, Copy, Debug)]
pub struct SparseOnly<'a> {
    /// The sparse area on the rows of `frame`; `None` where there is nothing else.
    pub area: Option<&'a Rows>,
    /// The rows of areas.
    pub frame: &'a RowFrame,
}

impl SparseOnly<'_> {
    /// True within a row's distance of the area: a wall bounds it, and lies between rows.
    fn is_near(&self, area: &Rows, p: Point2) -> bool {
        let (s, t) = self.frame.st(p);
        let (s, k, reach) = (i64::from(s), self.frame.nearest_row(t.into()), self.frame.pitch());
        (k - 1..=k + 1).any(|k| {
            let row = area.row(k);
            let i = row.partition_point(|span| i64::from(span.end) + reach < s);
            row.get(i).is_some_and(|span| i64::from(span.start) - reach <= s)
        })
    }
}

impl Open for SparseOnly<'_> {
    fn is_all(&self) -> bool {
        self.area.is_none()
    }

    /// Looked at every second row's distance.
    fn reach(&self, a: Point2, b: Point2) -> f64 {
        let Some(area) = self.area else { return f64::INFINITY };
        let length = a.distance(b);
        let step = 2.0 * self.frame.pitch() as f64 / self.frame.scale();
        let steps = (length / step).ceil().max(1.0);
        let mut i = 0.0;
        while i <= steps {
            if !self.is_near(area, a.toward(b, i / steps)) {
                return ((i - 1.0) / steps * length).max(0.0);
            }
            i += 1.0;
        }
        f64::INFINITY
    }
}
