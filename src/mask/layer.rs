//! One layer's mask as runs.

/// Lit pixels of one grey in raster order: those at `start..end`, counted along the rows of the image
/// from its upper left corner. A run may go on into the next row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// The first pixel.
    pub start: u32,
    /// The pixel behind the last.
    pub end: u32,
    /// Grey, 1..=255; 255 is fully lit.
    pub value: u8,
}

/// The mask of one layer: its lit runs, ascending, none empty, none overlapping, and none that could be
/// joined with the one before. Equal masks are equal lists.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MaskLayer {
    /// The runs.
    pub runs: Vec<Run>,
}

impl MaskLayer {
    /// Appends a run; one that continues the last is joined with it, black and empty ones are left out.
    /// Runs must come in ascending order.
    #[inline]
    pub fn push(&mut self, start: u32, end: u32, value: u8) {
        if start >= end || value == 0 {
            return;
        }
        if let Some(last) = self.runs.last_mut()
            && last.end == start
            && last.value == value
        {
            last.end = end;
            return;
        }
        self.runs.push(Run { start, end, value });
    }

    /// Number of lit pixels, of any grey.
    pub fn lit(&self) -> u64 {
        self.runs.iter().map(|r| u64::from(r.end - r.start)).sum()
    }

    /// Sum of all greys over 255: the lit area \[pixels\].
    pub fn area(&self) -> f64 {
        let sum: u64 = self.runs.iter().map(|r| u64::from(r.end - r.start) * u64::from(r.value)).sum();
        sum as f64 / 255.0
    }

    /// All `pixels` pixels as (length, grey) in raster order, black ones included: what run-length
    /// encoders eat. Nothing is merged across a change of grey, nothing split.
    pub fn lengths(&self, pixels: u32) -> impl Iterator<Item = (u32, u8)> + '_ {
        let last = self.runs.last().map_or(0, |r| r.end);
        let mut at = 0;
        self.runs
            .iter()
            .flat_map(move |r| {
                let gap = r.start - at;
                at = r.end;
                [(gap, 0), (r.end - r.start, r.value)]
            })
            .chain([(pixels.saturating_sub(last), 0)])
            .filter(|(length, _)| *length > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_joined_and_all_pixels_covered() {
        let mut mask = MaskLayer::default();
        for (start, end, value) in [(2, 4, 255), (4, 6, 255), (6, 6, 9), (6, 7, 0), (7, 9, 3), (9, 10, 255)] {
            mask.push(start, end, value);
        }
        let run = |start, end, value| Run { start, end, value };
        assert_eq!(mask.runs, [run(2, 6, 255), run(7, 9, 3), run(9, 10, 255)]);
        assert_eq!((mask.lit(), mask.area()), (7, (5.0 * 255.0 + 6.0) / 255.0));
        let lengths: Vec<_> = mask.lengths(12).collect();
        assert_eq!(lengths, [(2, 0), (4, 255), (1, 0), (2, 3), (1, 255), (2, 0)]);
        assert_eq!(MaskLayer::default().lengths(5).collect::<Vec<_>>(), [(5, 0)]);
    }
}
