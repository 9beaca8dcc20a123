//! By how much the areas of a layer are grown or shrunk before they become pixels.

use crate::span::{Rows, morph};

/// Compensation of what curing does to outlines: offsets in the plane, by layer.
///
/// It acts on the spans in lattice units, before there are pixels, so that it keeps the fineness of
/// anti-aliasing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Correction {
    /// Growth of every layer \[nm\]; negative shrinks (`absolute_correction`).
    pub absolute: i64,
    /// Shrinkage of the first layer (`elefant_foot_compensation`) \[nm\].
    pub foot: i64,
    /// Number of layers over which the shrinkage of the foot falls linearly to nothing; 0 counts as 1.
    pub fade: u32,
}

impl Correction {
    /// The offset of a layer \[nm\], negative where it shrinks: one radius, so that growing first and
    /// shrinking then does not close gaps. The foot shrinks layer `i` by `foot * (fade - i) / fade`,
    /// rounded towards zero.
    pub fn radius(&self, layer: u32) -> i64 {
        let fade = i64::from(self.fade.max(1));
        let left = (fade - i64::from(layer)).max(0);
        let foot = i128::from(self.foot) * i128::from(left) / i128::from(fade);
        self.absolute.saturating_sub(foot as i64)
    }

    /// True where no layer is changed.
    pub fn is_none(&self) -> bool {
        self.absolute == 0 && self.foot == 0
    }

    /// A layer's area with its correction; `t` is the position of each row \[nm\], ascending.
    pub fn apply(&self, area: Rows, layer: u32, t: impl Fn(i32) -> i64) -> Rows {
        match self.radius(layer) {
            0 => area,
            radius => morph::offset_disc(&area, radius, t),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::span::RowsBuilder;

    #[test]
    fn the_foot_fades() {
        let c = Correction { absolute: 10, foot: 100, fade: 4 };
        assert_eq!([0, 1, 2, 3, 4, u32::MAX].map(|l| c.radius(l)), [-90, -65, -40, -15, 10, 10]);
        let first_only = Correction { foot: 100, ..Default::default() };
        assert_eq!([0, 1].map(|l| first_only.radius(l)), [-100, 0]);
        assert!(Correction::default().is_none() && !c.is_none());
        let mut area = RowsBuilder::new(0);
        area.push(0, 1000);
        area.end_row();
        let area = area.finish();
        let apply = |layer| c.apply(area.clone(), layer, |k| i64::from(k) * 1000);
        assert!(apply(9).length() == 1020 && apply(3).length() == 970);
    }
}
