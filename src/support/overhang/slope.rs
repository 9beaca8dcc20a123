//! How far a layer may reach over those below, and where it reaches further.

use crate::span::Rows;
use crate::span::algebra::or;
use crate::span::beyond::{beyond, half_widths, thick_half_widths};
use crate::support::{Part, SupportPlan};

/// Steps across the rows are measured over so many rows, or as many layers as that takes.
const ROWS: i64 = 8;
/// ... but over no more layers than these.
const LAYERS: usize = 8;

/// What one layer may.
#[derive(Clone, Copy, Debug)]
pub struct Reach<'a> {
    pub part: Part<'a>,
    pub plan: &'a SupportPlan,
    pub layer: usize,
}

impl Reach<'_> {
    /// How far the layer may reach over the `n`-th below it \[units\].
    pub fn units(&self, n: usize) -> i64 {
        let middle =
            |i: usize| self.part.levels.get(i).map_or(0.0, |level| 0.5 * (level.top + level.bottom) as f64);
        // From one cutting plane to the other.
        let rise = middle(self.layer) - middle(self.layer.saturating_sub(n));
        let reach = |degrees: f64| rise / libm::tan(degrees.to_radians());
        let nm = self.plan.threshold.map_or(self.plan.half_wall * n as f64, reach);
        self.part.frame.units(nm.clamp(0.0, 1e9))
    }

    /// The points of the layer further beyond the layer below, and beyond `held`, than allowed.
    ///
    /// Along the rows that is exact. Across them a border lies up to a row beyond what the rows show, on
    /// either layer, so that a step between two layers may be a row off. Where that decides, the step from a
    /// layer further down does: over several layers the error is the same and the allowance larger.
    pub fn exceeded(&self, held: &Rows) -> Rows {
        let layer = |n: usize| self.layer.checked_sub(n).and_then(|b| self.part.outlines.get(b));
        let (Some(own), Some(below)) = (self.part.outlines.get(self.layer), layer(1)) else {
            return Rows::default();
        };
        let (pitch, reach) = (self.part.frame.pitch(), self.units(1));
        let rest_of = |area: &Rows, widths: &[i32]| {
            let rest = beyond(area, below, widths);
            if held.is_empty() || rest.is_empty() { rest } else { beyond(&rest, held, widths) }
        };
        let doubtful = rest_of(own, &half_widths(reach - pitch, pitch));
        if doubtful.is_empty() {
            return doubtful;
        }
        let thick = thick_half_widths(reach, pitch, 1);
        let certain = rest_of(&doubtful, &thick);
        let n = ((ROWS * pitch + reach) / reach.max(1)).clamp(1, LAYERS as i64) as usize;
        let n = n.min(self.layer);
        let Some(deep) = layer(n) else { return certain };
        let mut far = beyond(&doubtful, deep, &half_widths(self.units(n), pitch));
        if !held.is_empty() {
            far = beyond(&far, held, &thick);
        }
        or(&far, &certain)
    }
}
