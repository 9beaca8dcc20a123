//! A window of rows in whole numbers: what a device is told of a frame.

use crate::lattice::Point2;
use crate::shaders::SpanSizes;
use thiserror::Error;

/// Rows in a window are fewer than this.
pub const MAX_ROWS: u64 = 1 << 24;

/// Coordinates along and across the rows stay below this on a device \[units\]. Along the axes the lattice
/// itself ends there.
pub const REACH: u32 = 1 << 30;

/// Consecutive rows, several of them to a line: row `i` lies at
/// `base + i / n * pitch + offsets[i % n]` \[units\] with `n` offsets.
///
/// A row is crossed by an edge from t0 to t1 where `min(t0, t1) < t <= max(t0, t1)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RowWindow {
    first: i32,
    sizes: SpanSizes,
}

/// Why rows are not for a device.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[expect(missing_docs, reason = "fields say what their message shows")]
pub enum WindowError {
    /// Neither along an axis nor along a diagonal.
    #[error("rows along ({a}, {b}) on a device; only the axes and the diagonals are exact")]
    Direction { a: i32, b: i32 },
    /// No pitch, or one beyond 32 bits.
    #[error("a row pitch of {pitch} on a device; it takes 1 to 4294967295")]
    Pitch { pitch: i64 },
    /// Offsets that do not ascend from 0 to below the pitch, none, or more than 16.
    #[error("rows at {offsets:?} in lines {pitch} apart; they must ascend within the pitch, at most 16")]
    Offsets { offsets: Vec<i64>, pitch: i64 },
    /// Rows beyond 32 bits, or too many.
    #[error("{lines} lines from {base} on, {pitch} apart; a device takes 2^24 rows within 32 bits")]
    TooMany { base: i64, pitch: i64, lines: u32 },
}

impl RowWindow {
    /// Lines `base + k * pitch`, `k` in `0..lines`, each with a row at every offset from it \[units\]. The
    /// rows are numbered from `first` on. `[a, b]` is their direction as in [`super::RowFrame`]:
    /// `s = a x + b y`, `t = a y - b x`, each of a, b in -1..=1.
    ///
    /// # Errors
    /// [`WindowError`] for what 32-bit arithmetic does not hold.
    pub fn new(
        [a, b]: [i32; 2],
        first: i32,
        base: i64,
        pitch: i64,
        offsets: &[i64],
        lines: u32,
    ) -> Result<Self, WindowError> {
        if a.abs() > 1 || b.abs() > 1 || (a, b) == (0, 0) {
            return Err(WindowError::Direction { a, b });
        }
        let Some(pitch_32) = u32::try_from(pitch).ok().filter(|&pitch| pitch > 0) else {
            return Err(WindowError::Pitch { pitch });
        };
        let ascend = offsets.windows(2).all(|pair| pair[0] < pair[1]);
        let inside = offsets.iter().all(|offset| (0..pitch).contains(offset));
        if !ascend || !inside || offsets.is_empty() || offsets.len() > 16 {
            return Err(WindowError::Offsets { offsets: offsets.to_vec(), pitch });
        }
        let rows = u64::from(lines) * offsets.len() as u64;
        let end = base.saturating_add(pitch.saturating_mul(lines.into()));
        let wrong = WindowError::TooMany { base, pitch, lines };
        let Some(base) = i32::try_from(base).ok().filter(|_| i32::try_from(end).is_ok() && rows < MAX_ROWS)
        else {
            return Err(wrong);
        };
        let mut sizes = SpanSizes {
            a,
            b,
            base,
            pitch: pitch_32,
            lines,
            sub_rows: offsets.len() as u32,
            rows: rows as u32,
            ..SpanSizes::default()
        };
        for (place, &offset) in sizes.offsets.iter_mut().zip(offsets) {
            *place = offset as u32;
        }
        Ok(Self { first, sizes })
    }

    /// Number of the first row.
    pub const fn first(&self) -> i32 {
        self.first
    }

    /// Number of rows.
    pub const fn rows(&self) -> u32 {
        self.sizes.rows
    }

    /// What the kernels are told, but for the run.
    pub const fn sizes(&self) -> SpanSizes {
        self.sizes
    }

    /// Position of the window's `row`-th row \[units\].
    pub fn t(&self, row: u32) -> i32 {
        t(&self.sizes, row)
    }
}

/// Position of a row \[units\]; within 32 bits for every row of a window.
pub(super) fn t(sizes: &SpanSizes, row: u32) -> i32 {
    let sub_rows = sizes.sub_rows.max(1);
    let within = sizes.offsets.get((row % sub_rows) as usize).copied().unwrap_or(0);
    sizes.base.wrapping_add((row / sub_rows).wrapping_mul(sizes.pitch).wrapping_add(within) as i32)
}

/// Coordinates (s, t) of a point \[units\].
pub(super) fn st(sizes: &SpanSizes, p: Point2) -> (i32, i32) {
    (sizes.a * p.x + sizes.b * p.y, sizes.a * p.y - sizes.b * p.x)
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn rows_lie_where_they_were_put() {
        let window = RowWindow::new([1, 0], -8, -1_000, 700, &[44, 131, 219, 306], 3).unwrap();
        assert_eq!((window.rows(), window.first()), (12, -8));
        let t: Vec<i32> = (0..6).map(|row| window.t(row)).collect();
        assert_eq!(t, [-956, -869, -781, -694, -256, -169]);
    }

    #[test]
    fn what_32_bits_do_not_hold_is_refused() {
        let new = |axes, base, pitch, offsets: &[i64], lines| {
            RowWindow::new(axes, 0, base, pitch, offsets, lines).err()
        };
        assert_eq!(new([-1, 1], i32::MIN.into(), 1 << 31, &[0], 1), None);
        assert!(matches!(new([0, 0], 0, 9, &[0], 1), Some(WindowError::Direction { .. })));
        assert!(matches!(new([2, 0], 0, 9, &[0], 1), Some(WindowError::Direction { .. })));
        for pitch in [0, -5, 1 << 32] {
            assert!(matches!(new([1, 0], 0, pitch, &[0], 1), Some(WindowError::Pitch { .. })));
        }
        for offsets in [&[][..], &[3, 3], &[9], &[-1], &[0; 17]] {
            assert!(matches!(new([1, 0], 0, 9, offsets, 1), Some(WindowError::Offsets { .. })));
        }
        for (base, pitch, lines) in
            [(1 << 31, 9, 1), (1 << 30, 1 << 30, 1), (0, 1, 1 << 24), (i64::MIN, 1, 1)]
        {
            assert!(matches!(new([1, 0], base, pitch, &[0], lines), Some(WindowError::TooMany { .. })));
        }
    }
}
